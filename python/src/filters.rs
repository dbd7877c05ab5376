//! The filters of the papers over measured series.

use std::collections::BTreeMap;

use numpy::{IntoPyArray, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use seamtrack::kalman::adaptive::{NoiseAdaptation, complete_frames_gate, filter_adaptively};
use seamtrack::kalman::fit::{self, Filtered};
use seamtrack::kalman::{
    ChiSquareGate, ColouredMeasurement, ColouredProcess, ConstantVelocity, Frame, InvalidParameter, Model, SeriesError,
    Trajectory, Width, smoother, with_displacement,
};

use crate::errors::raised;

/// Noise parameters by name.
type Parameters = BTreeMap<String, f64>;

/// A paper's model with its numbers.
enum Paper {
    White(ConstantVelocity),
    ColouredMeasurement(ColouredMeasurement),
    ColouredProcess(ColouredProcess),
    Adaptive(Width),
}

impl Paper {
    fn of(model: &str, given: &Parameters) -> PyResult<Self> {
        let number = |name: &str| {
            given.get(name).copied().ok_or_else(|| PyValueError::new_err(format!("the model {model} needs {name}")))
        };
        let invalid = |error: InvalidParameter| raised(&error);
        Ok(match model {
            "white" => Self::White(
                ConstantVelocity::new(number("acceleration_variance")?, number("white_variance")?).map_err(invalid)?,
            ),
            "coloured-measurement" => Self::ColouredMeasurement(
                ColouredMeasurement::new(
                    number("acceleration_variance")?,
                    number("colour_drive_variance")?,
                    number("colour_coefficient")?,
                    number("white_variance")?,
                    number("period_s")?,
                )
                .map_err(invalid)?,
            ),
            "coloured-process" => Self::ColouredProcess(
                ColouredProcess::new(
                    number("drive_variance")?,
                    number("colour_coefficient")?,
                    number("position_variance")?,
                    number("displacement_variance")?,
                    number("period_s")?,
                )
                .map_err(invalid)?,
            ),
            "adaptive" => Self::Adaptive(
                Width::new(number("acceleration_variance")?, number("white_variance")?).map_err(invalid)?,
            ),
            other => return Err(PyValueError::new_err(format!("there is no model {other:?}"))),
        })
    }
}

/// The parameters that a paper prints, by name; `period_s` is the caller's.
#[pyfunction]
pub fn model_parameters(model: &str) -> PyResult<Parameters> {
    Ok(match model {
        "white" => named(&ConstantVelocity::printed()),
        "coloured-measurement" => named(&ColouredMeasurement::printed()),
        "coloured-process" => named(&ColouredProcess::printed()),
        other => return Err(PyValueError::new_err(format!("there are no printed parameters of {other:?}"))),
    })
}

fn named<const N: usize, const M: usize, const P: usize>(model: &impl Model<N, M, P>) -> Parameters {
    model.parameters().iter().map(|parameter| (parameter.name.replace('-', "_"), parameter.value)).collect()
}

/// A measured series.
struct Series {
    z: Vec<Option<f64>>,
    second: Option<Vec<Option<f64>>>,
    steps_s: Vec<f64>,
}

impl Series {
    fn of(
        z: &PyReadonlyArray1<'_, f64>,
        time_s: &PyReadonlyArray1<'_, f64>,
        second: Option<&PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<Self> {
        let measured = |array: &PyReadonlyArray1<'_, f64>| -> Vec<Option<f64>> {
            array.as_array().iter().map(|&value| Some(value).filter(|value| !value.is_nan())).collect()
        };
        let stamps = time_s.as_array();
        let series = Self {
            z: measured(z),
            second: second.map(measured),
            steps_s: stamps.iter().zip(stamps.iter().skip(1)).map(|(before, now)| now - before).collect(),
        };
        let count = series.z.len();
        if count < 2 || stamps.len() != count || series.second.as_ref().is_some_and(|second| second.len() != count) {
            return Err(PyValueError::new_err("measurements and times must be as many, and at least two"));
        }
        Ok(series)
    }

    /// Time before each measurement [s]; before the first one as before the second.
    fn steps_s(&self) -> impl Iterator<Item = f64> {
        self.steps_s.first().into_iter().chain(&self.steps_s).copied()
    }

    fn one_row(&self) -> PyResult<Vec<Frame<1>>> {
        if self.second.is_some() {
            return Err(PyValueError::new_err("this model measures one row: leave the second out"));
        }
        Ok(self.steps_s().zip(&self.z).map(|(dt_s, z)| Frame::new(dt_s, [*z])).collect())
    }

    fn two_rows(&self) -> Vec<Frame<2>> {
        let rows = match &self.second {
            Some(second) => self.z.iter().zip(second).map(|(a, b)| [*a, *b]).collect(),
            None => with_displacement(&self.z),
        };
        self.steps_s().zip(rows).map(|(dt_s, z)| Frame::new(dt_s, z)).collect()
    }
}

/// Filters and smooths a series: a dictionary of arrays, NaN where there is no value.
#[pyfunction]
#[pyo3(signature = (model, parameters, z, time_s, second = None, gate = false, fixed_lag = None))]
#[expect(clippy::too_many_arguments, reason = "the Python classes give them names")]
pub fn filter_series<'py>(
    py: Python<'py>,
    model: &str,
    parameters: Parameters,
    z: PyReadonlyArray1<'_, f64>,
    time_s: PyReadonlyArray1<'_, f64>,
    second: Option<PyReadonlyArray1<'_, f64>>,
    gate: bool,
    fixed_lag: Option<usize>,
) -> PyResult<Bound<'py, PyDict>> {
    if fixed_lag.is_some_and(|lag| lag > smoother::LONGEST_LAG) {
        return Err(PyValueError::new_err(format!("fixed_lag is at most {} measurements", smoother::LONGEST_LAG)));
    }
    let series = Series::of(&z, &time_s, second.as_ref())?;
    let count = series.z.len();
    let paper = Paper::of(model, &parameters)?;
    let told = py.detach(|| match paper {
        Paper::White(model) => told(&filtered(&model, &series.one_row()?, gate)?, count, 1.0, fixed_lag),
        Paper::ColouredMeasurement(model) => told(&filtered(&model, &series.one_row()?, gate)?, count, 1.0, fixed_lag),
        Paper::ColouredProcess(model) => {
            told(&filtered(&model, &series.two_rows(), gate)?, count, 1.0 / model.period_s(), fixed_lag)
        }
        Paper::Adaptive(model) => told(&adaptive(&model, &series.two_rows())?, count, 1.0, fixed_lag),
    })?;
    let table = PyDict::new(py);
    for (name, values) in COLUMNS.into_iter().zip(told.columns) {
        table.set_item(name, values.into_pyarray(py))?;
    }
    table.set_item("log_likelihood", told.log_likelihood)?;
    Ok(table)
}

