//! A V-groove's flanks, shoulders and plates from the stripe's brightest rows.
//!
//! Where plates are in sight they are followed inwards to the shoulders, and the flanks from there: what lies between the
//! flanks, an earlier pass's bead or an open root, is left alone. The root is where the flanks' lines meet. Without plates the
//! flanks are followed from the root outwards.

use std::ops::Range;

use super::HALF_WINDOW_PX;
use super::line::Line;
use super::peaks::{Peak, consensus_line, median};

/// Columns left out next to a closed root \[px\].
const TOE_PX: f64 = 3.0;
/// Columns left out at most at either end of a flank \[px\], and as shares of what is seen of it: shoulders are worn, and a
/// bead's toe runs out on the flank and wanders from frame to frame.
const END_PX: f64 = 5.0;
const END_SHARE: f64 = 0.12;
const TOE_SHARE: f64 = 0.25;
/// Least that must be left of it \[px\].
const LEAST_FLANK_PX: f64 = 7.0;
/// The stretch in which a V-groove's flank begins at its root \[px\], in the smallest window.
const FLANK_PX: Range<f64> = 5.0..20.0;
/// From this distance to the stripe on, a root counts as open \[px\].
const LEAST_OPEN_PX: f64 = 6.0;
/// Narrowest V-groove, root to shoulder \[px\], and the widest as a share of the window: the plates must be in it.
const LEAST_HALF_WIDTH_PX: f64 = 12.0;
const WIDEST_SHARE: f64 = 0.88;
/// The stretch of a plate behind its shoulder \[px\], in the smallest window, and by how much its slope differs from the
/// flank's at least.
const PLATE_PX: Range<f64> = 4.0..60.0;
const LEAST_SHOULDER_BEND: f64 = 0.15;
/// How often a line is fitted anew over its new length.
const GROWTH_ROUNDS: usize = 12;
/// The outer share of the window in which a plate is sought.
const OUTER_SHARE: f64 = 2.0 / 3.0;
/// First stretch of a flank behind its shoulder \[px\], in the smallest window.
const FIRST_FLANK_PX: f64 = 12.0;
/// How far off its line a flank may be, as a share of what a plate may: the concave toe of a bead leaves it slowly.
const FLANK_SHARE: f64 = 0.6;
/// A shoulder is sharp: this share of the bend lies within [`KINK_PX`] of it; on a curved plate it is spread. Chosen.
const KINK_SHARE: f64 = 0.6;
const KINK_PX: Range<f64> = 2.0..16.0;
/// Where a bead is seen beyond its toe \[px\]: it leaves the flank by a bend, as no curved plate does.
const TOE_STRETCH_PX: Range<f64> = 2.0..14.0;
/// A toe this close to the root is none: the flanks go down to it \[px\].
const BEAD_PX: f64 = 8.0;
/// Part of the groove that may be dark: an open root, not a gap with worn edges. Chosen.
const LARGEST_OPEN_SHARE: f64 = 0.4;
/// Share of the columns between a bead's toes that show it.
const BEAD_SHARE: f64 = 0.5;
/// How far below the root the stripe may lie \[px\]: the bottom of a gap lies deeper.
const ROOT_DEPTH_PX: f64 = 5.0;

/// A groove, its lines relative to the root's column.
#[derive(Debug)]
pub struct Groove {
    /// The root's distance from the seed \[px\].
    pub root_du: f64,
    pub flanks: [Line; 2],
    /// From where to where each flank is seen, from the root outwards \[px\].
    pub flanks_px: [Range<f64>; 2],
    /// From the root to the nearer shoulder \[px\], where shoulders are in sight.
    pub half_width_px: Option<f64>,
    pub plates: Option<[Line; 2]>,
}

/// One half of a groove, seen from its plate; distances are from the seed, going outwards.
struct Half {
    plate: Line,
    flank: Line,
    /// Where the flank is first seen, and where it meets the plate \[px\].
    toe_px: f64,
    shoulder_px: f64,
}

