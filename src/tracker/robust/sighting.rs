//! One frame's own view of the seam.

use crate::imgproc::geometry::{JointFit, Refusal};
use crate::tracker::estimate::{CrossSection, Evidence};
use crate::tracker::path::Measured;
use crate::units::PixelPoint;

/// Where a frame shows the seam, and how well.
#[derive(Debug, Clone, Copy)]
pub struct Sighting {
    /// The seam centre.
    pub centre: PixelPoint,
    /// Variance of the position along the stripe \[px²\].
    pub variance_px2: f64,
    /// Variance of the position across it \[px²\].
    pub across_variance_px2: f64,
    /// So good that it needs no second one beside it.
    pub clear: bool,
    /// What it rests on.
    pub evidence: Evidence,
    /// The joint as it was seen.
    pub section: Option<CrossSection>,
    /// The stripe's geometry, where the seam was sighted by it.
    pub fit: Option<JointFit>,
}

impl Sighting {
    /// The measurement, its R that of a noise `noise` times the nominal one.
    pub fn measured(&self, noise: f64) -> Measured {
        let across = (self.centre.v_px, self.across_variance_px2);
        Measured { along: (self.centre.u_px, noise * self.variance_px2), across: Some(across) }
    }
}

/// A frame that shows no seam to be trusted.
#[derive(Debug, Clone, Copy)]
pub struct Unsighted {
    /// Why.
    pub refusal: Refusal,
    /// What was seen nevertheless.
    pub evidence: Evidence,
}

impl From<Refusal> for Unsighted {
    fn from(refusal: Refusal) -> Self {
        Self { refusal, evidence: Evidence::NONE }
    }
}
