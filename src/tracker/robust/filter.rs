//! The seam's estimator: interacting models of Du 2022's augmented state, in pixels and frames.

use nalgebra::{SMatrix, vector};

use crate::kalman::{ColouredMeasurement, Gaussian, Imm, InnovationNotPositive, InvalidParameter, StateSpace};

/// Process noise of the three models \[px²/frame⁴\]: nearly straight, bending, sharp corner. Prototype.
pub const PROCESS_NOISE: [f64; 3] = [1e-7, 2e-4, 3e-2];
/// Probability that a model stays from frame to frame. Prototype.
const STAY: f64 = 0.998;
/// ψ and stationary variance of the coloured measurement noise \[px²\]: plate edges are ragged. Prototype.
pub const COLOUR_COEFFICIENT: f64 = 0.5;
/// See [`COLOUR_COEFFICIENT`].
pub const COLOUR_VARIANCE_PX2: f64 = 0.18;
/// Variance of the start velocity \[px²/frame²\]. Chosen: slopes up to 1 px a frame are common.
const START_VELOCITY_VARIANCE: f64 = 1.0;

/// One model with process noise `q`, in pixels and frames; `white_variance_px2` is R.
///
/// # Errors
/// When a number is out of range.
pub fn model(q: f64, white_variance_px2: f64) -> Result<ColouredMeasurement, InvalidParameter> {
    let drive = COLOUR_VARIANCE_PX2 * (1.0 - COLOUR_COEFFICIENT * COLOUR_COEFFICIENT);
    ColouredMeasurement::new(q, drive, COLOUR_COEFFICIENT, white_variance_px2, 1.0)?
        .with_velocity_variance(START_VELOCITY_VARIANCE)
}

/// Position, velocity and coloured noise under three models.
#[derive(Debug, Clone, Copy)]
pub struct SeamFilter {
    imm: Imm<3, 3>,
    models: [ColouredMeasurement; 3],
    spaces: [StateSpace<3, 1>; 3],
}

impl SeamFilter {
    /// Starts at `u_px` with velocity `velocity_px` a frame, of the given variances.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn start(u_px: f64, velocity_px: f64, variances: [f64; 2]) -> Result<Self, InvalidParameter> {
        let models = [model(PROCESS_NOISE[0], 1.0)?, model(PROCESS_NOISE[1], 1.0)?, model(PROCESS_NOISE[2], 1.0)?];
        let diagonal = vector![variances[0], variances[1], COLOUR_VARIANCE_PX2];
        let start = Gaussian::new(vector![u_px, velocity_px, 0.0], SMatrix::from_diagonal(&diagonal))?;
        let spaces = [models[0].state_space(1.0)?, models[1].state_space(1.0)?, models[2].state_space(1.0)?];
        Ok(Self { imm: Imm::new(start, STAY)?, models, spaces })
    }

    /// The state `frames` later.
    ///
    /// # Errors
    /// When `frames` is not positive.
    pub fn predict(&mut self, frames: f64) -> Result<(), InvalidParameter> {
        for (space, model) in self.spaces.iter_mut().zip(&self.models) {
            *space = model.state_space(frames)?;
        }
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
        let space = self.spaces[0].with_R(SMatrix::from_element(variance_px2));
        Ok(self.imm.nis(&space, &[Some(u_px)])?.unwrap_or(0.0))
    }

    /// Takes in a measurement.
    ///
    /// # Errors
    /// When the innovation's variance is not positive.
    pub fn update(&mut self, u_px: f64, variance_px2: f64) -> Result<(), InnovationNotPositive> {
        let spaces = self.spaces.map(|space| space.with_R(SMatrix::from_element(variance_px2)));
        self.imm = self.imm.update(&spaces, &[Some(u_px)], None)?.posterior;
        Ok(())
    }
}
