//! A trajectory in the TUM format, which evo (`evo_ape tum`) and other tools read.
//!
//! `timestamp tx ty tz qx qy qz qw`, seconds and metres: tx is the position along the stripe, `x_mm / 1000`; ty and
//! tz are 0 and the orientation is the identity, since one seam position is all there is to say.

use std::io::Write;
use std::path::Path;

use nalgebra::Vector3;

use super::atomic::{ResultsError, write_atomically};

/// Write the positions that are known. Nine decimals: a nanometre, finer than `path.csv`.
///
/// # Errors
/// When the file cannot be written.
pub fn write_tum(path: &Path, samples: impl IntoIterator<Item = (f64, Option<f64>)>) -> Result<(), ResultsError> {
    write_atomically(path, |file| {
        for (time_s, x_mm) in samples {
            if let Some(x_mm) = x_mm {
                writeln!(file, "{time_s:.6} {:.9} 0 0 0 0 0 1", x_mm / 1000.0)?;
            }
        }
        Ok(())
    })
}

/// Write the points of a path in space \[mm\]; the orientation is the identity.
///
/// # Errors
/// When the file cannot be written.
pub fn write_points(path: &Path, points: impl IntoIterator<Item = (f64, Vector3<f64>)>) -> Result<(), ResultsError> {
    write_atomically(path, |file| {
        for (time_s, point_mm) in points {
            let m = point_mm / 1000.0;
            writeln!(file, "{time_s:.6} {:.9} {:.9} {:.9} 0 0 0 1", m.x, m.y, m.z)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn millimetres_become_metres_and_absent_values_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("filtered.tum");
        write_tum(&path, [(0.0, Some(1.5)), (0.2, None), (0.4, Some(-0.25))]).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        assert_eq!(text, "0.000000 0.001500000 0 0 0 0 0 1\n0.400000 -0.000250000 0 0 0 0 0 1\n");
    }
}
