//! The stripe of a whole frame: its centreline, whether it is straight, and whether nothing else shines.

use crate::frame::GrayFrame;
use crate::imgproc::{Centreline, CentrelineSettings, extract_along, extract_centreline, stripe_path};

/// A frame is calm when the pixels off the stripe that are as bright as half of it are fewer than this share of those on it:
/// no spatter, no glare. Chosen: 30 px in a picture of 640 columns.
pub const CALM_SHARE: f64 = 0.008;
/// What counts as off the stripe \[px\].
pub const OFF_STRIPE_PX: f32 = 15.0;
/// A hairline lies in one straight stripe: this share of the columns near it must lie on the stripe's line.
pub const STRAIGHT_SHARE: f64 = 0.75;
pub const STRAIGHT_REACH_PX: usize = 40;
pub const STRAIGHT_TOLERANCE_PX: f64 = 3.5;

/// The stripe's centre in each column, along its likeliest path through the frame where `by_path`.
pub fn centreline(frame: &GrayFrame, by_path: bool) -> Centreline {
    match stripe_path(frame).filter(|_| by_path) {
        Some(path) => extract_along(frame, &CentrelineSettings::default(), &path),
        None => extract_centreline(frame, &CentrelineSettings::default()),
    }
}

/// Whether nothing but the stripe shines.
pub fn is_calm(frame: &GrayFrame, line: &Centreline) -> bool {
    let peaks = line.v_px.iter().enumerate().filter_map(|(u, v)| v.map(|v| (u, v)));
    let mut stripe: Vec<u8> = peaks.clone().map(|(u, v)| frame.at_clamped(u as isize, v.round() as isize)).collect();
    if stripe.is_empty() {
        return false;
    }
    let middle = stripe.len() / 2;
    let bright = *stripe.select_nth_unstable(middle).1 / 2;
    let (mut on_stripe, mut off_stripe) = (0usize, 0usize);
    for v in 0..frame.height_px() {
        let row = frame.row(v).iter().enumerate();
        for (u, _) in row.filter(|(_, grey)| **grey >= bright) {
            let is_on = line.at(u).is_some_and(|at| (v as f32 - at).abs() <= OFF_STRIPE_PX);
            *(if is_on { &mut on_stripe } else { &mut off_stripe }) += 1;
        }
    }
    (off_stripe as f64) < CALM_SHARE * on_stripe as f64
}

/// Share of the columns near `u_px` whose centre lies on the stripe's line.
pub fn straight_share(line: &Centreline, u_px: f64, stripe_v_px: impl Fn(f64) -> Option<f64>) -> f64 {
    let centre = u_px.round().max(0.0) as usize;
    let near = centre.saturating_sub(STRAIGHT_REACH_PX)..centre + STRAIGHT_REACH_PX + 1;
    let on_line = |u: usize| {
        let (Some(v), Some(expected)) = (line.at(u), stripe_v_px(u as f64)) else { return false };
        (f64::from(v) - expected).abs() < STRAIGHT_TOLERANCE_PX
    };
    let count = near.len() as f64;
    near.filter(|&u| on_line(u)).count() as f64 / count
}
