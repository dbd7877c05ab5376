//! What is seen where a gap should be: its bottom, the plate itself, or nothing.
//!
//! A dark mark on the plate, dirt on the glass, a dead column of the sensor or a gap in the laser's line look like the gap of
//! a butt joint: the stripe is missing there. But a gap has relief. Its bottom lies off the plates' lines, or its edges are
//! bent; a mark lies on the line, and often the stripe is seen through it, only darker.

use super::peaks::median;
use super::ridge::{CrossSection, Ridge, RidgePoint, Search, ridge};
use super::{EdgeQuality, JointFit, Line};
use crate::frame::GrayFrame;

/// What a gap shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GapShows {
    /// Relief: a bottom off the plates' lines, or edges that are bent.
    Relief,
    /// The same, but the stripe goes through it unbroken: a small groove, a weld's toe, a scratch, something on the plate.
    Dip,
    /// The stripe goes on through it on the plates' lines, only darker: a mark.
    Plate,
    /// The stripe goes on through it as bright as beside it, a little off the plates' lines: something lies on the plate.
    Bump,
    /// The light falls on something level in it, about as bright as the plates and not near their lines: a bar under the gap, or a
    /// rib or a clamp that lies on one plate.
    Ledge,
    /// The stripe goes down into it and comes up again: a groove between its shoulders.
    Groove,
    /// The stripe leaves a plate's line unbroken near an edge: a groove's flank of which the rest is hidden, or the side of what
    /// lies on the plate.
    Flank,
    /// Nothing that would tell one from the other.
    Nothing,
}

/// A narrower gap shows nothing \[px\].
const LEAST_GAP_PX: f64 = 4.0;
/// Columns at either edge that belong to neither \[px\].
const EDGE_PX: f64 = 1.0;
/// Columns of the plates beside each edge that tell how bright the stripe is, and those next to the edge that tell whether it
/// is bent \[px\].
const BESIDE_PX: f64 = 24.0;
const BENT_PX: f64 = 6.0;
/// Rows above and below that are looked at \[px\]. Chosen: as deep as the sides' windows are long.
const REACH_PX: usize = 64;
/// A ridge in the gap counts from this share of the plates' amplitude, and this correlation with the stripe's cross-section.
const LEAST_SHARE: f64 = 0.12;
const LEAST_QUALITY: f64 = 0.5;
/// It is the plate's within so many SDs of the stripe of its line, a bottom's beyond so many.
const ON_LINE_SDS: f64 = 0.8;
const OFF_LINE_SDS: f64 = 1.5;
/// A column is as bright as the plates from this share of their amplitude; so many such columns side by side on the line, dark on
/// both sides, are an island of plate between two marks, or a mark and a gap.
const BRIGHT_SHARE: f64 = 0.5;
const ISLAND_PX: usize = 4;
/// What lies on the plate is at least this wide \[px\], lit in this share of its columns, and no higher than so many SDs of the
/// stripe: the bottom of a gap is a plate's thickness away, and darker. Chosen.
const LEAST_BUMP_PX: f64 = 8.0;
const BUMP_SHARE: f64 = 0.7;
const HIGHEST_BUMP_SDS: f64 = 6.0;
/// A ledge is at least so bright, as a share of the plates' amplitude, on one level in this share of a gap's columns. Chosen: a bar
/// under a gap lies in the plates' shade, at half their brightness.
const LEDGE_BRIGHTNESS: f64 = 0.7;
const LEDGE_SHARE: f64 = 0.6;
/// A groove is at least this wide \[px\] and, in the middle half, so deep in SDs of the stripe; its outer quarters are less deep than
/// this share of that. The bottom of a gap is as deep at its edges; flanks have 1/3, and up to .7 where something lies on their
/// shoulders.
const LEAST_GROOVE_PX: f64 = 16.0;
const LEAST_GROOVE_SDS: f64 = 3.0;
const FLANKS_SHARE: f64 = 0.75;
/// A flank begins on a plate beside an edge and takes the stripe unbroken at least so far off its line, in SDs of the stripe, in at
/// least so many columns. Chosen: rounded edges droop by two SDs.
const LEAST_FLANK_SDS: f64 = 3.0;
const LEAST_FLANK_PX: usize = 3;
/// From one column to the next it goes no farther than this \[px\], and speckle hides no more than so many \[px\].
const STEEPEST_STEP_PX: f64 = 3.0;
const FLANK_BREAK_PX: f64 = 3.5;
/// An unbroken stripe is seen in this share of a gap's columns; narrower gaps may be blurred together \[px\]. Chosen.
const UNBROKEN_SHARE: f64 = 0.85;
const LEAST_DIP_PX: f64 = 6.0;
/// A plate that goes on past its edge is seen on its line in this share of the columns there \[px\], as bright as this share of it;
/// how far off its line it is looked for, in SDs of the stripe. An edge is blurred over some 3 px.
const PAST_PX: std::ops::Range<f64> = 4.0..16.0;
const PAST_SHARE: f64 = 0.6;
const PAST_BRIGHTNESS: f64 = 0.4;
const PAST_BAND_SDS: f64 = 3.0;
/// By how much the plates of a step may overlap, in SDs of the stripe: beyond it, two stripes run beside one another. Chosen.
const WIDEST_OVERLAP_SDS: f64 = 2.5;
/// The edges of a step are farther apart than this where something dark lies beside it \[px\]. Chosen.
const LEAST_DIM_PX: f64 = 8.0;
/// Share of a gap's columns that decide.
const DECISIVE_SHARE: f64 = 0.5;
/// Mean distance of the columns next to an edge from their line that makes it bent, in SDs of the stripe. Chosen: three times
/// what speckle leaves of the mean of six columns.
const BENT_SDS: f64 = 0.4;

