//! `path.csv` of a melt pool: one row a frame, an empty cell where there is no value, fixed decimals.

use std::path::Path;

use serde::Deserialize;

use crate::report::atomic::{ResultsError, write_atomically};
use crate::report::results::{Status, fixed};

/// One row.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PoolRow {
    /// Number of the frame, from 0 in processing order.
    pub frame: usize,
    /// Name of the frame's file; `name[number]` for one of a stack.
    pub file: String,
    /// Time stamp \[s\].
    pub time_s: f64,
    /// How the value is known.
    pub status: Status,
    /// The frame's own measure \[px\]: the tip's coordinate across the travel, or the width.
    pub measured_px: Option<f64>,
    /// The filter's \[px\]; empty unless tracked or coasting.
    pub filtered_px: Option<f64>,
    /// The filter's \[mm\]: the offset from the zero, or the width.
    pub filtered_mm: Option<f64>,
    /// One σ of it \[mm\], without the scale's own.
    pub filtered_std_mm: Option<f64>,
    /// Normalised innovation squared of the measurement's rows.
    pub nis: Option<f64>,
    /// Given the whole recording \[px\].
    pub smooth_px: Option<f64>,
    /// Given the whole recording \[mm\].
    pub smooth_mm: Option<f64>,
    /// One σ of it \[mm\].
    pub smooth_std_mm: Option<f64>,
}

/// The columns of the contract, in order.
const COLUMNS: [&str; 12] = [
    "frame",
    "file",
    "time_s",
    "status",
    "measured_px",
    "filtered_px",
    "filtered_mm",
    "filtered_std_mm",
    "nis",
    "smooth_px",
    "smooth_mm",
    "smooth_std_mm",
];

const PX_DECIMALS: usize = 3;
/// Two more than a seam's: at 114 px/mm a hundredth of a pixel is 0.1 µm.
const MM_DECIMALS: usize = 5;
const NIS_DECIMALS: usize = 4;
const TIME_DECIMALS: usize = 6;

/// Writes `path.csv`.
///
/// # Errors
/// When the file cannot be written, or a value is not finite.
pub fn write_pool_csv(path: &Path, rows: &[PoolRow]) -> Result<(), ResultsError> {
    write_atomically(path, |file| {
        let mut csv = csv::Writer::from_writer(file);
        csv.write_record(COLUMNS)?;
        for row in rows {
            csv.write_record(cells(row)?)?;
        }
        csv.flush()
    })
}

fn cells(row: &PoolRow) -> std::io::Result<[String; 12]> {
    let cell = |value: Option<f64>, decimals: usize| match value {
        None => Ok(String::new()),
        Some(value) if value.is_finite() => Ok(fixed(value, decimals)),
        Some(value) => Err(std::io::Error::other(format!("frame {} has a value that is {value}", row.frame))),
    };
    Ok([
        row.frame.to_string(),
        row.file.clone(),
        cell(Some(row.time_s), TIME_DECIMALS)?,
        row.status.name().to_owned(),
        cell(row.measured_px, PX_DECIMALS)?,
        cell(row.filtered_px, PX_DECIMALS)?,
        cell(row.filtered_mm, MM_DECIMALS)?,
        cell(row.filtered_std_mm, MM_DECIMALS)?,
        cell(row.nis, NIS_DECIMALS)?,
        cell(row.smooth_px, PX_DECIMALS)?,
        cell(row.smooth_mm, MM_DECIMALS)?,
        cell(row.smooth_std_mm, MM_DECIMALS)?,
    ])
}

/// Reads `path.csv`.
///
/// # Errors
/// When the file cannot be read, a column is missing, a cell is malformed or not finite, or the frames do not count
/// from 0.
pub fn read_pool_csv(path: &Path) -> Result<Vec<PoolRow>, ResultsError> {
    let file = std::fs::File::open(path).map_err(|source| ResultsError::Read { path: path.to_owned(), source })?;
    let mut rows: Vec<PoolRow> = Vec::new();
    for row in csv::Reader::from_reader(std::io::BufReader::new(file)).deserialize() {
        let row: PoolRow = row.map_err(|error| ResultsError::content(path, error))?;
        if row.frame != rows.len() {
            let problem = format!("frame {} stands where {} is due; frames count from 0", row.frame, rows.len());
            return Err(ResultsError::content(path, problem));
        }
        let numbers = [row.measured_px, row.filtered_px, row.filtered_mm, row.filtered_std_mm, row.nis];
        let smoothed = [row.smooth_px, row.smooth_mm, row.smooth_std_mm, Some(row.time_s)];
        if !numbers.into_iter().chain(smoothed).flatten().all(f64::is_finite) {
            let problem = format!("frame {} has a value that is not finite; leave the cell empty", row.frame);
            return Err(ResultsError::content(path, problem));
        }
        rows.push(row);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_are_the_contracts_and_what_was_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        let empty = PoolRow {
            frame: 0,
            file: "a.npy[0]".into(),
            time_s: 0.0,
            status: Status::Seeking,
            measured_px: None,
            filtered_px: None,
            filtered_mm: None,
            filtered_std_mm: None,
            nis: None,
            smooth_px: None,
            smooth_mm: None,
            smooth_std_mm: None,
        };
        let full = PoolRow {
            frame: 1,
            status: Status::Tracked,
            measured_px: Some(239.5),
            filtered_px: Some(239.25),
            filtered_mm: Some(-0.25219),
            filtered_std_mm: Some(0.001),
            nis: Some(1.5),
            ..empty.clone()
        };
        write_pool_csv(&path, &[empty.clone(), full.clone()]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(
            lines[0],
            "frame,file,time_s,status,measured_px,filtered_px,filtered_mm,filtered_std_mm,nis,smooth_px,smooth_mm,\
             smooth_std_mm"
        );
        assert_eq!(lines[1], "0,a.npy[0],0.000000,seeking,,,,,,,,");
        assert_eq!(lines[2], "1,a.npy[0],0.000000,tracked,239.500,239.250,-0.25219,0.00100,1.5000,,,");
        assert_eq!(read_pool_csv(&path).unwrap(), [empty, full]);
    }
}
