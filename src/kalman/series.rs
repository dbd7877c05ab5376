//! The filter over a whole recorded series.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::SMatrix;

use super::gaussian::{ChiSquareGate, Gaussian, InnovationNotPositive, Update};
use super::state_space::{InvalidParameter, StateSpace, check_covariance};

/// One frame of a series: what was measured, and how long after the frame before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame<const M: usize> {
    /// Time since the frame before \[s\], greater than 0.
    pub dt_s: f64,
    /// The measurement, row by row; none where there is none.
    pub z: [Option<f64>; M],
    /// The measurement's own noise covariance; none for the model's.
    pub R: Option<SMatrix<f64, M, M>>,
}

/// One step of the filter over a series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<const N: usize, const M: usize> {
    /// The model over the step, with the R the frame had.
    pub space: StateSpace<N, M>,
    /// The state before the measurement.
    pub prior: Gaussian<N>,
    /// The update by the measurement; its posterior is the filtered state.
    pub update: Update<N, M>,
}

/// The filter's path through a series: the start, then one step a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory<const N: usize, const M: usize> {
    /// The state the first step starts from.
    pub start: Gaussian<N>,
    /// One step a frame.
    pub steps: Vec<Step<N, M>>,
}

/// A series the filter cannot run through.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SeriesError {
    /// A frame's time step or measurement noise is no such thing.
    #[error("frame {frame}: {reason}")]
    InvalidFrame {
        /// Position in the series, from 0.
        frame: usize,
        /// What is wrong with it.
        reason: InvalidParameter,
    },
    /// The innovation's covariance broke down at a frame.
    #[error("frame {frame}: {reason}")]
    Innovation {
        /// Position in the series, from 0.
        frame: usize,
        /// What is wrong with it.
        reason: InnovationNotPositive,
    },
    /// There are not enough measurements to start from.
    #[error("the series has {measured} measured frames, but the filter starts from {needed}")]
    TooShort {
        /// Frames measured.
        measured: usize,
        /// Frames needed.
        needed: usize,
    },
}

impl SeriesError {
    /// The same error, said of another frame: a series often starts later than its recording.
    #[must_use]
    pub(crate) const fn at_frame(self, frame: usize) -> Self {
        match self {
            Self::InvalidFrame { reason, .. } => Self::InvalidFrame { frame, reason },
            Self::Innovation { reason, .. } => Self::Innovation { frame, reason },
            Self::TooShort { .. } => self,
        }
    }
}

impl<const M: usize> Frame<M> {
    /// A frame measured with the model's own noise, `dt_s` seconds after the frame before.
    #[must_use]
    pub const fn new(dt_s: f64, z: [Option<f64>; M]) -> Self {
        Self { dt_s, z, R: None }
    }
}

impl<const N: usize, const M: usize> Trajectory<N, M> {
    /// Predicts and updates through `frames`; `space_over` gives the model over a step of so many seconds.
    ///
    /// # Errors
    /// When a frame's time step is not positive, its R not a covariance, or an S not positive definite.
    pub fn filter(
        start: Gaussian<N>,
        frames: &[Frame<M>],
        space_over: impl Fn(f64) -> Result<StateSpace<N, M>, InvalidParameter>,
        gate: Option<ChiSquareGate<M>>,
    ) -> Result<Self, SeriesError> {
        let mut trajectory = Self { start, steps: Vec::with_capacity(frames.len()) };
        for frame in frames {
            trajectory.push(frame, &space_over, gate)?;
        }
        Ok(trajectory)
    }

    /// Takes one more frame.
    ///
    /// # Errors
    /// As [`Trajectory::filter`].
    pub fn push(
        &mut self,
        frame: &Frame<M>,
        space_over: impl Fn(f64) -> Result<StateSpace<N, M>, InvalidParameter>,
        gate: Option<ChiSquareGate<M>>,
    ) -> Result<&Step<N, M>, SeriesError> {
        let index = self.steps.len();
        let invalid = |reason| SeriesError::InvalidFrame { frame: index, reason };
        let mut space = space_over(frame.dt_s).map_err(invalid)?;
        if let Some(R) = frame.R {
            check_covariance("R", &R).map_err(invalid)?;
            space = space.with_R(R);
        }
        let state = self.steps.last().map_or(self.start, |step| step.update.posterior);
        let prior = state.predict(&space);
        let innovation = |reason| SeriesError::Innovation { frame: index, reason };
        let update = prior.update(&space, &frame.z, gate).map_err(innovation)?;
        self.steps.push(Step { space, prior, update });
        Ok(&self.steps[index])
    }

    /// Log-likelihood of the series given its start.
    #[must_use]
    pub fn log_likelihood(&self) -> f64 {
        self.steps.iter().map(|step| step.update.log_likelihood).sum()
    }

    /// The filtered states, the start first: one more than there are steps.
    pub fn filtered(&self) -> impl Iterator<Item = &Gaussian<N>> {
        std::iter::once(&self.start).chain(self.steps.iter().map(|step| &step.update.posterior))
    }

    /// Normalised innovations squared of the frames that had a measurement.
    pub fn nis(&self) -> impl Iterator<Item = f64> {
        self.steps.iter().filter_map(|step| step.update.nis)
    }
}
