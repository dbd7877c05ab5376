//! The noise parameters under which a recorded series is most likely.

use super::gaussian::{ChiSquareGate, Gaussian};
use super::model::Model;
use super::nelder_mead::minimise;
use super::series::{Frame, SeriesError, Trajectory};
use super::state_space::InvalidParameter;
use super::{ColouredMeasurement, smoother};

/// First simplex of the search, in the logarithm of a variance; chosen, a factor of e.
const FIRST_STEP: f64 = 1.0;
/// Factors on the process noise the search starts from, so that a local maximum does not hold it; chosen.
const PROCESS_NOISE_STARTS: [f64; 3] = [1e-3, 1.0, 1e3];
/// A variance of 0 has no logarithm: the search starts from this one instead, chosen.
const SMALLEST_VARIANCE: f64 = 1e-12;
/// Process noise tried for a seam \[px²/frame⁴\], from straight to corners at every frame; chosen.
const SEAM_ACCELERATION_PX2_FRAME4: [f64; 10] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// A series filtered from its first measurements on.
#[derive(Debug, Clone, PartialEq)]
pub struct Filtered<const N: usize, const M: usize> {
    /// The frame the start stands at; frames before it have no estimate.
    pub first: usize,
    /// The path from there: the start belongs to frame `first`, step i to frame `first` + 1 + i.
    pub trajectory: Trajectory<N, M>,
}

impl<const N: usize, const M: usize> Filtered<N, M> {
    /// The state in each frame given the whole series; none before the first measurement.
    #[must_use]
    pub fn smoothed(&self) -> Vec<Option<Gaussian<N>>> {
        let states = smoother::bryson_frazier(&self.trajectory).into_iter().map(Some);
        std::iter::repeat_n(None, self.first).chain(states).collect()
    }
}

/// Starts `model` from the first measurements of a series and filters the rest.
///
/// # Errors
/// When the series is too short to start from, or a frame of it is invalid.
pub fn filter<const N: usize, const M: usize, const P: usize>(
    model: &impl Model<N, M, P>,
    frames: &[Frame<M>],
    gate: Option<ChiSquareGate<M>>,
) -> Result<Filtered<N, M>, SeriesError> {
    let (start, first) = model.start_of(frames)?;
    let mut trajectory = Trajectory { start, steps: Vec::with_capacity(frames.len() - first - 1) };
    for (index, frame) in frames.iter().enumerate().skip(first + 1) {
        trajectory.push(frame, |dt_s| model.space_over(dt_s), gate).map_err(|error| error.at_frame(index))?;
    }
    Ok(Filtered { first, trajectory })
}

/// The model's noise parameters under which the series is most likely, and the log-likelihood reached. All are free;
/// a frame's own R overrides the model's, and then says nothing about it.
///
/// # Errors
/// When the series cannot be filtered with the parameters the search starts from.
pub fn maximum_likelihood<const N: usize, const M: usize, const P: usize, T: Model<N, M, P>>(
    model: &T,
    frames: &[Frame<M>],
    gate: Option<ChiSquareGate<M>>,
) -> Result<(T, f64), SeriesError> {
    let given = filter(model, frames, gate)?.trajectory.log_likelihood();
    let cost = |parameters: &[f64; P]| {
        let model = model.with_unbounded(parameters).ok();
        let run = model.and_then(|model| filter(&model, frames, gate).ok());
        run.map_or(f64::INFINITY, |run| -run.trajectory.log_likelihood())
    };
    let mut best = (*model, given);
    for factor in PROCESS_NOISE_STARTS {
        let mut start = model.unbounded().map(|value| value.max(SMALLEST_VARIANCE.ln()));
        start[0] += factor.ln();
        let (parameters, cost) = minimise(start, FIRST_STEP, cost);
        if let Ok(model) = model.with_unbounded(&parameters)
            && -cost > best.1
        {
            best = (model, -cost);
        }
    }
    Ok(best)
}

/// A recorded seam path given all its measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct SmoothedSeam {
    /// The model with the process noise that was found.
    pub model: ColouredMeasurement,
    /// Log-likelihood of the series under it.
    pub log_likelihood: f64,
    /// The state at each frame \[px, px/s, px\]; none before the first measurement.
    pub states: Vec<Option<Gaussian<3>>>,
}

/// Smooths a recorded seam path with the process noise that makes it most likely; measurement noise is each frame's
/// own R, or the model's.
///
/// # Errors
/// When nothing was measured, or a frame is invalid.
pub fn smooth_seam(
    model: &ColouredMeasurement,
    frames: &[Frame<1>],
    gate: Option<ChiSquareGate<1>>,
) -> Result<SmoothedSeam, SeriesError> {
    let model = fit_seam(model, frames, gate)?;
    let run = filter(&model, frames, gate)?;
    let log_likelihood = run.trajectory.log_likelihood();
    Ok(SmoothedSeam { model, log_likelihood, states: run.smoothed() })
}

/// The model with the process noise that makes the series most likely.
fn fit_seam(
    model: &ColouredMeasurement,
    frames: &[Frame<1>],
    gate: Option<ChiSquareGate<1>>,
) -> Result<ColouredMeasurement, SeriesError> {
    let per_frame4 = model.period_s().powi(4);
    let with = |ln_q: f64| model.with_acceleration_variance(ln_q.exp());
    let cost = |ln_q: &[f64; 1]| {
        let run = with(ln_q[0]).ok().and_then(|model| filter(&model, frames, gate).ok());
        run.map_or(f64::INFINITY, |run| -run.trajectory.log_likelihood())
    };
    let grid = SEAM_ACCELERATION_PX2_FRAME4.map(|q| [(q / per_frame4).ln()]);
    let coarse = grid.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(grid[0]);
    let ([ln_q], _) = minimise(coarse, FIRST_STEP, cost);
    let within = ln_q.clamp(grid[0][0], grid[grid.len() - 1][0]);
    with(within).map_err(|reason: InvalidParameter| SeriesError::InvalidFrame { frame: 0, reason })
}
