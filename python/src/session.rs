//! The tracker, frame by frame.

use std::sync::{Mutex, PoisonError};

use numpy::{PyReadonlyArray2, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use seamtrack::run::{expect_calibrated_size, session_settings};
use seamtrack::source::SixteenBitScale;
use seamtrack::tracker;
use seamtrack::{GrayFrame, StripeAxis};

use crate::config::{Config, config_of};
use crate::errors::raised;
use crate::sensor::Sensor;

/// What the tracker says of one frame. What it does not know is None.
#[pyclass(frozen, eq, get_all, module = "seamtrack", from_py_object)]
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// seeking, tracked, coasting (a prediction with a growing σ) or lost.
    status: String,
    /// The seam's column [px]; None unless tracked or coasting.
    u_px: Option<f64>,
    /// The seam's row [px].
    v_px: Option<f64>,
    /// One σ along the stripe [px].
    std_px: Option<f64>,
    /// One σ across the stripe [px].
    std_across_px: Option<f64>,
    /// The seam in the laser's plane along the stripe [mm]; None without a scale.
    lateral_mm: Option<f64>,
    /// The same across it [mm]; with a calibrated plane it grows towards the camera.
    height_mm: Option<f64>,
    /// What became of the frame's measurement, in a word of the program's trace.csv.
    observation: String,
    /// Normalised innovation squared of the measurement.
    nis: Option<f64>,
    /// The correlation filter's own peak, column [px].
    kcf_u_px: Option<f64>,
    /// The correlation filter's own peak, row [px].
    kcf_v_px: Option<f64>,
    /// Peak-to-sidelobe ratio of its response.
    psr: Option<f64>,
    /// Gap of a butt joint, shadow of a lap joint, along the stripe [px].
    gap_px: Option<f64>,
    /// By how much the stripe behind the seam has the larger coordinate across it [px].
    mismatch_px: Option<f64>,
    /// The frame equals its predecessor byte for byte.
    repeated: bool,
}

#[pymethods]
impl Estimate {
    #[new]
    #[pyo3(signature = (
        status, u_px = None, v_px = None, std_px = None, std_across_px = None, lateral_mm = None, height_mm = None,
        observation = "", nis = None, kcf_u_px = None, kcf_v_px = None, psr = None, gap_px = None,
        mismatch_px = None, repeated = false
    ))]
    #[expect(clippy::too_many_arguments, reason = "one a field, for copies and pickles")]
    fn new(
        status: String,
        u_px: Option<f64>,
        v_px: Option<f64>,
        std_px: Option<f64>,
        std_across_px: Option<f64>,
        lateral_mm: Option<f64>,
        height_mm: Option<f64>,
        observation: &str,
        nis: Option<f64>,
        kcf_u_px: Option<f64>,
        kcf_v_px: Option<f64>,
        psr: Option<f64>,
        gap_px: Option<f64>,
        mismatch_px: Option<f64>,
        repeated: bool,
    ) -> Self {
        Self {
            status,
            u_px,
            v_px,
            std_px,
            std_across_px,
            lateral_mm,
            height_mm,
            observation: observation.to_owned(),
            nis,
            kcf_u_px,
            kcf_v_px,
            psr,
            gap_px,
            mismatch_px,
            repeated,
        }
    }

    fn __repr__(&self) -> String {
        let Self { status, observation, .. } = self;
        let millimetres = match (self.lateral_mm, self.height_mm) {
            (Some(lateral), Some(height)) => format!(", lateral_mm={lateral:.4}, height_mm={height:.4}"),
            _ => String::new(),
        };
        match (self.u_px, self.v_px, self.std_px) {
            (Some(u), Some(v), Some(std)) => {
                format!("<Estimate {status}, u_px={u:.3}, v_px={v:.3}, std_px={std:.3}{millimetres}, {observation}>")
            }
            _ => format!("<Estimate {status}, {observation}>"),
        }
    }

    fn __getnewargs_ex__<'py>(slf: &Bound<'py, Self>) -> PyResult<((), Bound<'py, PyDict>)> {
        let fields = PyDict::new(slf.py());
        for name in FIELDS {
            fields.set_item(name, slf.getattr(name)?)?;
        }
        Ok(((), fields))
    }
}

const FIELDS: [&str; 15] = [
    "status",
    "u_px",
    "v_px",
    "std_px",
    "std_across_px",
    "lateral_mm",
    "height_mm",
    "observation",
    "nis",
    "kcf_u_px",
    "kcf_v_px",
    "psr",
    "gap_px",
    "mismatch_px",
    "repeated",
];

