//! A whole recording: the table of `path.csv`, the summary and the verdict.

use std::path::{Path, PathBuf};

use numpy::IntoPyArray;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use seamtrack::calib::{KnownSensor, Origin};
use seamtrack::config;
use seamtrack::eval::{TruthRow, read_truth};
use seamtrack::report::results::{PathRow, as_written, path_csv};
use seamtrack::report::run::Run;
use seamtrack::report::summary::{FIRST_FRAME, Limits, summary_json};
use seamtrack::report::truth::read_truth_along_px;
use seamtrack::report::verdict::verdict;
use seamtrack::run::{RunOutcome, error_table, plane_errors, summarise};
use seamtrack::source::{Cut, FrameRange, FrameSource, Period, SourceError};

use crate::config::{Config, config_of, python_of};
use crate::errors::raised;
use crate::sensor::Sensor;

/// What is said of frames that cannot be read, at most.
const MOST_TROUBLES: usize = 100;

/// The result of tracking a recording.
#[pyclass(frozen, module = "seamtrack._native")]
pub struct Recording {
    rows: Vec<PathRow>,
    summary: serde_json::Value,
    verdict: &'static str,
    sentence: String,
    doubts: Vec<String>,
    facts: Vec<String>,
    notes: Vec<String>,
}

/// What is asked for, beside the configuration and the sensor.
struct Asked<'a> {
    input: &'a Path,
    truth: Option<PathBuf>,
    frames: Option<FrameRange>,
    origin: Origin,
    period: Period,
    limits: Limits,
}

/// Tracks the recording at `input`; keywords are the keys of the configuration.
#[pyfunction]
#[pyo3(signature = (
    input, *, sensor = None, config = None, truth = None, frames = None, origin = "first", max_unavailable = 5.0,
    tolerance_mm = None, **keys
))]
#[expect(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn track_recording(
    py: Python<'_>,
    input: PathBuf,
    sensor: Option<Sensor>,
    config: Option<&Config>,
    truth: Option<PathBuf>,
    frames: Option<&str>,
    origin: &str,
    max_unavailable: f64,
    tolerance_mm: Option<f64>,
    keys: Option<&Bound<'_, PyDict>>,
) -> PyResult<Recording> {
    let Config { inner: config, has_period } = config_of(config, keys)?;
    let known = sensor.map_or_else(|| config.sensor(), |sensor| sensor.known);
    if !(0.0..=100.0).contains(&max_unavailable) {
        return Err(PyValueError::new_err("max_unavailable is a percentage from 0 to 100"));
    }
    if let Some(tolerance_mm) = tolerance_mm {
        if !(tolerance_mm.is_finite() && tolerance_mm > 0.0) {
            return Err(PyValueError::new_err("tolerance_mm is a length in millimetres above 0"));
        }
        if !known.sensor.has_millimetres() {
            return Err(PyValueError::new_err("tolerance_mm is in millimetres: give mm_per_px or a sensor"));
        }
    }
    let asked = Asked {
        input: &input,
        truth,
        frames: frames.map(str::parse).transpose().map_err(|error: seamtrack::source::NoFrameRange| raised(&error))?,
        origin: origin.parse().map_err(|problem| PyValueError::new_err(format!("origin: {problem}")))?,
        period: if has_period { Period::Given(config.period_s) } else { Period::OwnOr(config.period_s) },
        limits: Limits { max_unavailable_pct: Some(max_unavailable), tolerance_mm, ..Limits::default() },
    };
    py.detach(|| tracked(&asked, &config, &known))
}

