//! The papers' table: mean absolute, maximum, standard deviation, and what else tells runs apart.

use super::results::Estimator;
use super::run::Run;
use crate::eval::Errors;

/// Heads of the columns, with their units.
pub const HEADS: [&str; 9] = [
    "mean abs. [mm]",
    "max [mm]",
    "SD [mm]",
    "RMSE [mm]",
    "P95 [mm]",
    "bias [mm]",
    "in ±2σ [%]",
    "wrong",
    "unavailable",
];

/// One row of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableRow {
    /// The method.
    pub name: String,
    /// One cell for each of [`HEADS`].
    pub cells: [String; HEADS.len()],
}

/// One row for each estimate of `run` that has errors; none without a truth.
#[must_use]
pub fn error_rows(run: &Run) -> Vec<TableRow> {
    let Some(errors) = &run.summary.errors else { return Vec::new() };
    let row = |estimator: Estimator| {
        let errors = errors.of(estimator)?;
        Some(TableRow { name: estimator.name().to_owned(), cells: cells(errors) })
    };
    Estimator::ALL.into_iter().filter_map(row).collect()
}

fn cells(errors: &Errors) -> [String; HEADS.len()] {
    let mm = |value: f64| format!("{value:.3}");
    [
        mm(errors.mae_mm),
        mm(errors.max_mm),
        mm(errors.std_mm),
        mm(errors.rmse_mm),
        mm(errors.p95_mm),
        format!("{:+.3}", errors.bias_mm),
        errors.coverage_2sigma.map_or("–".to_owned(), |share| format!("{:.1}", 100.0 * share)),
        errors.wrong_frames.to_string(),
        errors.unavailable_frames.to_string(),
    ]
}
