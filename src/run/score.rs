//! A run's rows against the truth.

use crate::eval::TruthRow;
use crate::report::errors::errors_against;
use crate::report::results::PathRow;
use crate::report::summary::ErrorTable;
use crate::units::{MmPerPx, StripeAxis};

/// The errors of KCF, filter and smoother along the stripe; none when no frame of the run has a truth. The run's first frame is
/// the recording's `first_frame`.
#[must_use]
pub fn error_table(
    rows: &[PathRow],
    (truth, first_frame): (&[TruthRow], usize),
    axis: StripeAxis,
    scale: MmPerPx,
) -> Option<ErrorTable> {
    let mut truth_px = vec![None; rows.len()];
    for row in truth {
        // A truth may be longer than the path, when only a part was tracked.
        if let Some(place) = row.frame.checked_sub(first_frame).and_then(|frame| truth_px.get_mut(frame)) {
            *place = row.along_px(axis);
        }
    }
    errors_against(rows, &truth_px, axis, scale)
}