/// Looks into the gap of `fit`; of a joint without edges it says relief.
#[must_use]
pub fn gap_shows(frame: &GrayFrame, fit: &JointFit, stripe_sd_px: f64) -> GapShows {
    let Some(edges) = fit.edges else { return GapShows::Relief };
    match looked_into(frame, fit, edges, stripe_sd_px) {
        GapShows::Relief if is_unbroken(frame, fit, edges, stripe_sd_px) => GapShows::Dip,
        shows => shows,
    }
}

/// Looks at the step of `fit` between two plates: nothing speaks against it (relief), a plate goes on dark to the other's edge or both
/// overlap (plate), or one goes on bright past its own edge (nothing that would tell).
#[must_use]
pub fn step_shows(frame: &GrayFrame, fit: &JointFit, stripe_sd_px: f64) -> GapShows {
    let Some(edges) = fit.edges else { return GapShows::Relief };
    if edges.gap_px < -WIDEST_OVERLAP_SDS * stripe_sd_px {
        return GapShows::Plate;
    }
    let half_px = 0.5 * edges.gap_px;
    let section = CrossSection::new(stripe_sd_px);
    let search =
        Search { half_band_px: (PAST_BAND_SDS * stripe_sd_px).ceil() as usize, prior_sd_px: f64::from(u16::MAX) };
    for (line, edge_px, inwards) in [(fit.left, -half_px, 1.0), (fit.right, half_px, -1.0)] {
        let along = |from: f64, to: f64| {
            let ends = [edge_px + inwards * from, edge_px + inwards * to];
            ridge_between(frame, fit, line, (ends[0].min(ends[1]), ends[0].max(ends[1])), &section, search)
        };
        let mut beside: Vec<f64> = along(-BESIDE_PX, -EDGE_PX).iter().map(|p| p.amplitude).collect();
        let Some(amplitude) = median(&mut beside) else { continue };
        let goes_on = |from: f64, to: f64, share: f64| {
            let points = along(from, to);
            let off_px = |p: &RidgePoint| (p.v_px - line.at(p.u_px - fit.centre.u_px)).abs();
            let lit = |p: &&RidgePoint| {
                p.quality > LEAST_QUALITY && p.amplitude > share * amplitude && off_px(p) < ON_LINE_SDS * stripe_sd_px
            };
            !points.is_empty() && points.iter().filter(lit).count() as f64 >= PAST_SHARE * points.len() as f64
        };
        if edges.gap_px >= LEAST_DIM_PX && goes_on(EDGE_PX, edges.gap_px - EDGE_PX, LEAST_SHARE) {
            return GapShows::Plate;
        }
        let ends = (edge_px - inwards * BESIDE_PX, edge_px + inwards * PAST_PX.end);
        let side = || near(frame, fit, line, (ends.0.min(ends.1), ends.0.max(ends.1)), &section);
        if goes_on(PAST_PX.start, PAST_PX.end, PAST_BRIGHTNESS)
            || flank_columns(&side(), fit, (line, ends.0), amplitude, stripe_sd_px) >= LEAST_FLANK_PX
        {
            return GapShows::Nothing;
        }
    }
    GapShows::Relief
}

