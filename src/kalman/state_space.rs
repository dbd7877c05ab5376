//! A linear Gaussian model over one step of time, and what makes its parameters acceptable.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{SMatrix, SVector};

/// Relative size of a negative eigenvalue that is still taken for rounding, chosen: ten thousand times the double's
/// own rounding.
const PSD_TOLERANCE: f64 = 1e-12;

/// x₊ = F x + w, w ~ N(0, Qd); z = H x + v, v ~ N(0, R), over one step of time.
///
/// N is the size of the state, M that of the measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateSpace<const N: usize, const M: usize> {
    /// Transition over the step, N×N.
    pub F: SMatrix<f64, N, N>,
    /// Covariance of the process noise gathered over the step, N×N.
    pub Qd: SMatrix<f64, N, N>,
    /// Measurement from state, M×N.
    pub H: SMatrix<f64, M, N>,
    /// Covariance of the measurement noise, M×M.
    pub R: SMatrix<f64, M, M>,
}

impl<const N: usize, const M: usize> StateSpace<N, M> {
    /// A model from its four matrices.
    ///
    /// # Errors
    /// When a number is not finite, or Qd or R is not a covariance.
    pub fn new(
        F: SMatrix<f64, N, N>,
        Qd: SMatrix<f64, N, N>,
        H: SMatrix<f64, M, N>,
        R: SMatrix<f64, M, M>,
    ) -> Result<Self, InvalidParameter> {
        if !F.iter().chain(H.iter()).all(|value| value.is_finite()) {
            return Err(InvalidParameter::NotFinite { name: "F or H" });
        }
        check_covariance("Qd", &Qd)?;
        check_covariance("R", &R)?;
        Ok(Self { F, Qd, H, R })
    }

    /// The same model with another measurement noise, for a measurement whose own quality is known.
    #[must_use]
    pub const fn with_R(self, R: SMatrix<f64, M, M>) -> Self {
        Self { R, ..self }
    }

    /// The measurement this model expects in state `x`.
    #[must_use]
    pub fn measurement_from_state(&self, x: &SVector<f64, N>) -> SVector<f64, M> {
        self.H * x
    }
}

/// A parameter no filter can be built from.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum InvalidParameter {
    /// The number, or one of the matrix's, is NaN or infinite.
    #[error("{name} is not finite: give a number")]
    NotFinite {
        /// The parameter.
        name: &'static str,
    },
    /// A step of time, gap or period must be positive.
    #[error("{name} is {value}, but must be greater than 0")]
    NotPositive {
        /// The parameter, with its unit.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// A variance may be zero, never negative.
    #[error("{name} is {value}, but must not be negative")]
    Negative {
        /// The parameter, with its unit.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// A first-order autoregression is stationary only inside the unit circle.
    #[error("{name} is {value}, but must lie between -1 and 1, both excluded")]
    NotStationary {
        /// The parameter.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// A probability lies between 0 and 1.
    #[error("{name} is {value}, but must lie between 0 and 1")]
    NotAProbability {
        /// The parameter.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// With neither white nor coloured measurement noise the innovation's variance can reach zero.
    #[error("both measurement noises are 0, so the innovation would have no variance: give one of them")]
    NoMeasurementNoise,
    /// The matrix is not symmetric positive semidefinite.
    #[error("{name} is not a covariance: it must be symmetric with no negative eigenvalue")]
    NotACovariance {
        /// The matrix.
        name: &'static str,
    },
}

/// Passes a finite number on.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<f64, InvalidParameter> {
    if value.is_finite() { Ok(value) } else { Err(InvalidParameter::NotFinite { name }) }
}

/// Passes a finite number greater than zero on.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, InvalidParameter> {
    if finite(name, value)? > 0.0 { Ok(value) } else { Err(InvalidParameter::NotPositive { name, value }) }
}

/// Passes a finite number not below zero on.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<f64, InvalidParameter> {
    if finite(name, value)? >= 0.0 { Ok(value) } else { Err(InvalidParameter::Negative { name, value }) }
}

/// Passes the coefficient of a stationary first-order autoregression on.
pub(crate) fn stationary(name: &'static str, value: f64) -> Result<f64, InvalidParameter> {
    if finite(name, value)?.abs() < 1.0 { Ok(value) } else { Err(InvalidParameter::NotStationary { name, value }) }
}

/// Whether `matrix` is positive semidefinite to rounding; it must be symmetric already.
pub(crate) fn is_semidefinite<const N: usize>(matrix: &SMatrix<f64, N, N>) -> bool {
    // An entry of a semidefinite matrix never exceeds its diagonal; scaling the diagonal to one makes the tolerance
    // fit rows of different units.
    let scale = matrix.map_diagonal(|d| if d > 0.0 { d.sqrt() } else { 1.0 });
    let correlation = SMatrix::<f64, N, N>::from_fn(|i, j| matrix[(i, j)] / (scale[i] * scale[j]));
    (correlation + SMatrix::identity() * PSD_TOLERANCE).cholesky().is_some()
}

/// Refuses a matrix that is not a covariance.
pub(crate) fn check_covariance<const N: usize>(
    name: &'static str,
    matrix: &SMatrix<f64, N, N>,
) -> Result<(), InvalidParameter> {
    if !matrix.iter().all(|value| value.is_finite()) {
        return Err(InvalidParameter::NotFinite { name });
    }
    let size = matrix.amax();
    let symmetric = (matrix - matrix.transpose()).amax() <= PSD_TOLERANCE * size;
    if symmetric && is_semidefinite(matrix) { Ok(()) } else { Err(InvalidParameter::NotACovariance { name }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{matrix, vector};

    #[test]
    fn a_matrix_with_a_negative_eigenvalue_is_no_covariance() {
        let refused = check_covariance("P", &matrix![1.0, 2.0; 2.0, 1.0]);
        assert_eq!(refused, Err(InvalidParameter::NotACovariance { name: "P" }));
        assert!(check_covariance("P", &matrix![1.0, 1.0; 0.0, 1.0]).is_err());
        assert!(check_covariance("P", &matrix![1.0, 0.0; 0.0, f64::NAN]).is_err());
        assert!(check_covariance("P", &matrix![-1e-3]).is_err());
    }

    #[test]
    fn a_singular_covariance_is_accepted_in_any_unit() {
        let g = vector![1e-4, 1.0];
        assert!(check_covariance("Qd", &(g * g.transpose())).is_ok());
        assert!(check_covariance("Qd", &(g * g.transpose() * 1e9)).is_ok());
        assert!(check_covariance("Qd", &SMatrix::<f64, 3, 3>::zeros()).is_ok());
    }
}
