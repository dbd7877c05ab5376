//! The error figures of a path against its truth.

use serde::{Deserialize, Serialize};

/// Errors along the stripe, estimate − truth, over the frames that have both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Frames with an estimate and a truth.
    pub frames: usize,
    /// Mean absolute error \[mm\].
    pub mae_mm: f64,
    /// Largest absolute error \[mm\].
    pub max_mm: f64,
    /// Standard deviation of the absolute error \[mm\], as in the papers.
    pub std_mm: f64,
    /// Root mean square error \[mm\].
    pub rmse_mm: f64,
    /// 95th percentile of the absolute error \[mm\].
    pub p95_mm: f64,
    /// Mean signed error \[mm\].
    pub bias_mm: f64,
    /// Share of frames within ±2σ, 0 to 1; absent for an estimate without σ.
    pub coverage_2sigma: Option<f64>,
    /// Frames with a value that is off by over 1 mm.
    pub wrong_frames: usize,
    /// Frames without a value after the seam was first confirmed.
    pub unavailable_frames: usize,
}
