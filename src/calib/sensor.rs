//! What a pixel is in the plane of the laser.

use std::sync::Arc;

use nalgebra::{Matrix2, matrix};

use super::laser_camera::{LaserCamera, PlanePoint};
use crate::units::{LengthUnit, MmPerPx, PixelPoint, StripeAxis};

/// Maps a pixel to the point of the laser's plane that it shows, and back. Without a scale the plane's coordinates are pixels of
/// the picture: [`Sensor::has_millimetres`]. Of one scale the height grows as the picture's coordinate across the stripe; of a
/// calibrated camera and plane it points towards the camera.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Sensor {
    /// Nothing is known: lengths stay pixels.
    #[default]
    Pixels,
    /// One scale along and across the stripe, the plane's origin at pixel (0, 0).
    Scale(MmPerPx),
    /// A calibrated camera and laser plane.
    Plane(Arc<LaserCamera>),
}

impl Sensor {
    /// Whether the plane's coordinates are millimetres.
    #[must_use]
    pub const fn has_millimetres(&self) -> bool {
        !matches!(self, Self::Pixels)
    }

    /// The unit of the plane's coordinates.
    #[must_use]
    pub const fn unit(&self) -> LengthUnit {
        if self.has_millimetres() { LengthUnit::Mm } else { LengthUnit::Px }
    }

    /// The calibrated camera and plane, if that is what the sensor is.
    #[must_use]
    pub fn laser_camera(&self) -> Option<&LaserCamera> {
        match self {
            Self::Plane(sensor) => Some(sensor),
            Self::Pixels | Self::Scale(_) => None,
        }
    }

    /// The point of the plane that `pixel` shows, the stripe running along `axis`. None where the pixel's ray does not meet
    /// the plane in front of the camera.
    #[must_use]
    pub fn plane_from_pixel(&self, pixel: PixelPoint, axis: StripeAxis) -> Option<PlanePoint> {
        let scale = match self {
            Self::Plane(sensor) => return sensor.point(pixel),
            Self::Scale(mm_per_px) => mm_per_px.get(),
            Self::Pixels => 1.0,
        };
        let along = axis.stripe_from_image(pixel);
        Some(PlanePoint { lateral_mm: scale * along.u_px, height_mm: scale * along.v_px })
    }

    /// The pixel that shows `point`: the inverse of [`Self::plane_from_pixel`]. None behind the camera.
    #[must_use]
    pub fn pixel_from_plane(&self, point: PlanePoint, axis: StripeAxis) -> Option<PixelPoint> {
        let scale = match self {
            Self::Plane(sensor) => return sensor.pixel(point),
            Self::Scale(mm_per_px) => mm_per_px.get(),
            Self::Pixels => 1.0,
        };
        Some(axis.image_from_stripe(PixelPoint::new(point.lateral_mm / scale, point.height_mm / scale)))
    }

    /// Derivatives of (lateral, height) \[mm\] with respect to (along, across) \[px\] of the stripe at `pixel`, 2×2.
    #[must_use]
    pub fn jacobian_mm_per_px(&self, pixel: PixelPoint, axis: StripeAxis) -> Option<Matrix2<f64>> {
        let scale = match self {
            Self::Plane(sensor) => {
                let mut by_pixel = sensor.jacobian(pixel)?;
                if axis == StripeAxis::Vertical {
                    by_pixel.swap_columns(0, 1);
                }
                return Some(by_pixel);
            }
            Self::Scale(mm_per_px) => mm_per_px.get(),
            Self::Pixels => 1.0,
        };
        Some(matrix![scale, 0.0; 0.0, scale])
    }

    /// Length along the stripe that one pixel shows at `pixel`, in the sensor's unit a pixel.
    #[must_use]
    pub fn scale_along(&self, pixel: PixelPoint, axis: StripeAxis) -> Option<f64> {
        self.jacobian_mm_per_px(pixel, axis).map(|jacobian| jacobian[(0, 0)])
    }
}

#[cfg(test)]
mod tests {
    use super::super::laser_camera::tests::sensor as laser_camera;
    use super::*;
    use proptest::prelude::*;

    fn kinds() -> impl Strategy<Value = (Sensor, StripeAxis)> {
        let axis = any::<bool>().prop_map(|v| if v { StripeAxis::Vertical } else { StripeAxis::Horizontal });
        let plain = (axis, prop::option::of(0.001..2.0f64)).prop_map(|(axis, scale)| {
            (scale.map_or(Sensor::Pixels, |scale| Sensor::Scale(MmPerPx::new(scale).unwrap())), axis)
        });
        prop_oneof![plain, Just((Sensor::Plane(Arc::new(laser_camera())), StripeAxis::Horizontal))]
    }

    proptest! {
        #[test]
        fn a_pixel_comes_back_from_the_plane(u_px in 0.0..1000.0, v_px in 150.0..700.0, (sensor, axis) in kinds()) {
            let pixel = PixelPoint::new(u_px, v_px);
            let back = sensor.pixel_from_plane(sensor.plane_from_pixel(pixel, axis).unwrap(), axis).unwrap();
            prop_assert!((back.u_px - u_px).abs() < 1e-6 && (back.v_px - v_px).abs() < 1e-6);
        }

        #[test]
        fn the_jacobian_is_what_a_small_step_does(u_px in 10.0..990.0, v_px in 150.0..700.0, (sensor, axis) in kinds()) {
            let pixel = PixelPoint::new(u_px, v_px);
            let at = |along: f64, across: f64| {
                let by = axis.image_from_stripe(PixelPoint::new(along, across));
                sensor.plane_from_pixel(PixelPoint::new(u_px + by.u_px, v_px + by.v_px), axis).unwrap()
            };
            let jacobian = sensor.jacobian_mm_per_px(pixel, axis).unwrap();
            for (column, (along, across)) in [(0.01, 0.0), (0.0, 0.01)].into_iter().enumerate() {
                let (there, back) = (at(along, across), at(-along, -across));
                prop_assert!(((there.lateral_mm - back.lateral_mm) / 0.02 - jacobian[(0, column)]).abs() < 1e-6);
                prop_assert!(((there.height_mm - back.height_mm) / 0.02 - jacobian[(1, column)]).abs() < 1e-6);
            }
            prop_assert!(sensor.scale_along(pixel, axis).unwrap() > 0.0);
        }
    }
}
