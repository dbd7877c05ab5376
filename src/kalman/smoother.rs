//! The states of a recorded series given all its measurements, or those up to a fixed lag.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{SMatrix, SVector};

use super::gaussian::{Gaussian, symmetric};
use super::series::{Step, Trajectory};

/// A prediction whose covariance cannot be inverted, which Rauch–Tung–Striebel needs: use [`bryson_frazier`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("step {step}: the predicted covariance is singular, so the Rauch-Tung-Striebel smoother has no gain")]
pub struct SingularPrediction {
    /// The step, from 0.
    pub step: usize,
}

/// What the measurements from a step on say about the state before it: x given all = x − P λ, P given all = P − P Λ P.
#[derive(Debug, Clone, Copy)]
struct Adjoint<const N: usize> {
    lambda: SVector<f64, N>,
    Lambda: SMatrix<f64, N, N>,
}

impl<const N: usize> Adjoint<N> {
    fn nothing() -> Self {
        Self { lambda: SVector::zeros(), Lambda: SMatrix::zeros() }
    }

    /// Takes a step's measurement and transition in, from the adjoint after the step to that before it.
    fn through<const M: usize>(&self, step: &Step<N, M>) -> Self {
        let update = &step.update;
        let mut H = step.space.H;
        let mut e = SVector::<f64, M>::zeros();
        for (row, innovation) in update.innovation.iter().enumerate() {
            match innovation {
                Some(value) => e[row] = *value,
                None => H.row_mut(row).fill(0.0),
            }
        }
        let HtSi = H.transpose() * update.S_inverse;
        let I_KH = SMatrix::<f64, N, N>::identity() - update.K * H;
        let lambda = I_KH.transpose() * self.lambda - HtSi * e;
        let Lambda = I_KH.transpose() * self.Lambda * I_KH + HtSi * H;
        let F = &step.space.F;
        Self { lambda: F.transpose() * lambda, Lambda: symmetric(F.transpose() * Lambda * F) }
    }

    fn smooth(&self, filtered: &Gaussian<N>) -> Gaussian<N> {
        let P = filtered.P;
        Gaussian { x: filtered.x - P * self.lambda, P: symmetric(P - P * self.Lambda * P) }
    }
}

/// The states given the whole series, the start first, by the modified Bryson–Frazier recursion (Bierman 1973): no
/// covariance is inverted, so R = 0 and singular predictions are no obstacle.
#[must_use]
pub fn bryson_frazier<const N: usize, const M: usize>(trajectory: &Trajectory<N, M>) -> Vec<Gaussian<N>> {
    let mut adjoint = Adjoint::nothing();
    let mut smoothed: Vec<_> = trajectory.filtered().copied().collect();
    for (index, step) in trajectory.steps.iter().enumerate().rev() {
        adjoint = adjoint.through(step);
        smoothed[index] = adjoint.smooth(&smoothed[index]);
    }
    smoothed
}

/// Longest lag that the program takes \[frames\]: each frame costs as many steps as the lag has. Chosen: dozens of frames tell
/// all that later ones can.
pub const LONGEST_LAG: usize = 1000;

/// The states, the start first, each given the measurements up to `lag` frames after it.
#[must_use]
pub fn fixed_lag<const N: usize, const M: usize>(trajectory: &Trajectory<N, M>, lag: usize) -> Vec<Gaussian<N>> {
    let steps = &trajectory.steps;
    if lag >= steps.len() {
        return bryson_frazier(trajectory);
    }
    let later = |index: usize| &steps[index..steps.len().min(index + lag)];
    let adjoint = |index| later(index).iter().rev().fold(Adjoint::nothing(), |adjoint, step| adjoint.through(step));
    trajectory.filtered().enumerate().map(|(index, filtered)| adjoint(index).smooth(filtered)).collect()
}

/// The states given the whole series, the start first, by the Rauch–Tung–Striebel recursion (1965).
///
/// # Errors
/// When a predicted covariance is singular.
pub fn rauch_tung_striebel<const N: usize, const M: usize>(
    trajectory: &Trajectory<N, M>,
) -> Result<Vec<Gaussian<N>>, SingularPrediction> {
    let mut smoothed: Vec<_> = trajectory.filtered().copied().collect();
    for (index, step) in trajectory.steps.iter().enumerate().rev() {
        let filtered = smoothed[index];
        let after = smoothed[index + 1];
        let inverse = step.prior.P.cholesky().ok_or(SingularPrediction { step: index })?;
        let C = inverse.solve(&(step.space.F * filtered.P)).transpose();
        smoothed[index] = Gaussian {
            x: filtered.x + C * (after.x - step.prior.x),
            P: symmetric(filtered.P + C * (after.P - step.prior.P) * C.transpose()),
        };
    }
    Ok(smoothed)
}
