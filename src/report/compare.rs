//! Several runs on one recording: methods, presets or configurations beside one another.

use super::errors::errors_against;
use super::results::Estimator;
use super::run::Run;
use super::table::{TableRow, error_rows};
use crate::units::LengthUnit;

/// Why runs cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The runs saw different recordings.
    #[error(
        "{first} has {first_frames} frames of {first_size}, {other} has {other_frames} of {other_size}: \
         compare runs on the same recording"
    )]
    DifferentRecordings {
        /// Directory of the first run.
        first: String,
        /// Its number of frames.
        first_frames: usize,
        /// Its frame size.
        first_size: String,
        /// Directory of the other run.
        other: String,
        /// Its number of frames.
        other_frames: usize,
        /// Its frame size.
        other_size: String,
    },
    /// One run is in millimetres, another in pixels.
    #[error("{first} is in {first_unit}, {other} in {other_unit}: track both with the same scale")]
    DifferentUnits {
        /// Directory of the first run.
        first: String,
        /// Its unit.
        first_unit: LengthUnit,
        /// Directory of the other run.
        other: String,
        /// Its unit.
        other_unit: LengthUnit,
    },
}

/// Check that all runs saw frames of one number, size and names, and have one unit.
///
/// # Errors
/// [`CompareError`] naming the first run that does not fit.
pub fn check_same_recording(runs: &[Run]) -> Result<(), CompareError> {
    let size = |run: &Run| format!("{} x {} px", run.summary.input.width_px, run.summary.input.height_px);
    let names = |run: &Run| run.rows.iter().map(|row| row.file.clone()).collect::<Vec<_>>();
    let Some((first, others)) = runs.split_first() else { return Ok(()) };
    match others.iter().find(|other| size(other) != size(first) || names(other) != names(first)) {
        None => check_same_unit(first, others),
        Some(other) => Err(CompareError::DifferentRecordings {
            first: first.dir.display().to_string(),
            first_frames: first.rows.len(),
            first_size: size(first),
            other: other.dir.display().to_string(),
            other_frames: other.rows.len(),
            other_size: size(other),
        }),
    }
}

fn check_same_unit(first: &Run, others: &[Run]) -> Result<(), CompareError> {
    others.iter().find(|other| other.unit() != first.unit()).map_or(Ok(()), |other| {
        Err(CompareError::DifferentUnits {
            first: first.dir.display().to_string(),
            first_unit: first.unit(),
            other: other.dir.display().to_string(),
            other_unit: other.unit(),
        })
    })
}

/// Call runs by their whole path where the last part is the same.
pub fn tell_apart(runs: &mut [Run]) {
    let names: Vec<String> = runs.iter().map(|run| run.name.clone()).collect();
    for run in runs {
        if names.iter().filter(|name| **name == run.name).count() > 1 {
            run.name = run.dir.display().to_string();
        }
    }
}

/// Gives runs without errors those against the truth of the first run that has one: the recording is the same.
pub fn lend_truth(runs: &mut [Run]) {
    let Some(truth) = runs.iter().find_map(|run| run.truth_px.clone()) else { return };
    for run in runs.iter_mut().filter(|run| run.truth_px.is_none()) {
        run.summary.errors = errors_against(&run.rows, &truth, &run.ruler());
        run.truth_px = Some(truth.clone());
    }
}

/// A sentence where the runs do not share one scale: their millimetres are not the same.
#[must_use]
pub fn mixed_scales(runs: &[Run]) -> Option<String> {
    let first = runs.first()?.summary.calibration.sensor();
    if runs.iter().all(|run| run.summary.calibration.sensor() == first) {
        return None;
    }
    let list: Vec<String> =
        runs.iter().map(|run| format!("{}: {}", run.name, run.summary.calibration.words())).collect();
    Some(format!("The runs have different scales ({}): each one's lengths are its own.", list.join("; ")))
}

/// The papers' table over all runs: each run's estimates one after another. Without any truth there are no rows.
#[must_use]
pub fn comparison_rows(runs: &[Run]) -> Vec<TableRow> {
    let named = |run: &Run| {
        let name = run.name.clone();
        error_rows(run).into_iter().map(move |row| TableRow { name: format!("{name}, {}", row.name), ..row })
    };
    runs.iter().flat_map(named).collect()
}

/// Availability of each run in a line, for runs with or without a truth.
#[must_use]
pub fn availability_lines(runs: &[Run]) -> Vec<String> {
    let line = |run: &Run| {
        let known = run.rows.iter().filter_map(|row| row.point(Estimator::Filtered)).count();
        format!("{}: a value on {known} of {} frames", run.name, run.rows.len())
    };
    runs.iter().map(line).collect()
}