/// Whether the stripe goes on through the gap without a jump.
fn is_unbroken(frame: &GrayFrame, fit: &JointFit, edges: EdgeQuality, stripe_sd_px: f64) -> bool {
    let reach_px = 0.5 * edges.gap_px + BENT_PX;
    let middle = Line::straight(0.5 * (fit.left.v_px + fit.right.v_px), 0.5 * (fit.left.slope + fit.right.slope));
    let points = near(frame, fit, middle, (-reach_px, reach_px), &CrossSection::new(stripe_sd_px));
    let seen: Vec<&RidgePoint> = points.iter().filter(|p| p.quality > LEAST_QUALITY).collect();
    edges.gap_px >= LEAST_DIP_PX
        && seen.len() as f64 >= UNBROKEN_SHARE * points.len() as f64
        && seen
            .windows(2)
            .all(|pair| (pair[1].v_px - pair[0].v_px).abs() <= STEEPEST_STEP_PX * (pair[1].u_px - pair[0].u_px))
}

/// What lies in the gap, and how the stripe comes to its edges.
fn looked_into(frame: &GrayFrame, fit: &JointFit, edges: EdgeQuality, stripe_sd_px: f64) -> GapShows {
    let half_px = 0.5 * edges.gap_px;
    let section = CrossSection::new(stripe_sd_px);
    // Each side from its plate to the middle of the gap; what is beside the edge belongs to the plate.
    let sides = [(fit.left, -half_px - BESIDE_PX, 0.0), (fit.right, 0.0, half_px + BESIDE_PX)]
        .map(|(line, from, to)| near(frame, fit, line, (from, to), &section));
    let plates_px = [fit.centre.u_px + (-half_px - EDGE_PX), fit.centre.u_px + (half_px + EDGE_PX)];
    let beside: [Vec<RidgePoint>; 2] = [
        sides[0].iter().filter(|p| p.u_px <= plates_px[0]).copied().collect(),
        sides[1].iter().filter(|p| p.u_px >= plates_px[1]).copied().collect(),
    ];
    let amplitude = beside.iter().flatten().map(|p| p.amplitude).sum::<f64>()
        / beside.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let is_bent = |points: &[RidgePoint], line: Line| {
        let next = points.iter().filter(|p| (p.u_px - fit.centre.u_px).abs() < half_px + EDGE_PX + BENT_PX);
        let off: Vec<f64> = next.map(|p| p.v_px - line.at(p.u_px - fit.centre.u_px)).collect();
        off.len() as f64 > 0.5 * BENT_PX && (off.iter().sum::<f64>() / off.len() as f64).abs() > BENT_SDS * stripe_sd_px
    };
    let flanks_px = [
        flank_columns(&sides[0], fit, (fit.left, -half_px - BESIDE_PX), amplitude, stripe_sd_px),
        flank_columns(&sides[1], fit, (fit.right, half_px + BESIDE_PX), amplitude, stripe_sd_px),
    ];
    // With two it is a small groove all of which is seen.
    if flanks_px.contains(&0) && flanks_px.iter().any(|&columns| columns >= LEAST_FLANK_PX) {
        return GapShows::Flank;
    }
    let middle = Line::straight(0.5 * (fit.left.v_px + fit.right.v_px), 0.5 * (fit.left.slope + fit.right.slope));
    let inside = near(frame, fit, middle, (-half_px + EDGE_PX, half_px - EDGE_PX), &section);
    let columns = (edges.gap_px - 2.0 * EDGE_PX).max(1.0);
    let seen = |p: &&RidgePoint| p.quality > LEAST_QUALITY && p.amplitude > LEAST_SHARE * amplitude;
    let below_sds = |p: &RidgePoint| (p.v_px - middle.at(p.u_px - fit.centre.u_px)) / stripe_sd_px;
    let off_sds = |p: &RidgePoint| below_sds(p).abs();
    let lit = |p: &&RidgePoint| seen(p) && p.amplitude > LEDGE_BRIGHTNESS * amplitude;
    let mut below: Vec<f64> = inside.iter().filter(lit).map(below_sds).collect();
    if edges.gap_px >= LEAST_BUMP_PX
        && let Some(level_sds) = median(&mut below).filter(|level_sds| level_sds.abs() >= HIGHEST_BUMP_SDS)
        && below.iter().filter(|sds| (*sds - level_sds).abs() < OFF_LINE_SDS).count() as f64 >= LEDGE_SHARE * columns
    {
        return GapShows::Ledge;
    }
    if is_bent(&beside[0], fit.left) && is_bent(&beside[1], fit.right) {
        return GapShows::Relief;
    }
    if edges.gap_px < LEAST_GAP_PX {
        return GapShows::Nothing;
    }
    let share =
        |is: &dyn Fn(f64) -> bool| inside.iter().filter(seen).filter(|p| is(off_sds(p))).count() as f64 / columns;
    let bright = |p: &&RidgePoint| seen(p) && p.amplitude > BRIGHT_SHARE * amplitude;
    let on_plate: Vec<f64> =
        inside.iter().filter(bright).filter(|p| off_sds(p) < ON_LINE_SDS).map(|p| p.u_px - fit.centre.u_px).collect();
    if has_island(&on_plate, half_px - EDGE_PX) {
        return GapShows::Plate;
    }
    let bump = |p: &&RidgePoint| (0.0..HIGHEST_BUMP_SDS).contains(&off_sds(p));
    if edges.gap_px >= LEAST_BUMP_PX && inside.iter().filter(bright).filter(bump).count() as f64 >= BUMP_SHARE * columns
    {
        return GapShows::Bump;
    }
    let outer = |p: &RidgePoint| (p.u_px - fit.centre.u_px).abs() > 0.5 * half_px;
    let depth_sds = |is_outer: bool| {
        let mut depths: Vec<f64> = inside.iter().filter(seen).filter(|p| outer(p) == is_outer).map(&off_sds).collect();
        let is_enough = depths.len() as f64 >= 0.5 * DECISIVE_SHARE * columns;
        median(&mut depths).filter(|_| is_enough)
    };
    if edges.gap_px >= LEAST_GROOVE_PX
        && let Some((rim, bottom)) = depth_sds(true).zip(depth_sds(false))
        && bottom > LEAST_GROOVE_SDS
        && rim < FLANKS_SHARE * bottom
    {
        return GapShows::Groove;
    }
    if share(&|sds| sds > OFF_LINE_SDS) >= DECISIVE_SHARE {
        GapShows::Relief
    } else if share(&|sds| sds < ON_LINE_SDS) >= DECISIVE_SHARE {
        GapShows::Plate
    } else {
        GapShows::Nothing
    }
}

