//! The native part of the Python package `seamtrack`: sessions, whole recordings, made-up scenes, calibrations, and the filters of the
//! papers, for arrays. What users see of it is written down in `python/seamtrack/_native.pyi`.

mod config;
mod errors;
mod filters;
mod recording;
mod scenes;
mod sensor;
mod session;

use pyo3::prelude::*;

/// The native part of `seamtrack`.
#[pymodule(gil_used = false)]
mod _native {
    #[pymodule_export]
    use super::config::Config;
    #[pymodule_export]
    use super::filters::{filter_series, fit_series, model_parameters};
    #[pymodule_export]
    use super::recording::{Recording, track_recording, value_columns};
    #[pymodule_export]
    use super::scenes::{render_scene, scene_names, write_scene};
    #[pymodule_export]
    use super::sensor::Sensor;
    #[pymodule_export]
    use super::session::{Estimate, Session};
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name that Python gives it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