/// Finds the seam and follows it from frame to frame, as a camera gives them.
///
/// >>> import seamtrack
/// >>> frames, truth = seamtrack.synth.render("A-butt", frames=30)
/// >>> session = seamtrack.Session(seamtrack.Sensor(0.073), joint="auto")
/// >>> for frame, time_s in zip(frames, truth.time_s):
/// ...     estimate = session.step(frame, time_s)
/// >>> estimate.status, session.joint["kind"]
/// ('tracked', 'butt')
///
/// sensor: what a pixel is. config, keys: the configuration. white: the 16-bit grey that becomes 255; without it the bit depth (8, 10,
/// 12, 14, 16) that frames have needed so far. A session runs without the GIL, so that several run at once in threads; calls of one
/// session wait for each other.
#[pyclass(frozen, module = "seamtrack")]
pub struct Session {
    config: Config,
    sensor: Sensor,
    /// A class must be Sync, and a session is Send only.
    state: Mutex<State>,
    /// The memory of the frame before, for the next one.
    pixels: Mutex<Vec<u8>>,
}

struct State {
    session: seamtrack::Session,
    /// The scale of 16-bit frames, and whether the user gave it.
    scale: Option<SixteenBitScale>,
    is_given: bool,
}

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (sensor = None, *, config = None, white = None, **keys))]
    fn new(
        sensor: Option<Sensor>,
        config: Option<&Config>,
        white: Option<u16>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        if white == Some(0) {
            return Err(PyValueError::new_err("white is the grey that becomes 255: it must be above 0"));
        }
        let config = config_of(config, keys)?;
        let sensor = sensor.unwrap_or_else(|| Sensor { known: config.inner.sensor() });
        let settings = session_settings(&config.inner, &sensor.known).map_err(|error| raised(&error))?;
        let session = seamtrack::Session::new(&settings).map_err(|error| raised(&error))?;
        let (scale, is_given) = (white.map(|white| SixteenBitScale { white }), white.is_some());
        Ok(Self { config, sensor, state: Mutex::new(State { session, scale, is_given }), pixels: Mutex::default() })
    }

    /// Takes the next frame, shape (rows, columns), recorded at time_s [s]; strided arrays and views are fine.
    ///
    /// A time that is no number or not later than the one before makes the frame a miss ("bad-stamp").
    /// Raises TypeError for anything but a 2-D array of uint8 or uint16, ValueError when the frames' size changes.
    // One copy is made before the GIL is released: another thread of Python may write into the array meanwhile.
    fn step(&self, py: Python<'_>, frame: &Bound<'_, PyAny>, time_s: f64) -> PyResult<Estimate> {
        if let Ok(array) = frame.extract::<PyReadonlyArray2<'_, u8>>() {
            let view = array.as_array();
            let (rows, columns) = view.dim();
            let mut pixels = self.emptied();
            match view.as_slice() {
                Some(all) => pixels.extend_from_slice(all),
                None => pixels.extend(view.iter()),
            }
            return py.detach(|| self.step_on(gray(columns, rows, pixels)?, time_s));
        }
        if let Ok(array) = frame.extract::<PyReadonlyArray2<'_, u16>>() {
            let view = array.as_array();
            let (rows, columns) = view.dim();
            let greys: Vec<u16> = view.as_slice().map_or_else(|| view.iter().copied().collect(), <[u16]>::to_vec);
            return py.detach(|| {
                let scale = self.scale_of(&greys);
                let mut pixels = self.emptied();
                pixels.extend(greys.iter().map(|&grey| scale.eight_bits(grey)));
                self.step_on(gray(columns, rows, pixels)?, time_s)
            });
        }
        let got = match frame.cast::<PyUntypedArray>() {
            Ok(array) => format!("an array of {} with {} dimensions", array.dtype(), array.ndim()),
            Err(_) => frame.get_type().to_string(),
        };
        Err(PyTypeError::new_err(format!("a frame is a 2-D array of uint8 or uint16, got {got}")))
    }

    /// Says that the frame of time_s [s] could not be read: the filter predicts through it.
    fn miss(&self, py: Python<'_>, time_s: f64) -> PyResult<Estimate> {
        py.detach(|| {
            let mut state = self.state();
            let estimate = state.session.miss(time_s).map_err(|error| raised(&error))?;
            Ok(self.told(&estimate, state.session.axis()))
        })
    }

    /// The joint found last: kind, frame, reason, doubt.
    #[getter]
    fn joint<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let state = self.state();
        let Some(joint) = state.session.joint() else { return Ok(None) };
        let told = PyDict::new(py);
        told.set_item("kind", joint.kind)?;
        told.set_item("frame", joint.frame)?;
        told.set_item("reason", &joint.reason)?;
        told.set_item("doubt", joint.doubt)?;
        told.set_item("contradicted_by", joint.contradicted_by)?;
        Ok(Some(told))
    }

    /// How the stripe runs.
    #[getter]
    fn stripe(&self) -> Option<&'static str> {
        self.state().session.axis().map(|axis| match axis {
            StripeAxis::Horizontal => "horizontal",
            StripeAxis::Vertical => "vertical",
        })
    }

    /// The 16-bit grey that becomes 255, if a frame of 16 bits came or it was given.
    #[getter]
    fn white(&self) -> Option<u16> {
        self.state().scale.map(|scale| scale.white)
    }

    /// The configuration.
    #[getter]
    fn config(&self) -> Config {
        self.config.clone()
    }

    /// What a pixel is.
    #[getter]
    fn sensor(&self) -> Sensor {
        self.sensor.clone()
    }

    fn __repr__(&self) -> String {
        let state = self.state();
        let joint =
            state.session.joint().map_or_else(|| "no joint yet".into(), |joint| format!("joint {}", joint.kind));
        format!("<Session: {joint}, {}>", self.sensor.known.source)
    }
}

