//! Tracks a hairline butt joint along the stripe: evidence per column, a grid filter, and the courage to say "none"
//! (docs/method.md §6).

use crate::frame::GrayFrame;
use crate::imgproc::{AmbientLine, Band, NotchEvidence, NotchTemplate, StripeRectifier};
use crate::units::PixelPoint;

use super::grid::{GridEstimate, GridFilter, LocalObservation};
use super::grid_smooth::EvidenceRow;

/// Log likelihood ratio of a notch score, linear: nats a unit of score, and the score that speaks neither way. Measured
/// on two real scans, clean and in composited arcs: at the seam the score's median is 5 to 8; on the same stripes with the
/// seam painted over 99 % of all columns score below 3.
const NATS_PER_SCORE: f32 = 0.8;
const NEUTRAL_SCORE: f32 = 2.5;
const NOTCH_FLOOR_NATS: f32 = -3.0;
/// The ambient line speaks for a seam only, as the arc drowns it: nats a unit of its score, from which score on, and
/// at most (chosen: plain plates score about 0.3, a visible joint 1 to 3).
const NATS_PER_AMBIENT: f32 = 1.5;
const AMBIENT_FROM: f32 = 0.5;
const AMBIENT_NATS: f32 = 3.0;
/// What the learned template may add \[nats\] (docs/method.md §6.4: capped). It may take little away: the seam's look changes.
const TEMPLATE_NATS: (f32, f32) = (-1.0, 3.0);
/// Most that one frame may say for one column \[nats\]: with 8, single spatters decide.
const FRAME_NATS: f32 = 4.0;
/// Share of frames in which an existing seam cannot be seen where it is: the look of plain stripe is no proof against it.
const INVISIBLE_SHARE: f32 = 0.3;
/// A column outside the stripe is ruled out \[nats\].
const OUTSIDE_NATS: f32 = -20.0;

/// A seam is confirmed when the probabilities that it exists, and where, have been this high for so many frames.
/// Painted-over controls stay below 0.01, in severe arcs below 0.3.
const CONFIRM_PRESENCE: f64 = 0.99;
const CONFIRM_CONFIDENCE: f64 = 0.95;
const CONFIRM_FRAMES: u32 = 3;
/// Below either of these a confirmed seam is doubtful until it is convincing again, and below the last it has ended.
const CLEAR_PRESENCE: f64 = 0.5;
const CLEAR_CONFIDENCE: f64 = 0.9;
const GIVE_UP_PRESENCE: f64 = 0.05;
/// The template learns where the fixed evidence within 3 px agrees, and no glare is within 8 px (docs/method.md §6.4).
const LEARN_SCORE: f32 = 3.0;
const LEARN_REACH_PX: usize = 3;
const LEARN_HOT_REACH_PX: usize = 8;

/// Whether there is a seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeamPresence {
    /// No seam has been confirmed, or the last one has ended.
    Seeking,
    /// A seam was confirmed, but the last frames leave open whether it is still there, or where: nothing to rely on.
    Doubtful,
    /// A seam is confirmed and its place is clear.
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
    /// How much the stripe's cross-section differs there ([`NotchEvidence::relief`]).
    pub relief: f64,
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
    clear: bool,
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
        // After a doubt, a few lucky frames at another place must not pass for the seam.
        self.clear = self.confirmed
            && estimate.presence >= CLEAR_PRESENCE
            && estimate.confidence >= CLEAR_CONFIDENCE
            && (self.clear || self.convinced_frames >= CONFIRM_FRAMES);
        if convinced && may_learn(band, score, estimate.u_px) {
            self.template.learn(estimate.u_px);
        }
        Some(HairlineEstimate {
            seam: PixelPoint::new(estimate.u_px, band.line.v_px(estimate.u_px)),
            grid: estimate,
            observation: grid.local_observation(estimate.u_px),
            relief: self.notch.relief(estimate.u_px).into(),
            presence: if !self.confirmed {
                SeamPresence::Seeking
            } else if self.clear {
                SeamPresence::Present
            } else {
                SeamPresence::Doubtful
            },
        })
    }

    /// The stripe's row at column `u_px` in the last frame \[px\].
    #[must_use]
    pub fn stripe_v_px(&self, u_px: f64) -> Option<f64> {
        self.rectifier.band().map(|band| band.line.v_px(u_px))
    }

    /// The last frame's evidence, to be kept for [`super::grid_smooth::smooth`].
    #[must_use]
    pub const fn evidence(&self) -> &EvidenceRow {
        &self.evidence
    }
}

