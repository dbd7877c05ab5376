//! The place where the user says that the seam is.

use super::seed::{self, Seed};
use crate::frame::GrayFrame;
use crate::imgproc::geometry::JointKind;
use crate::units::PixelPoint;

/// For how many frames with a stripe a joint is sought at the place the user gave. Chosen: a hairline takes some twenty.
pub const ASKED_FRAMES: usize = 40;
/// How far from there it may be found \[px of the picture\]: as far as a fit searches and a hand errs, and for some frames as far
/// as the seam moves. Chosen.
const ASKED_PX: f64 = 16.0;
const ASKED_MOVING_FRAMES: usize = 10;

/// How far a seam may move from frame to frame \[px\].
pub const MOTION_PX: f64 = 1.5;

/// Where the user says that the seam is.
pub struct Asked {
    centre: PixelPoint,
    raster_px_a_px: f64,
    /// Frames with a stripe that showed nothing there.
    pub frames: usize,
    /// A joint that is certain, and not there.
    pub elsewhere: Option<(JointKind, PixelPoint)>,
}

impl Asked {
    /// There, in a view that has so many pixels a pixel of the picture.
    pub const fn new(centre: PixelPoint, raster_px_a_px: f64) -> Self {
        Self { centre, raster_px_a_px, frames: 0, elsewhere: None }
    }

    /// The joint at that place: certain in the first frame, for which it was given; later it must be confirmed.
    pub fn seed(&self, frame: &GrayFrame, kind: Option<JointKind>) -> Option<Seed> {
        let seed = seed::at(frame, kind, self.centre)?;
        Some(Seed { certain: self.frames == 0, ..seed })
    }

    /// Whether a joint at `place` may be the one that was meant.
    pub fn is_near(&self, place: PixelPoint) -> bool {
        let reach_px = (ASKED_PX + MOTION_PX * self.frames.min(ASKED_MOVING_FRAMES) as f64) * self.raster_px_a_px;
        let (du, dv) = (place.u_px - self.centre.u_px, place.v_px - self.centre.v_px);
        du.abs() <= reach_px && dv.abs() <= reach_px
    }
}
