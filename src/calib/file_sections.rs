//! The sections of `calibration.toml`, key by key.

use serde::{Deserialize, Serialize};

/// Size of the calibrated pictures \[px\].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct ImageSection {
    pub width: usize,
    pub height: usize,
}

/// The camera, as in [`Intrinsics`](super::intrinsics::Intrinsics), with what its fit left over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct CameraSection {
    pub fx: f64,
    pub fy: f64,
    pub cx: f64,
    pub cy: f64,
    #[serde(default)]
    pub k1: f64,
    #[serde(default)]
    pub k2: f64,
    #[serde(default)]
    pub p1: f64,
    #[serde(default)]
    pub p2: f64,
    #[serde(default)]
    pub k3: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_px: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views: Option<usize>,
    /// Reprojection error of views left out one by one \[px\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out_rms_px: Option<f64>,
}

/// The laser's plane: normal · X = distance, camera frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct LaserSection {
    pub normal: [f64; 3],
    pub distance_mm: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views: Option<usize>,
}

/// Where stripes were seen: least and largest value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct RangeSection {
    pub u_px: [f64; 2],
    pub v_px: [f64; 2],
    pub lateral_mm: [f64; 2],
    pub height_mm: [f64; 2],
}

/// One scale alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct ScaleSection {
    pub mm_per_px: f64,
    #[serde(default)]
    pub std_mm_per_px: f64,
    /// The coordinate that was measured: u or v.
    #[serde(default)]
    pub axis: String,
}

/// The board.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct BoardSection {
    /// Inner corners along a row, and rows of them.
    pub corners: [usize; 2],
    pub square_mm: f64,
}

/// The camera in the frame of the robot's flange: X_flange = M · X_camera, in mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct HandEyeSection {
    pub matrix: [[f64; 4]; 4],
}

/// Covariance of the parameters in the order of `parameters`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct CovarianceSection {
    pub parameters: Vec<String>,
    pub matrix: Vec<Vec<f64>>,
}

/// A picture that went into the calibration.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct ImageHash {
    pub file: String,
    pub sha256: String,
}

/// A board that the camera was calibrated with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are the file's keys")]
pub struct ViewSection {
    pub file: String,
    pub sha256: String,
    /// Corners row by row \[px\].
    pub corners: Vec<[f64; 2]>,
    /// Numbers of the corners that are not used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unused: Vec<usize>,
}
