//! Pixels to millimetres.

pub mod adjust;
pub mod board;
pub mod board_svg;
pub mod camera;
pub mod check;
pub mod check_travel;
pub mod corners;
mod cv;
pub mod detect;
pub mod error;
pub mod file;
mod file_sections;
pub mod guidance;
pub mod interchange;
pub mod intrinsics;
pub mod laser;
pub mod laser_camera;
pub mod pairs;
pub mod plane;
pub mod pose;
pub mod resample;
pub mod scale;
mod sensor;
pub mod stripe;
pub mod stripes;
mod student;
pub mod travel;
pub mod uncertainty;
mod yaml;

use serde::Serialize;

pub use laser_camera::PlanePoint;
pub use sensor::Sensor;

use crate::units::MmPerPx;

/// Where x = 0 lies along the stripe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Origin {
    /// At the seam of the first tracked frame.
    First,
    /// At the middle of the image.
    Centre,
    /// At this coordinate along the stripe \[px\].
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

/// x = scale · (position along the stripe − origin).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ScaleCalibration {
    /// Scale \[mm/px\].
    pub mm_per_px: MmPerPx,
    /// Coordinate along the stripe where x = 0 \[px\].
    pub origin_px: f64,
}

impl ScaleCalibration {
    /// The position in millimetres of a coordinate along the stripe \[px\].
    #[must_use]
    pub fn mm_from_px(&self, along_px: f64) -> f64 {
        self.mm_per_px.get() * (along_px - self.origin_px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn millimetres_count_from_the_origin() {
        let scale = ScaleCalibration { mm_per_px: MmPerPx::DU_2022, origin_px: 100.0 };
        approx::assert_relative_eq!(scale.mm_from_px(110.0), 0.73, epsilon = 1e-12);
        assert_eq!("centre".parse(), Ok(Origin::Centre));
        assert!("nan".parse::<Origin>().is_err());
    }
}
