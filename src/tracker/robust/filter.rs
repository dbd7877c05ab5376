//! The seam's estimator: interacting models of Du 2022's augmented state, in pixels and frames.

use nalgebra::{SMatrix, vector};

use super::part::{Part, Parts};
use crate::kalman::{Bending, ColouredMeasurement, Gaussian, Imm, InnovationNotPositive, InvalidParameter, StateSpace};

/// White acceleration of the three models \[px²/frame⁴\]: nearly straight, bending, sharp corner.
const KINKS: [f64; 3] = [1e-7, 1e-5, 3e-2];
/// SD of their lasting acceleration \[px/frame²\] and how long a bend lasts \[frames\].
const BENDS: [(f64, f64); 3] = [(1e-4, 1.0), (0.15, 15.0), (1e-2, 1.0)];
/// Process noise that the smoother's fit starts from \[px²/frame⁴\].
pub const PROCESS_NOISE: f64 = 2e-4;
/// Probability that a model stays from frame to frame. Prototype.
const STAY: f64 = 0.998;
/// ψ and stationary variance of the coloured measurement noise \[px²\]: plate edges are ragged. Prototype.
pub const COLOUR_COEFFICIENT: f64 = 0.5;
/// See [`COLOUR_COEFFICIENT`].
pub const COLOUR_VARIANCE_PX2: f64 = 0.18;
/// Variance of the seam's own vibration along the stripe \[px²\], which no filter can follow: part of the reported σ.
/// Chosen: 0.12 px, as machines vibrate.
pub const VIBRATION_VARIANCE_PX2: f64 = 0.0144;
/// Variance of the start velocity \[px²/frame²\]. Chosen: slopes up to 1 px a frame are common.
const START_VELOCITY_VARIANCE: f64 = 1.0;
/// Variance of the start acceleration \[px²/frame⁴\].
const START_ACCELERATION_VARIANCE: f64 = 0.0025;

/// One model with process noise `q`, in pixels and frames; `white_variance_px2` is R, `noise` scales the coloured
/// noise's variance.
///
/// # Errors
/// When a number is out of range.
pub fn model(q: f64, white_variance_px2: f64, noise: f64) -> Result<ColouredMeasurement, InvalidParameter> {
    let drive = noise * COLOUR_VARIANCE_PX2 * (1.0 - COLOUR_COEFFICIENT * COLOUR_COEFFICIENT);
    ColouredMeasurement::new(q, drive, COLOUR_COEFFICIENT, white_variance_px2, 1.0)?
        .with_velocity_variance(START_VELOCITY_VARIANCE)
}

fn spaces(noise: f64, frames: f64, parts: Parts) -> Result<[StateSpace<4, 1>; 3], InvalidParameter> {
    let colour = if parts.has(Part::ColouredNoise) { noise } else { 0.0 };
    let space = |i: usize| {
        let i = if i == 2 && !parts.has(Part::Corners) { 1 } else { i };
        let (kinks, (bend, bend_frames)) = match i {
            1 if !parts.has(Part::Bends) => (PROCESS_NOISE, BENDS[0]),
            _ => (KINKS[i], BENDS[i]),
        };
        Bending::new(model(kinks, 1.0, colour)?, bend.powi(2), bend_frames)?.state_space(frames)
    };
    Ok([space(0)?, space(1)?, space(2)?])
}

/// Position, velocity and coloured noise under three models.
#[derive(Debug, Clone, Copy)]
pub struct SeamFilter {
    imm: Imm<4, 3>,
    noise: f64,
    parts: Parts,
    spaces: [StateSpace<4, 1>; 3],
}

impl SeamFilter {
    /// Starts at `u_px` with velocity `velocity_px` a frame, of the given variances.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn start(u_px: f64, velocity_px: f64, variances: [f64; 2], parts: Parts) -> Result<Self, InvalidParameter> {
        let diagonal = vector![variances[0], variances[1], START_ACCELERATION_VARIANCE, COLOUR_VARIANCE_PX2];
        let start = Gaussian::new(vector![u_px, velocity_px, 0.0, 0.0], SMatrix::from_diagonal(&diagonal))?;
        Ok(Self { imm: Imm::new(start, STAY)?, noise: 1.0, parts, spaces: spaces(1.0, 1.0, parts)? })
    }

    /// Sets the scale of the measurements' noise: 1 for plate edges with a raggedness of 0.6 px.
    pub fn set_noise(&mut self, noise: f64) {
        self.noise = noise;
    }

    /// The state `frames` later.
    ///
    /// # Errors
    /// When `frames` is not positive.
    pub fn predict(&mut self, frames: f64) -> Result<(), InvalidParameter> {
        self.spaces = spaces(self.noise, frames, self.parts)?;
        self.imm = self.imm.predict(&self.spaces);
        Ok(())
    }

    /// Mean and variance of the position \[px, px²\].
    #[must_use]
    pub fn position(&self) -> (f64, f64) {
        let state = self.imm.output();
        (state.x[0], state.P[(0, 0)].max(0.0))
    }

    /// NIS of a measurement `u_px` of variance `variance_px2`.
    ///
    /// # Errors
    /// When the innovation's variance is not positive.
    pub fn nis(&self, u_px: f64, variance_px2: f64) -> Result<f64, InnovationNotPositive> {
        let space = self.spaces[0].with_R(self.white(variance_px2));
        Ok(self.imm.nis(&space, &[Some(u_px)])?.unwrap_or(0.0))
    }

    /// R of a measurement: what is not coloured is white.
    fn white(&self, variance_px2: f64) -> SMatrix<f64, 1, 1> {
        let colour = if self.parts.has(Part::ColouredNoise) { 0.0 } else { self.noise * COLOUR_VARIANCE_PX2 };
        SMatrix::from_element(variance_px2 + colour)
    }

    /// Takes in a measurement.
    ///
    /// # Errors
    /// When the innovation's variance is not positive.
    pub fn update(&mut self, u_px: f64, variance_px2: f64) -> Result<(), InnovationNotPositive> {
        let spaces = self.spaces.map(|space| space.with_R(self.white(variance_px2)));
        self.imm = self.imm.update(&spaces, &[Some(u_px)], None)?.posterior;
        Ok(())
    }
}
