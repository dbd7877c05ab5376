//! What the whole stripe says against a joint: a corner is the shoulder of a groove, or lies between two grooves; a gap is the toe
//! of what lies on the plates.

use std::ops::Range;

use super::classify;
use super::seed::{LEAST_LEG_PX, Seed};
use crate::imgproc::Centreline;
use crate::imgproc::geometry::{JointFit, Line};

/// Beyond a groove's flank the stripe is nearer to the other plate's line than this share of the angle's opening, in at least so many
/// columns \[px\] of so many windows. Chosen: plates beside a groove are level to a third of its depth.
const BACK_SHARE: f64 = 0.35;
const LEAST_BACK_PX: usize = 20;
const SHOULDER_WINDOWS: f64 = 3.0;
/// What parts two grooves lies in this middle share of the outer flanks' width, no deeper than this share of the less deep of
/// them, in so many columns \[px\], and they are so many SDs of the stripe deep. Chosen: beads lie deeper, or fill their groove.
const RIDGE_SHARE: f64 = 0.5;
const RIDGE_DEPTH_SHARE: f64 = 0.4;
const LEAST_TURN_PX: usize = 5;
const LEAST_TWO_SDS: f64 = 5.0;

/// What lies on the plates leaves the line of the plate beyond its toe by more than so many SDs of the stripe in at least so many
/// columns \[px\], and beyond its other toe the stripe is back within them in as many. Chosen: speckle leaves a third of an SD;
/// a second seam is narrower.
const LYING_SDS: f64 = 1.4;
const LEAST_LYING_PX: usize = 20;

/// The same in \[px\] where the stripe's SD is not known, and how far from a hairline it is looked for \[px\]. Chosen: a stripe of SD 2.2 px,
/// and twice a hairline's own surroundings; a bead's cap is wider than it is away.
const LYING_PX: f64 = 3.0;
const HAIRLINE_REACH_PX: f64 = 160.0;

/// Whether on one side of what should be a gap something lies, beyond which the other side's plate goes on: a bead's cap, of which
/// the gap is a toe.
pub fn is_toe(line: &Centreline, seed: &Seed) -> bool {
    let JointFit { centre, left, right, .. } = seed.fit;
    let off_px = LYING_SDS * seed.model.stripe_sd_px;
    let from_px = 0.5 * seed.gap_px()..SHOULDER_WINDOWS * seed.model.half_window_px;
    [(1.0, left), (-1.0, right)].into_iter().any(|(sign, plate)| {
        lies_beside(line, centre.u_px, sign, &from_px, off_px, |du| Some(plate.v_px + plate.slope * du))
    })
}

/// The same of what should be a hairline at `u_px` in a stripe on the line `row`.
pub fn is_toe_of_hairline(line: &Centreline, u_px: f64, row: impl Fn(f64) -> Option<f64>) -> bool {
    let on_line = |du: f64| row(u_px + du);
    [1.0, -1.0].into_iter().any(|sign| lies_beside(line, u_px, sign, &(0.0..HAIRLINE_REACH_PX), LYING_PX, on_line))
}

/// Whether going to `sign` from `u_px` the stripe leaves the line `row`, given by the distance from there, and comes back to it.
fn lies_beside(
    line: &Centreline,
    u_px: f64,
    sign: f64,
    from_px: &Range<f64>,
    off_px: f64,
    row: impl Fn(f64) -> Option<f64>,
) -> bool {
    let (mut lying, mut back) = (0, 0);
    let mut away_px = from_px.start;
    while away_px < from_px.end && back < LEAST_LYING_PX {
        let du = sign * away_px;
        away_px += 1.0;
        let seen = if u_px + du < 0.0 { None } else { line.at((u_px + du) as usize) };
        let Some((v_px, plate_px)) = seen.zip(row(du)) else { continue };
        match ((f64::from(v_px) - plate_px).abs() > off_px, lying >= LEAST_LYING_PX) {
            (true, _) => (lying, back) = (lying + 1, 0),
            (false, true) => back += 1,
            (false, false) => {}
        }
    }
    back >= LEAST_LYING_PX
}

