//! What the views leave open: the parameters' covariance by a Bayesian bootstrap over poses (Rubin 1981).
//!
//! The errors of one picture are not independent: a warped board, a blurred picture or the stripe's speckle move all of
//! it. So whole poses are drawn again, each with a random weight of mean and variance 1, instead of corners. Unlike drawing
//! with replacement this never leaves a set of boards that determine nothing.

use nalgebra::{SMatrix, SVector};
use rand_distr::{Distribution, Exp1, StandardNormal};
use rand_pcg::Pcg32;
use rayon::prelude::*;

use super::adjust::{AdjustError, Problem, State, adjust};
use super::intrinsics::{INTRINSICS, Intrinsics};
use super::laser_camera::{PARAMETERS, ParameterCovariance};

/// Number of draws: σ is known to 1/√(2 · 240) = 4.6 %.
pub const DRAWS: usize = 240;
/// Seed of the draws: same pictures, same covariance.
const SEED: u64 = 2026;
/// At least this share of the draws must have a fit.
const LEAST_SHARE: f64 = 0.9;

/// The parameters of each draw as a difference from the fit of `state`. `pose_of` numbers each sighting's pose.
///
/// # Errors
/// When more than a tenth of the draws have no fit.
pub fn draws(
    problem: &Problem,
    state: &State,
    pose_of: &[usize],
) -> Result<Vec<SVector<f64, PARAMETERS>>, AdjustError> {
    let poses = pose_of.iter().max().map_or(0, |last| last + 1);
    let fits: Vec<Option<SVector<f64, PARAMETERS>>> = (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut random = Pcg32::new(SEED, draw as u64);
            let raw: Vec<f64> = (0..poses).map(|_| Exp1.sample(&mut random)).collect();
            let mean = raw.iter().sum::<f64>() / poses as f64;
            let weight = |sighting: usize| problem.weights[sighting] * raw[pose_of[sighting]] / mean;
            let weights = (0..problem.weights.len()).map(weight).collect();
            let drawn = adjust(&Problem { weights, ..problem.clone() }, state.clone()).ok()?;
            Some(difference(state, &drawn))
        })
        .collect();
    let fits: Vec<SVector<f64, PARAMETERS>> = fits.into_iter().flatten().collect();
    if (fits.len() as f64) < LEAST_SHARE * DRAWS as f64 { Err(AdjustError::Singular) } else { Ok(fits) }
}

/// Covariance of draws about the fit. The weights' own mean takes a degree of freedom, hence n / (n − 1) for n poses.
#[must_use]
pub fn covariance(draws: &[SVector<f64, PARAMETERS>], poses: usize) -> ParameterCovariance {
    let sum = draws.iter().fold(ParameterCovariance::zeros(), |sum, d| sum + d * d.transpose());
    let freedom = poses as f64 / (poses as f64 - 1.0).max(1.0);
    sum * freedom / draws.len().max(1) as f64
}

/// The parameters of as many draws when the camera, which is not fitted, is drawn from its covariance instead.
///
/// # Errors
/// When the covariance is none, or a draw has no fit.
pub fn with_drawn_camera(
    problem: &Problem,
    state: &State,
    covariance: &SMatrix<f64, INTRINSICS, INTRINSICS>,
) -> Result<Vec<SVector<f64, PARAMETERS>>, AdjustError> {
    let eigen = covariance.symmetric_eigen();
    let root = eigen.eigenvectors * SMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
    let fits: Option<Vec<SVector<f64, PARAMETERS>>> = (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut random = Pcg32::new(SEED + 1, draw as u64);
            let by = root * SVector::<f64, INTRINSICS>::from_fn(|_, _| StandardNormal.sample(&mut random));
            let mut intrinsics = state.intrinsics.to_array();
            intrinsics.iter_mut().zip(by.iter()).for_each(|(value, by)| *value += by);
            let drawn = State { intrinsics: Intrinsics::from_array(intrinsics), ..state.clone() };
            Some(difference(state, &adjust(problem, drawn).ok()?))
        })
        .collect();
    fits.ok_or(AdjustError::Singular)
}

fn difference(from: &State, to: &State) -> SVector<f64, PARAMETERS> {
    let mut difference = SVector::zeros();
    let cameras = from.intrinsics.to_array().into_iter().zip(to.intrinsics.to_array());
    cameras.enumerate().for_each(|(i, (from, to))| difference[i] = to - from);
    if let (Some(from), Some(to)) = (&from.plane, &to.plane) {
        let planes = from.variation_to(to);
        planes.into_iter().enumerate().for_each(|(i, by)| difference[INTRINSICS + i] = by);
    }
    difference
}

/// The jackknife's replicates over poses.
///
/// # Errors
/// When a pose cannot be left out.
pub fn jackknife(
    problem: &Problem,
    state: &State,
    pose_of: &[usize],
) -> Result<Vec<SVector<f64, PARAMETERS>>, AdjustError> {
    let poses = pose_of.iter().max().map_or(0, |last| last + 1);
    let scale = (poses as f64 - 1.0).max(0.0).sqrt();
    (0..poses)
        .into_par_iter()
        .map(|left_out| {
            let keep = |k: usize| if pose_of[k] == left_out { 0.0 } else { problem.weights[k] };
            let weights = (0..problem.weights.len()).map(keep).collect();
            let others = adjust(&Problem { weights, ..problem.clone() }, state.clone())?;
            Ok(scale * difference(state, &others))
        })
        .collect()
}