/// Columns of a side in which the stripe, unbroken, is off the plate's `line`, counted from the plate: from `first_px` of the centre.
fn flank_columns(
    side: &[RidgePoint],
    fit: &JointFit,
    (line, first_px): (Line, f64),
    amplitude: f64,
    stripe_sd_px: f64,
) -> usize {
    let lit = side.iter().filter(|p| p.quality > LEAST_QUALITY && p.amplitude > LEAST_SHARE * amplitude);
    let off = |p: &RidgePoint| {
        let du_px = p.u_px - fit.centre.u_px;
        ((du_px - first_px).abs(), p.v_px - line.at(du_px))
    };
    let mut from_plate: Vec<(f64, f64)> = lit.map(off).collect();
    from_plate.sort_by(|a, b| a.0.total_cmp(&b.0));
    columns_off(&from_plate, stripe_sd_px)
}

/// Columns far off a plate's line until the stripe breaks, given in order by their distance from the first one and from that line.
fn columns_off(columns: &[(f64, f64)], stripe_sd_px: f64) -> usize {
    let mut last = (0.0, 0.0);
    let mut far = 0;
    for &(along, off) in columns {
        if along - last.0 > FLANK_BREAK_PX || (off - last.1).abs() > STEEPEST_STEP_PX * (along - last.0).max(1.0) {
            break;
        }
        last = (along, off);
        far += usize::from(off.abs() >= LEAST_FLANK_SDS * stripe_sd_px);
    }
    far
}

