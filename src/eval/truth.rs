//! Reading `truth.csv`.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use serde::Deserialize;

use crate::units::{PixelPoint, StripeAxis};

/// What is true in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruthRow {
    /// Frame number, from 0.
    pub frame: usize,
    /// Column of the seam centre \[px\], where the file gives one.
    pub u_px: Option<f64>,
    /// Row of the seam centre \[px\], where the file gives one.
    pub v_px: Option<f64>,
    /// Whether the seam is hidden in this frame.
    pub occluded: bool,
    /// Visible opening \[px\], where there is one.
    pub gap_px: Option<f64>,
    /// The seam in the plane of the laser, along the stripe and towards the camera \[mm\], where the file gives both.
    pub plane_mm: Option<[f64; 2]>,
}

impl TruthRow {
    /// The seam's position along the stripe \[px\]; none where there is no seam.
    #[must_use]
    pub fn along_px(&self, axis: StripeAxis) -> Option<f64> {
        match axis {
            StripeAxis::Horizontal => self.u_px,
            StripeAxis::Vertical => self.v_px,
        }
    }

    /// The seam centre, where both coordinates are given.
    #[must_use]
    pub fn seam(&self) -> Option<PixelPoint> {
        Some(PixelPoint::new(self.u_px?, self.v_px?))
    }
}

/// A truth file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TruthFileError {
    /// The file cannot be read, or a line is not a row.
    #[error("cannot read the truth {file}")]
    Read {
        /// The file.
        file: String,
        /// Why, with the line.
        source: csv::Error,
    },
    /// The file has no column for the position.
    #[error("{file} is not a truth: it needs the columns frame and u_px or v_px, frames once each")]
    Columns {
        /// The file.
        file: String,
    },
    /// A number is not finite.
    #[error("{file}: frame {frame} has a coordinate that is not a finite number")]
    NotFinite {
        /// The file.
        file: String,
        /// The frame.
        frame: usize,
    },
}

#[derive(Deserialize)]
struct Line {
    frame: usize,
    u_px: Option<f64>,
    v_px: Option<f64>,
    occluded: Option<u8>,
    gap_px: Option<f64>,
    lateral_mm: Option<f64>,
    height_mm: Option<f64>,
}

/// Reads a truth (`frame,u_px,v_px,x_mm,occluded[,gap_px][,lateral_mm,height_mm]`, an empty cell where there is no value); the coordinate
/// along the stripe suffices, further columns are ignored. The rows come sorted by frame.
///
/// # Errors
/// When the file cannot be read, has no position, names a frame twice, or holds a number that is not finite.
pub fn read_truth(file: &Path) -> Result<Vec<TruthRow>, TruthFileError> {
    let failed = |source| TruthFileError::Read { file: file.display().to_string(), source };
    parse_truth(std::fs::File::open(file).map_err(csv::Error::from).map_err(failed)?, file)
}

/// The same of what `file` holds, or held.
///
/// # Errors
/// As [`read_truth`].
pub fn parse_truth(content: impl Read, file: &Path) -> Result<Vec<TruthRow>, TruthFileError> {
    let name = || file.display().to_string();
    let read = |source| TruthFileError::Read { file: name(), source };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(content);
    let headers = reader.headers().map_err(read)?.clone();
    let has = |column: &str| headers.iter().any(|header| header == column);
    if !(has("frame") && (has("u_px") || has("v_px"))) {
        return Err(TruthFileError::Columns { file: name() });
    }
    let mut rows = BTreeMap::new();
    for line in reader.deserialize() {
        let line: Line = line.map_err(read)?;
        if [line.u_px, line.v_px, line.gap_px, line.lateral_mm, line.height_mm]
            .into_iter()
            .flatten()
            .any(|value| !value.is_finite())
        {
            return Err(TruthFileError::NotFinite { file: name(), frame: line.frame });
        }
        let occluded = line.occluded.is_some_and(|flag| flag != 0);
        let row = TruthRow {
            frame: line.frame,
            u_px: line.u_px,
            v_px: line.v_px,
            occluded,
            gap_px: line.gap_px,
            plane_mm: line.lateral_mm.zip(line.height_mm).map(|(lateral, height)| [lateral, height]),
        };
        if rows.insert(line.frame, row).is_some() {
            return Err(TruthFileError::Columns { file: name() });
        }
    }
    Ok(rows.into_values().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file_with(text: &str) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    #[test]
    fn empty_cells_mean_that_there_is_no_seam() {
        let file = file_with("frame,u_px,v_px,x_mm,occluded,gap_px\n1,310.5,200.0,0.1,1,13\n0,,,,0,\n");
        let rows = read_truth(file.path()).unwrap();
        assert_eq!(rows[0].along_px(StripeAxis::Horizontal), None);
        assert_eq!(rows[1].seam(), Some(PixelPoint::new(310.5, 200.0)));
        assert!(rows[1].occluded && rows[1].gap_px == Some(13.0));
    }

    #[test]
    fn the_coordinate_along_the_stripe_suffices() {
        let file = file_with("frame,v_px\n0,12.5\n");
        assert_eq!(read_truth(file.path()).unwrap()[0].along_px(StripeAxis::Vertical), Some(12.5));
    }

    #[test]
    fn a_file_that_is_no_truth_is_refused_by_name() {
        for text in ["time,x\n0,1\n", "frame,u_px\n0,nan\n", "frame,u_px\n0,one\n", "frame,u_px\n0,1\n0,2\n"] {
            let file = file_with(text);
            let error = read_truth(file.path()).unwrap_err().to_string();
            assert!(error.contains(&file.path().display().to_string()), "{error}");
        }
    }
}
