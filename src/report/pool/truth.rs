//! The truth of a made-up pool.

use std::path::Path;

use super::summary::PoolSummary;
use crate::eval::parse_truth;
use crate::meltpool::Measure;
use crate::report::atomic::ResultsError;
use crate::report::truth::FILE_NAME;
use crate::units::{StripeAxis, Travel};

/// The truth beside a run's results, frame by frame \[px\]: the tip's coordinate across the travel, or the width; none where the
/// run had no truth.
pub(super) fn truth_beside(
    dir: &Path,
    summary: &PoolSummary,
    frames: usize,
) -> Result<Option<Vec<Option<f64>>>, ResultsError> {
    let path = dir.join(FILE_NAME);
    if !path.is_file() {
        return Ok(None);
    }
    let setting = |key: &str| summary.config.get(key).cloned().unwrap_or_default();
    let measure = if setting("measure") == "width" { Measure::Width } else { Measure::Tip };
    let travel: Travel = serde_json::from_value(setting("travel")).unwrap_or_default();
    let content = std::fs::read(&path).map_err(|source| ResultsError::Read { path: path.clone(), source })?;
    let mut truth_px = vec![None; frames];
    for (frame, px) in parse_true_values(&content, &path, measure, travel)? {
        if let Some(place) = truth_px.get_mut(frame) {
            *place = px;
        }
    }
    Ok(Some(truth_px))
}

/// Frame and true value \[px\] of each line of what a truth file holds: the tip's coordinate across the travel, or the width.
///
/// # Errors
/// When it lacks a column, or holds what is no number; `path` names it.
pub fn parse_true_values(
    content: &[u8],
    path: &Path,
    measure: Measure,
    travel: Travel,
) -> Result<Vec<(usize, Option<f64>)>, ResultsError> {
    match measure {
        Measure::Width => true_widths(content, path),
        Measure::Tip => {
            let axis = if travel.is_along_columns() { StripeAxis::Horizontal } else { StripeAxis::Vertical };
            Ok(parse_truth(content, path)?.iter().map(|row| (row.frame, row.along_px(axis))).collect())
        }
    }
}

/// Frame and true width \[px\] of each line of a truth file with the columns `frame` and `width_px`; none where the pool
/// cannot be seen.
fn true_widths(content: &[u8], path: &Path) -> Result<Vec<(usize, Option<f64>)>, ResultsError> {
    let mut reader = csv::Reader::from_reader(content);
    let headers = reader.headers().map_err(|error| ResultsError::content(path, error))?.clone();
    let column = |name: &str| {
        let missing = || ResultsError::content(path, format!("the first line names no column {name}: add it"));
        headers.iter().position(|header| header.trim() == name).ok_or_else(missing)
    };
    let (frame, width) = (column("frame")?, column("width_px")?);
    let mut widths = vec![];
    for (line, record) in reader.records().enumerate() {
        let record = record.map_err(|error| ResultsError::content(path, error))?;
        let cell = |column: usize| record.get(column).unwrap_or_default().trim();
        let wrong = |what: &str| ResultsError::content(path, format!("line {}: {what:?} is no number", line + 2));
        let number: usize = cell(frame).parse().map_err(|_| wrong(cell(frame)))?;
        let width_px = match cell(width) {
            "" => None,
            text => Some(text.parse().ok().filter(|w: &f64| w.is_finite()).ok_or_else(|| wrong(text))?),
        };
        widths.push((number, width_px));
    }
    Ok(widths)
}