/// The groove round the seed, from its plates inwards. None where plates, shoulders and flanks are not in sight.
pub fn from_plates(peaks: &[Peak], half_window_px: f64, inlier_px: f64) -> Option<Groove> {
    let halves = [-1.0, 1.0].map(|sign| half_from_plate(peaks, sign, half_window_px, inlier_px));
    let [Some(left), Some(right)] = halves else { return None };
    let (root_du, root_v_px) = left.flank.meets(right.flank)?;
    // Both flanks go to the same side of their plates, and meet between the shoulders.
    let inwards = [left.flank.slope - left.plate.slope, right.plate.slope - right.flank.slope];
    if inwards[0] * inwards[1] <= 0.0 || root_du <= -left.shoulder_px || root_du >= right.shoulder_px {
        return None;
    }
    let outer_px = [root_du + left.shoulder_px, right.shoulder_px - root_du];
    let inner_px = [root_du + left.toe_px, right.toe_px - root_du];
    let half_width_px = outer_px[0].min(outer_px[1]);
    if half_width_px < LEAST_HALF_WIDTH_PX {
        return None;
    }
    let between = |p: &&Peak| (-left.toe_px..right.toe_px).contains(&p.du_px);
    let mut rows: Vec<f64> = peaks.iter().filter(between).map(|p| p.v_px).collect();
    let (lit, width_px) = (rows.len() as f64, left.toe_px + right.toe_px);
    let is_bead = lit > BEAD_SHARE * width_px;
    let is_open = inner_px[0].max(inner_px[1]) > BEAD_PX && !is_bead;
    if is_open && width_px > LARGEST_OPEN_SHARE * (outer_px[0] + outer_px[1]) {
        return None;
    }
    let toe_bends = |half: &Half, sign: f64| {
        let within = |p: &&Peak| TOE_STRETCH_PX.contains(&(half.toe_px - sign * p.du_px));
        let beyond = consensus_line(&peaks.iter().filter(within).copied().collect::<Vec<_>>(), inlier_px);
        beyond.is_none_or(|beyond| (beyond.slope - half.flank.slope).abs() >= LEAST_SHOULDER_BEND)
    };
    if inner_px[0].max(inner_px[1]) > BEAD_PX && !(toe_bends(&left, -1.0) && toe_bends(&right, 1.0)) {
        return None;
    }
    let below_px = |v_px: f64| (v_px - root_v_px) * inwards[0].signum();
    if median(&mut rows).is_some_and(|middle| below_px(middle) > ROOT_DEPTH_PX) {
        return None;
    }
    let flanks_px = [0, 1].map(|i| {
        let seen_px = outer_px[i] - inner_px[i];
        let end_px = (END_SHARE * seen_px).min(END_PX);
        let toe_px = (TOE_SHARE * seen_px).min(END_PX);
        let start_px = if inner_px[i] > BEAD_PX { inner_px[i] + toe_px } else { TOE_PX.max(inner_px[i]) };
        start_px..outer_px[i] - end_px
    });
    if flanks_px.iter().any(|range| range.end - range.start < LEAST_FLANK_PX) {
        return None;
    }
    // Once more without what is left out beside toe and shoulder.
    let anew = |half: &Half, sign: f64, range: &Range<f64>| {
        let within = |p: &&Peak| range.contains(&(sign * (p.du_px - root_du)));
        let seen: Vec<Peak> = peaks.iter().filter(within).copied().collect();
        consensus_line(&seen, FLANK_SHARE * inlier_px).unwrap_or(half.flank)
    };
    let flanks = [anew(&left, -1.0, &flanks_px[0]), anew(&right, 1.0, &flanks_px[1])];
    let (anew_du, _) = flanks[0].meets(flanks[1])?;
    let further_px = anew_du - root_du;
    let moved = |range: &Range<f64>, by_px: f64| (range.start + by_px).max(TOE_PX)..range.end + by_px;
    Some(Groove {
        root_du: anew_du,
        flanks: flanks.map(|flank| flank.moved(anew_du)),
        flanks_px: [moved(&flanks_px[0], further_px), moved(&flanks_px[1], -further_px)],
        half_width_px: Some((outer_px[0] + further_px).min(outer_px[1] - further_px)),
        plates: Some([left.plate.moved(anew_du), right.plate.moved(anew_du)]),
    })
}

