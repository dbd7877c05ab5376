//! The truth a run was judged by, kept beside its results as `truth.csv`.

use std::path::Path;

use serde::Deserialize;

use super::atomic::ResultsError;
use crate::units::StripeAxis;

/// Name of the copy beside `path.csv`.
pub const FILE_NAME: &str = "truth.csv";

#[derive(Deserialize)]
struct TruthRow {
    frame: usize,
    u_px: Option<f64>,
    v_px: Option<f64>,
}

/// The true coordinate along the stripe of each of `frames` frames \[px\]; `None` when there is no file.
///
/// # Errors
/// When the file cannot be read or lacks the column of the stripe's axis.
pub fn read_truth_along_px(
    path: &Path,
    axis: StripeAxis,
    frames: usize,
) -> Result<Option<Vec<Option<f64>>>, ResultsError> {
    if !path.exists() {
        return Ok(None);
    }
    let mut along_px = vec![None; frames];
    let mut reader = csv::Reader::from_path(path).map_err(|error| ResultsError::content(path, error))?;
    for row in reader.deserialize() {
        let row: TruthRow = row.map_err(|error| ResultsError::content(path, error))?;
        let value = match axis {
            StripeAxis::Horizontal => row.u_px,
            StripeAxis::Vertical => row.v_px,
        };
        if let Some(place) = along_px.get_mut(row.frame) {
            *place = value.filter(|px| px.is_finite());
        }
    }
    Ok(Some(along_px))
}
