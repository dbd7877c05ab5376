//! `trace.csv`: what was measured in each frame, and what speaks for it.

use std::path::Path;

use super::atomic::{ResultsError, write_atomically};
use super::results::fixed;

/// One row of `trace.csv`. An empty cell where this kind of measurement has no such figure.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceRow {
    /// Number of the frame, from 0.
    pub frame: usize,
    /// What became of the measurement, in a word.
    pub observation: &'static str,
    /// Normalised innovation squared.
    pub nis: Option<f64>,
    /// Position along the stripe as this frame alone shows it \[px\], whether accepted or not.
    pub measured_px: Option<f64>,
    /// Share of the stripe's columns that lie on its fitted lines.
    pub support: Option<f64>,
    /// RMS distance of the stripe from its lines \[px\].
    pub residual_px: Option<f64>,
    /// How badly two edges explain where the stripe is and where not.
    pub cost: Option<f64>,
    /// By how much the next-best place is worse.
    pub margin: Option<f64>,
    /// Probability that there is a seam (hairline).
    pub presence: Option<f64>,
    /// PSR of the KCF over its ceiling.
    pub psr_ratio: Option<f64>,
}

const COLUMNS: [&str; 10] =
    ["frame", "observation", "nis", "support", "residual_px", "cost", "margin", "presence", "psr_ratio", "measured_px"];
const DECIMALS: usize = 4;

/// Writes `trace.csv`.
///
/// # Errors
/// When the file cannot be written.
pub fn write_trace_csv(path: &Path, rows: &[TraceRow]) -> Result<(), ResultsError> {
    write_atomically(path, |file| {
        let mut csv = csv::Writer::from_writer(file);
        csv.write_record(COLUMNS)?;
        for row in rows {
            let evidence = [row.support, row.residual_px, row.cost, row.margin, row.presence];
            let figures = [row.nis].into_iter().chain(evidence).chain([row.psr_ratio, row.measured_px]);
            let cells = figures.map(|figure| figure.map(|figure| fixed(figure, DECIMALS)).unwrap_or_default());
            csv.write_record([row.frame.to_string(), row.observation.to_owned()].into_iter().chain(cells))?;
        }
        csv.flush()
    })
}
