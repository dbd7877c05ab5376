//! What a pixel is: nothing known, one scale, or a calibrated camera and laser plane; pixels to millimetres and back, on arrays.

use std::path::PathBuf;

use numpy::ndarray::{Array2, Array3};
use numpy::{AllowTypeChange, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayLike2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use seamtrack::calib::file::CalibrationFile;
use seamtrack::calib::{self, KnownSensor};
use seamtrack::units::{MmPerPx, PixelPoint, StripeAxis};

use crate::errors::raised;

/// The source of a scale that is given as a number: the program's words.
const ONE_SCALE: &str = "one scale along the stripe";

/// What a pixel is: `Sensor()` knows nothing, `Sensor(0.073)` is one scale [mm/px], `Sensor.read(file)` a calibration.
///
/// toml is the text of a calibration file, source where the knowledge comes from.
#[pyclass(frozen, eq, module = "seamtrack.calib", from_py_object)]
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    pub known: KnownSensor,
}

/// Anything that NumPy makes an array of numbers of.
type Pairs<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;
type Mapped<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>);

#[pymethods]
impl Sensor {
    #[new]
    #[pyo3(signature = (mm_per_px = None, *, toml = None, source = None))]
    fn new(mm_per_px: Option<f64>, toml: Option<&str>, source: Option<String>) -> PyResult<Self> {
        let known = match (mm_per_px, toml) {
            (Some(_), Some(_)) => return Err(PyValueError::new_err("give mm_per_px or toml, not both")),
            (None, None) => KnownSensor::unknown(),
            (Some(mm_per_px), None) => {
                let scale = MmPerPx::new(mm_per_px).map_err(|error| raised(&error))?;
                KnownSensor::scale(scale, source.as_deref().unwrap_or(ONE_SCALE))
            }
            (None, Some(text)) => {
                let source = source.unwrap_or_else(|| "calibration".into());
                let file = CalibrationFile::parse(text).map_err(|problem| problem_of(&source, &problem))?;
                KnownSensor::of(file, source.clone()).map_err(|problem| problem_of(&source, &problem))?
            }
        };
        Ok(Self { known })
    }

