//! The rows of a run against the truth.

use super::results::{Estimator, PathRow};
use super::summary::ErrorTable;
use crate::eval;
use crate::units::{MmPerPx, StripeAxis};

/// The errors of KCF, filter and smoother along the stripe; none when no frame has a truth.
#[must_use]
pub fn errors_against(
    rows: &[PathRow],
    truth_px: &[Option<f64>],
    axis: StripeAxis,
    scale: MmPerPx,
) -> Option<ErrorTable> {
    if truth_px.iter().all(Option::is_none) {
        return None;
    }
    let of = |estimator| {
        let estimates: Vec<_> = rows.iter().map(|row| estimate(row, estimator, axis, scale)).collect();
        eval::errors(&estimates, truth_px, scale)
    };
    Some(ErrorTable { kcf: of(Estimator::Kcf), filtered: of(Estimator::Filtered), smoothed: of(Estimator::Smoothed) })
}

fn estimate(row: &PathRow, estimator: Estimator, axis: StripeAxis, scale: MmPerPx) -> Option<eval::Estimate> {
    let std_mm = match estimator {
        Estimator::Kcf => None,
        Estimator::Filtered => row.x_std_mm,
        Estimator::Smoothed => row.smooth_x_std_mm,
    };
    let position_px = row.along_px(estimator, axis)?;
    Some(eval::Estimate { position_px, std_px: std_mm.map(|std_mm| std_mm / scale.get()) })
}
