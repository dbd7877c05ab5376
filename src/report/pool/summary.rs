//! `summary.json` of a melt pool.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::eval::Errors;
use crate::report::atomic::{ResultsError, write_atomically};
use crate::report::summary::{FrameCounts, SCHEMA_VERSION, Timing, round};
use crate::units::MmPerPx;

/// What tells a melt pool's summary from a seam's.
pub const SENSOR: &str = "melt-pool";

/// The content of `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoolSummary {
    /// [`SCHEMA_VERSION`] of the writer.
    pub schema_version: u32,
    /// `seamtrack x.y.z`.
    pub program: String,
    /// [`SENSOR`].
    pub sensor: String,
    /// What was read.
    pub input: PoolInput,
    /// The effective settings.
    pub config: Value,
    /// What turns pixels into millimetres.
    pub calibration: PoolCalibration,
    /// The filter's noise levels and where they come from.
    pub noise: Value,
    /// Frames by status; `saturated` counts those refused for it.
    pub frames: FrameCounts,
    /// Frames whose value was not taken, by reason.
    pub refused: BTreeMap<String, usize>,
    /// Largest part of the frames that may be without a value \[%\].
    pub max_unavailable_pct: f64,
    /// How long it took.
    pub timing: Timing,
    /// Errors against the truth, if it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub errors: Option<PoolErrors>,
}

/// What was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoolInput {
    /// The path as the user gave it.
    pub path: String,
    /// Columns of a frame \[px\].
    pub width_px: usize,
    /// Rows of a frame \[px\].
    pub height_px: usize,
    /// Folder, NumPy stack and so on.
    pub kind: String,
    /// Black and white of the recording, and the rule they were found by.
    pub scale: Value,
}

/// What turns pixels into millimetres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoolCalibration {
    /// Scale across the travel \[mm/px\].
    pub mm_per_px: MmPerPx,
    /// Coordinate across the travel where the tip's offset is 0 \[px\]; 0 for a width.
    pub zero_px: f64,
    /// Nobody gave the scale: it is the infrared paper's.
    #[serde(default)]
    pub assumed: bool,
}

/// Errors against the truth.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PoolErrors {
    /// Of the frame's own measure.
    pub measured: Option<Errors>,
    /// Of the filter.
    pub filtered: Option<Errors>,
    /// Of the smoother.
    pub smoothed: Option<Errors>,
}

/// Writes `summary.json`, errors and timing rounded.
///
/// # Errors
/// When the file cannot be written.
pub fn write_pool_summary(path: &Path, summary: &PoolSummary) -> Result<(), ResultsError> {
    write_atomically(path, |file| {
        let mut value = serde_json::to_value(summary)?;
        for key in ["timing", "errors"] {
            value.get_mut(key).into_iter().for_each(round);
        }
        serde_json::to_writer_pretty(&mut *file, &value)?;
        file.write_all(b"\n")
    })
}

/// Whether `dir/summary.json` is a melt pool's.
#[must_use]
pub fn is_pool_summary(dir: &Path) -> bool {
    let text = std::fs::read_to_string(dir.join("summary.json"));
    let value: Option<Value> = text.ok().and_then(|text| serde_json::from_str(&text).ok());
    value.is_some_and(|value| value.get("sensor").and_then(Value::as_str) == Some(SENSOR))
}

/// Reads `summary.json`.
///
/// # Errors
/// When the file cannot be read, or is not a melt pool's summary of this schema version.
pub fn read_pool_summary(path: &Path) -> Result<PoolSummary, ResultsError> {
    let text = std::fs::read_to_string(path).map_err(|source| ResultsError::Read { path: path.to_owned(), source })?;
    let summary: PoolSummary = serde_json::from_str(&text).map_err(|error| ResultsError::content(path, error))?;
    if summary.schema_version != SCHEMA_VERSION {
        let problem = format!(
            "schema version {}, this program reads {SCHEMA_VERSION}; measure the recording again",
            summary.schema_version
        );
        return Err(ResultsError::content(path, problem));
    }
    Ok(summary)
}