fn half_from_plate(peaks: &[Peak], sign: f64, half_window_px: f64, inlier_px: f64) -> Option<Half> {
    let mut inwards: Vec<(f64, Peak)> = peaks.iter().map(|p| (sign * p.du_px, *p)).collect();
    inwards.sort_by(|a, b| b.0.total_cmp(&a.0));
    let line_over = |stretch: Range<f64>, inlier_px: f64| {
        let within = inwards.iter().filter(|(distance, _)| stretch.contains(distance)).map(|(_, p)| *p);
        consensus_line(&within.collect::<Vec<_>>(), inlier_px)
    };
    let mut plate = line_over(OUTER_SHARE * half_window_px..half_window_px, inlier_px)?;
    let mut edge_px = last_on(&inwards, plate, inlier_px)?;
    for _ in 0..GROWTH_ROUNDS {
        plate = line_over(edge_px..half_window_px, inlier_px)?;
        let further_px = last_on(&inwards, plate, inlier_px)?;
        if (further_px - edge_px).abs() < 1.0 {
            break;
        }
        edge_px = further_px;
    }
    let first_px = FIRST_FLANK_PX * (half_window_px / HALF_WINDOW_PX).sqrt();
    let inside = inwards.iter().position(|(distance, _)| *distance < edge_px)?;
    let straight_px = FLANK_SHARE * inlier_px;
    let mut flank = line_over(edge_px - first_px..edge_px - 1.0, straight_px)?;
    let mut toe_px = last_on(&inwards[inside..], flank, straight_px)?;
    for _ in 0..GROWTH_ROUNDS {
        let Some(longer) = line_over(toe_px..edge_px - 1.0, straight_px) else { break };
        flank = longer;
        let further_px = last_on(&inwards[inside..], flank, straight_px)?;
        if (further_px - toe_px).abs() < 1.0 {
            break;
        }
        toe_px = further_px;
    }
    let (shoulder_du, _) = flank.meets(plate)?;
    let shoulder_px = sign * shoulder_du;
    let seen = shoulder_px > toe_px && (shoulder_px - edge_px).abs() < first_px;
    (seen && is_shoulder(peaks, sign, shoulder_px, flank, plate, inlier_px)).then_some(Half {
        plate,
        flank,
        toe_px,
        shoulder_px,
    })
}

/// Whether flank and plate part by a bend at `shoulder_px`, not little by little.
fn is_shoulder(peaks: &[Peak], sign: f64, shoulder_px: f64, flank: Line, plate: Line, inlier_px: f64) -> bool {
    let line_over = |from_px: f64, to_px: f64| {
        let within = |p: &&Peak| (from_px..to_px).contains(&(sign * p.du_px - shoulder_px));
        consensus_line(&peaks.iter().filter(within).copied().collect::<Vec<_>>(), inlier_px)
    };
    let bend = (flank.slope - plate.slope).abs();
    let near = line_over(-KINK_PX.end, -KINK_PX.start).zip(line_over(KINK_PX.start, KINK_PX.end));
    let kink = near.map_or(0.0, |(inner, outer)| (inner.slope - outer.slope).abs());
    bend >= LEAST_SHOULDER_BEND && kink >= LEAST_SHOULDER_BEND.max(KINK_SHARE * bend)
}

