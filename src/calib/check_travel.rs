//! A known travel against the one that the calibration makes of a plate's texture.

use nalgebra::Vector2;

use super::check::{CheckError, Checked, Figure, median, stripe_points};
use super::laser_camera::LaserCamera;
use super::scale::{LEAST_POSITIONS, Position, fit_scale};
use super::travel::{Moved, StillLight, Travel};
use crate::frame::GrayFrame;

/// Follows a plate through a recording whose robot's travel is known.
pub struct TravelCheck<'a> {
    sensor: &'a LaserCamera,
    travel: Travel,
    /// Measured and known displacement of each distinct frame \[mm\].
    track: Vec<(f64, f64)>,
    texture_mm: Vector2<f64>,
    heights: Vec<f64>,
    frames: usize,
    lost: usize,
}

impl<'a> TravelCheck<'a> {
    /// A check with this sensor; `still` is the light of the recording that does not move.
    #[must_use]
    pub fn new(sensor: &'a LaserCamera, still: StillLight) -> Self {
        let travel = Travel::new(sensor.stripe_axis(), still);
        Self { sensor, travel, track: vec![], texture_mm: Vector2::zeros(), heights: vec![], frames: 0, lost: 0 }
    }

    /// Takes the next frame, at which the robot had travelled `known_mm` from the first.
    pub fn step(&mut self, frame: &GrayFrame, known_mm: f64) {
        let moved = self.travel.step(frame);
        if moved == Moved::Repeated {
            return;
        }
        let Some(seen) = stripe_points(self.sensor, frame) else { return };
        let mut heights: Vec<f64> = seen.points.iter().map(|p| p.y).collect();
        let height_mm = median(&mut heights);
        self.frames += 1;
        match moved {
            Moved::By(by) => {
                // At the stripe the plate's distance is known: a pixel is z/f there.
                let middle = seen.pixels[seen.pixels.len() / 2];
                let Some(point) = self.sensor.camera_point_mm(middle) else { return };
                let camera = self.sensor.intrinsics();
                self.texture_mm += Vector2::new(by.x * point.z / camera.fx_px, by.y * point.z / camera.fy_px);
            }
            Moved::Unknown => {
                self.lost += 1;
                return;
            }
            Moved::First | Moved::Repeated => {}
        }
        let first = *self.heights.first().unwrap_or(&height_mm);
        self.heights.push(height_mm);
        let measured = (self.texture_mm.norm_squared() + (height_mm - first).powi(2)).sqrt();
        self.track.push((measured, known_mm));
    }

    /// The travel as measured against the travel as known.
    ///
    /// # Errors
    /// When the plate's texture could not be followed.
    pub fn finish(self, gate_mm: f64) -> Result<Checked, CheckError> {
        if self.lost * 5 > self.frames || self.track.len() < LEAST_POSITIONS {
            return Err(CheckError::Travel(format!(
                "the plate's texture was followed in {} of {} frames only: light it so that it shows, or check with --plate or --step",
                self.frames - self.lost,
                self.frames
            )));
        }
        let positions: Vec<Position> =
            self.track.iter().map(|(measured, known)| Position { px: *measured, mm: *known }).collect();
        let fit = fit_scale(&positions).map_err(|error| CheckError::Travel(error.to_string()))?;
        let travel_mm = positions.iter().map(|p| p.mm).fold(0.0, f64::max);
        let (ratio, half) = (1.0 / fit.mm_per_px, fit.half_95_mm_per_px / fit.mm_per_px.powi(2));
        let error_mm = (ratio - 1.0) * travel_mm;
        let figure = Figure {
            name: "travel",
            value: error_mm,
            // What the recording cannot tell is not held against the calibration.
            limit: gate_mm + half * travel_mm,
            unit: "mm",
            meaning: format!(
                "a travel of {travel_mm:.1} mm comes out as {:.1} mm, {:+.2} ± {:.2} %: the plate lies nearer or farther than the calibration says",
                ratio * travel_mm,
                100.0 * (ratio - 1.0),
                100.0 * half
            ),
        };
        Ok(Checked { used: self.track.len(), figures: vec![figure], notes: vec![] })
    }
}
