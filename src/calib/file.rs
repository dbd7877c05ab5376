//! `calibration.toml`: reading and writing.
//!
//! The sections `[image]`, `[camera]`, `[laser]`, `[range]` and `[scale]` are a contract for other programs; what they do
//! not hold of it may be absent, and what they add is skipped. `[covariance]`, `[board]`, `[hand_eye]` and `[[views]]` are
//! what seamtrack itself needs to fit again and to say how sure it is.

use std::path::{Path, PathBuf};

use nalgebra::{Matrix4, SMatrix, Vector2, Vector3};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::board::BoardSize;
use super::intrinsics::{INTRINSIC_NAMES, INTRINSICS, Intrinsics};
use super::laser::KnownCamera;
use super::laser_camera::{CalibratedRange, LaserCamera, PARAMETERS, ParameterCovariance};
use super::plane::LaserPlane;
use super::sightings::BoardSighting;

pub use super::file_sections::*;

/// Version of the file's layout.
pub const CALIBRATION_SCHEMA_VERSION: u32 = 1;
/// Names of the plane's parameters in the covariance: [`LaserPlane::varied`].
const PLANE_NAMES: [&str; PARAMETERS - INTRINSICS] = ["towards_lateral_rad", "towards_height_rad", "distance_mm"];
/// A rotation is accepted when its columns are unit vectors and perpendicular to within this.
const ROTATION_TOLERANCE: f64 = 1e-3;
/// No calibration file is longer \[bytes\].
const LONGEST_FILE: u64 = 64 << 20;

/// A calibration file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationFileError {
    /// It cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Its content is wrong.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, and the remedy.
        problem: String,
    },
}

/// The whole file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct CalibrationFile {
    pub schema_version: u32,
    /// The first twelve digits of the SHA-256 of what was measured.
    #[serde(default)]
    pub id: String,
    /// Day of the calibration, yyyy-mm-dd.
    #[serde(default)]
    pub date: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<ImageSection>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSection>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub laser: Option<LaserSection>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<RangeSection>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<ScaleSection>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub board: Option<BoardSection>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hand_eye: Option<HandEyeSection>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<CovarianceSection>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub images: Vec<ImageHash>,
    /// The camera's boards.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub views: Vec<ViewSection>,
}

