//! The truth a run was judged by, kept beside its results as `truth.csv`.

use std::path::Path;

use crate::eval::{TruthFileError, read_truth};
use crate::units::StripeAxis;

/// Name of the copy beside `path.csv`.
pub const FILE_NAME: &str = "truth.csv";

/// The true coordinate along the stripe of each of `frames` frames \[px\], of which the first is the recording's `first`;
/// `None` when there is no file.
///
/// # Errors
/// When the file is no truth.
pub fn read_truth_along_px(
    path: &Path,
    axis: StripeAxis,
    (first, frames): (usize, usize),
) -> Result<Option<Vec<Option<f64>>>, TruthFileError> {
    if !path.exists() {
        return Ok(None);
    }
    let mut along_px = vec![None; frames];
    for row in read_truth(path)? {
        if let Some(place) = row.frame.checked_sub(first).and_then(|frame| along_px.get_mut(frame)) {
            *place = row.along_px(axis);
        }
    }
    Ok(Some(along_px))
}
