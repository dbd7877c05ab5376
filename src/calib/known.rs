//! A sensor, and where the knowledge of it comes from.

use std::path::Path;
use std::sync::Arc;

use super::file::{CalibrationFile, CalibrationFileError};
use super::laser_camera::{LaserCamera, OtherImageSize};
use super::sensor::Sensor;
use crate::units::{MmPerPx, StripeAxis};

/// A sensor with its source, for those who read the results.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownSensor {
    /// What a pixel is.
    pub sensor: Sensor,
    /// Where that comes from, in a few words.
    pub source: String,
    /// σ of the scale itself, where there is one scale and it is known \[mm/px\].
    pub std_mm_per_px: Option<f64>,
    /// The calibration, if a file holds one.
    pub file: Option<CalibrationFile>,
}

impl KnownSensor {
    /// Nobody said what a pixel is.
    #[must_use]
    pub fn unknown() -> Self {
        Self { sensor: Sensor::Pixels, source: "no scale was given".into(), std_mm_per_px: None, file: None }
    }

    /// One scale, from `source`.
    #[must_use]
    pub fn scale(mm_per_px: MmPerPx, source: &str) -> Self {
        Self { sensor: Sensor::Scale(mm_per_px), source: source.into(), std_mm_per_px: None, file: None }
    }

    /// What a calibration file holds: camera and plane, or one scale.
    ///
    /// # Errors
    /// When the file cannot be read, or holds neither.
    pub fn read(path: &Path) -> Result<Self, CalibrationFileError> {
        let content = |problem: String| CalibrationFileError::Content { path: path.to_owned(), problem };
        Self::of(CalibrationFile::read(path)?, path.display().to_string()).map_err(content)
    }

    /// The sensor of a calibration that came from `source`.
    ///
    /// # Errors
    /// In one line, when it holds neither camera and plane nor one scale.
    pub fn of(file: CalibrationFile, source: String) -> Result<Self, String> {
        if let Some(scale) = &file.scale
            && file.laser.is_none()
        {
            let sensor = Sensor::Scale(MmPerPx::new(scale.mm_per_px).map_err(|error| error.to_string())?);
            let std_mm_per_px = (scale.std_mm_per_px > 0.0).then_some(scale.std_mm_per_px);
            return Ok(Self { sensor, source, std_mm_per_px, file: Some(file) });
        }
        let sensor = Sensor::Plane(Arc::new(file.laser_camera()?));
        Ok(Self { sensor, source, std_mm_per_px: None, file: Some(file) })
    }

    /// The same for pictures of `size_px` that were cut out of the calibrated ones at column and row `at_px`. One scale, and
    /// none, is the same in every part of a picture.
    ///
    /// # Errors
    /// When the cut does not lie within the calibrated picture.
    pub fn cropped(&self, at_px: (usize, usize), size_px: (usize, usize)) -> Result<Self, OtherImageSize> {
        let Sensor::Plane(whole) = &self.sensor else { return Ok(self.clone()) };
        let sensor = Sensor::Plane(Arc::new(whole.cropped(at_px, size_px)?));
        let source = format!("{}, cut out at {}x{}", self.source, at_px.0, at_px.1);
        let file = self.file.clone().map(|file| file.cropped(at_px, size_px));
        Ok(Self { sensor, source, file, ..self.clone() })
    }

    /// Which way the stripe runs through the picture, where the calibration says so.
    #[must_use]
    pub fn stripe_axis(&self) -> Option<StripeAxis> {
        self.sensor.laser_camera().map(LaserCamera::stripe_axis)
    }
}
