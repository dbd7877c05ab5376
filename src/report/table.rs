//! The papers' table: mean absolute, maximum, standard deviation, and what else tells runs apart.

use super::results::Estimator;
use super::run::Run;
use crate::eval::Errors;
use crate::units::LengthUnit;

/// Columns of the table.
pub const COLUMNS: usize = 9;

/// Heads of the columns, with the unit of their lengths.
#[must_use]
pub fn heads(unit: LengthUnit) -> [String; COLUMNS] {
    let length = |name: &str| format!("{name} [{unit}]");
    let [wrong, unavailable] = ["wrong", "unavailable"].map(str::to_owned);
    let [mean, max, sd, rmse, p95, bias] = ["mean abs.", "max", "SD", "RMSE", "P95", "bias"].map(length);
    [mean, max, sd, rmse, p95, bias, "in ±2σ [%]".to_owned(), wrong, unavailable]
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableRow {
    /// The method.
    pub name: String,
    /// One cell for each of [`heads`].
    pub cells: [String; COLUMNS],
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

fn cells(errors: &Errors) -> [String; COLUMNS] {
    let length = |value: f64| format!("{value:.3}");
    [
        length(errors.mae),
        length(errors.max),
        length(errors.std),
        length(errors.rmse),
        length(errors.p95),
        format!("{:+.3}", errors.bias),
        errors.coverage_2sigma.map_or("–".to_owned(), |share| format!("{:.1}", 100.0 * share)),
        errors.wrong_frames.to_string(),
        errors.unavailable_frames.to_string(),
    ]
}
