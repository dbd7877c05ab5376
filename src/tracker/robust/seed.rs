//! The joint in one whole frame, without a prediction.

use super::classify;
use super::outline::{is_shoulder, is_toe, is_two_grooves, shorter_leg_px};
use crate::frame::GrayFrame;
use crate::imgproc::geometry::{JointFit, JointKind, JointModel, Learned, learn};
use crate::imgproc::{Centreline, SeamFeatures, SeedSettings, seam_candidates};
use crate::units::PixelPoint;

/// Arm of the second difference that shows a corner \[px\]. Prototype.
const CORNER_ARM_PX: usize = 18;
/// Least second difference of a corner over the arms \[px\]: a bend of 0.2 in slope. Chosen.
const LEAST_CORNER_PX: f32 = 3.6;
/// From where to where on both sides the way of the stripe past a notch is taken \[px\], and its least depth \[px\].
/// Chosen: bent edges lie nearer; three times the noise of a speckled stripe's mean over three columns.
const NOTCH_ARM_PX: std::ops::Range<usize> = 12..28;
const LEAST_NOTCH_PX: f32 = 2.0;
/// The kinds that have edges.
const EDGED: [JointKind; 2] = [JointKind::Butt, JointKind::Lap];
/// Places that are kept of each sort, and how far joints at two places are apart at least \[px\].
const MOST_PLACES: usize = 3;
/// Neighbours may share a shoulder: so much of both their half widths is between them at least.
const APART_SHARE: f64 = 0.8;
const LEAST_APART_PX: f64 = 6.0;
/// Places of a frame that are looked at closely.
const MOST_CANDIDATES: usize = 6;
const MOST_CORNERS: usize = 4;
/// Bends among which the shoulders of a groove are sought, and their least distance \[px\].
const MOST_BENDS: usize = 8;
const LEAST_GROOVE_PX: f64 = 24.0;
/// How many bends on a shoulder is paired with. Chosen: the crowns of two beads lie between them.
const MOST_BETWEEN: usize = 3;
/// Width of a break that may be an open root \[px\].
const OPEN_ROOT_PX: std::ops::Range<usize> = 8..110;
/// A narrower gap is no gap with two edges, but a speckle or a hairline \[px\]. Tuned.
const LEAST_GAP_PX: f64 = 2.5;
/// A gap at least this wide is fitted with its width as it shows \[px\]. Chosen: the fit expects 12 ± 8 px otherwise.
const WIDE_GAP_PX: f64 = 25.0;
/// A gap at least this wide may be bridged, by a stripe seen in this share of its columns and of some on either side \[px\],
/// which nowhere jumps by as much \[px\]. Chosen: walls are steep, flanks are not.
const LEAST_BRIDGED_PX: f64 = 10.0;
const BRIDGED_SHARE: f64 = 0.85;
const BRIDGE_REACH_PX: f64 = 3.0;
const LEAST_JUMP_PX: f32 = 3.5;
/// Shortest leg of a corner that nobody asked for \[px\]: shorter ones do not tell a bend from a curve. Chosen.
pub const LEAST_LEG_PX: f64 = 40.0;
/// Share of the columns of a fit's window in which both legs must be seen. Chosen: a flank of 40 px has half.
const LEAST_LEG_SUPPORT: f64 = 0.55;
/// How often the legs of a corner are fitted anew, as curved as they then are. Chosen: their curvature is known to a tenth.
const CURVING_FITS: usize = 3;
/// How far the refined centre may lie from the seed \[px\].
const SEARCH_PX: f64 = 12.0;
/// Support above which a seed, being clear otherwise, needs no second frame. Chosen: a frame without spatter.
const CLEAR_SUPPORT: f64 = 0.7;
/// Columns on each flank of a groove with both its shoulders that make it certain in any frame \[px\]. Chosen: crossing
/// spatters make small grooves, of 30 px at most.
const COMPLETE_FLANK_PX: f64 = 50.0;

