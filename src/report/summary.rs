//! `summary.json`: what a run was, in numbers.
//!
//! Keys may be added; a key that goes or changes its meaning takes a new [`SCHEMA_VERSION`]. Timing is the only part
//! that may differ between two equal runs.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::atomic::{ResultsError, write_atomically};
use super::results::Estimator;
use super::tolerance::Tolerance;
use crate::calib::file::CalibrationFile;
use crate::calib::{KnownSensor, Sensor};
use crate::eval::{Errors, PlaneErrors};
use crate::units::{MmPerPx, PixelPoint, StripeAxis};

/// Version of `summary.json` and `path.csv` together.
pub const SCHEMA_VERSION: u32 = 1;

/// The content of `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// [`SCHEMA_VERSION`] of the writer.
    pub schema_version: u32,
    /// `seamtrack x.y.z`.
    pub program: String,
    /// What was read.
    pub input: Input,
    /// The effective configuration, as it stands in the TOML file.
    pub config: Value,
    /// The scale and the axis that turn pixels into millimetres.
    pub calibration: Calibration,
    /// Limits drawn in the plots.
    #[serde(default)]
    pub limits: Limits,
    /// Frames by status.
    pub frames: FrameCounts,
    /// The kind of joint and how it was decided.
    pub joint: Joint,
    /// How long it took.
    pub timing: Timing,
    /// Errors against the truth, if it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub errors: Option<ErrorTable>,
    /// Errors of the filtered path in the plane of a calibrated laser, if the truth has a place in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane_errors: Option<PlaneErrors>,
    /// The path within its tolerance, if one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Tolerance>,
}

/// What was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// The path as the user gave it.
    pub path: String,
    /// Columns of a frame \[px\].
    pub width_px: usize,
    /// Rows of a frame \[px\].
    pub height_px: usize,
    /// Anything else worth saying (kind, 16-bit scale …).
    #[serde(flatten)]
    pub more: Map<String, Value>,
}

/// Key of [`Input::more`] for the recording's number of the run's first frame, with `--frames`.
pub const FIRST_FRAME: &str = "first_frame";

impl Input {
    /// The recording's number of the run's first frame: 0 without `--frames`.
    #[must_use]
    pub fn first_frame(&self) -> usize {
        self.more.get(FIRST_FRAME).and_then(Value::as_u64).map_or(0, |first| first as usize)
    }
}

/// What turned the pixels of a run into millimetres, if anything did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// One scale along the stripe \[mm/px\]; absent without a scale, and where camera and laser plane are calibrated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mm_per_px: Option<MmPerPx>,
    /// σ of that scale, where it is known \[mm/px\]: all millimetres are off by the same share.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_mm_per_px: Option<f64>,
    /// Which way the stripe runs.
    pub stripe: StripeAxis,
    /// Coordinate along the stripe where `x_mm` is 0 \[px\]; absent when nothing was tracked.
    pub origin_px: Option<f64>,
    /// That across the stripe, where it matters \[px\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin_across_px: Option<f64>,
    /// Where the scale comes from, in words.
    pub source: String,
    /// The calibration file's own account of camera, laser plane and range, without covariance and boards.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<Box<CalibrationFile>>,
    /// Anything else worth saying.
    #[serde(flatten)]
    pub more: Map<String, Value>,
}

impl Calibration {
    /// Nobody said what a pixel is.
    #[must_use]
    pub fn unknown(stripe: StripeAxis) -> Self {
        Self::of(&KnownSensor::unknown(), stripe, None)
    }

    /// What is known of a sensor, and the pixel where `x_mm` is 0.
    #[must_use]
    pub fn of(known: &KnownSensor, stripe: StripeAxis, origin: Option<PixelPoint>) -> Self {
        let is_plane = known.sensor.laser_camera().is_some();
        let own = |file: &CalibrationFile| {
            let (covariance, views, images) = (None, vec![], vec![]);
            Box::new(CalibrationFile { covariance, views, images, ..file.clone() })
        };
        Self {
            mm_per_px: if let Sensor::Scale(mm_per_px) = known.sensor { Some(mm_per_px) } else { None },
            std_mm_per_px: known.std_mm_per_px,
            stripe,
            origin_px: origin.map(|origin| stripe.along_px(origin)),
            origin_across_px: origin.filter(|_| is_plane).map(|origin| stripe.across_px(origin)),
            source: known.source.clone(),
            file: known.file.as_ref().map(own),
            more: Map::new(),
        }
    }

    /// The sensor, without its uncertainty.
    #[must_use]
    pub fn sensor(&self) -> Sensor {
        let plane = || self.file.as_ref()?.laser_camera().ok();
        match self.mm_per_px {
            Some(mm_per_px) => Sensor::Scale(mm_per_px),
            None => plane().map_or(Sensor::Pixels, |sensor| Sensor::Plane(Arc::new(sensor))),
        }
    }

    /// The scale in a few words.
    #[must_use]
    pub fn words(&self) -> String {
        let source = &self.source;
        match (self.mm_per_px, self.std_mm_per_px, &self.file) {
            (Some(scale), Some(std), _) => format!("{} ± {std:.6} mm/px ({source})", scale.get()),
            (Some(scale), None, _) => format!("{} mm/px ({source})", scale.get()),
            (None, _, Some(file)) => format!("Millimetres by {source} ({}, {})", file.id, file.date),
            (None, _, None) => "Lengths in pixels".to_owned(),
        }
    }
}