/// The three witnesses' log likelihood ratios, summed and limited.
fn fill_evidence(evidence: &mut EvidenceRow, band: &Band, score: &[f32], ambient: &[f32], template: &[f32]) {
    evidence.inside = band.inside.clone();
    evidence.log_ratio.clear();
    evidence.log_ratio.extend((0..band.width_px()).map(|u| {
        if !band.inside.contains(&u) {
            return OUTSIDE_NATS;
        }
        let notch = (NATS_PER_SCORE * (score[u] - NEUTRAL_SCORE)).clamp(NOTCH_FLOOR_NATS, FRAME_NATS);
        if band.hot()[u] {
            // Glare can look like a seam and can hide one.
            return notch.min(0.0);
        }
        let ambient = (NATS_PER_AMBIENT * (ambient[u] - AMBIENT_FROM)).clamp(0.0, AMBIENT_NATS);
        let template = template[u].clamp(TEMPLATE_NATS.0, TEMPLATE_NATS.1);
        let visible = (notch + ambient + template).min(FRAME_NATS).exp();
        (INVISIBLE_SHARE + (1.0 - INVISIBLE_SHARE) * visible).ln()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::{Scene, builtin};
    use crate::units::StripeAxis;

    fn scene(name: &str, frames: usize) -> Scene {
        let mut scenario = builtin::scenario(name).unwrap();
        scenario.frames = frames;
        scenario.image.stripe = StripeAxis::Horizontal;
        (scenario.image.width_px, scenario.image.height_px) = (448, 384);
        scenario.recorder.repeated = 0.0;
        Scene::new(&scenario, 1).unwrap()
    }

    #[test]
    fn a_made_up_hairline_in_an_arc_is_found_and_followed() {
        let scene = scene("hairline-medium", 60);
        let mut tracker = HairlineTracker::default();
        let mut clear = 0;
        for i in 0..60 {
            let Some(estimate) = tracker.step(&scene.render(i)) else { continue };
            if estimate.presence == SeamPresence::Present {
                clear += 1;
                let truth = scene.truth(i).seam.unwrap();
                assert!((estimate.seam.u_px - truth.u_px).abs() < 5.0, "frame {i}: {estimate:?}, truth {truth:?}");
                assert!((estimate.seam.v_px - truth.v_px).abs() < 3.0, "frame {i}: {estimate:?}, truth {truth:?}");
            }
        }
        assert!(clear > 30, "clear on {clear} of 60 frames");
    }

    #[test]
    fn a_flat_plate_has_no_seam() {
        let scene = scene("flat", 60);
        let mut tracker = HairlineTracker::default();
        for i in 0..60 {
            let estimate = tracker.step(&scene.render(i));
            assert!(estimate.is_none_or(|e| e.presence == SeamPresence::Seeking), "frame {i}: {estimate:?}");
        }
    }

    #[test]
    fn a_frame_without_a_stripe_gives_nothing_and_does_not_disturb() {
        let mut tracker = HairlineTracker::default();
        assert!(tracker.step(&GrayFrame::filled(448, 384, 40).unwrap()).is_none());
        assert!(tracker.step(&GrayFrame::filled(1, 1, 40).unwrap()).is_none());
        assert!(tracker.step(&scene("flat", 1).render(0)).is_some());
    }
}