/// A joint found in a frame.
#[derive(Debug, Clone)]
pub struct Seed {
    /// Its cross-section.
    pub model: JointModel,
    /// The fit on the same frame.
    pub fit: JointFit,
    /// So clear that no second frame need confirm it, if nothing but the stripe shines in this one.
    pub clear: bool,
    /// Beyond doubt: the user said so, or all of a groove is seen.
    pub certain: bool,
    /// How far the shorter leg of a corner goes in the whole stripe; 0 of other joints \[px\].
    pub leg_px: f64,
}

impl Seed {
    /// From edge to edge; 0 of a joint without edges \[px\].
    pub fn gap_px(&self) -> f64 {
        self.fit.edges.map_or(0.0, |edges| edges.gap_px)
    }

    /// From the centre to the joint's end: the nearer shoulder, or an edge \[px\].
    pub fn half_px(&self) -> f64 {
        self.model.half_width_px.unwrap_or(0.5 * self.gap_px())
    }

    /// How far apart two centres are \[px\].
    pub fn away_px(&self, other: &Self) -> f64 {
        (self.fit.centre.u_px - other.fit.centre.u_px).abs()
    }
}

/// The joints with a corner and those with edges, of `kind` or of any kind, in the frame whose centreline is `line`, each place
/// once, the best of each sort first. Corners come first: what passes for one without being asked for is one.
pub fn find(frame: &GrayFrame, line: &Centreline, kind: Option<JointKind>) -> Vec<Seed> {
    let wants = |candidate: JointKind| kind.is_none_or(|kind| kind == candidate);
    let mut seeds = vec![];
    if wants(JointKind::VGroove) || wants(JointKind::Fillet) {
        let found = corners(line).into_iter().filter_map(|place| corner(frame, Some(line), place, kind));
        // A groove's root bends as much as both its shoulders together.
        seeds.extend(places_of(found.collect(), |seed| classify::bend(seed).abs()));
        for seed in seeds.iter_mut().filter(|seed| seed.model.kind == JointKind::Fillet) {
            seed.leg_px = shorter_leg_px(line, seed);
        }
    }
    if !kind.is_none_or(JointKind::has_edges) {
        return seeds;
    }
    // The median of three keeps joints that are only a few columns wide.
    let settings = SeedSettings { median_columns: 3, ..SeedSettings::default() };
    let candidates = seam_candidates(line, &settings);
    let strong =
        candidates.iter().take(MOST_CANDIDATES).map(|(features, _)| (features.centre(), wide_gap_px(features)));
    let places = strong.chain(notches(line).into_iter().map(|place| (place, None)));
    let learned: Vec<(Learned, Option<f64>)> =
        places.filter_map(|(place, wide_px)| Some((beside(frame, place)?, wide_px))).collect();
    let is_one_toe = |seed: &Seed| kind.is_none() && seed.model.kind == JointKind::Butt && is_toe(line, seed);
    for tried in EDGED.into_iter().filter(|&tried| wants(tried)) {
        let unknown = learned.iter().map(|(learned, _)| (learned, None));
        let wide = learned.iter().filter(|(_, wide_px)| tried == JointKind::Butt && wide_px.is_some());
        let open = kind.is_none();
        let all = unknown.chain(wide.map(|(learned, wide_px)| (learned, *wide_px)));
        let found = all.filter_map(|(learned, gap_px)| edges(frame, learned, gap_px, tried, open));
        seeds.extend(places_of(found.filter(|seed| !is_bridged(line, seed) && !is_one_toe(seed)).collect(), score));
    }
    seeds
}

/// The joint where the user says it is.
pub fn at(frame: &GrayFrame, kind: Option<JointKind>, place: PixelPoint) -> Option<Seed> {
    let with_edges = |kind: Option<JointKind>| {
        let learned = beside(frame, place)?;
        let tried = EDGED.into_iter().filter(|&tried| kind.is_none_or(|kind| kind == tried));
        best(tried.filter_map(|tried| edges(frame, &learned, None, tried, kind.is_none())))
    };
    let seed = match kind {
        Some(kind) if !kind.has_edges() => corner(frame, None, place, Some(kind)),
        Some(_) => with_edges(kind),
        None => corner(frame, None, place, None).or_else(|| with_edges(None)),
    };
    seed.map(|seed| Seed { certain: true, ..seed })
}

