//! What the whole stripe says against a corner: it is the shoulder of a groove, or lies between two grooves.

use super::classify;
use super::seed::{LEAST_LEG_PX, Seed};
use crate::imgproc::Centreline;
use crate::imgproc::geometry::JointFit;

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
