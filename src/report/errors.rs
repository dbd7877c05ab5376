//! The rows of a run against the truth.

use super::results::{Estimator, PathRow};
use super::summary::ErrorTable;
use crate::calib::Ruler;
use crate::eval;
use crate::units::LengthUnit;

/// The errors of KCF, filter and smoother along the stripe, in the ruler's unit; none when no frame has a truth. They are taken
/// in pixels first, so that neither the origin nor the height enters.
#[must_use]
pub fn errors_against(rows: &[PathRow], truth_px: &[Option<f64>], ruler: &Ruler) -> Option<ErrorTable> {
    if truth_px.iter().all(Option::is_none) {
        return None;
    }
    let of = |estimator| {
        // A pixel of another row than the seam's may have no scale: then the frame has no error either.
        let scales: Vec<Option<f64>> =
            rows.iter().map(|row| ruler.sensor.scale_along(row.point(estimator)?, ruler.axis)).collect();
        let estimates: Vec<_> =
            rows.iter().zip(&scales).map(|(row, scale)| estimate(row, estimator, ruler, *scale)).collect();
        eval::errors_by(&estimates, truth_px, ruler.unit(), |frame| scales[frame].unwrap_or(0.0))
    };
    Some(ErrorTable { kcf: of(Estimator::Kcf), filtered: of(Estimator::Filtered), smoothed: of(Estimator::Smoothed) })
}

fn estimate(row: &PathRow, estimator: Estimator, ruler: &Ruler, scale: Option<f64>) -> Option<eval::Estimate> {
    let (position_px, scale) = (row.along_px(estimator, ruler.axis)?, scale?);
    // Paths of version 0.1.0 have their σ in millimetres only.
    let in_mm = || row.sigma(estimator, LengthUnit::Mm).map(|std_mm| std_mm / scale);
    Some(eval::Estimate { position_px, std_px: row.sigma(estimator, LengthUnit::Px).or_else(in_mm) })
}