fn best(seeds: impl Iterator<Item = Seed>) -> Option<Seed> {
    seeds.max_by(|a, b| score(a).total_cmp(&score(b)))
}

/// How good a joint with edges is.
fn score(seed: &Seed) -> f64 {
    seed.fit.support - seed.fit.residual_px / 4.0 - seed.fit.edges.map_or(0.0, |edges| edges.cost)
}

/// The best seed of each place, the best place first. A place is as wide as the joint there, and what overlaps is one.
fn places_of(mut seeds: Vec<Seed>, worth: impl Fn(&Seed) -> f64) -> Vec<Seed> {
    seeds.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    let mut places: Vec<Seed> = vec![];
    for seed in seeds {
        if places.len() < MOST_PLACES
            && places.iter().all(|other| seed.away_px(other) > APART_SHARE * (reach_px(&seed) + reach_px(other)))
        {
            places.push(seed);
        }
    }
    places
}

/// From a joint's centre to its end, a little over \[px\].
fn reach_px(seed: &Seed) -> f64 {
    seed.half_px() + LEAST_APART_PX
}

/// The width of a wide gap between level plates; its bottom may show.
fn wide_gap_px(features: &SeamFeatures) -> Option<f64> {
    let gap_px = features.behind.u_px - features.before.u_px;
    let level = (features.behind.v_px - features.before.v_px).abs() < classify::LAP_STEP_PX;
    (level && gap_px >= WIDE_GAP_PX).then_some(gap_px)
}

/// Whether the stripe goes on through what should be a gap, without a jump: a groove's flanks and its bead do.
fn is_bridged(line: &Centreline, seed: &Seed) -> bool {
    let Some(edges) = seed.fit.edges.filter(|edges| edges.gap_px > LEAST_BRIDGED_PX) else { return false };
    let ends = [-0.5, 0.5].map(|half| seed.fit.centre.u_px + half * edges.gap_px);
    let columns = (ends[0] - BRIDGE_REACH_PX).max(0.0) as usize..(ends[1] + BRIDGE_REACH_PX) as usize;
    let width = columns.len();
    let rows: Vec<f32> = columns.filter_map(|u| line.at(u)).collect();
    let jumps = rows.windows(2).any(|pair| (pair[1] - pair[0]).abs() > LEAST_JUMP_PX);
    rows.len() as f64 > BRIDGED_SHARE * width as f64 && !jumps
}

/// The stripe beside the edges at `place`: the same for every kind that has some.
fn beside(frame: &GrayFrame, place: PixelPoint) -> Option<Learned> {
    learn(frame, place, EDGED[0])
}

/// A joint with edges where the stripe beside them was learned, fitted with the first gap of kind `tried` or the one that is
/// known; its step says which kind it is, if that is open.
fn edges(frame: &GrayFrame, learned: &Learned, gap_px: Option<f64>, tried: JointKind, open: bool) -> Option<Seed> {
    let model = JointModel { kind: tried, gap_px, ..learned.model.clone() };
    let mut seed = fitted(frame, model, learned.place)?;
    if open {
        seed.model.kind = classify::kind_with_edges(&seed);
    }
    let is_narrow = seed.fit.edges.is_some_and(|edges| edges.gap_px < LEAST_GAP_PX);
    // One side is a groove's flank.
    let is_bent = open && classify::is_corner(&seed);
    (!is_bent && (!is_narrow || seed.model.kind != JointKind::Butt)).then_some(seed)
}

