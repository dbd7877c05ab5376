//! `path.csv`: one row a frame.
//!
//! An empty cell where there is no value, fixed decimals, booleans 0/1. Columns may be added at the end, never moved
//! or renamed without a new [schema version](super::summary::SCHEMA_VERSION); a reader ignores those it does not know.

use std::io::{self, Write};
use std::path::Path;

use super::atomic::{ResultsError, write_atomically};
use super::path_row::COLUMNS;

pub(crate) use super::path_row::fixed;
pub use super::path_row::{Estimator, PathRow, Status};

/// Write `path.csv`. Time stamps have 3 decimals, or 6 when some do not fit into 3.
///
/// # Errors
/// When the file cannot be written, or a value is not finite (an absent value is `None`).
pub fn write_path_csv(path: &Path, rows: &[PathRow]) -> Result<(), ResultsError> {
    write_atomically(path, |file| path_csv(file, rows))
}

/// Writes the content of `path.csv` anywhere.
///
/// # Errors
/// When it cannot be written, or a value is not finite.
pub fn path_csv(target: impl Write, rows: &[PathRow]) -> io::Result<()> {
    let time_decimals = time_decimals(rows);
    let mut csv = csv::Writer::from_writer(target);
    csv.write_record(COLUMNS)?;
    for row in rows {
        if let Some(value) = row.numbers().find(|value| !value.is_finite()) {
            return Err(io::Error::other(format!("frame {} has a value that is {value}", row.frame)));
        }
        csv.write_record(row.cells(time_decimals))?;
    }
    csv.flush()
}

fn time_decimals(rows: &[PathRow]) -> usize {
    let whole_milliseconds = rows.iter().all(|row| (row.time_s * 1e3 - (row.time_s * 1e3).round()).abs() < 1e-4);
    if whole_milliseconds { 3 } else { 6 }
}

/// The rows as [`read_path_csv`] gives them back after [`write_path_csv`]: the path of a run that leaves no file.
#[must_use]
pub fn as_written(rows: Vec<PathRow>) -> Vec<PathRow> {
    let time_decimals = time_decimals(&rows);
    rows.into_iter().map(|row| row.rounded(time_decimals)).collect()
}

/// Read `path.csv`.
///
/// # Errors
/// When the file cannot be read, a column is missing, a cell is malformed or not finite, or the frames do not count
/// from 0.
pub fn read_path_csv(path: &Path) -> Result<Vec<PathRow>, ResultsError> {
    let file = std::fs::File::open(path).map_err(|source| ResultsError::Read { path: path.to_owned(), source })?;
    let mut rows: Vec<PathRow> = Vec::new();
    for row in csv::Reader::from_reader(std::io::BufReader::new(file)).deserialize() {
        let row: PathRow = row.map_err(|error| ResultsError::content(path, error))?;
        if row.frame != rows.len() {
            let expected = rows.len();
            let problem = format!("frame {} stands where {expected} is due; frames count from 0", row.frame);
            return Err(ResultsError::content(path, problem));
        }
        if !row.numbers().all(f64::is_finite) {
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

    fn tracked(frame: usize, time_s: f64) -> PathRow {
        PathRow {
            u_px: Some(320.123_45),
            v_px: Some(200.0),
            x_mm: Some(-0.000_01),
            x_std_mm: Some(0.012),
            nis: Some(1.5),
            psr: Some(11.25),
            template_updated: true,
            ..PathRow::empty(frame, format!("{frame:04}.png"), time_s, Status::Tracked)
        }
    }

    fn written(rows: &[PathRow]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        write_path_csv(&path, rows).unwrap();
        std::fs::read_to_string(path).unwrap()
    }

    #[test]
    fn cells_have_fixed_decimals_and_are_empty_without_a_value() {
        let text = written(&[tracked(0, 0.0), PathRow::empty(1, "a,b.png".into(), 0.2, Status::Lost)]);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(
            lines[0],
            "frame,file,time_s,status,kcf_u_px,kcf_v_px,psr,template_updated,u_px,v_px,x_mm,x_std_mm,nis,\
             smooth_u_px,smooth_v_px,smooth_x_mm,smooth_x_std_mm,gap_px,gap_mm,mismatch_px,\
             shoulder_before_u_px,shoulder_before_v_px,shoulder_behind_u_px,shoulder_behind_v_px,travel_mm,\
             lateral_mm,height_mm,lateral_std_mm,height_std_mm,calib_lateral_std_mm,calib_height_std_mm,calibrated,\
             gap_std_mm,hi_lo_mm,hi_lo_std_mm,groove_width_mm,groove_width_std_mm,depth_mm,depth_std_mm,\
             opening_angle_deg,opening_angle_std_deg,root_opening_mm,root_opening_std_mm,area_mm2,area_std_mm2,\
             along_std_px,smooth_along_std_px"
        );
        assert_eq!(
            lines[1],
            format!("0,0000.png,0.000,tracked,,,11.250,1,320.123,200.000,0.0000,0.0120,1.5000{}", ",".repeat(34))
        );
        assert_eq!(lines[2], format!("1,\"a,b.png\",0.200,lost,,,,0{}", ",".repeat(39)));
    }

    #[test]
    fn irregular_time_stamps_have_six_decimals() {
        assert!(written(&[tracked(0, 0.0), tracked(1, 0.033_367)]).contains(",0.033367,tracked"));
    }

    #[test]
    fn reading_gives_back_what_was_written_and_ignores_columns_added_at_the_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        let row = PathRow { u_px: Some(1.5), x_mm: Some(0.25), ..tracked(0, 0.2) };
        write_path_csv(&path, std::slice::from_ref(&row)).unwrap();
        assert_eq!(read_path_csv(&path).unwrap(), std::slice::from_ref(&row));
        let unrounded = vec![tracked(0, 0.033_367_4), tracked(1, 0.2)];
        write_path_csv(&path, &unrounded).unwrap();
        assert_eq!(read_path_csv(&path).unwrap(), as_written(unrounded));
        write_path_csv(&path, std::slice::from_ref(&row)).unwrap();
        let wider: String = std::fs::read_to_string(&path)
            .unwrap()
            .lines()
            .zip(["brightness", "3.5"])
            .map(|(line, cell)| format!("{line},{cell}\n"))
            .collect();
        std::fs::write(&path, wider).unwrap();
        assert_eq!(read_path_csv(&path).unwrap(), [row]);
    }

    #[test]
    fn a_value_that_is_not_finite_is_refused_both_ways() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        let row = PathRow { psr: Some(f64::NAN), ..tracked(0, 0.0) };
        assert!(write_path_csv(&path, &[row]).is_err());
        write_path_csv(&path, &[tracked(0, 0.0)]).unwrap();
        let poisoned = std::fs::read_to_string(&path).unwrap().replace("11.250", "NaN");
        std::fs::write(&path, poisoned).unwrap();
        assert!(read_path_csv(&path).unwrap_err().to_string().contains("not finite"));
    }

    #[test]
    fn a_missing_frame_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        write_path_csv(&path, &[tracked(0, 0.0), tracked(2, 0.2)]).unwrap();
        assert!(read_path_csv(&path).unwrap_err().to_string().contains("frame 2 stands where 1 is due"));
    }
}
