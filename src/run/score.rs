//! A run's rows against the truth.

use crate::calib::Ruler;
use crate::eval::{PlaneErrors, PlaneValue, TruthRow, axis_errors};
use crate::report::errors::errors_against;
use crate::report::results::PathRow;
use crate::report::summary::ErrorTable;

/// A truth, and the recording's number of the run's first frame.
type Truth<'a> = (&'a [TruthRow], usize);

/// The rows of a truth with the number of their frame in the run.
fn in_run<'a>((truth, first_frame): Truth<'a>) -> impl Iterator<Item = (usize, &'a TruthRow)> {
    truth.iter().filter_map(move |row| Some((row.frame.checked_sub(first_frame)?, row)))
}

/// A truth has no line for any frame of the run: it is that of another recording.
#[derive(Debug, thiserror::Error)]
#[error("the truth has no frame of this recording")]
pub struct NoCommonFrame;

/// The errors of KCF, filter and smoother along the stripe, in the ruler's unit; none when the truth has no seam in any frame of
/// the run.
///
/// # Errors
/// When the truth has no line for any of its frames.
pub fn error_table(rows: &[PathRow], truth: Truth<'_>, ruler: &Ruler) -> Result<Option<ErrorTable>, NoCommonFrame> {
    if !in_run(truth).any(|(frame, _)| frame < rows.len()) {
        return Err(NoCommonFrame);
    }
    let mut truth_px = vec![None; rows.len()];
    for (frame, row) in in_run(truth) {
        // A truth may be longer than the path, when only a part was tracked.
        if let Some(place) = truth_px.get_mut(frame) {
            *place = row.along_px(ruler.axis);
        }
    }
    Ok(errors_against(rows, &truth_px, ruler))
}

/// Errors of the filtered path in the plane of a calibrated laser; none where the path or the truth has no place in it.
#[must_use]
pub fn plane_errors(rows: &[PathRow], truth: Truth<'_>) -> Option<PlaneErrors> {
    let both = || in_run(truth).filter_map(|(frame, truth)| Some((rows.get(frame)?, truth.plane_mm?)));
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
