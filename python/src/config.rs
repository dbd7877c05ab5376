//! The configuration: the keys of the program's TOML file as keywords.

use std::path::PathBuf;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use seamtrack::config;
use serde_json::{Map, Value};

use crate::errors::raised;

/// The configuration of the tracker: the keys of `seamtrack config --print` as keywords, checked, never changed.
///
/// >>> import seamtrack
/// >>> config = seamtrack.Config(joint="butt", mm_per_px=0.073)
/// >>> config.replace(joint="lap")
/// Config(joint="lap", mm_per_px=0.073)
///
/// Raises ValueError for an unknown key and for a number out of its range.
#[pyclass(frozen, eq, module = "seamtrack", from_py_object)]
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    pub inner: config::Config,
    /// Whether the time between frames was given: then it counts, whatever a recording says of itself.
    pub has_period: bool,
}

#[pymethods]
impl Config {
    #[new]
    #[pyo3(signature = (**keys))]
    fn new(keys: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let Some(keys) = keys else { return Ok(Self { inner: config::Config::default(), has_period: false }) };
        let given = json_of(keys)?;
        Self::of(given)
    }

    /// Reads a TOML file. Raises OSError when it cannot be read, ValueError when it is wrong.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let inner = config::Config::read(&path).map_err(|error| raised(&error))?;
        inner.method().map_err(|error| PyValueError::new_err(format!("{}: {error}", path.display())))?;
        let text = std::fs::read_to_string(&path)?;
        let has_period = text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("period_s"));
        Ok(Self { inner, has_period })
    }

    /// The same configuration with other values of some keys.
    #[pyo3(signature = (**keys))]
    fn replace(&self, keys: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let Some(keys) = keys else { return Ok(self.clone()) };
        let mut own = self.given()?;
        for (key, value) in json_of(keys)? {
            match (own.get_mut(&key), value) {
                (Some(Value::Object(part)), Value::Object(other)) => part.extend(other),
                (_, value) => _ = own.insert(key, value),
            }
        }
        Self::of(own)
    }

    /// All keys with their values.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.value()?)
    }

    fn __repr__(&self) -> PyResult<String> {
        let keys: Vec<String> = self.given()?.iter().map(|(key, value)| format!("{key}={}", literal(value))).collect();
        Ok(format!("Config({})", keys.join(", ")))
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyAny>)> {
        Ok((PyTuple::empty(py), python_of(py, &Value::Object(self.given()?))?))
    }
}

impl Config {
    fn of(given: Map<String, Value>) -> PyResult<Self> {
        let has_period = given.contains_key("period_s");
        let inner: config::Config = serde_json::from_value(Value::Object(given))
            .map_err(|error| PyValueError::new_err(format!("the configuration: {error}")))?;
        inner.method().map_err(|error| raised(&error))?;
        Ok(Self { inner, has_period })
    }

    fn value(&self) -> PyResult<Value> {
        serde_json::to_value(&self.inner).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The keys that are not as in the default configuration, and the period where it was given.
    fn given(&self) -> PyResult<Map<String, Value>> {
        let default = Self { inner: config::Config::default(), has_period: false }.value()?;
        Ok(match different(self.value()?, &default, self.has_period.then_some("period_s")) {
            Some(Value::Object(given)) => given,
            _ => Map::new(),
        })
    }
}

/// What of `value` is not as in `default`; `kept` stays.
fn different(value: Value, default: &Value, kept: Option<&str>) -> Option<Value> {
    match value {
        Value::Object(map) => {
            let differs = |(key, value): (String, Value)| {
                let other = default.get(&key).filter(|_| kept != Some(key.as_str())).unwrap_or(&Value::Null);
                different(value, other, None).map(|value| (key, value))
            };
            let map: Map<String, Value> = map.into_iter().filter_map(differs).collect();
            (!map.is_empty()).then_some(Value::Object(map))
        }
        value => (value != *default).then_some(value),
    }
}

/// A value as Python writes it.
fn literal(value: &Value) -> String {
    match value {
        Value::Null => "None".into(),
        Value::Bool(flag) => if *flag { "True" } else { "False" }.into(),
        Value::String(text) => format!("{text:?}"),
        Value::Array(list) => format!("[{}]", list.iter().map(literal).collect::<Vec<_>>().join(", ")),
        Value::Object(map) => {
            let parts: Vec<String> = map.iter().map(|(key, value)| format!("{key:?}: {}", literal(value))).collect();
            format!("{{{}}}", parts.join(", "))
        }
        Value::Number(number) => number.to_string(),
    }
}

/// A dictionary of plain values.
fn json_of(keys: &Bound<'_, PyDict>) -> PyResult<Map<String, Value>> {
    let py = keys.py();
    let options = PyDict::new(py);
    options.set_item("allow_nan", false)?;
    let dumped = py.import("json")?.call_method("dumps", (keys,), Some(&options));
    let text: String = match dumped {
        Err(error) if error.is_instance_of::<PyValueError>(py) => {
            return Err(PyValueError::new_err("the configuration: a number is not finite"));
        }
        dumped => dumped?.extract()?,
    };
    match serde_json::from_str(&text) {
        Ok(Value::Object(map)) => Ok(map),
        _ => Err(PyTypeError::new_err("keys must be plain values")),
    }
}

/// A value as Python's own.
pub fn python_of<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (value.to_string(),))
}

/// A configuration from one and from keywords, which come first.
pub fn config_of(config: Option<&Config>, keys: Option<&Bound<'_, PyDict>>) -> PyResult<Config> {
    match config {
        Some(config) => config.replace(keys),
        None => Config::new(keys),
    }
}
