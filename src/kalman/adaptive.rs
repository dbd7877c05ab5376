//! Measurement noise learnt while filtering: the stable form of Jiang 2016, equation (18).
//!
//! R is learnt from the residual after the update instead of the innovation before it, which keeps it positive
//! definite by construction; outliers are bounded first, since learning R from them would make the filter worse than
//! none. The process noise is not learnt (fit it by likelihood, [`super::fit`]), nor the means of the noises (a bias
//! of the width cannot be told from the width).
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{SMatrix, SVector};

use super::gaussian::{ChiSquareGate, Gaussian};
use super::series::{Frame, SeriesError, Step, Trajectory};
use super::state_space::{InvalidParameter, StateSpace};

/// Fading factor b of the statistics, chosen: fifty frames of memory.
const FADING: f64 = 0.98;
/// Frames the start's R counts for, so that the first residuals do not overturn it; chosen, since R loses
/// definiteness without.
const PRIOR_FRAMES: i32 = 20;
/// Frames filtered before learning begins, until the start's uncertainty has died out; chosen.
const WARM_UP_FRAMES: usize = 10;
/// R stays within these multiples of the start's, chosen.
const R_RANGE: (f64, f64) = (0.01, 100.0);

/// The diagonal R a filter learns from complete frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseAdaptation<const M: usize> {
    start: SVector<f64, M>,
    R: SVector<f64, M>,
    frames: usize,
    learnt: i32,
}

impl<const M: usize> NoiseAdaptation<M> {
    /// Starts from the diagonal of a model's R.
    #[must_use]
    pub fn new(R: &SMatrix<f64, M, M>) -> Self {
        Self { start: R.diagonal(), R: R.diagonal(), frames: 0, learnt: PRIOR_FRAMES }
    }

    /// The R learnt so far.
    #[must_use]
    pub fn R(&self) -> SMatrix<f64, M, M> {
        SMatrix::from_diagonal(&self.R)
    }

    /// Learns from a step that used [`NoiseAdaptation::R`]: R ← (1−d) R + d diag((I−HK) f ε εᵀ (I−HK)ᵀ + H P Hᵀ).
    pub fn learn<const N: usize>(&mut self, step: &Step<N, M>) {
        let warm = self.frames >= WARM_UP_FRAMES;
        self.frames += 1;
        if !warm || step.update.innovation.iter().any(Option::is_none) {
            return;
        }
        let e = SVector::from(step.update.innovation.map(Option::unwrap_or_default));
        self.learnt = self.learnt.saturating_add(1);
        let d = (1.0 - FADING) / (1.0 - FADING.powi(self.learnt));
        let H = &step.space.H;
        let residual = e - H * step.update.K * e;
        let explained = (H * step.update.posterior.P * H.transpose()).diagonal();
        for row in 0..M {
            let seen = step.update.weight * residual[row] * residual[row] + explained[row];
            let learnt = (1.0 - d) * self.R[row] + d * seen;
            self.R[row] = learnt.clamp(R_RANGE.0 * self.start[row], R_RANGE.1 * self.start[row]);
        }
    }
}

/// The 99 % rule on complete frames only: an incomplete one is used as it is.
#[must_use]
pub const fn complete_frames_gate() -> ChiSquareGate<2> {
    ChiSquareGate { thresholds: [f64::INFINITY, ChiSquareGate::<2>::P99.thresholds[1]] }
}

/// Filters a series while learning R from its model's; gives the path and the R after each frame.
///
/// # Errors
/// As [`Trajectory::filter`].
pub fn filter_adaptively<const N: usize>(
    start: Gaussian<N>,
    frames: &[Frame<2>],
    space_over: impl Fn(f64) -> Result<StateSpace<N, 2>, InvalidParameter>,
    mut adaptation: NoiseAdaptation<2>,
) -> Result<(Trajectory<N, 2>, Vec<SMatrix<f64, 2, 2>>), SeriesError> {
    let mut trajectory = Trajectory { start, steps: Vec::with_capacity(frames.len()) };
    let mut learnt = Vec::with_capacity(frames.len());
    for frame in frames {
        let learning = |dt_s| Ok(space_over(dt_s)?.with_R(adaptation.R()));
        let step = trajectory.push(frame, learning, Some(complete_frames_gate()))?;
        adaptation.learn(step);
        learnt.push(adaptation.R());
    }
    Ok((trajectory, learnt))
}