/// The parameters under which the series is most likely, by name, and the log-likelihood reached.
#[pyfunction]
#[pyo3(signature = (model, parameters, z, time_s, second = None, gate = false))]
pub fn fit_series(
    py: Python<'_>,
    model: &str,
    parameters: Parameters,
    z: PyReadonlyArray1<'_, f64>,
    time_s: PyReadonlyArray1<'_, f64>,
    second: Option<PyReadonlyArray1<'_, f64>>,
    gate: bool,
) -> PyResult<(Parameters, f64)> {
    let series = Series::of(&z, &time_s, second.as_ref())?;
    let paper = Paper::of(model, &parameters)?;
    py.detach(|| match paper {
        Paper::White(model) => fitted(&model, &series.one_row()?, gate_of(gate)),
        Paper::ColouredMeasurement(model) => fitted(&model, &series.one_row()?, gate_of(gate)),
        Paper::ColouredProcess(model) => fitted(&model, &series.two_rows(), gate_of(gate)),
        Paper::Adaptive(model) => fitted(&model, &series.two_rows(), Some(complete_frames_gate())),
    })
}

fn fitted<const N: usize, const M: usize, const P: usize>(
    model: &impl Model<N, M, P>,
    frames: &[Frame<M>],
    gate: Option<ChiSquareGate<M>>,
) -> PyResult<(Parameters, f64)> {
    let (model, log_likelihood) = fit::maximum_likelihood(model, frames, gate).map_err(failed)?;
    Ok((named(&model), log_likelihood))
}