/// As the program does it, in memory.
fn tracked(asked: &Asked<'_>, config: &config::Config, known: &KnownSensor) -> PyResult<Recording> {
    let truth: Option<Vec<TruthRow>> =
        asked.truth.as_deref().map(read_truth).transpose().map_err(|error| raised(&error))?;
    let mut source = asked.open().map_err(|error| raised(&error))?;
    let config = &config::Config { period_s: source.period_s(), ..config.clone() };
    let (kind, mut notes) = (source.kind(), source.notes().to_vec());
    let outcome = seamtrack::run::track(&mut *source, (config, known), asked.origin, |seen| {
        if let Err(error) = seen.picture
            && notes.len() < MOST_TROUBLES
        {
            notes.push(format!("frame {}: {error}", seen.row.frame));
        }
    })
    .map_err(|error| asked.named(&error))?;
    let first_frame = asked.frames.map_or(0, |range| range.first);
    let errors = match (&truth, &outcome.ruler) {
        (Some(truth), Some(ruler)) => error_table(&outcome.rows, (truth, first_frame), ruler)
            .map_err(|error| PyValueError::new_err(error.to_string()))?,
        _ => None,
    };
    let in_plane = truth.as_ref().and_then(|truth| plane_errors(&outcome.rows, (truth, first_frame)));
    let name = asked.input.to_string_lossy();
    let mut summary = summarise(&outcome, (&name, kind), (config, known), asked.limits, (errors, in_plane))
        .map_err(|error| raised(&error))?;
    if let Some(range) = asked.frames {
        summary.input.more.insert(FIRST_FRAME.into(), range.first.into());
    }
    let RunOutcome { rows, .. } = outcome;
    let rows = as_written(rows);
    let truth_px = match &asked.truth {
        Some(file) => read_truth_along_px(file, summary.calibration.stripe, (first_frame, rows.len()))
            .map_err(|error| raised(&error))?,
        None => None,
    };
    let mut run = Run { dir: PathBuf::new(), name: name.into_owned(), rows, summary, truth_px, thumbnails: vec![] };
    run.summary.tolerance = run.tolerance();
    let told = verdict(&run);
    Ok(Recording {
        summary: summary_json(&run.summary).map_err(|error| raised(&error))?,
        rows: run.rows,
        verdict: told.trust.word(),
        sentence: told.sentence,
        doubts: told.doubts,
        facts: told.facts,
        notes,
    })
}

impl Asked<'_> {
    /// Opens the recording, or the part of it that was asked for.
    fn open(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        let whole = seamtrack::source::open(self.input, self.period)?;
        match (self.frames, whole.frame_count()) {
            (None, _) => Ok(whole),
            (Some(range), Some(count)) if count <= range.first => {
                let problem = format!("frames {range}: it has {count} frames, numbered from 0");
                Err(SourceError::Frames { path: self.input.to_owned(), problem })
            }
            (Some(range), _) => Ok(Box::new(Cut::new(whole, range))),
        }
    }

    /// An error in the middle of a recording, with the recording's name.
    fn named(&self, error: &(dyn std::error::Error + 'static)) -> PyErr {
        PyValueError::new_err(format!("{}: {}", self.input.display(), crate::errors::one_line(error)))
    }
}

/// The columns of `path.csv` behind `status`.
#[pyfunction]
pub fn value_columns() -> Vec<&'static str> {
    PathRow::VALUE_COLUMNS.to_vec()
}

#[pymethods]
impl Recording {
    fn __len__(&self) -> usize {
        self.rows.len()
    }

    /// The content of `summary.json`.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.summary)
    }

    /// "good", "check" or "bad"; the frames in one sentence; what speaks against trust; what else there is to know.
    #[getter]
    fn verdict(&self) -> (&str, &str, Vec<String>, Vec<String>) {
        (self.verdict, &self.sentence, self.doubts.clone(), self.facts.clone())
    }

    /// What there is to say of the recording and of frames that could not be read.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// The columns of `path.csv`, NaN where there is no value.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (table, rows) = (PyDict::new(py), &self.rows);
        table.set_item("frame", rows.iter().map(|row| row.frame as i64).collect::<Vec<_>>().into_pyarray(py))?;
        table.set_item("file", PyList::new(py, rows.iter().map(|row| row.file.as_str()))?)?;
        table.set_item("time_s", rows.iter().map(|row| row.time_s).collect::<Vec<_>>().into_pyarray(py))?;
        table.set_item("status", PyList::new(py, rows.iter().map(|row| row.status.name()))?)?;
        let mut columns = vec![Vec::with_capacity(rows.len()); PathRow::VALUE_COLUMNS.len()];
        for row in rows {
            let values = row.values().into_iter();
            values.zip(&mut columns).for_each(|(value, column)| column.push(value.unwrap_or(f64::NAN)));
        }
        for (name, column) in PathRow::VALUE_COLUMNS.iter().zip(columns) {
            table.set_item(name, column.into_pyarray(py))?;
        }
        Ok(table)
    }

    /// The bytes of `path.csv`.
    fn csv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mut bytes = vec![];
        path_csv(&mut bytes, &self.rows)?;
        Ok(PyBytes::new(py, &bytes))
    }
}
