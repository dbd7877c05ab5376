//! What is written from a finished run beside `path.csv` and `summary.json`.

use super::atomic::ResultsError;
use super::page::{DEFAULT_MAX_BYTES, write_report};
use super::results::Estimator;
use super::run::Run;
use super::tum::write_tum;
use crate::units::LengthUnit;

/// What to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exports {
    /// Largest size of `report.html` \[bytes\].
    pub max_page_bytes: usize,
    /// The TUM trajectories as well.
    pub tum: bool,
}

impl Default for Exports {
    fn default() -> Self {
        Self { max_page_bytes: DEFAULT_MAX_BYTES, tum: false }
    }
}

/// Names of the TUM trajectories without their ending: the estimates', then the truth's.
pub fn trajectory_names() -> impl Iterator<Item = &'static str> {
    TRAJECTORIES.iter().map(|&(_, name)| name).chain([TRUE_TRAJECTORY])
}

const TRAJECTORIES: [(Estimator, &str); 3] =
    [(Estimator::Kcf, "kcf"), (Estimator::Filtered, "filtered"), (Estimator::Smoothed, "smoothed")];
const TRUE_TRAJECTORY: &str = "truth";

/// Write `report.html` and, if asked, `kcf.tum`, `filtered.tum`, `smoothed.tum` and `truth.tum` into the run's
/// directory. A run in pixels has no trajectories: they are in metres.
///
/// # Errors
/// When a file cannot be written.
pub fn write_exports(run: &Run, exports: Exports) -> Result<(), ResultsError> {
    write_report(&run.dir.join("report.html"), run, exports.max_page_bytes)?;
    if exports.tum && run.unit() == LengthUnit::Mm {
        let ruler = run.ruler();
        let truth = run.true_position(&ruler).map(|truth| (TRUE_TRAJECTORY, truth));
        let paths = TRAJECTORIES.map(|(estimator, name)| (name, run.position(estimator, &ruler)));
        for (name, positions) in paths.into_iter().chain(truth) {
            let samples = run.rows.iter().map(|row| row.time_s).zip(positions);
            write_tum(&run.dir.join(format!("{name}.tum")), samples)?;
        }
    }
    Ok(())
}