impl Session {
    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Memory for a frame.
    fn emptied(&self) -> Vec<u8> {
        let mut pixels = std::mem::take(&mut *self.pixels.lock().unwrap_or_else(PoisonError::into_inner));
        pixels.clear();
        pixels
    }

    fn step_on(&self, frame: GrayFrame, time_s: f64) -> PyResult<Estimate> {
        let size_px = (frame.width_px(), frame.height_px());
        expect_calibrated_size(&self.sensor.known, size_px).map_err(|error| raised(&error))?;
        let mut state = self.state();
        let estimate = state.session.step(&frame, time_s).map_err(|error| raised(&error))?;
        *self.pixels.lock().unwrap_or_else(PoisonError::into_inner) = frame.into_pixels();
        Ok(self.told(&estimate, state.session.axis()))
    }

    /// The scale that was given, else the largest bit depth that a frame has needed so far: dark frames do not lower it.
    fn scale_of(&self, greys: &[u16]) -> SixteenBitScale {
        let mut state = self.state();
        if !state.is_given {
            let own = SixteenBitScale::from_greys(greys);
            state.scale = state.scale.into_iter().chain(own).max_by_key(|scale| scale.white);
        }
        state.scale.unwrap_or(SixteenBitScale { white: u16::MAX })
    }

    fn told(&self, estimate: &tracker::Estimate, axis: Option<StripeAxis>) -> Estimate {
        let (seam, kcf, section) = (estimate.seam, estimate.kcf, estimate.section);
        let sensor = &self.sensor.known.sensor;
        let point = seam.zip(axis).filter(|_| sensor.has_millimetres());
        let point = point.and_then(|(seam, axis)| sensor.plane_from_pixel(seam.centre, axis));
        let status = match estimate.status {
            tracker::Status::Seeking => "seeking",
            tracker::Status::Tracked => "tracked",
            tracker::Status::Coasting => "coasting",
            tracker::Status::Lost => "lost",
        };
        Estimate {
            status: status.into(),
            u_px: seam.map(|seam| seam.centre.u_px),
            v_px: seam.map(|seam| seam.centre.v_px),
            std_px: seam.map(|seam| seam.std_px),
            std_across_px: seam.map(|seam| seam.std_across_px),
            lateral_mm: point.map(|point| point.lateral_mm),
            height_mm: point.map(|point| point.height_mm),
            observation: estimate.observation.name().into(),
            nis: estimate.nis,
            kcf_u_px: kcf.map(|kcf| kcf.peak.u_px),
            kcf_v_px: kcf.map(|kcf| kcf.peak.v_px),
            psr: kcf.map(|kcf| kcf.psr),
            gap_px: section.and_then(|section| section.gap_px),
            mismatch_px: section.and_then(|section| section.mismatch_px),
            repeated: estimate.repeated,
        }
    }
}

fn gray(columns: usize, rows: usize, pixels: Vec<u8>) -> PyResult<GrayFrame> {
    GrayFrame::new(columns, rows, pixels).map_err(|error| raised(&error))
}
