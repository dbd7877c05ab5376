//! Branches of light that are not the joint's: reflections, other stripes.

use super::noise::{Component, SmoothNoise};
use super::profile::{Branch, branch, edge};
use super::scenario::{OtherStripe, Reflection, SeamSide};
use super::stripe::END_BLUR_PX;
use crate::units::PixelPoint;

/// Length over which a reflection comes and goes \[px, frames\] (chosen: rolled sheet).
const PATCH_PX: f64 = 18.0;
const PATCH_FRAMES: f64 = 7.0;
/// Lengths over which a reflection begins and fades, relative to its own (chosen: brightest at the corner, where the
/// plates are close).
const BEGIN_SHARE: f64 = 0.08;
const FADE_SHARE: f64 = 0.6;

/// The reflection of one plate in the other, beside a seam.
pub(super) fn reflection(
    reflection: &Reflection,
    number: u64,
    columns: usize,
    seam: PixelPoint,
    tick: f64,
    seed: u64,
) -> Branch {
    let patches = SmoothNoise::new(seed, Component::Rivals, number);
    let sign = match reflection.side {
        SeamSide::Left => -1.0,
        SeamSide::Right => 1.0,
    };
    let [begin, fade] = [BEGIN_SHARE, FADE_SHARE].map(|share| (share * reflection.length_px).max(1.0));
    branch(columns, |x| {
        let out = sign * (x - seam.u_px) - reflection.from_px;
        let ends = (out / begin).clamp(0.0, 1.0) * ((reflection.length_px - out) / fade).clamp(0.0, 1.0);
        let patch = reflection.patchiness * f64::from(patches.at(out / PATCH_PX, tick / PATCH_FRAMES, 0.0));
        let row = seam.v_px + reflection.below_px + reflection.slope * out;
        (row, reflection.strength * ends * patch.exp(), reflection.width)
    })
}

/// A stripe on another surface, `row_px` being the plates' mean row.
pub(super) fn other_stripe(stripe: &OtherStripe, columns: usize, row_px: f64) -> Branch {
    let length = columns as f64;
    let [from, to] = stripe.extent.map(|share| share * length);
    // What reaches the image's border goes on beyond it.
    let begin = move |x: f64| if from <= 0.0 { 1.0 } else { edge(x - from, END_BLUR_PX) };
    let end = move |x: f64| if to >= length { 1.0 } else { edge(to - x, END_BLUR_PX) };
    branch(columns, |x| {
        let row = row_px + stripe.below_px + stripe.tilt * (x - 0.5 * length);
        (row, stripe.brightness * begin(x) * end(x), stripe.width)
    })
}
