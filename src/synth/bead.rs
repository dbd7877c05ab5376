//! Beads of earlier passes in a V-groove: their surface and their toes.

use super::noise::{Component, SmoothNoise};
use super::scenario::{Bead, Vgroove};

/// Frames over which a bead wanders (chosen: some centimetres of weld).
const WANDER_FRAMES: f64 = 14.0;
/// Slope with which a bead falls off beside its half width, where no flank holds it (read off real beads' steps).
const FALL: f64 = 2.5;
/// Height of the ripples relative to the wandering, their length along the stripe \[px\] and along the travel \[frames\] (chosen).
const RIPPLE_SHARE: f64 = 0.35;
const RIPPLE_PX: f64 = 7.0;
const RIPPLE_FRAMES: f64 = 2.5;
/// Step with which toes are sought \[px\].
const TOE_STEP_PX: f64 = 0.05;

/// The beads of one frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beads<'a> {
    /// In this seed's numbers.
    pub(super) beads: &'a [Bead],
    /// The camera's frame number.
    pub(super) tick: usize,
    /// The scene's seed.
    pub(super) seed: u64,
}

impl Beads<'_> {
    /// The upper surface of all beads at a distance `t` from the groove's line: how far it lies below the plates \[px\],
    /// and its brightness.
    pub(super) fn at(&self, t: f64) -> Option<(f64, f64)> {
        let time = self.tick as f64;
        let surface = |(number, bead): (u64, &Bead)| {
            let noise = |kind: u64| SmoothNoise::new(self.seed, Component::Beads, 8 * number + kind);
            let wander = |kind: u64| bead.wander_px * f64::from(noise(kind).at(time / WANDER_FRAMES, 0.0, 0.0));
            let ripple =
                RIPPLE_SHARE * bead.wander_px * f64::from(noise(3).at(t / RIPPLE_PX, time / RIPPLE_FRAMES, 0.0));
            let half_width = (bead.half_width_px + wander(2)).max(2.0);
            let s = (t - bead.beside_px - wander(1)).abs() / half_width;
            let side = s.min(1.0);
            let row = bead.top_px + wander(0) + ripple + bead.crown_px * side * side + FALL * half_width * (s - side);
            let patches = 0.25 * f64::from(noise(4).at(t / 5.0, time / 3.0, 0.0));
            (row, bead.brightness * (1.0 + patches))
        };
        (0..).zip(self.beads).map(surface).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The outermost toes, from the groove's line \[px\]: where the beads' surface leaves the nominal groove or the plates.
    pub(super) fn toes_px(&self, groove: &Vgroove, fraction: f64) -> Option<[f64; 2]> {
        let [left, right] = groove.half_widths_px();
        let reach = self
            .beads
            .iter()
            .map(|bead| bead.beside_px.abs() + 2.0 * bead.half_width_px + 10.0)
            .fold(left.max(right), f64::max);
        let above = |t: f64| self.at(t).is_some_and(|(row, _)| row < groove_row_px(groove, fraction, t));
        let steps = (reach / TOE_STEP_PX) as i64;
        let mut covered = (-steps..=steps).map(|i| i as f64 * TOE_STEP_PX).filter(|&t| above(t));
        let left = covered.next()?;
        Some([left, covered.next_back().unwrap_or(left)])
    }
}

/// The nominal groove at a distance `t` from its line \[px below the plates' mean\].
fn groove_row_px(groove: &Vgroove, fraction: f64, t: f64) -> f64 {
    let half_hi_lo = 0.5 * groove.hi_lo_px.at(fraction);
    let plate = if t < 0.0 { half_hi_lo } else { -half_hi_lo };
    let half_width_px = groove.half_widths_px()[usize::from(t >= 0.0)];
    plate + (groove.depth_px - plate) * (1.0 - t.abs() / half_width_px).max(0.0)
}