/// A joint with a corner at `place`; without a kind asked for, only beyond doubt, and a V-groove where the flanks end in
/// shoulders.
fn corner(frame: &GrayFrame, line: Option<&Centreline>, place: PixelPoint, kind: Option<JointKind>) -> Option<Seed> {
    if let Some(kind) = kind {
        return refine(frame, place, kind);
    }
    let is_one = |seed: &Seed| classify::is_groove(seed) && !line.is_some_and(|line| is_two_grooves(line, seed));
    let groove = refine(frame, place, JointKind::VGroove).filter(is_one);
    groove.or_else(|| {
        let is_inside = |u_px: f64| (LEAST_LEG_PX..frame.width_px() as f64 - LEAST_LEG_PX).contains(&u_px);
        let fillet = refine(frame, place, JointKind::Fillet).filter(classify::is_corner);
        // A shoulder has a plate on one side and but a flank on the other.
        let is_long =
            |seed: &Seed| seed.fit.support > LEAST_LEG_SUPPORT && !line.is_some_and(|line| is_shoulder(line, seed));
        fillet.filter(|seed| is_inside(seed.fit.centre.u_px) && is_long(seed))
    })
}

/// How far the centreline at `u` lies off the chord over the arms on both sides \[px\]: positive where it bends up on both.
fn bend_at(line: &Centreline, u: usize) -> Option<f32> {
    let at = |u: usize| mean(line, u - 2..u + 3);
    Some(2.0 * at(u)? - at(u - CORNER_ARM_PX)? - at(u + CORNER_ARM_PX)?)
}

/// Learns the cross-section round `place` and fits it there.
fn refine(frame: &GrayFrame, place: PixelPoint, kind: JointKind) -> Option<Seed> {
    let Learned { model, place } = learn(frame, place, kind)?;
    fitted(frame, model, place)
}

/// Fits a cross-section that was learned from the same frame near `place`.
fn fitted(frame: &GrayFrame, mut model: JointModel, place: PixelPoint) -> Option<Seed> {
    let known = model.known;
    let fit_again = |model: &mut JointModel, place: PixelPoint| {
        let fit = model.fit(frame, place.u_px, 0.0, SEARCH_PX).ok().filter(|fit| fit.refusal().is_none())?;
        model.learn(&fit);
        Some(fit)
    };
    let mut fit = fit_again(&mut model, place)?;
    if model.kind == JointKind::Fillet {
        // Straight lines put on a curved plate meet with a bend. Looked at again, they bend themselves, and it goes.
        for _ in 0..CURVING_FITS {
            fit = fit_again(&mut model, fit.centre)?;
        }
        let known = [(known[0], fit.left), (known[1], fit.right)];
        let shown = |i: usize| known[i].0.with(fit.shown[i], known[i].1.curvature_per_px);
        model = JointModel { known: [shown(0), shown(1)], fits: 1, ..model };
    }
    let clear = fit.is_clear() && fit.support > CLEAR_SUPPORT;
    // Plate, shoulder, flank, flank, shoulder, plate: no large spatter looks like that.
    let flank_px = fit.support * model.half_width_px.unwrap_or(0.0);
    let certain = flank_px > COMPLETE_FLANK_PX && fit.shoulders().iter().all(Option::is_some);
    Some(Seed { clear, certain, model, fit, leg_px: 0.0 })
}

/// The strongest bends of the centreline, where its root is open, and between what may be two shoulders.
fn corners(line: &Centreline) -> Vec<PixelPoint> {
    let bend = |u: usize| bend_at(line, u).filter(|bend| bend.abs() > LEAST_CORNER_PX);
    let bends = strongest(line, CORNER_ARM_PX + 2, MOST_BENDS, bend);
    let between = between_shoulders(&bends);
    let bends = bends.into_iter().take(MOST_CORNERS).map(|(_, place)| place);
    bends.chain(open_roots(line)).chain(between).collect()
}

