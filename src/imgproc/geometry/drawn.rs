//! Small drawn frames for the tests of the geometry: 200 x 160 px, a stripe of SD 2 px, dark round it.

use super::{JointFit, JointKind, Refusal, learn};
use crate::frame::GrayFrame;
use crate::units::PixelPoint;

/// SD of the stripe's cross-section \[px\].
pub const STRIPE_SD_PX: f64 = 2.0;

/// A frame with the stripe in row `row(u)` of column u; none where it has no value.
pub fn drawn(row: impl Fn(f64) -> Option<f64>) -> GrayFrame {
    let (width_px, height_px) = (200, 160);
    let mut frame = GrayFrame::filled(width_px, height_px, 12).unwrap();
    for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
        let (u, v) = ((i % width_px) as f64, (i / width_px) as f64);
        let light = row(u).map_or(0.0, |row| 180.0 * (-0.5 * ((v - row) / STRIPE_SD_PX).powi(2)).exp());
        // A little noise, the same in every run.
        *pixel = (12.0 + light + 1.5 * (7.3 * u + 3.1 * v).sin()).round() as u8;
    }
    frame
}

/// The joint of `kind` learned round column 100 of a frame, fitted where it is sought.
pub fn fitted(frame: &GrayFrame, kind: JointKind, sought_at_px: f64) -> Result<JointFit, Refusal> {
    let learned = learn(frame, PixelPoint::new(100.0, 80.0), kind).ok_or(Refusal::NoLine)?;
    learned.model.fit(frame, sought_at_px, 0.0, 12.0)
}
