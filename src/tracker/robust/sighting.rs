//! One frame's own view of the seam.

use crate::units::PixelPoint;

/// Where a frame shows the seam, and how well.
#[derive(Debug, Clone, Copy)]
pub struct Sighting {
    /// The seam centre.
    pub centre: PixelPoint,
    /// Variance of the position along the stripe \[px²\] at the nominal noise.
    pub variance_px2: f64,
    /// So good that it needs no second one beside it.
    pub clear: bool,
    /// The stripe's lines before and behind the seam, each by its two ends.
    pub sides: Option<[[PixelPoint; 2]; 2]>,
}