    /// Reads a calibration that `seamtrack calibrate` wrote: camera and laser plane, or a scale.
    ///
    /// Raises OSError when the file cannot be read, ValueError when it is no calibration.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Ok(Self { known: KnownSensor::read(&path).map_err(|error| raised(&error))? })
    }

    /// The sensor of pictures that were cut out of the calibrated ones.
    ///
    /// at: their first column and row in the calibrated picture; size: their columns and rows [px]. Raises ValueError when they
    /// reach beyond the calibrated picture.
    fn cropped(&self, at: (usize, usize), size: (usize, usize)) -> PyResult<Self> {
        Ok(Self { known: self.known.cropped(at, size).map_err(|error| raised(&error))? })
    }

    /// "pixels", "scale" or "plane".
    #[getter]
    fn kind(&self) -> &'static str {
        match self.known.sensor {
            calib::Sensor::Pixels => "pixels",
            calib::Sensor::Scale(_) => "scale",
            calib::Sensor::Plane(_) => "plane",
        }
    }

    /// Where the knowledge comes from.
    #[getter]
    fn source(&self) -> &str {
        &self.known.source
    }

    /// The scale, if there is one [mm/px].
    #[getter]
    fn mm_per_px(&self) -> Option<f64> {
        if let calib::Sensor::Scale(scale) = self.known.sensor { Some(scale.get()) } else { None }
    }

    /// Points of the laser's plane that pixels show, and their Jacobians.
    ///
    /// uv: shape (n, 2), columns u and v [px]. Returns points of shape (n, 2), lateral and height [mm], and Jacobians of shape
    /// (n, 2, 2), d(lateral, height)/d(u, v) [mm/px]; NaN where a pixel's ray does not meet the plane. Without a scale the lengths
    /// are pixels. stripe is how the stripe runs, of one scale.
    #[pyo3(signature = (uv, *, stripe = "horizontal"))]
    fn to_plane<'py>(&self, py: Python<'py>, uv: Pairs<'_>, stripe: &str) -> PyResult<Mapped<'py>> {
        let (axis, pixels) = (axis_of(stripe)?, pairs(&uv, "pixels (u, v)")?);
        let count = pixels.len();
        let (mut points, mut jacobians) =
            (Array2::from_elem((count, 2), f64::NAN), Array3::from_elem((count, 2, 2), f64::NAN));
        for (i, [u_px, v_px]) in pixels.into_iter().enumerate() {
            let pixel = PixelPoint::new(u_px, v_px);
            if let Some(point) = self.known.sensor.plane_from_pixel(pixel, axis) {
                (points[(i, 0)], points[(i, 1)]) = (point.lateral_mm, point.height_mm);
            }
            if let Some(jacobian) = self.known.sensor.jacobian_mm_per_px(pixel, axis) {
                // The library's columns are along and across the stripe.
                let columns = if axis == StripeAxis::Horizontal { [0, 1] } else { [1, 0] };
                for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    jacobians[(i, row, column)] = jacobian[(row, columns[column])];
                }
            }
        }
        Ok((points.into_pyarray(py), jacobians.into_pyarray(py)))
    }

    /// Pixels (u, v) that show points (lateral, height) [mm] of shape (n, 2): the inverse of to_plane.
    #[pyo3(signature = (points, *, stripe = "horizontal"))]
    fn to_pixel<'py>(&self, py: Python<'py>, points: Pairs<'_>, stripe: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (axis, points) = (axis_of(stripe)?, pairs(&points, "points (lateral, height)")?);
        let mut pixels = Array2::from_elem((points.len(), 2), f64::NAN);
        for (i, [lateral_mm, height_mm]) in points.into_iter().enumerate() {
            let point = calib::PlanePoint { lateral_mm, height_mm };
            if let Some(pixel) = self.known.sensor.pixel_from_plane(point, axis) {
                (pixels[(i, 0)], pixels[(i, 1)]) = (pixel.u_px, pixel.v_px);
            }
        }
        Ok(pixels.into_pyarray(py))
    }

    /// Covariance of (lateral, height) [mm²], shape (n, 2, 2), that the calibration's own error makes: the same in all frames.
    fn calibration_covariance<'py>(&self, py: Python<'py>, uv: Pairs<'_>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let pixels = pairs(&uv, "pixels (u, v)")?;
        let mut covariances = Array3::from_elem((pixels.len(), 2, 2), f64::NAN);
        for (i, [u_px, v_px]) in pixels.into_iter().enumerate() {
            let camera = self.known.sensor.laser_camera();
            if let Some(covariance) = camera.and_then(|c| c.calibration_covariance_mm2(PixelPoint::new(u_px, v_px))) {
                for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    covariances[(i, row, column)] = covariance[(row, column)];
                }
            }
        }
        Ok(covariances.into_pyarray(py))
    }

    /// Whether the pixels, shape (n, 2), lie where stripes were seen when the sensor was calibrated.
    fn is_calibrated<'py>(&self, py: Python<'py>, uv: Pairs<'_>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let camera = self.known.sensor.laser_camera();
        let is_calibrated =
            |[u_px, v_px]: [f64; 2]| camera.is_some_and(|camera| camera.is_calibrated(PixelPoint::new(u_px, v_px)));
        let flags: Vec<bool> = pairs(&uv, "pixels (u, v)")?.into_iter().map(is_calibrated).collect();
        Ok(flags.into_pyarray(py))
    }

    fn __repr__(&self) -> String {
        match (&self.known.sensor, &self.known.file) {
            (calib::Sensor::Pixels, _) => "Sensor()".into(),
            (calib::Sensor::Scale(scale), _) => format!("Sensor({}, source={:?})", scale.get(), self.known.source),
            (calib::Sensor::Plane(_), file) => {
                let (id, date) = file.as_ref().map_or(("", ""), |file| (file.id.as_str(), file.date.as_str()));
                format!("<Sensor: camera and laser plane, {:?}, id {id:?}, {date}>", self.known.source)
            }
        }
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<((Option<f64>,), Bound<'py, PyDict>)> {
        let keywords = PyDict::new(py);
        let scale = match &self.known.file {
            Some(file) => {
                keywords.set_item("toml", file.to_toml().map_err(PyValueError::new_err)?)?;
                None
            }
            None => self.mm_per_px(),
        };
        if self.kind() != "pixels" {
            keywords.set_item("source", &self.known.source)?;
        }
        Ok(((scale,), keywords))
    }
}

fn problem_of(source: &str, problem: &str) -> PyErr {
    PyValueError::new_err(format!("{source}: {problem}"))
}

fn axis_of(stripe: &str) -> PyResult<StripeAxis> {
    match stripe {
        "horizontal" => Ok(StripeAxis::Horizontal),
        "vertical" => Ok(StripeAxis::Vertical),
        other => Err(PyValueError::new_err(format!("stripe is horizontal or vertical, not {other:?}"))),
    }
}

/// The rows of an array of shape (n, 2).
fn pairs(array: &Pairs<'_>, what: &str) -> PyResult<Vec<[f64; 2]>> {
    let array = array.as_array();
    if array.ncols() != 2 {
        let shape = (array.nrows(), array.ncols());
        return Err(PyValueError::new_err(format!("{what} are an array of shape (n, 2), got {shape:?}")));
    }
    Ok(array.rows().into_iter().map(|row| [row[0], row[1]]).collect())
}