impl CalibrationFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// When it cannot be read, is no calibration, or holds numbers that no calibration can have.
    pub fn read(path: &Path) -> Result<Self, CalibrationFileError> {
        let failed = |source| CalibrationFileError::Read { path: path.to_owned(), source };
        let content = |problem| CalibrationFileError::Content { path: path.to_owned(), problem };
        let metadata = std::fs::metadata(path).map_err(failed)?;
        if !metadata.is_file() || metadata.len() > LONGEST_FILE {
            return Err(content("is no calibration file: give the TOML file that `calibrate` wrote".into()));
        }
        let text = std::fs::read_to_string(path).map_err(failed)?;
        Self::parse(&text).map_err(content)
    }

    /// The same from the file's text.
    ///
    /// # Errors
    /// In one line, what is wrong.
    pub fn parse(text: &str) -> Result<Self, String> {
        let file: Self = toml::from_str(text).map_err(|error| error.message().replace('\n', " "))?;
        if file.schema_version != CALIBRATION_SCHEMA_VERSION {
            return Err(format!(
                "has schema_version {}, this program reads {CALIBRATION_SCHEMA_VERSION}: calibrate again, or take the program's version that wrote it",
                file.schema_version
            ));
        }
        file.check()?;
        Ok(file)
    }

    /// The file's text.
    ///
    /// # Errors
    /// When a number cannot be written.
    pub fn to_toml(&self) -> Result<String, String> {
        toml::to_string(self).map_err(|error| error.to_string())
    }

    fn check(&self) -> Result<(), String> {
        if let Some(camera) = self.intrinsics() {
            if let Some(problem) = camera.problem() {
                return Err(format!("[camera] {problem}"));
            }
            let image =
                self.image.ok_or("[camera] without [image]: give width and height of the calibrated pictures")?;
            if image.width == 0 || image.height == 0 {
                return Err("[image] has no pixel".into());
            }
        }
        if let Some(laser) = &self.laser {
            LaserPlane::new(Vector3::from(laser.normal), laser.distance_mm).map_err(|e| format!("[laser] {e}"))?;
        }
        if let Some(range) = &self.range {
            let pairs = [
                ("u_px", range.u_px),
                ("v_px", range.v_px),
                ("lateral_mm", range.lateral_mm),
                ("height_mm", range.height_mm),
            ];
            if let Some((name, _)) = pairs.iter().find(|(_, [a, b])| !(a.is_finite() && b.is_finite() && a <= b)) {
                return Err(format!("[range] {name} must be two finite numbers, the smaller first"));
            }
        }
        let wrong = |s: &ScaleSection| !(s.mm_per_px.is_finite() && s.mm_per_px > 0.0 && s.std_mm_per_px >= 0.0);
        if self.scale.as_ref().is_some_and(wrong) {
            return Err("[scale] mm_per_px must be above 0 and std_mm_per_px not below".into());
        }
        if let Some(board) = &self.board {
            BoardSize::new(board.corners[0], board.corners[1]).map_err(|e| format!("[board] {e}"))?;
            if !(board.square_mm.is_finite() && board.square_mm > 0.0) {
                return Err("[board] square_mm must be above 0".into());
            }
        }
        self.hand_eye.as_ref().map_or(Ok(()), |h| check_hand_eye(&h.matrix))?;
        let corners = self.board.map_or(0, |b| b.corners[0] * b.corners[1]);
        if let Some(view) = self
            .views
            .iter()
            .find(|v| v.corners.len() != corners || v.corners.as_flattened().iter().any(|x| !x.is_finite()))
        {
            return Err(format!("[[views]] {} has not the board's {corners} corners", view.file));
        }
        self.parameter_covariance().map(drop)
    }

    /// The camera, if the file has one.
    #[must_use]
    pub fn intrinsics(&self) -> Option<Intrinsics> {
        self.camera.map(|c| Intrinsics::from_array([c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3]))
    }

    /// Columns and rows of the pictures.
    #[must_use]
    pub fn size_px(&self) -> Option<(usize, usize)> {
        self.image.map(|image| (image.width, image.height))
    }

    /// The board, if the file names it.
    #[must_use]
    pub fn board(&self) -> Option<(BoardSize, f64)> {
        self.board.and_then(|b| Some((BoardSize::new(b.corners[0], b.corners[1]).ok()?, b.square_mm)))
    }

    /// The camera with what is needed to fit it again.
    ///
    /// # Errors
    /// When the file has no camera.
    pub fn known_camera(&self) -> Result<KnownCamera, String> {
        let (Some(intrinsics), Some(size_px)) = (self.intrinsics(), self.size_px()) else {
            return Err("has no [camera]: make it with `seamtrack calibrate camera`".into());
        };
        let covariance =
            self.parameter_covariance()?.map(|c| c.fixed_view::<INTRINSICS, INTRINSICS>(0, 0).into_owned());
        let rms_px = self.camera.and_then(|camera| camera.rms_px).filter(|rms_px| *rms_px > 0.0);
        Ok(KnownCamera { size_px, intrinsics, covariance, views: self.sightings(), rms_px })
    }

    fn sightings(&self) -> Vec<BoardSighting> {
        let sighting = |view: &ViewSection| BoardSighting {
            name: view.file.clone(),
            sha256: view.sha256.clone(),
            corners: view.corners.iter().map(|c| Vector2::from(*c)).collect(),
            used: (0..view.corners.len()).map(|i| !view.unused.contains(&i)).collect(),
        };
        self.views.iter().map(sighting).collect()
    }

    /// The calibrated sensor: the one call from a file to millimetres.
    ///
    /// # Errors
    /// When the file has no camera and laser plane.
    pub fn laser_camera(&self) -> Result<LaserCamera, String> {
        let camera = self.known_camera()?;
        let laser = self.laser.ok_or("has no [laser] plane: make it with `seamtrack calibrate laser`")?;
        let plane =
            LaserPlane::new(Vector3::from(laser.normal), laser.distance_mm).map_err(|e| format!("[laser] {e}"))?;
        let range = self.range.map(|r| CalibratedRange {
            u_px: r.u_px,
            v_px: r.v_px,
            lateral_mm: r.lateral_mm,
            height_mm: r.height_mm,
        });
        Ok(LaserCamera::new(camera.size_px, camera.intrinsics, plane, range, self.parameter_covariance()?))
    }

    /// The same for pictures of `size_px` that were cut out at column and row `at_px`; the boards' corners do not come along.
    pub(super) fn cropped(mut self, at_px: (usize, usize), size_px: (usize, usize)) -> Self {
        let (u_px, v_px) = (at_px.0 as f64, at_px.1 as f64);
        self.image = Some(ImageSection { width: size_px.0, height: size_px.1 });
        self.camera = self.camera.map(|c| CameraSection { cx: c.cx - u_px, cy: c.cy - v_px, ..c });
        self.range =
            self.range.map(|r| RangeSection { u_px: r.u_px.map(|u| u - u_px), v_px: r.v_px.map(|v| v - v_px), ..r });
        self.views = vec![];
        self
    }

    /// The robot's hand-eye matrix: X_flange = M · X_camera \[mm\].
    #[must_use]
    pub fn hand_eye(&self) -> Option<Matrix4<f64>> {
        self.hand_eye.map(|h| Matrix4::from_fn(|i, j| h.matrix[i][j]))
    }

    fn parameter_covariance(&self) -> Result<Option<ParameterCovariance>, String> {
        let Some(section) = &self.covariance else { return Ok(None) };
        let known: Vec<&str> = INTRINSIC_NAMES.into_iter().chain(PLANE_NAMES).collect();
        let count = section.parameters.len();
        let expected =
            section.parameters.iter().zip(&known).all(|(a, b)| a == b) && (count == INTRINSICS || count == PARAMETERS);
        let square = section.matrix.len() == count && section.matrix.iter().all(|row| row.len() == count);
        if !expected || !square {
            return Err(format!("[covariance] must be a square matrix over {}", known.join(", ")));
        }
        let mut covariance = ParameterCovariance::zeros();
        for i in 0..count {
            for j in 0..count {
                let (value, mirrored) = (section.matrix[i][j], section.matrix[j][i]);
                if !value.is_finite()
                    || (value - mirrored).abs() > 1e-6 * (value.abs() + mirrored.abs())
                    || (i == j && value < 0.0)
                {
                    return Err("[covariance] must be symmetric, with finite numbers and no variance below 0".into());
                }
                covariance[(i, j)] = value;
            }
        }
        Ok(Some(covariance))
    }

    /// Writes the camera's part.
    pub fn set_camera(&mut self, size_px: (usize, usize), intrinsics: &Intrinsics) {
        let [fx, fy, cx, cy, k1, k2, p1, p2, k3] = intrinsics.to_array();
        self.image = Some(ImageSection { width: size_px.0, height: size_px.1 });
        let former = self.camera.take();
        let (rms_px, views) = (former.and_then(|c| c.rms_px), former.and_then(|c| c.views));
        let left_out_rms_px = former.and_then(|c| c.left_out_rms_px);
        self.camera = Some(CameraSection { fx, fy, cx, cy, k1, k2, p1, p2, k3, rms_px, views, left_out_rms_px });
    }

    /// Writes a covariance over the first `N` parameters.
    pub fn set_covariance<const N: usize>(&mut self, covariance: &SMatrix<f64, N, N>) {
        let names = INTRINSIC_NAMES.into_iter().chain(PLANE_NAMES).take(N).map(ToOwned::to_owned).collect();
        let row = |i: usize| (0..N).map(|j| 0.5 * (covariance[(i, j)] + covariance[(j, i)])).collect();
        self.covariance = Some(CovarianceSection { parameters: names, matrix: (0..N).map(row).collect() });
    }

    /// Writes the boards of the camera.
    pub fn set_views<'a>(&mut self, board: BoardSize, square_mm: f64, views: impl Iterator<Item = &'a BoardSighting>) {
        self.board = Some(BoardSection { corners: [board.columns, board.rows], square_mm });
        let view = |sighting: &BoardSighting| ViewSection {
            file: sighting.name.clone(),
            sha256: sighting.sha256.clone(),
            corners: sighting.corners.iter().map(|c| [round(c.x), round(c.y)]).collect(),
            unused: (0..sighting.used.len()).filter(|&i| !sighting.used[i]).collect(),
        };
        self.views = views.map(view).collect();
    }

    /// Writes date and id; call it last.
    pub fn seal(&mut self, today: String) {
        self.schema_version = CALIBRATION_SCHEMA_VERSION;
        self.id = String::new();
        self.date = String::new();
        let content = self.to_toml().unwrap_or_default();
        self.id = sha256_hex(content.as_bytes())[..12].to_owned();
        self.date = today;
    }
}