/// The middles of two bends to the same side: of a groove whose root does not show, as a bead lies in it. The bead may bend
/// to that side too.
fn between_shoulders(bends: &[(f32, PixelPoint)]) -> Vec<PixelPoint> {
    let mut sorted = bends.to_vec();
    sorted.sort_by(|a, b| a.1.u_px.total_cmp(&b.1.u_px));
    let pairs = [1.0, -1.0].into_iter().flat_map(|side: f32| {
        let alike: Vec<PixelPoint> = sorted.iter().filter(|(bend, _)| bend * side > 0.0).map(|(_, p)| *p).collect();
        let next = |i: usize| alike.iter().skip(i + 1).take(MOST_BETWEEN);
        alike.iter().enumerate().flat_map(|(i, a)| next(i).map(|b| (*a, *b))).collect::<Vec<_>>()
    });
    let wide = pairs.filter(|(a, b)| b.u_px - a.u_px >= LEAST_GROOVE_PX);
    wide.map(|(a, b)| PixelPoint::new(0.5 * (a.u_px + b.u_px), 0.5 * (a.v_px + b.v_px))).collect()
}

/// Where the centreline leaves the way it has on both sides: gaps too narrow and too shallow for a jump.
fn notches(line: &Centreline) -> Vec<PixelPoint> {
    let depth = |u: usize| {
        let around = [u - NOTCH_ARM_PX.end..u - NOTCH_ARM_PX.start, u + NOTCH_ARM_PX.start..u + NOTCH_ARM_PX.end];
        let [before, behind] = around.map(|columns| mean(line, columns));
        let depth = (mean(line, u - 1..u + 2)? - 0.5 * (before? + behind?)).abs();
        (depth > LEAST_NOTCH_PX).then_some(depth)
    };
    strongest(line, NOTCH_ARM_PX.end, MOST_CORNERS, depth).into_iter().map(|(_, place)| place).collect()
}

fn mean(line: &Centreline, columns: std::ops::Range<usize>) -> Option<f32> {
    let values: Vec<f32> = columns.filter_map(|u| line.at(u)).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f32>() / values.len() as f32)
}

/// The points of the centreline, `margin_px` inside it, with the largest `strength` of either sign, an arm's length apart.
fn strongest(
    line: &Centreline,
    margin_px: usize,
    most: usize,
    strength: impl Fn(usize) -> Option<f32>,
) -> Vec<(f32, PixelPoint)> {
    let inner = margin_px..line.v_px.len().saturating_sub(margin_px);
    let mut strong: Vec<(f32, usize)> = inner.filter_map(|u| Some((strength(u)?, u))).collect();
    strong.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()).then(a.1.cmp(&b.1)));
    let mut peaks: Vec<(f32, usize)> = vec![];
    for (strength, u) in strong {
        if peaks.iter().all(|(_, other)| other.abs_diff(u) > CORNER_ARM_PX) {
            peaks.push((strength, u));
        }
        if peaks.len() == most {
            break;
        }
    }
    let place = |u: usize| Some(PixelPoint::new(u as f64, f64::from(mean(line, u - 2..u + 3)?)));
    peaks.into_iter().filter_map(|(strength, u)| Some((strength, place(u)?))).collect()
}

/// The middles of the widest breaks of the centreline that may be the open root of a groove.
fn open_roots(line: &Centreline) -> Vec<PixelPoint> {
    let points: Vec<(usize, f32)> = (0..line.v_px.len()).filter_map(|u| line.at(u).map(|v| (u, v))).collect();
    let width = |pair: &&[(usize, f32)]| pair[1].0 - pair[0].0;
    let mut broken: Vec<_> = points.windows(2).filter(|pair| OPEN_ROOT_PX.contains(&width(pair))).collect();
    broken.sort_by_key(|pair| std::cmp::Reverse(width(pair)));
    let middle = |pair: &[(usize, f32)]| {
        PixelPoint::new(0.5 * (pair[0].0 + pair[1].0) as f64, 0.5 * f64::from(pair[0].1 + pair[1].1))
    };
    broken.into_iter().map(middle).take(MOST_CORNERS).collect()
}

#[cfg(test)]
mod tests;
