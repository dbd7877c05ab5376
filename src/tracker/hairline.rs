//! Tracks a hairline butt joint along the stripe: evidence per column, a grid filter, and the courage to say "none"
//! (METHOD.md §6).

use crate::frame::GrayFrame;
use crate::imgproc::{AmbientLine, Band, NotchEvidence, NotchTemplate, StripeRectifier};
use crate::units::PixelPoint;

use super::grid::{GridEstimate, GridFilter, LocalObservation};
use super::grid_smooth::EvidenceRow;

/// Log likelihood ratio of a notch score, linear: nats a unit of score, and the score that speaks neither way.
/// Measured on two real scans: at the seam the score's median is near 8 (5 % lie below 3.3 on the worse scan); on the
/// same stripes with the seam painted over, the best false path's median is 2.7 (5 % lie above 5.5).
const NATS_PER_SCORE: f32 = 0.8;
const NEUTRAL_SCORE: f32 = 4.0;
/// The ambient line speaks for a seam only, as the arc drowns it: nats a unit of its score, from which score on, and
/// at most (chosen: plain plates score about 0.3, a visible joint 1 to 3).
const NATS_PER_AMBIENT: f32 = 1.5;
const AMBIENT_FROM: f32 = 0.5;
const AMBIENT_NATS: f32 = 3.0;
/// What the learned template may add \[nats\] (METHOD.md §6.4: capped).
const TEMPLATE_NATS: (f32, f32) = (-3.0, 5.0);
/// What one frame may say about one column \[nats\]: no frame alone decides, none rules a place out.
const FRAME_NATS: (f32, f32) = (-3.0, 8.0);
/// A column outside the stripe is ruled out \[nats\].
const OUTSIDE_NATS: f32 = -20.0;

/// A seam is confirmed when the probabilities that it exists, and where, have been this high for so many frames; it is
/// given up when the first is this low. Painted-over controls stay below 0.02.
const CONFIRM_PRESENCE: f64 = 0.99;
const CONFIRM_CONFIDENCE: f64 = 0.9;
const CONFIRM_FRAMES: u32 = 3;
const GIVE_UP_PRESENCE: f64 = 0.05;
/// The template learns where the fixed evidence within 3 px agrees, and no glare is within 8 px (METHOD.md §6.4).
const LEARN_SCORE: f32 = 3.0;
const LEARN_REACH_PX: usize = 3;
const LEARN_HOT_REACH_PX: usize = 8;

/// Whether there is a seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeamPresence {
    /// No seam has been confirmed, or the last one has ended.
    Seeking,
    /// A seam is confirmed.
    Present,
}

/// What one frame, and those before it, say about the seam, in the stripe's frame (u along a horizontal stripe).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HairlineEstimate {
    /// Where the seam most likely is: u of the grid's mean, v on the stripe's line.
    pub seam: PixelPoint,
    /// What the grid filter knows after this frame.
    pub grid: GridEstimate,
    /// This frame's own observation near the seam, nearly independent of the other frames': food for another filter.
    /// None when this frame says nothing about the place.
    pub observation: Option<LocalObservation>,
    /// Whether to believe in the seam.
    pub presence: SeamPresence,
}

/// The tracker. Frames have a horizontal stripe; a byte for byte repeated frame must not be given to it again.
#[derive(Debug, Clone, Default)]
pub struct HairlineTracker {
    rectifier: StripeRectifier,
    notch: NotchEvidence,
    ambient: AmbientLine,
    template: NotchTemplate,
    grid: Option<GridFilter>,
    evidence: EvidenceRow,
    convinced_frames: u32,
    confirmed: bool,
}

impl HairlineTracker {
    /// Takes the next frame; `None` while no stripe has been seen.
    pub fn step(&mut self, frame: &GrayFrame) -> Option<HairlineEstimate> {
        let width = frame.width_px();
        let grid = self.grid.take().filter(|grid| grid.columns() == width);
        let grid = self.grid.insert(grid.unwrap_or_else(|| GridFilter::new(width)));
        let band = self.rectifier.rectify(frame)?;
        let score = self.notch.score(band);
        let ambient = self.ambient.score(frame, band);
        fill_evidence(&mut self.evidence, band, score, ambient, self.template.log_ratio(band));

        grid.predict(&band.inside);
        grid.update(&self.evidence.log_ratio);
        let estimate = grid.estimate();

        let convinced = estimate.presence >= CONFIRM_PRESENCE && estimate.confidence >= CONFIRM_CONFIDENCE;
        self.convinced_frames = if convinced { self.convinced_frames + 1 } else { 0 };
        let was_confirmed = self.confirmed;
        self.confirmed =
            self.convinced_frames >= CONFIRM_FRAMES || (self.confirmed && estimate.presence > GIVE_UP_PRESENCE);
        if was_confirmed && !self.confirmed {
            self.template.forget();
        }
        if convinced && may_learn(band, score, estimate.u_px) {
            self.template.learn(estimate.u_px);
        }
        Some(HairlineEstimate {
            seam: PixelPoint::new(estimate.u_px, band.line.v_px(estimate.u_px)),
            grid: estimate,
            observation: grid.local_observation(estimate.u_px),
            presence: if self.confirmed { SeamPresence::Present } else { SeamPresence::Seeking },
        })
    }

    /// The last frame's evidence, to be kept for [`super::grid_smooth::smooth`].
    #[must_use]
    pub const fn evidence(&self) -> &EvidenceRow {
        &self.evidence
    }
}

/// The three witnesses' log likelihood ratios, summed and limited.
fn fill_evidence(evidence: &mut EvidenceRow, band: &Band, score: &[f32], ambient: &[f32], template: &[f32]) {
    let p = [k("NEUTRAL", 2.5), k("EPS", 0.3), k("CAP", 4.0), k("GAIN", 0.8), k("LOW", -3.0)];
    evidence.inside = band.inside.clone();
    evidence.log_ratio.clear();
    evidence.log_ratio.extend((0..band.width_px()).map(|u| {
        if !band.inside.contains(&u) {
            return OUTSIDE_NATS;
        }
        let notch = (p[3] * (score[u] - p[0])).clamp(p[4], p[2]);
        if band.hot()[u] {
            // Glare can look like a seam and can hide one.
            return notch.min(0.0);
        }
        let ambient = (NATS_PER_AMBIENT * (ambient[u] - AMBIENT_FROM)).clamp(0.0, AMBIENT_NATS);
        let template = template[u].clamp(TEMPLATE_NATS.0, TEMPLATE_NATS.1);
        let x = (notch + ambient + template).clamp(-20.0, p[2]);
        if p[1] > 0.0 { ((1.0 - p[1]) * x.exp() + p[1]).ln() } else { x.max(-3.0) }
    }));
}

/// Whether the fixed evidence agrees with the place, and no glare is near.
fn may_learn(band: &Band, score: &[f32], u_px: f64) -> bool {
    let near = |reach: usize| {
        let u = (u_px.round() as usize).min(band.width_px() - 1);
        u.saturating_sub(reach)..(u + reach + 1).min(band.width_px())
    };
    score[near(LEARN_REACH_PX)].iter().any(|&score| score > LEARN_SCORE)
        && !band.hot()[near(LEARN_HOT_REACH_PX)].contains(&true)
}

/// dev
pub fn k(name: &str, default: f32) -> f32 {
    std::env::var(name).map_or(default, |v| v.parse().unwrap_or(default))
}
