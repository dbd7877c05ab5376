//! Whether a filter's own idea of its error is right: NEES against the truth, the mean NIS without one.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::SVector;

use super::gaussian::Gaussian;

/// 99.95 % point of the normal distribution: both sides of a 99.9 % band.
const Z_999: f64 = 3.290_526_731_491_926;

/// Normalised estimation error squared (x − x̂)ᵀ P⁻¹ (x − x̂), on average N for a consistent filter; none when P is
/// singular.
#[must_use]
pub fn nees<const N: usize>(estimate: &Gaussian<N>, truth: &SVector<f64, N>) -> Option<f64> {
    let error = truth - estimate.x;
    let P = estimate.P.cholesky()?;
    Some(error.dot(&P.solve(&error)))
}

/// The band in which the mean of `count` values of χ² with `dof` degrees of freedom lies in 99.9 % of all cases, by
/// Wilson and Hilferty's approximation (within 0.002 of the exact band from 50 values on).
#[must_use]
pub fn mean_band_999(count: usize, dof: usize) -> (f64, f64) {
    #[expect(clippy::cast_precision_loss, reason = "counts far below 2⁵²")]
    let (total, dof) = ((count * dof).max(1) as f64, dof as f64);
    let spread = 2.0 / (9.0 * total);
    let point = |z: f64| dof * (1.0 - spread + z * spread.sqrt()).max(0.0).powi(3);
    (point(-Z_999), point(Z_999))
}