/// The groove whose root is at the seed, from the root outwards, wherever its flanks end.
pub fn from_root(peaks: &[Peak], half_window_px: f64, inlier_px: f64) -> Option<Groove> {
    let scale = half_window_px / HALF_WINDOW_PX;
    let side = |from_px: f64, to_px: f64| {
        let part: Vec<Peak> = peaks.iter().copied().filter(|p| p.du_px > from_px && p.du_px < to_px).collect();
        consensus_line(&part, inlier_px)
    };
    let open_px = open_root(peaks);
    let first = open_px + FLANK_PX.start..open_px + FLANK_PX.end * scale;
    let (left, left_end) = grown_flank(peaks, -1.0, &first, inlier_px)?;
    let (right, right_end) = grown_flank(peaks, 1.0, &first, inlier_px)?;
    let half = left_end.min(right_end);
    let widths = LEAST_HALF_WIDTH_PX..=WIDEST_SHARE * half_window_px;
    let in_sight = widths.contains(&half);
    let half = half.clamp(*widths.start(), *widths.end());
    let (from, to) = (open_px + 4.0, half - 4.0);
    let flanks = [side(-to, -from).unwrap_or(left), side(from, to).unwrap_or(right)];
    let beside = |sign: f64, end_px: f64| {
        let (near, far) = (end_px + PLATE_PX.start * scale, end_px + PLATE_PX.end * scale);
        side((sign * near).min(sign * far), (sign * near).max(sign * far))
    };
    let plates = beside(-1.0, left_end).zip(beside(1.0, right_end)).filter(|_| in_sight);
    let plates = plates.filter(|(left, right)| {
        (flanks[0].slope - left.slope) * (right.slope - flanks[1].slope) > 0.0
            && is_shoulder(peaks, -1.0, left_end, flanks[0], *left, inlier_px)
            && is_shoulder(peaks, 1.0, right_end, flanks[1], *right, inlier_px)
    });
    let outer_px = if in_sight { half - END_PX } else { half_window_px };
    Some(Groove {
        root_du: 0.0,
        flanks,
        flanks_px: [0, 1].map(|_| open_px + TOE_PX..outer_px),
        // Flanks without an end in sight have no shoulder: then there is no half width.
        half_width_px: plates.map(|_| half),
        plates: plates.map(|(left, right)| [left, right]),
    })
}

/// How far the root is open: the distance to the stripe on the farther side \[px\], 0 where it is closed.
pub fn open_root(peaks: &[Peak]) -> f64 {
    let nearest = |sign: f64| {
        let side = peaks.iter().map(|p| sign * p.du_px).filter(|du| *du >= 0.0);
        side.fold(f64::INFINITY, f64::min)
    };
    let open_px = nearest(1.0).max(nearest(-1.0));
    if open_px < LEAST_OPEN_PX || !open_px.is_finite() { 0.0 } else { open_px }
}

/// A flank's line and where it ends, going to `sign`: from the stretch `first` next to the root outwards, as long as it
/// grows.
fn grown_flank(peaks: &[Peak], sign: f64, first: &Range<f64>, inlier_px: f64) -> Option<(Line, f64)> {
    let line_up_to = |end_px: f64| {
        let within = |p: &&Peak| (first.start..end_px).contains(&(sign * p.du_px));
        consensus_line(&peaks.iter().filter(within).copied().collect::<Vec<_>>(), inlier_px)
    };
    let mut line = line_up_to(first.end)?;
    let mut end_px = flank_end(peaks, line, sign, first, inlier_px);
    for _ in 0..GROWTH_ROUNDS {
        let Some(longer) = line_up_to(end_px) else { break };
        let longer_end_px = flank_end(peaks, longer, sign, first, inlier_px);
        if (longer_end_px - end_px).abs() < 1.0 {
            break;
        }
        (line, end_px) = (longer, longer_end_px);
    }
    Some((line, end_px))
}

/// How far from the root the columns stay on a flank's line, going to `sign` \[px\]: where the columns on it, less those
/// off it, are most, for a spatter over some columns ends no flank. Next to the root its edge may be worn.
fn flank_end(peaks: &[Peak], line: Line, sign: f64, first: &Range<f64>, inlier_px: f64) -> f64 {
    let middle_px = 0.5 * (first.start + first.end);
    let outward = peaks.iter().filter(|p| sign * p.du_px > middle_px).map(|p| (sign * p.du_px, *p));
    let mut outward: Vec<(f64, Peak)> = outward.collect();
    outward.sort_by(|a, b| a.0.total_cmp(&b.0));
    last_on(&outward, line, 2.0 * inlier_px).unwrap_or(middle_px)
}