/// Limits that give the plots and the verdict their meaning.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Limits {
    /// Below this PSR the template does not learn.
    pub psr: Option<f64>,
    /// Above this NIS an observation is refused.
    pub nis: Option<f64>,
    /// `--max-unavailable` \[% of the frames\].
    pub max_unavailable_pct: Option<f64>,
    /// `--tolerance`: half the width of the band that the path is to stay in \[mm\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance_mm: Option<f64>,
}

/// Frames by status. `repeated` and `saturated` frames are counted under their status as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the statuses of `path.csv`")]
pub struct FrameCounts {
    pub total: usize,
    pub seeking: usize,
    pub tracked: usize,
    pub coasting: usize,
    pub lost: usize,
    pub unreadable: usize,
    /// Frames equal to their predecessor byte for byte.
    pub repeated: usize,
    /// Frames of which over a twentieth is at full scale.
    pub saturated: usize,
    /// Frames whose picture had not changed for so long that the camera must have stopped.
    #[serde(default)]
    pub frozen: usize,
    /// Frames whose stamp is no number or not later than the one before.
    #[serde(default)]
    pub bad_stamps: usize,
}

/// The kind of joint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Joint {
    /// butt, lap, vgroove, fillet, or none.
    pub kind: String,
    /// The frame of the decision, if one was made.
    pub decided_at_frame: Option<usize>,
    /// Why, in one sentence.
    pub reason: String,
    /// What else it may be, where frames and time cannot tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
    /// The kind that the frames show where another was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contradicted_by: Option<String>,
    /// Joints found later in the recording, or the same one found again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub later: Vec<Self>,
}

/// How long a run took.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Reading and decoding one frame.
    pub decode_ms: Percentiles,
    /// One step of the tracker.
    pub track_ms: Percentiles,
    /// Frames by wall clock.
    pub frames_per_second: f64,
}

/// Percentiles of a duration \[ms\].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are their own names")]
pub struct Percentiles {
    pub p50: f64,
    pub p99: f64,
    pub max: f64,
}

impl Percentiles {
    /// Nearest-rank percentiles of `durations_ms`; zeros when there are none.
    #[must_use]
    pub fn of(durations_ms: &[f64]) -> Self {
        let mut sorted = durations_ms.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let rank = (share * sorted.len() as f64).ceil() as usize;
            sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
        };
        Self { p50: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}

/// Errors of the three estimates.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the estimators of `path.csv`")]
pub struct ErrorTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kcf: Option<Errors>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filtered: Option<Errors>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smoothed: Option<Errors>,
}

impl ErrorTable {
    /// The errors of one estimator.
    #[must_use]
    pub const fn of(&self, estimator: Estimator) -> Option<&Errors> {
        match estimator {
            Estimator::Kcf => self.kcf.as_ref(),
            Estimator::Filtered => self.filtered.as_ref(),
            Estimator::Smoothed => self.smoothed.as_ref(),
        }
    }
}

/// Write `summary.json`. Numbers of errors and timing are rounded to [`DECIMALS`].
///
/// # Errors
/// When the file cannot be written.
pub fn write_summary(path: &Path, summary: &Summary) -> Result<(), ResultsError> {
    write_atomically(path, |file| {
        serde_json::to_writer_pretty(&mut *file, &summary_json(summary)?)?;
        file.write_all(b"\n")
    })
}

/// The content of `summary.json`, rounded as in the file.
///
/// # Errors
/// When a number is not finite.
pub fn summary_json(summary: &Summary) -> Result<Value, serde_json::Error> {
    let mut value = serde_json::to_value(summary)?;
    for key in ["timing", "errors", "plane_errors", "tolerance"] {
        value.get_mut(key).into_iter().for_each(round);
    }
    Ok(value)
}

/// Decimals of millimetres and milliseconds in `summary.json`: a nanometre, far below any error.
pub const DECIMALS: i32 = 6;

pub(super) fn round(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() => {
            let scale = 10_f64.powi(DECIMALS);
            let rounded = number.as_f64().map(|x| (x * scale).round() / scale + 0.0);
            if let Some(rounded) = rounded.and_then(serde_json::Number::from_f64) {
                *number = rounded;
            }
        }
        Value::Object(map) => map.values_mut().for_each(round),
        Value::Array(list) => list.iter_mut().for_each(round),
        _ => {}
    }
}

/// Read `summary.json`.
///
/// # Errors
/// When the file cannot be read, or is not a summary of this schema version.
pub fn read_summary(path: &Path) -> Result<Summary, ResultsError> {
    let text = std::fs::read_to_string(path).map_err(|source| ResultsError::Read { path: path.to_owned(), source })?;
    let value: Value = serde_json::from_str(&text).map_err(|error| ResultsError::content(path, error))?;
    let version = value.get("schema_version").and_then(Value::as_u64);
    if version != Some(u64::from(SCHEMA_VERSION)) {
        let found = version.map_or("none".to_owned(), |v| v.to_string());
        let problem = format!("schema version {found}, this program reads {SCHEMA_VERSION}; track the recording again");
        return Err(ResultsError::content(path, problem));
    }
    serde_json::from_value(value).map_err(|error| ResultsError::content(path, error))
}
