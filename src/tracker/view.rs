//! From the picture to the frame in which a seam is followed, and back.

use std::borrow::Cow;

use crate::frame::GrayFrame;
use crate::imgproc::Raster;
use crate::units::{PixelPoint, PixelRect, StripeAxis};

/// What of the camera's picture a tracker is given: the part the user wants looked at, turned so that its stripe runs along
/// the rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// How the stripe runs in the picture.
    pub axis: StripeAxis,
    /// The field's first pixel, in the picture.
    pub origin_px: (usize, usize),
}

impl Field {
    /// The whole picture.
    pub const fn whole(axis: StripeAxis) -> Self {
        Self { axis, origin_px: (0, 0) }
    }

    /// A point of the picture in the field.
    pub fn field_from_picture(&self, point: PixelPoint) -> PixelPoint {
        let (u_px, v_px) = self.origin_px;
        self.axis.stripe_from_image(PixelPoint::new(point.u_px - u_px as f64, point.v_px - v_px as f64))
    }

    /// A point of the field in the picture.
    fn picture_from_field(&self, point: PixelPoint) -> PixelPoint {
        let (u_px, v_px) = self.origin_px;
        let turned = self.axis.image_from_stripe(point);
        PixelPoint::new(turned.u_px + u_px as f64, turned.v_px + v_px as f64)
    }
}

/// A frame of reference of its own: the stripe runs along the rows, there is one stripe, the raster fits the joint. Points
/// and lengths in it are called `_px` in the whole tracker; [`View`] alone knows what they are in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    field: Field,
    part: Option<PixelRect>,
    raster: Raster,
}

impl View {
    /// The view of the whole field in `raster`.
    pub const fn new(field: Field, raster: Raster) -> Self {
        Self { field, part: None, raster }
    }

    /// The view of the part of the field that holds one of its stripes.
    pub const fn of_part(field: Field, part: Option<PixelRect>, raster: Raster) -> Self {
        Self { field, part, raster }
    }

    /// How the stripe runs in the picture.
    pub const fn axis(&self) -> StripeAxis {
        self.field.axis
    }

    /// The part of the field that it shows, if not all of it.
    pub const fn part(&self) -> Option<PixelRect> {
        self.part
    }

    /// Its raster.
    pub const fn raster(&self) -> Raster {
        self.raster
    }

    /// The same part in another raster.
    pub const fn in_raster(self, raster: Raster) -> Self {
        Self { raster, ..self }
    }

    /// The part of the field that the view shows, in the field's own raster.
    pub fn part_of<'a>(&self, field: &'a GrayFrame) -> Option<Cow<'a, GrayFrame>> {
        self.in_raster(Raster::PICTURE).frame(field)
    }

    /// The field as this view has it; its stripe runs along the rows already.
    pub fn frame<'a>(&self, field: &'a GrayFrame) -> Option<Cow<'a, GrayFrame>> {
        let Some(part) = self.part else { return self.raster.resample(field) };
        let part = field.cropped(part)?;
        if self.raster == Raster::PICTURE {
            return Some(Cow::Owned(part));
        }
        self.raster.resample(&part).map(|frame| Cow::Owned(frame.into_owned()))
    }

    /// Pixels of the picture for one of the view.
    pub fn picture_px(&self) -> f64 {
        1.0 / self.raster.scale()
    }

    /// A point of the view in the picture.
    pub fn picture_from_view(&self, point: PixelPoint) -> PixelPoint {
        let at = self.raster.picture_from_raster(point);
        let corner = self.part.map_or((0, 0), |part| (part.u_px, part.v_px));
        self.field.picture_from_field(PixelPoint::new(at.u_px + corner.0 as f64, at.v_px + corner.1 as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_of_a_part_of_a_vertical_stripes_field_is_found_in_the_picture() {
        let field = Field { axis: StripeAxis::Vertical, origin_px: (100, 20) };
        let part = PixelRect { u_px: 30, v_px: 8, width_px: 50, height_px: 40 };
        let view = View::of_part(field, Some(part), Raster::PICTURE);
        let seen = view.picture_from_view(PixelPoint::new(3.0, 5.0));
        assert_eq!(seen, PixelPoint::new(100.0 + 8.0 + 5.0, 20.0 + 30.0 + 3.0));
        let back = field.field_from_picture(seen);
        assert_eq!(back, PixelPoint::new(33.0, 13.0));
    }
}