/// Corners are kept to a ten thousandth of a pixel.
fn round(px: f64) -> f64 {
    (px * 1e4).round() / 1e4
}

/// The SHA-256 of bytes in hexadecimal digits.
#[must_use]
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Whether a 4 × 4 matrix is a rigid motion.
///
/// # Errors
/// In one line, what it is instead.
pub fn check_hand_eye(matrix: &[[f64; 4]; 4]) -> Result<(), String> {
    let m = Matrix4::from_fn(|i, j| matrix[i][j]);
    let rotation = m.fixed_view::<3, 3>(0, 0);
    let off = (rotation.transpose() * rotation - SMatrix::<f64, 3, 3>::identity()).abs().max();
    let last = (m.row(3) - nalgebra::RowVector4::new(0.0, 0.0, 0.0, 1.0)).abs().max();
    let rigid = off < ROTATION_TOLERANCE && last < ROTATION_TOLERANCE && rotation.determinant() > 0.0;
    let finite = m.iter().all(|x| x.is_finite());
    if rigid && finite {
        Ok(())
    } else {
        Err("the hand-eye matrix is no rigid motion: 4 rows of 4 numbers, a rotation, a shift in mm, and 0 0 0 1"
            .into())
    }
}

/// The day of a number of seconds since 1970, UTC, as yyyy-mm-dd (Hinnant, chrono-compatible low-level date algorithms).
#[must_use]
pub fn day_of(seconds_since_1970: u64) -> String {
    let days = seconds_since_1970 / 86_400 + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let (month, next_year) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", year_of_era + era * 400 + next_year)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BY_HAND: &str = "schema_version = 1\nid = \"x\"\ndate = \"2026-01-01\"\n[image]\nwidth = 1000\nheight = 750\n\
        [camera]\nfx = 1250.0\nfy = 1252\ncx = 507.0\ncy = 371.0\n[laser]\nnormal = [0.02, 0.927, 0.375]\ndistance_mm = 93.0\n";

    #[test]
    fn a_file_written_by_hand_gives_a_sensor_without_range_and_covariance() {
        let sensor = CalibrationFile::parse(BY_HAND).unwrap().laser_camera().unwrap();
        assert_eq!(sensor.size_px(), (1000, 750));
        assert!(sensor.range().is_none() && sensor.covariance().is_none());
        assert!(!sensor.is_calibrated(crate::units::PixelPoint::new(507.0, 371.0)));
    }

    #[test]
    fn what_is_written_is_read_again() {
        let mut file = CalibrationFile::parse(BY_HAND).unwrap();
        let mut covariance = ParameterCovariance::identity() * 0.25;
        covariance[(0, 1)] = 0.1;
        covariance[(1, 0)] = 0.1;
        file.set_covariance(&covariance);
        file.range =
            Some(RangeSection { u_px: [0.0, 9.0], v_px: [1.0, 2.0], lateral_mm: [-1.0, 1.0], height_mm: [-3.0, -2.0] });
        file.seal("2026-11-25".into());
        let again = CalibrationFile::parse(&file.to_toml().unwrap()).unwrap();
        assert_eq!(again, file);
        assert_eq!(again.laser_camera().unwrap().covariance(), Some(&covariance));
        assert_eq!(again.id.len(), 12);
    }

    #[test]
    fn numbers_that_no_calibration_has_are_named() {
        let problem = |from: &str, to: &str| CalibrationFile::parse(&BY_HAND.replace(from, to)).unwrap_err();
        assert!(problem("fx = 1250.0", "fx = nan").contains("fx"));
        assert!(problem("schema_version = 1", "schema_version = 9").contains("schema_version 9"));
        assert!(problem("[0.02, 0.927, 0.375]", "[0.0, 0.0, 0.0]").contains("[laser]"));
        assert!(problem("[image]\nwidth = 1000\nheight = 750\n", "").contains("[image]"));
        assert!(
            CalibrationFile::parse("schema_version = 1")
                .unwrap()
                .laser_camera()
                .unwrap_err()
                .contains("calibrate camera")
        );
        assert!(CalibrationFile::parse("nonsense").is_err());
    }

    #[test]
    fn days_are_counted_over_leap_years() {
        assert_eq!(day_of(0), "1970-01-01");
        assert_eq!(day_of(951_782_400), "2000-02-29");
        assert_eq!(day_of(1_795_564_800), "2026-11-25");
    }
}
