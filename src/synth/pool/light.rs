//! The light of a pool and of what surrounds it.

use super::scenario::Light;
use super::shape::Shape;
use crate::synth::canvas::Canvas;
use crate::synth::noise::{Component, SmoothNoise};

/// Hot spot: standard deviations as parts of the pool's length and width (chosen: the keyhole and what it heats).
const HOT_SPOT_PART: f64 = 0.16;
/// Plume: standard deviations across and along, as parts of the pool's width, and its middle, in pool lengths before
/// the pool's middle (chosen: it leans forward over the front).
const PLUME_PARTS: (f64, f64) = (0.45, 0.7);
const PLUME_AHEAD: f64 = 0.45;
/// The track behind the pool cools over this part of the pool's length (chosen).
const TRACK_PART: f64 = 0.8;
/// Half the width of the seam's reflection \[px\] (chosen).
const SEAM_HALF_WIDTH_PX: f64 = 1.2;
/// Size of the plume's wisps \[px\], and frames in which they change (chosen).
const WISP_PX: f64 = 28.0;
const WISP_FRAMES: f64 = 6.0;

/// A pool on a canvas.
pub(super) struct Scene<'a> {
    pub(super) light: &'a Light,
    pub(super) shape: Shape,
    /// The pool's middle on the canvas.
    pub(super) middle: [f64; 2],
    pub(super) length_px: f64,
    pub(super) width_px: f64,
    /// Where the seam runs across, from the pool's middle \[px\].
    pub(super) seam_px: f64,
    pub(super) raggedness: (f64, f64),
    /// The light of the pool relative to that in the scenario.
    pub(super) emissivity: f64,
    pub(super) seed: u64,
    pub(super) frame: usize,
}

impl Scene<'_> {
    /// Paints surroundings and pool, blurred by the optics; then the plume, which has no edge.
    pub(super) fn paint(&self, canvas: &mut Canvas, with_pool: bool) {
        let light = self.light;
        let last = (canvas.width_px() - 1).max(1) as f64;
        let ragged = SmoothNoise::new(self.seed, Component::Outline, self.frame as u64);
        let front = self.middle[1] + self.shape.tip()[1];
        canvas.change(|column, row, value| {
            let (x, y) = (column as f64 - self.middle[0], row as f64 - self.middle[1]);
            let mut grey = light.background_grey + light.gradient_grey * (column as f64 / last - 0.5);
            let beside = (x - self.seam_px).abs();
            if light.seam_grey > 0.0 && (row as f64) < front && beside < 4.0 * SEAM_HALF_WIDTH_PX {
                grey += light.seam_grey * (-0.5 * (beside / SEAM_HALF_WIDTH_PX).powi(2)).exp();
            }
            if with_pool {
                let behind = y / (TRACK_PART * self.length_px);
                if light.track_grey > 0.0 && behind > 0.0 {
                    let inside = coverage(x.abs() - 0.45 * self.width_px);
                    grey += self.emissivity * light.track_grey * inside * (-behind).exp();
                }
                let share = self.share(&ragged, x, y);
                if share > 0.0 {
                    let (u, v) = (x / (HOT_SPOT_PART * self.width_px), y / (HOT_SPOT_PART * self.length_px));
                    let hot = light.hot_spot_grey * (-0.5 * (u * u + v * v)).exp();
                    grey += share * (self.emissivity * (light.pool_grey + hot) - grey);
                }
            }
            *value = grey as f32;
        });
        canvas.blur(light.blur_px as f32);
        if with_pool && light.plume_grey > 0.0 {
            self.add_plume(canvas);
        }
    }

    /// How much of a pixel the pool covers.
    fn share(&self, ragged: &SmoothNoise, x: f64, y: f64) -> f64 {
        let distance = self.shape.distance_px(x, y);
        let (raggedness, length) = self.raggedness;
        if distance.abs() > 4.0 * raggedness + 1.0 {
            return if distance < 0.0 { 1.0 } else { 0.0 };
        }
        if raggedness == 0.0 {
            return coverage(distance);
        }
        coverage(distance + raggedness * f64::from(ragged.cloud(x / length, y / length, 0.0)))
    }

    fn add_plume(&self, canvas: &mut Canvas) {
        let wisps = SmoothNoise::new(self.seed, Component::Plume, 0);
        let time = self.frame as f64 / WISP_FRAMES;
        let middle = [self.middle[0], self.middle[1] - PLUME_AHEAD * self.length_px];
        let (across, along) = (PLUME_PARTS.0 * self.width_px, PLUME_PARTS.1 * self.width_px);
        let plume = |x: f64, y: f64| {
            let (u, v) = ((x - middle[0]) / across, (y - middle[1]) / along);
            let glow = (-0.5 * (u * u + v * v)).exp();
            let wisp = 1.0 + 0.35 * f64::from(wisps.cloud(x / WISP_PX, y / WISP_PX + time, time));
            (self.light.plume_grey * glow * wisp.max(0.0)) as f32
        };
        canvas.change_by_field(4, plume, |plume, value| *value += plume);
    }
}

/// The part of a pixel inside an edge that passes its middle at `distance` \[px\], positive outside.
fn coverage(distance: f64) -> f64 {
    (0.5 - distance).clamp(0.0, 1.0)
}
