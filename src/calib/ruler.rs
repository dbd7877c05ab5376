//! Positions along the stripe.

use nalgebra::{Matrix2, matrix};

use super::sensor::Sensor;
use crate::units::{LengthUnit, PixelPoint, StripeAxis};

/// Where x = 0 lies along the stripe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Origin {
    /// At the seam of the first tracked frame.
    First,
    /// At the middle of the image.
    Centre,
    /// At this coordinate along the stripe \[px\], in the middle across it.
    At(f64),
}

impl std::str::FromStr for Origin {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "first" => Ok(Self::First),
            "centre" | "center" => Ok(Self::Centre),
            _ => match text.parse::<f64>() {
                Ok(px) if px.is_finite() => Ok(Self::At(px)),
                _ => Err("expected first, centre or a pixel coordinate".into()),
            },
        }
    }
}

/// Measures along a stripe: in millimetres from an origin, or, by a sensor without them, in the picture's own pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Ruler {
    /// What a pixel is.
    pub sensor: Sensor,
    /// Which way the stripe runs.
    pub axis: StripeAxis,
    /// The pixel where x = 0.
    pub origin: PixelPoint,
}

impl Ruler {
    /// The unit of positions and errors.
    #[must_use]
    pub const fn unit(&self) -> LengthUnit {
        self.sensor.unit()
    }

    /// The position along the stripe of what `pixel` shows, in [`Self::unit`].
    #[must_use]
    pub fn position(&self, pixel: PixelPoint) -> Option<f64> {
        if !self.sensor.has_millimetres() {
            return Some(self.axis.along_px(pixel));
        }
        let lateral = |pixel| self.sensor.plane_from_pixel(pixel, self.axis).map(|point| point.lateral_mm);
        Some(lateral(pixel)? - lateral(self.origin)?)
    }

    /// The same where it is in millimetres.
    #[must_use]
    pub fn position_mm(&self, pixel: PixelPoint) -> Option<f64> {
        self.sensor.has_millimetres().then(|| self.position(pixel))?
    }

    /// An error of `error_px` along the stripe at `pixel`, in [`Self::unit`].
    #[must_use]
    pub fn error(&self, pixel: PixelPoint, error_px: f64) -> Option<f64> {
        self.sensor.scale_along(pixel, self.axis).map(|scale| scale * error_px)
    }

    /// Covariance of (lateral, height) of a pixel whose σ along and across the stripe are given: what the picture's noise
    /// makes \[mm²\]. None without millimetres.
    #[must_use]
    pub fn noise_mm2(&self, pixel: PixelPoint, std_px: f64, std_across_px: f64) -> Option<Matrix2<f64>> {
        let jacobian = self.sensor.jacobian_mm_per_px(pixel, self.axis).filter(|_| self.sensor.has_millimetres())?;
        let covariance_px2 = matrix![std_px.powi(2), 0.0; 0.0, std_across_px.powi(2)];
        Some(jacobian * covariance_px2 * jacobian.transpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::MmPerPx;

    fn ruler(sensor: Sensor) -> Ruler {
        Ruler { sensor, axis: StripeAxis::Vertical, origin: PixelPoint::new(7.0, 100.0) }
    }

    #[test]
    fn millimetres_count_from_the_origin_and_pixels_from_the_pictures_border() {
        let pixel = PixelPoint::new(3.0, 110.0);
        let scale = ruler(Sensor::Scale(MmPerPx::DU_2022));
        approx::assert_relative_eq!(scale.position(pixel).unwrap(), 0.73, epsilon = 1e-12);
        approx::assert_relative_eq!(
            scale.noise_mm2(pixel, 2.0, 1.0).unwrap()[(0, 0)],
            0.146f64.powi(2),
            epsilon = 1e-12
        );
        let pixels = ruler(Sensor::Pixels);
        assert_eq!((pixels.position(pixel), pixels.position_mm(pixel)), (Some(110.0), None));
        assert_eq!(pixels.noise_mm2(pixel, 1.0, 1.0), None);
    }

    #[test]
    fn an_origin_is_a_word_or_a_pixel() {
        assert_eq!("centre".parse(), Ok(Origin::Centre));
        assert_eq!("12.5".parse(), Ok(Origin::At(12.5)));
        assert!("nan".parse::<Origin>().is_err());
    }
}
