//! What a pixel is in the plane of the laser.

use nalgebra::{Matrix2, matrix};
use serde::Serialize;

use super::laser_camera::PlanePoint;
use crate::units::{MmPerPx, PixelPoint, StripeAxis};

/// Maps a pixel to the point of the laser's plane that it shows, and back. Without a scale the plane's coordinates are pixels of
/// the picture: [`Sensor::has_millimetres`]. Of one scale the height grows as the picture's coordinate across the stripe.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sensor {
    /// Nothing is known: lengths stay pixels.
    #[default]
    Pixels,
    /// One scale along and across the stripe, the plane's origin at pixel (0, 0).
    Scale(MmPerPx),
}

impl Sensor {
    /// Whether the plane's coordinates are millimetres.
    #[must_use]
    pub const fn has_millimetres(&self) -> bool {
        matches!(self, Self::Scale(_))
    }

    /// The point of the plane that `pixel` shows, the stripe running along `axis`.
    #[must_use]
    pub fn plane_from_pixel(&self, pixel: PixelPoint, axis: StripeAxis) -> PlanePoint {
        let along = axis.stripe_from_image(pixel);
        let scale = self.scale();
        PlanePoint { lateral_mm: scale * along.u_px, height_mm: scale * along.v_px }
    }

    /// The pixel that shows `point`: the inverse of [`Self::plane_from_pixel`].
    #[must_use]
    pub fn pixel_from_plane(&self, point: PlanePoint, axis: StripeAxis) -> PixelPoint {
        let scale = self.scale();
        axis.image_from_stripe(PixelPoint::new(point.lateral_mm / scale, point.height_mm / scale))
    }

    /// Derivatives of (lateral, height) \[mm\] with respect to (along, across) \[px\] of the stripe at `pixel`, 2×2.
    #[must_use]
    pub fn jacobian_mm_per_px(&self, _pixel: PixelPoint, _axis: StripeAxis) -> Matrix2<f64> {
        let scale = self.scale();
        matrix![scale, 0.0; 0.0, scale]
    }

    fn scale(&self) -> f64 {
        match self {
            Self::Pixels => 1.0,
            Self::Scale(mm_per_px) => mm_per_px.get(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_pixel_comes_back_from_the_plane(
            u_px in -100.0..3000.0, v_px in -100.0..3000.0, scale in 0.001..2.0, vertical: bool, has_scale: bool,
        ) {
            let axis = if vertical { StripeAxis::Vertical } else { StripeAxis::Horizontal };
            let sensor = if has_scale { Sensor::Scale(MmPerPx::new(scale).unwrap()) } else { Sensor::Pixels };
            let pixel = PixelPoint::new(u_px, v_px);
            let back = sensor.pixel_from_plane(sensor.plane_from_pixel(pixel, axis), axis);
            prop_assert!((back.u_px - u_px).abs() < 1e-9 && (back.v_px - v_px).abs() < 1e-9);
        }

        #[test]
        fn the_jacobian_is_what_a_step_of_a_pixel_does(u_px in 0.0..2000.0, v_px in 0.0..2000.0, vertical: bool) {
            let axis = if vertical { StripeAxis::Vertical } else { StripeAxis::Horizontal };
            let sensor = Sensor::Scale(MmPerPx::DU_2022);
            let at = |along: f64, across: f64| {
                let point = axis.image_from_stripe(PixelPoint::new(along, across));
                sensor.plane_from_pixel(point, axis)
            };
            let here = at(u_px, v_px);
            let jacobian = sensor.jacobian_mm_per_px(PixelPoint::new(u_px, v_px), axis);
            for (column, there) in [at(u_px + 1.0, v_px), at(u_px, v_px + 1.0)].into_iter().enumerate() {
                prop_assert!((there.lateral_mm - here.lateral_mm - jacobian[(0, column)]).abs() < 1e-9);
                prop_assert!((there.height_mm - here.height_mm - jacobian[(1, column)]).abs() < 1e-9);
            }
        }
    }
}
