//! How the joint and the plates move through the image.

use serde::{Deserialize, Serialize};

/// One term of a path; a path is the sum of its terms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PathTerm {
    /// A constant drift, not varied from seed to seed.
    Straight {
        /// \[px/frame\]; the experiment of Du 2022 drifts 0.548 (0.04 mm at 0.073 mm/px).
        px_per_frame: f64,
    },
    /// Straight pieces of equal duration with sharp corners between them.
    Polyline {
        /// Slope of each piece \[px/frame\].
        px_per_frame: Vec<f64>,
    },
    /// A sine.
    Sine {
        /// \[px\].
        amplitude_px: f64,
        /// \[frames\], above 2.
        period_frames: f64,
        /// Phase at frame 0 \[degrees\], default 0.
        #[serde(default)]
        phase_deg: f64,
    },
    /// A smooth step (hyperbolic tangent).
    SCurve {
        /// Total travel \[px\].
        travel_px: f64,
        /// Time in which the middle 90 % of the travel happens \[frames\].
        duration_frames: f64,
        /// When the middle is reached, as a fraction of the recording, default 0.5.
        #[serde(default = "middle")]
        centre: f64,
    },
}

const fn middle() -> f64 {
    0.5
}

/// Where a hyperbolic tangent has done 95 % of its half: atanh 0.9.
const TANH_90: f64 = 1.472_219_489_583_22;

impl PathTerm {
    /// The displacement at a time \[px\], zero at frame 0 except for a sine's phase; `frames` is the recording's length.
    #[must_use]
    pub fn at(&self, frame: f64, frames: f64) -> f64 {
        match self {
            Self::Straight { px_per_frame } => px_per_frame * frame,
            Self::Polyline { px_per_frame } => {
                let piece_frames = frames / px_per_frame.len() as f64;
                let mut sum = 0.0;
                for (i, slope) in px_per_frame.iter().enumerate() {
                    let begin = if i == 0 { f64::NEG_INFINITY } else { i as f64 * piece_frames };
                    let end = if i + 1 == px_per_frame.len() { f64::INFINITY } else { (i + 1) as f64 * piece_frames };
                    sum += slope * (frame.clamp(begin, end) - 0.0_f64.clamp(begin, end));
                }
                sum
            }
            Self::Sine { amplitude_px, period_frames, phase_deg } => {
                amplitude_px * (std::f64::consts::TAU * frame / period_frames + phase_deg.to_radians()).sin()
            }
            Self::SCurve { travel_px, duration_frames, centre } => {
                let phase = |f: f64| (2.0 * TANH_90 * (f - centre * frames) / duration_frames).tanh();
                0.5 * travel_px * (phase(frame) - phase(0.0))
            }
        }
    }

    /// What is wrong with the term, if anything.
    pub(in crate::synth) fn problem(&self) -> Option<&'static str> {
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite() && v.abs() < 1e5);
        match self {
            Self::Straight { px_per_frame } if !finite(&[*px_per_frame]) => {
                Some("px_per_frame is not a sensible number")
            }
            Self::Polyline { px_per_frame } if px_per_frame.is_empty() || !finite(px_per_frame) => {
                Some("px_per_frame needs at least one slope, all of them sensible numbers")
            }
            Self::Sine { amplitude_px, period_frames, phase_deg }
                if !finite(&[*amplitude_px, *period_frames, *phase_deg]) || *period_frames <= 2.0 =>
            {
                Some("a sine needs sensible numbers and period_frames above 2")
            }
            Self::SCurve { travel_px, duration_frames, centre }
                if !finite(&[*travel_px, *duration_frames, *centre]) || *duration_frames <= 0.0 =>
            {
                Some("an s-curve needs sensible numbers and duration_frames above 0")
            }
            _ => None,
        }
    }
}

/// A quantity that is constant (`13.0`) or changes linearly over the recording (`[8.0, 24.0]`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Ramp {
    /// The same in every frame.
    Constant(f64),
    /// From the first frame to the last.
    FromTo([f64; 2]),
}

impl Ramp {
    /// The value at a fraction of the recording, 0 to 1.
    #[must_use]
    pub fn at(self, fraction: f64) -> f64 {
        match self {
            Self::Constant(value) => value,
            Self::FromTo([from, to]) => from + (to - from) * fraction.clamp(0.0, 1.0),
        }
    }

    /// The same course, every value multiplied.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(value * factor),
            Self::FromTo([from, to]) => Self::FromTo([from * factor, to * factor]),
        }
    }

    /// Whether both ends lie in a range.
    pub(super) fn within(self, range: std::ops::RangeInclusive<f64>) -> bool {
        range.contains(&self.at(0.0)) && range.contains(&self.at(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polyline_has_the_stated_slopes_and_no_jumps() {
        let line = PathTerm::Polyline { px_per_frame: vec![0.9, -0.75] };
        assert!((line.at(50.0, 100.0) - 45.0).abs() < 1e-9);
        assert!((line.at(100.0, 100.0) - (45.0 - 37.5)).abs() < 1e-9);
        assert!((line.at(110.0, 100.0) - line.at(109.0, 100.0) + 0.75).abs() < 1e-9);
        assert!((line.at(-3.0, 100.0) + 2.7).abs() < 1e-9);
    }

    #[test]
    fn an_s_curve_makes_nine_tenths_of_its_travel_in_its_duration() {
        let curve = PathTerm::SCurve { travel_px: 150.0, duration_frames: 40.0, centre: 0.5 };
        assert!((curve.at(145.0, 250.0) - curve.at(105.0, 250.0) - 135.0).abs() < 1e-6);
    }
}