/// Whether enough of `columns` lie side by side, none of them next to an edge `half_px` away.
fn has_island(columns: &[f64], half_px: f64) -> bool {
    let mut run = 0;
    let mut last = f64::NEG_INFINITY;
    let mut first = 0.0;
    columns.iter().any(|&u| {
        (run, first) = if u - last < 1.5 { (run + 1, first) } else { (1, u) };
        last = u;
        run >= ISLAND_PX && first > EDGE_PX + 1.0 - half_px && u < half_px - EDGE_PX - 1.0
    })
}

/// The brightest ridge of each column from `from` to `to` of the centre \[px\], wherever it lies.
fn near(frame: &GrayFrame, fit: &JointFit, line: Line, between_px: (f64, f64), section: &CrossSection) -> Ridge {
    let search = Search { half_band_px: REACH_PX, prior_sd_px: f64::from(u16::MAX) };
    ridge_between(frame, fit, line, between_px, section, search)
}

/// The ridge along `line` in the columns from `from` to `to` of the centre \[px\], as far as they are in the picture.
fn ridge_between(
    frame: &GrayFrame,
    fit: &JointFit,
    line: Line,
    (from, to): (f64, f64),
    section: &CrossSection,
    search: Search,
) -> Ridge {
    let first = (fit.centre.u_px + from).ceil().max(0.0) as usize;
    let end = ((fit.centre.u_px + to).floor().max(-1.0) + 1.0).min(frame.width_px() as f64) as usize;
    ridge(frame, first..end.max(first), |u| line.at(u - fit.centre.u_px), section, search)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imgproc::geometry::{JointKind, learn};
    use crate::units::PixelPoint;

    const STRIPE_ROW: f64 = 120.0;

    /// A picture whose stripe has `row(u)` and `grey(u)`.
    fn drawn(row: impl Fn(f64) -> f64, grey: impl Fn(f64) -> f64) -> GrayFrame {
        let mut frame = GrayFrame::filled(320, 240, 9).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 320) as f64, (i / 320) as f64);
            let noise = ((i * 7919) % 13) as f64 / 6.0;
            *pixel = (9.0 + noise + grey(u) * (-0.5 * ((v - row(u)) / 2.4).powi(2)).exp()).min(255.0) as u8;
        }
        frame
    }

    /// What the gap of 14 px in the middle of such a picture shows.
    fn shown(row: impl Fn(f64) -> f64, grey: impl Fn(f64) -> f64) -> GapShows {
        let frame = drawn(row, grey);
        let model = learn(&frame, PixelPoint::new(160.0, STRIPE_ROW), JointKind::Butt).unwrap().model;
        let fit = model.fit(&frame, 160.0, 0.0, 12.0).unwrap();
        assert!((fit.centre.u_px - 160.0).abs() < 1.5, "{fit:?}");
        gap_shows(&frame, &fit, model.stripe_sd_px)
    }

    fn in_gap(u: f64) -> bool {
        (u - 160.0).abs() < 7.0
    }

    #[test]
    fn a_bottom_below_the_plates_is_relief() {
        let row = |u: f64| if in_gap(u) { STRIPE_ROW + 24.0 } else { STRIPE_ROW };
        assert_eq!(shown(row, |u| if in_gap(u) { 80.0 } else { 200.0 }), GapShows::Relief);
    }

    #[test]
    fn a_rib_on_the_plates_as_bright_as_they_are_is_a_ledge() {
        let row = |u: f64| if in_gap(u) { STRIPE_ROW - 18.0 } else { STRIPE_ROW };
        assert_eq!(shown(row, |_| 200.0), GapShows::Ledge);
        assert_eq!(shown(row, |u| if in_gap(u) { 100.0 } else { 200.0 }), GapShows::Relief, "a bar in the shade");
    }

    #[test]
    fn bent_edges_are_relief_though_the_gap_is_black() {
        let droop = |u: f64| 4.0 * (-((u - 160.0).abs() - 7.0).max(0.0) / 8.0).exp();
        assert_eq!(shown(|u| STRIPE_ROW + droop(u), |u| if in_gap(u) { 0.0 } else { 200.0 }), GapShows::Relief);
    }

    #[test]
    fn a_dark_mark_shows_the_plate() {
        // A brighter one has no edges to speak of: its fit leaves the place open.
        assert_eq!(shown(|_| STRIPE_ROW, |u| if in_gap(u) { 28.0 } else { 200.0 }), GapShows::Plate);
    }

    #[test]
    fn a_groove_between_its_shoulders_is_no_gap() {
        let row = |u: f64| if in_gap(u) { STRIPE_ROW + 3.0 * (7.0 - (u - 160.0).abs()) } else { STRIPE_ROW };
        assert_eq!(shown(row, |u| if in_gap(u) { 60.0 } else { 200.0 }), GapShows::Relief, "too narrow to tell");
    }

    #[test]
    fn a_stripe_that_goes_on_through_an_edge_is_a_flank_and_no_gap() {
        let gap = drawn(|_| STRIPE_ROW, |u| if in_gap(u) { 0.0 } else { 200.0 });
        let model = learn(&gap, PixelPoint::new(160.0, STRIPE_ROW), JointKind::Butt).unwrap().model;
        let fit = model.fit(&gap, 160.0, 0.0, 12.0).unwrap();
        let flank = |u: f64| STRIPE_ROW + 1.6 * (u - 153.0).clamp(0.0, 14.0);
        let half_hidden = |u: f64| if in_gap(u) && u > 161.0 { 0.0 } else { 200.0 };
        let row = |u: f64| if u > 167.0 { STRIPE_ROW } else { flank(u) };
        assert_eq!(gap_shows(&drawn(row, half_hidden), &fit, model.stripe_sd_px), GapShows::Flank);
    }

    #[test]
    fn what_lies_on_the_plate_is_a_bump_and_plate_between_two_marks_an_island() {
        // The place of a gap is known; what is there is another thing.
        let gap = drawn(|_| STRIPE_ROW, |u| if in_gap(u) { 0.0 } else { 200.0 });
        let model = learn(&gap, PixelPoint::new(160.0, STRIPE_ROW), JointKind::Butt).unwrap().model;
        let fit = model.fit(&gap, 160.0, 0.0, 12.0).unwrap();
        let seen = |frame: &GrayFrame| gap_shows(frame, &fit, model.stripe_sd_px);
        let row = |u: f64| if in_gap(u) { STRIPE_ROW - 8.0 } else { STRIPE_ROW };
        assert_eq!(seen(&drawn(row, |_| 200.0)), GapShows::Bump);
        let island = |u: f64| if in_gap(u) && (u - 160.0).abs() > 2.6 { 0.0 } else { 200.0 };
        assert_eq!(seen(&drawn(|_| STRIPE_ROW, island)), GapShows::Plate);
    }

    /// What is shown, with `grey(u)` on its plates, by a step of 24 px in the middle of a picture, fitted where they are `fitted(u)`.
    fn step(fitted: impl Fn(f64) -> f64, grey: impl Fn(f64) -> f64) -> GapShows {
        let row = |u: f64| if u < 160.0 { STRIPE_ROW } else { STRIPE_ROW + 24.0 };
        let frame = drawn(row, fitted);
        let model = learn(&frame, PixelPoint::new(160.0, STRIPE_ROW), JointKind::Lap).unwrap().model;
        let fit = model.fit(&frame, 160.0, 0.0, 12.0).unwrap();
        step_shows(&drawn(row, grey), &fit, model.stripe_sd_px)
    }

    #[test]
    fn a_step_between_two_plates_is_relief_with_a_shadow_beside_it_too() {
        let shadow = |u: f64| if (160.0..172.0).contains(&u) { 0.0 } else { 200.0 };
        assert_eq!(step(|_| 200.0, |_| 200.0), GapShows::Relief);
        assert_eq!(step(shadow, shadow), GapShows::Relief);
    }

    #[test]
    fn a_step_beside_which_a_plate_is_only_dark_shows_the_plate() {
        let black = |u: f64| if (160.0..176.0).contains(&u) { 0.0 } else { 200.0 };
        let dark = |u: f64| if (160.0..176.0).contains(&u) { 40.0 } else { 200.0 };
        assert_eq!(step(black, dark), GapShows::Plate);
    }

    #[test]
    fn a_dead_block_of_the_sensor_shows_nothing() {
        assert_eq!(shown(|_| STRIPE_ROW, |u| if in_gap(u) { 0.0 } else { 200.0 }), GapShows::Nothing);
    }
}
