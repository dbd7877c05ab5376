//! A run's rows against the truth.

use crate::calib::Ruler;
use crate::eval::{self, PlaneErrors, PlaneValue, TruthRow, axis_errors};
use crate::report::results::{Estimator, PathRow};
use crate::report::summary::ErrorTable;
use crate::units::LengthUnit;

/// The errors of KCF, filter and smoother along the stripe, in the ruler's unit; none when no frame of the run has a truth.
/// They are taken in pixels first, so that neither the origin nor the height enters.
#[must_use]
pub fn error_table(rows: &[PathRow], truth: &[TruthRow], ruler: &Ruler) -> Option<ErrorTable> {
    let mut truth_px = vec![None; rows.len()];
    for row in truth {
        // A truth may be longer than the path, when only a part was tracked.
        if let Some(place) = truth_px.get_mut(row.frame) {
            *place = row.along_px(ruler.axis);
        }
    }
    if truth_px.iter().all(Option::is_none) {
        return None;
    }
    let of = |estimator| {
        // A pixel of another row than the seam's may have no scale: then the frame has no error either.
        let scales: Vec<Option<f64>> =
            rows.iter().map(|row| ruler.sensor.scale_along(row.point(estimator)?, ruler.axis)).collect();
        let estimates: Vec<_> =
            rows.iter().zip(&scales).map(|(row, scale)| estimate(row, estimator, ruler, *scale)).collect();
        eval::errors_by(&estimates, &truth_px, ruler.unit(), |frame| scales[frame].unwrap_or(0.0))
    };
    Some(ErrorTable { kcf: of(Estimator::Kcf), filtered: of(Estimator::Filtered), smoothed: of(Estimator::Smoothed) })
}

fn estimate(row: &PathRow, estimator: Estimator, ruler: &Ruler, scale: Option<f64>) -> Option<eval::Estimate> {
    let (position_px, scale) = (row.along_px(estimator, ruler.axis)?, scale?);
    // Paths of version 0.1.0 have their σ in millimetres only.
    let in_mm = || row.sigma(estimator, LengthUnit::Mm).map(|std_mm| std_mm / scale);
    Some(eval::Estimate { position_px, std_px: row.sigma(estimator, LengthUnit::Px).or_else(in_mm) })
}

/// Errors of the filtered path in the plane of a calibrated laser; none where the path or the truth has no place in it.
#[must_use]
pub fn plane_errors(rows: &[PathRow], truth: &[TruthRow]) -> Option<PlaneErrors> {
    let both = || truth.iter().filter_map(|truth| Some((rows.get(truth.frame)?, truth.plane_mm?)));
    let lateral: Vec<PlaneValue> = both()
        .filter_map(|(row, [lateral_mm, _])| {
            let error_mm = row.lateral_mm? - lateral_mm;
            Some(PlaneValue { error_mm, noise_std_mm: row.lateral_std_mm?, calib_std_mm: row.calib_lateral_std_mm })
        })
        .collect();
    let height: Vec<PlaneValue> = both()
        .filter_map(|(row, [_, height_mm])| {
            let error_mm = row.height_mm? - height_mm;
            Some(PlaneValue { error_mm, noise_std_mm: row.height_std_mm?, calib_std_mm: row.calib_height_std_mm })
        })
        .collect();
    Some(PlaneErrors { lateral: axis_errors(&lateral)?, height: axis_errors(&height)? })
}
