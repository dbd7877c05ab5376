//! What the arc does to the whole image: glare, smoke and its haze, covers.

use rand::Rng;

use super::canvas::Canvas;
use super::noise::{Component, SmoothNoise, generator};
use super::scenario::{Arc, Side, Smoke};
use crate::units::{PixelPoint, StripeAxis};

/// Distance of the arc from the border, as a fraction of the image's shorter side (chosen).
const ARC_DISTANCE: f64 = 0.12;
/// Frames in which the smoke's pattern moves by its own size (chosen).
const SMOKE_FRAMES: f64 = 2.2;

/// The light of the arc in a scene.
#[derive(Debug, Clone)]
pub(super) struct ArcLight {
    /// Where the arc is, in the stripe's frame.
    pub(super) position: PixelPoint,
    glare_grey: f64,
    half_distance_px: f64,
    border_px: f64,
}

impl ArcLight {
    /// The arc beside an image of `width_px` × `height_px` (in the stripe's frame), near the path's middle `along_px`.
    pub(super) fn new(arc: &Arc, axis: StripeAxis, width_px: usize, height_px: usize, along_px: f64) -> Self {
        let (width, height) = (width_px as f64, height_px as f64);
        let shorter = width.min(height);
        let border_px = ARC_DISTANCE * shorter;
        let side = match (axis, arc.side) {
            (StripeAxis::Horizontal, side) => side,
            (StripeAxis::Vertical, Side::Top) => Side::Left,
            (StripeAxis::Vertical, Side::Left) => Side::Top,
            (StripeAxis::Vertical, Side::Bottom) => Side::Right,
            (StripeAxis::Vertical, Side::Right) => Side::Bottom,
            (StripeAxis::Vertical, Side::Any) => Side::Any,
        };
        let position = match side {
            Side::Any | Side::Bottom => PixelPoint::new(along_px, height + border_px),
            Side::Top => PixelPoint::new(along_px, -border_px),
            Side::Left => PixelPoint::new(-border_px, 0.5 * height),
            Side::Right => PixelPoint::new(width + border_px, 0.5 * height),
        };
        Self { position, glare_grey: arc.glare_grey, half_distance_px: arc.reach * shorter, border_px }
    }

    /// Adds glare of a relative brightness.
    pub(super) fn add_glare(&self, flicker: f64, canvas: &mut Canvas) {
        if self.glare_grey * flicker < 0.05 {
            return;
        }
        let reach2 = self.half_distance_px * self.half_distance_px;
        // Normalised so that the nearest point of the border receives the stated glare.
        let peak = self.glare_grey * flicker * (1.0 + self.border_px * self.border_px / reach2);
        let glare = |x: f64, y: f64| {
            let distance2 = (x - self.position.u_px).powi(2) + (y - self.position.v_px).powi(2);
            (peak / (1.0 + distance2 / reach2)) as f32
        };
        canvas.change_by_field(8, glare, |glare, value| *value += glare);
    }
}

/// Dims the canvas by smoke of a mean opacity and adds what the smoke scatters.
pub(super) fn add_smoke(smoke: &Smoke, opacity: f64, flicker: f64, seed: u64, tick: usize, canvas: &mut Canvas) {
    if opacity < 0.003 {
        return;
    }
    let noise = SmoothNoise::new(seed, Component::Smoke, 0);
    let time = tick as f64 / SMOKE_FRAMES;
    // Beer and Lambert: light falls exponentially with the smoke's optical depth.
    let depth = -(1.0 - opacity as f32).ln();
    let wisps = |x: f64, y: f64| {
        let pattern = noise.cloud(x / smoke.wisp_px, y / smoke.wisp_px + 0.3 * time, time);
        1.0 - (-depth * (1.0 + 0.6 * pattern).max(0.0)).exp()
    };
    let haze = (smoke.haze_grey * flicker.max(0.2)) as f32;
    canvas.change_by_field(8, wisps, |opacity, value| *value += opacity * (haze - *value));
}

/// Hides the seam at `along_px`, `across_px` completely; `number` decides the look of this cover.
pub(super) fn add_cover(
    half_width_px: f64,
    number: u64,
    seam: PixelPoint,
    seed: u64,
    tick: usize,
    canvas: &mut Canvas,
) {
    let mut rng = generator(seed, number, Component::Cover);
    let glowing = rng.random_bool(0.5);
    let grey: f32 = if glowing { rng.random_range(180.0..420.0) } else { rng.random_range(4.0..60.0) };
    let off_centre = half_width_px * rng.random_range(-0.25..0.25);
    let half_height_px = (half_width_px * rng.random_range(0.6..1.6)).max(60.0);
    let noise = SmoothNoise::new(seed, Component::Cover, number);
    let time = tick as f64 / 2.0;
    let mask = |x: f64, y: f64| {
        let along = (x - seam.u_px - off_centre) / half_width_px;
        let across = (y - seam.v_px) / half_height_px;
        let radius = (along * along + across * across).sqrt() + 0.12 * f64::from(noise.cloud(x / 50.0, y / 50.0, time));
        ((1.15 - radius) / 0.3).clamp(0.0, 1.0) as f32
    };
    let texture = |x: f64, y: f64| grey * (1.0 + 0.2 * noise.cloud(x / 40.0, y / 40.0, time + 50.0)).max(0.2);
    // Both fields travel in one number: the mask's sign-free value in 0..1 selects, the texture is added in place.
    canvas.change_by_field(8, mask, |mask, value| *value *= 1.0 - mask);
    canvas.change_by_field(8, |x, y| mask(x, y) * texture(x, y), |light, value| *value += light);
}
