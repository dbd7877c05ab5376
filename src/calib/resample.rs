//! What the views leave open: the parameters' covariance by a jackknife over poses (Tukey 1958).
//!
//! The errors of one picture are not independent: a warped board, a blurred picture or the stripe's speckle move all of
//! it. So whole poses are left out, one after another, instead of corners. A bootstrap over a dozen poses would come out too
//! small, since a fit follows each pose that it holds; what a pose that is left out changes has no such share (Bell & McCaffrey
//! 2002, on clusters of unlike leverage).

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::adjust::{AdjustError, Problem, State, adjust};
use super::intrinsics::{INTRINSICS, Intrinsics};
use super::laser_camera::{PARAMETERS, ParameterCovariance};

/// The parameters without each pose as differences from the fit of `state`, scaled by √(n − 1) for n poses: the mean of their
/// outer products is the covariance. `pose_of` numbers each sighting's pose.
///
/// # Errors
/// When the poses without one of them determine nothing.
pub fn replicates(
    problem: &Problem,
    state: &State,
    pose_of: &[usize],
) -> Result<Vec<SVector<f64, PARAMETERS>>, AdjustError> {
    let poses = pose_of.iter().max().map_or(0, |last| last + 1);
    let scale = (poses as f64 - 1.0).max(0.0).sqrt();
    (0..poses)
        .into_par_iter()
        .map(|left_out| {
            let weight = |sighting: usize| if pose_of[sighting] == left_out { 0.0 } else { problem.weights[sighting] };
            let weights = (0..problem.weights.len()).map(weight).collect();
            let others = adjust(&Problem { weights, ..problem.clone() }, state.clone())?;
            Ok(scale * difference(state, &others))
        })
        .collect()
}

/// The covariance of [`replicates`].
#[must_use]
pub fn covariance(replicates: &[SVector<f64, PARAMETERS>]) -> ParameterCovariance {
    outer_products(replicates) / replicates.len().max(1) as f64
}

/// What the covariance of a camera that is not fitted adds: the parameters are fitted anew one σ along each of its axes.
///
/// # Errors
/// When one of these cameras has no fit.
pub fn covariance_by_camera(
    problem: &Problem,
    state: &State,
    camera: &SMatrix<f64, INTRINSICS, INTRINSICS>,
) -> Result<ParameterCovariance, AdjustError> {
    let eigen = camera.symmetric_eigen();
    let root = eigen.eigenvectors * SMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
    let fits: Result<Vec<_>, _> = (0..INTRINSICS)
        .into_par_iter()
        .map(|axis| {
            let mut intrinsics = state.intrinsics.to_array();
            intrinsics.iter_mut().zip(root.column(axis).iter()).for_each(|(value, by)| *value += by);
            let moved = State { intrinsics: Intrinsics::from_array(intrinsics), ..state.clone() };
            Ok(difference(state, &adjust(problem, moved)?))
        })
        .collect();
    Ok(outer_products(&fits?))
}

fn outer_products(all: &[SVector<f64, PARAMETERS>]) -> ParameterCovariance {
    all.iter().fold(ParameterCovariance::zeros(), |sum, d| sum + d * d.transpose())
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