/// Whether beyond a leg of what should be a fillet the stripe lies on the other leg's line again: the leg is a groove's flank, and the
/// corner its shoulder.
pub fn is_shoulder(line: &Centreline, seed: &Seed) -> bool {
    let JointFit { centre, left, right, .. } = seed.fit;
    let far_px = SHOULDER_WINDOWS * seed.model.half_window_px;
    let is_back = |u: usize| {
        let du = u as f64 - centre.u_px;
        let (leg, other) = if du > 0.0 { (right, left) } else { (left, right) };
        let opening_px = (leg.at(du) - other.at(du)).abs();
        du.abs() > LEAST_LEG_PX
            && line.at(u).is_some_and(|v| (f64::from(v) - other.at(du)).abs() < BACK_SHARE * opening_px)
    };
    let first = (centre.u_px - far_px).max(0.0) as usize;
    let end = ((centre.u_px + far_px) as usize).min(line.v_px.len());
    (first..end).filter(|&u| is_back(u)).count() >= LEAST_BACK_PX
}

/// How far the shorter of a corner's legs goes \[px\]: along its line, until the stripe has left it.
pub fn shorter_leg_px(line: &Centreline, seed: &Seed) -> f64 {
    let JointFit { centre, left, right, .. } = seed.fit;
    let off_px = LYING_SDS * seed.model.stripe_sd_px;
    let leg_px = |leg: Line, sign: f64| {
        let (mut end_px, mut away_px) = (0.0, 0.0);
        while away_px - end_px < LEAST_LYING_PX as f64 {
            away_px += 1.0;
            let u_px = centre.u_px + sign * away_px;
            let seen = if u_px < 0.0 { None } else { line.at(u_px as usize) };
            if seen.is_some_and(|v_px| (f64::from(v_px) - leg.at(sign * away_px)).abs() < off_px) {
                end_px = away_px;
            }
        }
        end_px
    };
    leg_px(left, -1.0).min(leg_px(right, 1.0))
}

/// Whether the stripe comes back to the plates between two depths: the outer flanks of two grooves meet below both.
pub fn is_two_grooves(line: &Centreline, seed: &Seed) -> bool {
    let (Some([left, right]), Some(half_px)) = (seed.model.plates, seed.model.half_width_px) else { return false };
    let down = classify::bend(seed).signum();
    let depth_px = |u: usize| {
        let du = u as f64 - seed.fit.centre.u_px;
        let share = (0.5 + 0.5 * du / half_px).clamp(0.0, 1.0);
        line.at(u).map(|v| down * (f64::from(v) - (1.0 - share) * left.at(du) - share * right.at(du)))
    };
    // Depths and heights of a few columns: of single ones spatter would decide.
    let depths = |from: f64, to: f64| {
        let first = (seed.fit.centre.u_px + from * half_px).max(0.0) as usize;
        let end = (seed.fit.centre.u_px + to * half_px).max(0.0) as usize;
        let mut depths: Vec<f64> = (first..end.min(line.v_px.len())).filter_map(depth_px).collect();
        depths.sort_by(f64::total_cmp);
        depths
    };
    let deep = |depths: Vec<f64>| depths.len().checked_sub(LEAST_TURN_PX).and_then(|i| depths.get(i).copied());
    let outer = deep(depths(-1.0, 0.0)).zip(deep(depths(0.0, 1.0)));
    let ridge_px = depths(-RIDGE_SHARE, RIDGE_SHARE).get(LEAST_TURN_PX).copied();
    outer.zip(ridge_px).is_some_and(|((left_px, right_px), ridge_px)| {
        let deep_px = left_px.min(right_px);
        deep_px > LEAST_TWO_SDS * seed.model.stripe_sd_px && ridge_px < RIDGE_DEPTH_SHARE * deep_px
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a hairline at column 300 of a level stripe in row 100, off by `off(u)`, is the toe of something.
    fn is_toe_in(off: impl Fn(f64) -> f64) -> bool {
        let line = Centreline { v_px: (0..640).map(|u| Some((100.0 + off(f64::from(u))) as f32)).collect() };
        is_toe_of_hairline(&line, 300.0, |_| Some(100.0))
    }

    #[test]
    fn beside_a_cap_on_which_the_stripe_comes_back_there_is_no_hairline() {
        let cap = |u: f64| if (302.0..400.0).contains(&u) { -6.0 + 9.0 * ((u - 351.0) / 49.0).powi(2) } else { 0.0 };
        assert!(is_toe_in(cap));
        assert!(is_toe_in(|u| cap(600.0 - u)));
        assert!(!is_toe_in(|_| 0.0));
        assert!(!is_toe_in(|u| 0.0005 * (u - 300.0).powi(2)), "a curved plate does not come back");
        assert!(!is_toe_in(|u| if (320.0..330.0).contains(&u) { -8.0 } else { 0.0 }), "a spatter is small");
    }
}