fn filtered<const N: usize, const M: usize, const P: usize>(
    model: &impl Model<N, M, P>,
    frames: &[Frame<M>],
    gate: bool,
) -> PyResult<Filtered<N, M>> {
    fit::filter(model, frames, gate_of(gate)).map_err(failed)
}

fn adaptive(model: &Width, frames: &[Frame<2>]) -> PyResult<Filtered<3, 2>> {
    let (start, first) = model.start_of(frames).map_err(failed)?;
    let space = model.state_space(1.0).map_err(|error| raised(&error))?;
    let adaptation = NoiseAdaptation::new(&space.R);
    let (trajectory, _) =
        filter_adaptively(start, &frames[first + 1..], |dt_s| model.state_space(dt_s), adaptation).map_err(failed)?;
    Ok(Filtered { first, trajectory })
}

/// The 99 % rule for one or two rows, if it is wanted.
fn gate_of<const M: usize>(wanted: bool) -> Option<ChiSquareGate<M>> {
    wanted.then(|| ChiSquareGate {
        thresholds: std::array::from_fn(|row| ChiSquareGate::<2>::P99.thresholds[row.min(1)]),
    })
}

fn failed(error: SeriesError) -> PyErr {
    raised(&error)
}

const COLUMNS: [&str; 9] =
    ["x", "x_std", "velocity", "velocity_std", "smooth_x", "smooth_x_std", "innovation", "nis", "weight"];

struct Told {
    columns: [Vec<f64>; COLUMNS.len()],
    log_likelihood: f64,
}

/// The columns of `count` measurements; `per_second` turns the model's velocity into one a second.
fn told<const N: usize, const M: usize>(
    run: &Filtered<N, M>,
    count: usize,
    per_second: f64,
    fixed_lag: Option<usize>,
) -> PyResult<Told> {
    let trajectory: &Trajectory<N, M> = &run.trajectory;
    let smoothed = match fixed_lag {
        Some(lag) => smoother::fixed_lag(trajectory, lag),
        None => smoother::bryson_frazier(trajectory),
    };
    let mut columns: [Vec<f64>; COLUMNS.len()] = std::array::from_fn(|_| vec![f64::NAN; count]);
    let std = |variance: f64| variance.max(0.0).sqrt();
    for (i, (state, smooth)) in trajectory.filtered().zip(&smoothed).enumerate() {
        let values = [
            state.x[0],
            std(state.P[(0, 0)]),
            state.x[1] * per_second,
            std(state.P[(1, 1)]) * per_second,
            smooth.x[0],
            std(smooth.P[(0, 0)]),
        ];
        values.into_iter().zip(&mut columns).for_each(|(value, column)| column[run.first + i] = value);
    }
    for (i, step) in trajectory.steps.iter().enumerate() {
        let (row, update) = (run.first + 1 + i, &step.update);
        columns[6][row] = update.innovation.first().copied().flatten().unwrap_or(f64::NAN);
        columns[7][row] = update.nis.unwrap_or(f64::NAN);
        columns[8][row] = update.nis.map_or(f64::NAN, |_| update.weight);
    }
    Ok(Told { columns, log_likelihood: trajectory.log_likelihood() })
}
