//! Made-up recordings.

use std::path::{Path, PathBuf};

use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use seamtrack::output::Existing;
use seamtrack::synth::recording::write_recording;
use seamtrack::synth::{Scenario, Scene, builtin};

use crate::errors::raised;

/// The names of the built-in scenes.
#[pyfunction]
pub fn scene_names() -> Vec<String> {
    builtin::names().into_iter().chain(builtin::sensor_names()).collect()
}

/// The scenario of a built-in scene or of a TOML file, cut to so many frames.
fn scenario(scene: &str, seed: Option<u64>, frames: Option<usize>) -> PyResult<Scenario> {
    let path = Path::new(scene);
    let is_file = path.extension().is_some_and(|ending| ending == "toml");
    let scenario = if is_file { Scenario::load(path) } else { builtin::scenario(scene) };
    let mut scenario = scenario.map_err(|error| raised(&error))?;
    if frames == Some(0) {
        return Err(PyValueError::new_err("a recording has at least one frame"));
    }
    scenario.frames = frames.unwrap_or(scenario.frames);
    scenario.seed = seed.unwrap_or(scenario.seed);
    Ok(scenario)
}

/// Frames of shape (frames, rows, columns), and a dictionary of what is true in each.
#[pyfunction]
#[pyo3(signature = (scene, seed = None, frames = None))]
pub fn render_scene<'py>(
    py: Python<'py>,
    scene: &str,
    seed: Option<u64>,
    frames: Option<usize>,
) -> PyResult<(Bound<'py, PyArray3<u8>>, Bound<'py, PyDict>)> {
    let scenario = scenario(scene, seed, frames)?;
    let (scene, pictures) = py.detach(|| {
        let scene = Scene::new(&scenario, scenario.seed).map_err(|error| raised(&error))?;
        let pictures: Vec<_> = (0..scene.frame_count()).into_par_iter().map(|frame| scene.render(frame)).collect();
        Ok::<_, PyErr>((scene, pictures))
    })?;
    let Some((columns, rows)) = pictures.first().map(|first| (first.width_px(), first.height_px())) else {
        return Err(PyValueError::new_err("the scenario has no frame"));
    };
    let pixels: Vec<u8> = pictures.iter().flat_map(|picture| picture.pixels()).copied().collect();
    let stack = Array3::from_shape_vec((pictures.len(), rows, columns), pixels)
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let truths: Vec<_> = (0..scene.frame_count()).map(|frame| scene.truth(frame)).collect();
    let numbers = |of: &dyn Fn(&seamtrack::synth::Truth) -> Option<f64>| {
        truths.iter().map(|truth| of(truth).unwrap_or(f64::NAN)).collect::<Vec<f64>>().into_pyarray(py)
    };
    let table = PyDict::new(py);
    let stamps: Vec<f64> = (0..scene.frame_count()).map(|frame| scene.timestamp_s(frame)).collect();
    table.set_item("time_s", stamps.into_pyarray(py))?;
    table.set_item("u_px", numbers(&|truth| truth.seam.map(|seam| seam.u_px)))?;
    table.set_item("v_px", numbers(&|truth| truth.seam.map(|seam| seam.v_px)))?;
    table.set_item("gap_px", numbers(&|truth| truth.gap_px))?;
    table.set_item("occluded", truths.iter().map(|truth| truth.occluded).collect::<Vec<bool>>().into_pyarray(py))?;
    Ok((stack.into_pyarray(py), table))
}

/// Writes the recording as `seamtrack synth` does: frames/, truth.csv, scenario.toml.
#[pyfunction]
#[pyo3(signature = (scene, folder, seed = None, frames = None, force = false))]
pub fn write_scene(
    py: Python<'_>,
    scene: &str,
    folder: PathBuf,
    seed: Option<u64>,
    frames: Option<usize>,
    force: bool,
) -> PyResult<()> {
    let scenario = scenario(scene, seed, frames)?;
    py.detach(|| write_recording(&scenario, &folder, Existing::forced(force), None, || {}))
        .map_err(|error| raised(&error))
}
