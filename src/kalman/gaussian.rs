//! The filter's recursion: predict and update of a Gaussian state.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use std::f64::consts::TAU;

use nalgebra::{SMatrix, SVector};

use super::state_space::{InvalidParameter, StateSpace, check_covariance};

/// What is known of the state: N(x, P).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian<const N: usize> {
    /// Mean.
    pub x: SVector<f64, N>,
    /// Covariance, N×N, symmetric.
    pub P: SMatrix<f64, N, N>,
}

/// Bounds the influence of an outlier: an innovation whose NIS exceeds γ is used with weight f = γ/NIS, that is with
/// R inflated to R + (1/f − 1) S.
///
/// The rule redescends, so a lasting jump is followed only slowly: pair it with a way to start anew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChiSquareGate<const M: usize> {
    /// γ for 1, 2, … M rows measured.
    pub thresholds: [f64; M],
}

impl ChiSquareGate<1> {
    /// 99 % point of χ² with one degree of freedom.
    pub const P99: Self = Self { thresholds: [6.635] };
}

impl ChiSquareGate<2> {
    /// 99 % points of χ² with one and two degrees of freedom.
    pub const P99: Self = Self { thresholds: [6.635, 9.21] };
}

/// The outcome of one update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Update<const N: usize, const M: usize> {
    /// The state after the measurement.
    pub posterior: Gaussian<N>,
    /// z − H x, row by row; none where the row was not measured.
    pub innovation: [Option<f64>; M],
    /// Covariance of the innovation as used, inflated where the gate was. A row not measured stands uncorrelated
    /// beside the others and means nothing.
    pub S: SMatrix<f64, M, M>,
    /// Inverse of [`Update::S`].
    pub S_inverse: SMatrix<f64, M, M>,
    /// Gain as used, N×M; zero in the column of a row not measured.
    pub K: SMatrix<f64, N, M>,
    /// Normalised innovation squared eᵀ S⁻¹ e before any inflation; none when nothing was measured.
    pub nis: Option<f64>,
    /// Log-likelihood of the innovation under the S used; 0 when nothing was measured.
    pub log_likelihood: f64,
    /// f: 1 unless the gate reduced it.
    pub weight: f64,
}

/// The innovation's covariance is not positive definite: the model has no measurement noise, or P is no covariance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the innovation's covariance is not positive definite: the measurement noise is 0 or P is not a covariance")]
pub struct InnovationNotPositive;

impl<const N: usize> Gaussian<N> {
    /// A state from its mean and covariance.
    ///
    /// # Errors
    /// When a number is not finite or P is not a covariance.
    pub fn new(x: SVector<f64, N>, P: SMatrix<f64, N, N>) -> Result<Self, InvalidParameter> {
        if !x.iter().all(|value| value.is_finite()) {
            return Err(InvalidParameter::NotFinite { name: "x" });
        }
        check_covariance("P", &P)?;
        Ok(Self { x, P })
    }

    /// The state one step later: F x, F P Fᵀ + Qd.
    #[must_use]
    pub fn predict<const M: usize>(&self, space: &StateSpace<N, M>) -> Self {
        Self { x: space.F * self.x, P: symmetric(space.F * self.P * space.F.transpose() + space.Qd) }
    }

    /// The state after a measurement, in Joseph form. A row that is none or not finite counts as not measured; with
    /// no row measured the state stays as it is.
    ///
    /// # Errors
    /// When S is not positive definite.
    pub fn update<const M: usize>(
        &self,
        space: &StateSpace<N, M>,
        z: &[Option<f64>; M],
        gate: Option<ChiSquareGate<M>>,
    ) -> Result<Update<N, M>, InnovationNotPositive> {
        // A row not measured gets H = 0, R = 1, e = 0: S falls into blocks and the row changes nothing.
        let mut H = space.H;
        let mut R = space.R;
        let mut e = SVector::<f64, M>::zeros();
        let mut innovation = [None; M];
        let mut rows = 0;
        let expected = space.H * self.x;
        for (row, measured) in z.iter().enumerate() {
            if let Some(value) = measured.filter(|value| value.is_finite()) {
                e[row] = value - expected[row];
                innovation[row] = Some(e[row]);
                rows += 1;
            } else {
                H.row_mut(row).fill(0.0);
                R.row_mut(row).fill(0.0);
                R.column_mut(row).fill(0.0);
                R[(row, row)] = 1.0;
            }
        }
        if rows == 0 {
            return Ok(Update {
                posterior: *self,
                innovation,
                S: SMatrix::identity(),
                S_inverse: SMatrix::identity(),
                K: SMatrix::zeros(),
                nis: None,
                log_likelihood: 0.0,
                weight: 1.0,
            });
        }
        let PHt = self.P * H.transpose();
        let S = symmetric(H * PHt + R);
        let cholesky = S.cholesky().ok_or(InnovationNotPositive)?;
        let nis = e.dot(&cholesky.solve(&e));
        let weight = gate.map_or(1.0, |gate| (gate.thresholds[rows - 1] / nis).min(1.0));
        let K = cholesky.solve(&PHt.transpose()).transpose() * weight;
        let R_used = R + S * (1.0 / weight - 1.0);
        let I_KH = SMatrix::<f64, N, N>::identity() - K * H;
        let P = symmetric(I_KH * self.P * I_KH.transpose() + K * R_used * K.transpose());
        #[expect(clippy::cast_precision_loss, reason = "a handful of rows")]
        let rows = rows as f64;
        let log_det = 2.0 * cholesky.l_dirty().diagonal().map(f64::ln).sum() - rows * weight.ln();
        let log_likelihood = -0.5 * (nis * weight + log_det + rows * TAU.ln());
        Ok(Update {
            posterior: Self { x: self.x + K * e, P },
            innovation,
            S: S / weight,
            S_inverse: cholesky.inverse() * weight,
            K,
            nis: Some(nis),
            log_likelihood,
            weight,
        })
    }
}

/// The symmetric part of a matrix.
pub(crate) fn symmetric<const N: usize>(matrix: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    (matrix + matrix.transpose()) * 0.5
}