/// How far from the seed a leg begins, going outwards to `sign` \[px\]: up to there, from outside, the columns stay on its line.
pub fn leg_begins(peaks: &[Peak], leg: Line, sign: f64, tolerance_px: f64) -> Option<f64> {
    let mut inwards: Vec<(f64, Peak)> =
        peaks.iter().map(|p| (sign * p.du_px, *p)).filter(|(distance_px, _)| *distance_px > 0.0).collect();
    inwards.sort_by(|a, b| b.0.total_cmp(&a.0));
    last_on(&inwards, leg, tolerance_px)
}

/// How far columns, in the order in which they are passed, stay on a line.
fn last_on(passed: &[(f64, Peak)], line: Line, tolerance_px: f64) -> Option<f64> {
    let (mut balance, mut best) = (0, (0, None));
    for (distance_px, peak) in passed {
        let off = (peak.v_px - line.at(peak.du_px)).abs() > tolerance_px;
        balance += if off { -1 } else { 1 };
        if balance > best.0 {
            best = (balance, Some(*distance_px));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A groove of half width 52 px and depth 50 px with its root at `root_du`, covered by `over` where that lies higher.
    fn groove(root_du: f64, over: impl Fn(f64) -> Option<f64>) -> Vec<Peak> {
        let row = |du: f64| {
            let depth = 50.0 * (1.0 - (du - root_du).abs() / 52.0);
            let bare = 200.0 + depth.max(0.0);
            // A little noise, the same in every run.
            let noise = 0.4 * (7.3 * du).sin();
            over(du - root_du).filter(|_| depth > 0.0).map_or(bare, |row| bare.min(row)) + noise
        };
        (-80..=80).map(f64::from).map(|du| Peak { du_px: du, v_px: row(du), height_grey: 100.0 }).collect()
    }

    #[test]
    fn the_root_under_a_bead_is_where_the_outer_flanks_meet() {
        let crowned = |du: f64| Some(225.0 + 4.0 * (du / 25.0).powi(2));
        let concave = |du: f64| Some(219.0 - 4.0 * (du / 31.0).powi(2));
        let one_sided = |du: f64| Some(if du > 0.0 { 215.0 } else { 232.0 });
        let beads: [&dyn Fn(f64) -> Option<f64>; 4] = [&|_| None, &crowned, &concave, &one_sided];
        for (i, bead) in beads.into_iter().enumerate() {
            for root_du in [0.0, 6.0, -9.0] {
                let found = from_plates(&groove(root_du, bead), 80.0, 1.8);
                let found = found.unwrap_or_else(|| panic!("bead {i} at {root_du}"));
                assert!((found.root_du - root_du).abs() < 1.5, "bead {i} at {root_du}: {found:?}");
                let half_width_px = found.half_width_px.unwrap();
                assert!((half_width_px - 52.0).abs() < 2.0, "bead {i} at {root_du}: {found:?}");
            }
        }
    }

    #[test]
    fn a_bead_is_left_out_of_the_flanks() {
        let found = from_plates(&groove(0.0, |_| Some(225.0)), 80.0, 1.8).unwrap();
        // The bead's top lies half-way down.
        for flank in found.flanks_px {
            assert!((26.0..32.0).contains(&flank.start) && (46.0..52.0).contains(&flank.end), "{flank:?}");
        }
    }

    #[test]
    fn neither_a_plain_stripe_nor_a_curved_one_nor_a_gap_is_a_groove() {
        let peaks = |row: &dyn Fn(f64) -> Option<f64>| -> Vec<Peak> {
            let columns = (-160..=160).map(f64::from);
            columns.filter_map(|du| Some(Peak { du_px: du, v_px: row(du)?, height_grey: 100.0 })).collect()
        };
        let plain = peaks(&|du| Some(200.0 + 0.1 * du));
        let pipe = peaks(&|du| Some(200.0 + 0.001 * du * du));
        let gap = peaks(&|du| (du.abs() > 10.0).then_some(200.0));
        let floor = peaks(&|du| Some(if du.abs() > 10.0 { 200.0 } else { 224.0 }));
        for stripe in [plain, pipe, gap, floor] {
            for half_px in [80.0, 160.0] {
                assert!(from_plates(&stripe, half_px, 1.8 * (half_px / 80.0_f64).sqrt()).is_none());
            }
        }
    }
}
