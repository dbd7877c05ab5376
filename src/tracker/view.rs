//! From the picture to the frame in which a seam is followed, and back.

use std::borrow::Cow;

use crate::frame::GrayFrame;
use crate::imgproc::Raster;
use crate::units::{PixelPoint, StripeAxis};

/// A frame of reference of its own: the stripe runs along the rows, the raster fits the joint. Points and lengths in it
/// are called `_px` in the whole tracker; [`View`] alone knows what they are in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    axis: StripeAxis,
    raster: Raster,
}

impl View {
    /// The view of a stripe along `axis` in `raster`.
    pub const fn new(axis: StripeAxis, raster: Raster) -> Self {
        Self { axis, raster }
    }

    /// How the stripe runs in the picture.
    pub const fn axis(&self) -> StripeAxis {
        self.axis
    }

    /// The picture as this view has it; its stripe runs along the rows already.
    pub fn frame<'a>(&self, picture: &'a GrayFrame) -> Option<Cow<'a, GrayFrame>> {
        self.raster.resample(picture)
    }

    /// Pixels of the picture for one of the view.
    pub fn picture_px(&self) -> f64 {
        1.0 / self.raster.scale()
    }

    /// A point of the view in the picture.
    pub fn picture_from_view(&self, point: PixelPoint) -> PixelPoint {
        self.axis.image_from_stripe(self.raster.picture_from_raster(point))
    }
}
