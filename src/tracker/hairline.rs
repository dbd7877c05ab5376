//! Tracks a hairline butt joint along the stripe: evidence per column, a grid filter, and the courage to say "none".

use crate::frame::GrayFrame;
use crate::imgproc::ambient_line::AmbientLine;
use crate::imgproc::notch::NotchEvidence;
use crate::imgproc::notch_template::NotchTemplate;
use crate::imgproc::rectify::{Band, StripeRectifier};
use crate::units::PixelPoint;

use super::grid::{GridEstimate, GridFilter};

/// Log likelihood ratio of a score, linear: nats a unit of score, and the score that speaks neither way. On both real
/// scans the score at the seam has its median near 8 (5 % below 3.3 on the worst), that of the best false path on the
/// same stripes with the seam painted over near 2.7 (5 % above 5.5).
const NATS_PER_SCORE: f32 = 0.8;
const NEUTRAL_SCORE: f32 = 4.0;
/// One frame's evidence in one column is worth at least and at most this \[nats\].
const EVIDENCE_NATS: (f32, f32) = (-3.0, 8.0);
/// A column outside the stripe is ruled out \[nats\].
const OUTSIDE_NATS: f32 = -20.0;
/// A seam is confirmed when its probability and its place's have been this high for so many frames, and given up when
/// its probability is this low.
const CONFIRM_PRESENCE: f64 = 0.99;
const CONFIRM_CONFIDENCE: f64 = 0.9;
const CONFIRM_FRAMES: u32 = 3;
const GIVE_UP_PRESENCE: f64 = 0.2;

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
    /// The grid's full estimate.
    pub grid: GridEstimate,
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
    log_ratio: Vec<f32>,
    convinced_frames: u32,
    confirmed: bool,
}

impl HairlineTracker {
    /// Takes the next frame; `None` while no stripe has been seen.
    pub fn step(&mut self, frame: &GrayFrame) -> Option<HairlineEstimate> {
        let width = frame.width_px();
        let grid = match self.grid.take() {
            Some(grid) if grid.columns() == width => grid,
            _ => GridFilter::new(width),
        };
        let grid = self.grid.insert(grid);
        let band = self.rectifier.rectify(frame)?;
        let score = self.notch.score(band);
        let ambient = self.ambient.score(frame, band);
        let template = self.template.log_ratio(band);
        let ak: f32 = std::env::var("AK").map_or(1.5, |v| v.parse().unwrap());
        let tk: f32 = std::env::var("TK").map_or(1.0, |v| v.parse().unwrap());
        let a0: f32 = std::env::var("A0").map_or(0.5, |v| v.parse().unwrap());
        fill_log_ratio(&mut self.log_ratio, score, band);
        for (u, nats) in self.log_ratio.iter_mut().enumerate() {
            if band.inside.contains(&u) && !band.hot()[u] {
                *nats = (*nats + ak * (ambient[u] - a0).clamp(0.0, 2.0) + tk * template[u].clamp(-3.0, 5.0)).clamp(EVIDENCE_NATS.0, EVIDENCE_NATS.1);
            }
        }
        grid.predict(&band.inside);
        grid.update(&self.log_ratio);
        let estimate = grid.estimate();
        let convinced = estimate.presence >= CONFIRM_PRESENCE && estimate.confidence >= CONFIRM_CONFIDENCE;
        self.convinced_frames = if convinced { self.convinced_frames + 1 } else { 0 };
        self.confirmed = self.convinced_frames >= CONFIRM_FRAMES
            || (self.confirmed && estimate.presence > GIVE_UP_PRESENCE);
        let near = estimate.u_px.round() as usize;
        let near = near.saturating_sub(8)..(near + 9).min(width);
        let fixed = score[near.start + 5..near.end.saturating_sub(5).max(near.start+6)].iter().fold(0.0_f32, |a, &b| a.max(b));
        if convinced && fixed > 3.0 && !band.hot()[near].contains(&true) {
            self.template.learn(estimate.u_px);
        }
        Some(HairlineEstimate {
            seam: PixelPoint::new(estimate.u_px, band.line.v_px(estimate.u_px)),
            grid: estimate,
            presence: if self.confirmed { SeamPresence::Present } else { SeamPresence::Seeking },
        })
    }

    /// The last frame's evidence, one log likelihood ratio a column \[nats\].
    #[must_use]
    pub fn log_ratio(&self) -> &[f32] {
        &self.log_ratio
    }
}

fn fill_log_ratio(log_ratio: &mut Vec<f32>, score: &[f32], band: &Band) {
    log_ratio.clear();
    log_ratio.extend(score.iter().map(|s| {
        let (least, most) = EVIDENCE_NATS;
        (NATS_PER_SCORE * (s - NEUTRAL_SCORE)).clamp(least, most)
    }));
    for (u, nats) in log_ratio.iter_mut().enumerate() {
        if !band.inside.contains(&u) {
            *nats = OUTSIDE_NATS;
        } else if band.hot()[u] {
            *nats = nats.min(0.0);
        }
    }
}
