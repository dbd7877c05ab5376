//! Scenes without anything random in them, and what a column of their pictures shows.

use seamtrack::frame::GrayFrame;
use seamtrack::synth::scenario::{Edges, Sensor, Severity, Stripe, Vibration};
use seamtrack::synth::{Scenario, builtin};

/// The scene without anything random in it.
pub fn bare(name: &str) -> Scenario {
    Scenario {
        variation: 0.0,
        severity: Severity::Clean,
        edges: Edges { raggedness_px: 0.0, ..Edges::default() },
        vibration: Vibration { along_px: 0.0, across_px: 0.0, ..Vibration::default() },
        stripe: Stripe { speckle: 0.0, reflectance: 0.0, wings: 0.0, tilt: 0.0, ..Stripe::default() },
        sensor: Sensor {
            texture_grey: 0.0,
            read_noise_grey: 0.0,
            shot_noise_grey: 0.0,
            column_noise_grey: 0.0,
            exposure: 0.0,
            ..Sensor::default()
        },
        ..builtin::scenario(name).unwrap()
    }
}

/// Light over the background in a column.
pub fn light(frame: &GrayFrame, u: usize) -> f64 {
    (0..frame.height_px()).map(|v| f64::from(frame.row(v)[u].saturating_sub(9))).sum()
}

/// Centroid row of a column.
pub fn ridge(frame: &GrayFrame, u: usize) -> f64 {
    let light_at = |v: usize| f64::from(frame.row(v)[u].saturating_sub(9));
    (0..frame.height_px()).map(|v| v as f64 * light_at(v)).sum::<f64>() / light(frame, u)
}
