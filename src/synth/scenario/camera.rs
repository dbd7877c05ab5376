//! The stripe as the camera sees it, the sensor, and the recorder.

use serde::{Deserialize, Serialize};

use crate::units::StripeAxis;

/// The image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Image {
    /// Columns \[px\], 320 to 2592. Default 640.
    pub width_px: usize,
    /// Rows \[px\], 240 to 2048. Default 480.
    pub height_px: usize,
    /// How the stripe runs. Default horizontal.
    pub stripe: StripeAxis,
}

impl Default for Image {
    fn default() -> Self {
        Self { width_px: 640, height_px: 480, stripe: StripeAxis::Horizontal }
    }
}

/// The laser stripe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Stripe {
    /// Standard width of the Gaussian cross-section \[px\], 0.5 to 20. Default 2.4: all scenes.
    pub sigma_px: f64,
    /// Height of the cross-section \[grey\], 1 to 5000; above 255 the core saturates. Default 200: the scenes' 185–215.
    pub amplitude_grey: f64,
    /// Contrast of the speckle (standard deviation over mean), 0 to 2: of the grains, and seven tenths of it of whole
    /// cross-sections. Default 0.33: the scenes' 0.28–0.38.
    pub speckle: f64,
    /// Variation of the plates' reflectance along the stripe, 0 to 1. Default 0.18: all scenes.
    pub reflectance: f64,
    /// Tilt in the image \[px/px\], −0.5 to 0.5; its sign is drawn when `variation` is not 0. Default 0.03: all scenes.
    pub tilt: f64,
    /// Sag of the stripe from the middle to the ends of the image \[px\], −100 to 100. Default 0.
    pub sag_px: f64,
    /// Share of the light in wide wings (lens, plate), 0 to 0.2. Default 0.02: real frames.
    pub wings: f64,
    /// Length of a stripe that ends inside the image \[px\], at least 50. Default: longer than the image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_px: Option<f64>,
}

impl Default for Stripe {
    fn default() -> Self {
        Self {
            sigma_px: 2.4,
            amplitude_grey: 200.0,
            speckle: 0.33,
            reflectance: 0.18,
            tilt: 0.03,
            sag_px: 0.0,
            wings: 0.02,
            length_px: None,
        }
    }
}

/// The sensor and the light around.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Background \[grey\], 0 to 200. Default 9: all scenes.
    pub background_grey: f64,
    /// Standard deviation of the plates' texture in ambient light \[grey\], 0 to 50. Default 0.6.
    pub texture_grey: f64,
    /// Read noise \[grey\], 0 to 50. Default 1.6, chosen: an industrial CMOS camera at some gain.
    pub read_noise_grey: f64,
    /// Shot noise: variance per grey value \[grey\], 0 to 2. Default 0.08, chosen.
    pub shot_noise_grey: f64,
    /// Fixed pattern: standard deviation of the columns' offsets \[grey\], 0 to 20. Default 0.5: real frames.
    pub column_noise_grey: f64,
    /// Share of the light above saturation that spreads to the neighbours (bloom), 0 to 1. Default 0.12, chosen.
    pub bloom: f64,
    /// Standard deviation of the exposure from frame to frame, 0 to 0.5. Default 0.02, chosen.
    pub exposure: f64,
    /// Exposure time and gain together: all light is multiplied by it before it saturates, 0.05 to 10. Default 1.
    pub gain: f64,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            background_grey: 9.0,
            texture_grey: 0.6,
            read_noise_grey: 1.6,
            shot_noise_grey: 0.08,
            column_noise_grey: 0.5,
            bloom: 0.12,
            exposure: 0.02,
            gain: 1.0,
        }
    }
}

/// Real motion between sensor and joint; it is part of the truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Vibration {
    /// Standard deviation along the stripe \[px\], 0 to 50. Default 0.115: the scenes' 0.08–0.15.
    pub along_px: f64,
    /// Standard deviation across the stripe \[px\], 0 to 50. Default 0.65: the scenes' 0.5–0.8.
    pub across_px: f64,
    /// Correlation from frame to frame, 0 to below 1. Default 0.3, chosen.
    pub correlation: f64,
}

impl Default for Vibration {
    fn default() -> Self {
        Self { along_px: 0.115, across_px: 0.65, correlation: 0.3 }
    }
}

/// What the recorder does to the sequence.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recorder {
    /// Chance that a frame repeats its predecessor byte for byte (the recorder is faster than the camera), 0 to 0.9.
    /// Default 0. The truth is that of the picture.
    pub repeated: f64,
    /// Chance that one to four frames are missing before a frame, 0 to 0.9. Default 0. Time and truth run on.
    pub dropped: f64,
    /// Standard deviation of the time stamps \[s\], 0 to a third of the period. Default 0.
    pub jitter_s: f64,
}

impl Recorder {
    /// Whether the time stamps are irregular, so that a recording needs them written down.
    #[must_use]
    pub fn is_irregular(&self) -> bool {
        self.dropped > 0.0 || self.jitter_s > 0.0
    }
}

impl Image {
    /// What is wrong with the image, if anything.
    pub(super) fn problem(&self) -> Option<&'static str> {
        (!((320..=2592).contains(&self.width_px) && (240..=2048).contains(&self.height_px)))
            .then_some("image: width_px lies in 320..2592, height_px in 240..2048")
    }
}

/// What is wrong with stripe, sensor, vibration or recorder, if anything.
pub(super) fn problem(
    stripe: &Stripe,
    sensor: &Sensor,
    vibration: &Vibration,
    recorder: &Recorder,
) -> Option<&'static str> {
    let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
    if !(within(stripe.sigma_px, 0.5, 20.0)
        && within(stripe.amplitude_grey, 1.0, 5000.0)
        && within(stripe.speckle, 0.0, 2.0)
        && within(stripe.reflectance, 0.0, 1.0)
        && within(stripe.tilt, -0.5, 0.5)
        && within(stripe.sag_px, -100.0, 100.0)
        && within(stripe.wings, 0.0, 0.2)
        && stripe.length_px.is_none_or(|length| within(length, 50.0, 1e5)))
    {
        return Some(
            "stripe: sigma_px lies in 0.5..20, amplitude_grey in 1..5000, speckle in 0..2, reflectance in 0..1, tilt in ±0.5, sag_px in ±100, wings in 0..0.2, length_px from 50",
        );
    }
    if !(within(sensor.background_grey, 0.0, 200.0)
        && within(sensor.texture_grey, 0.0, 50.0)
        && within(sensor.read_noise_grey, 0.0, 50.0)
        && within(sensor.shot_noise_grey, 0.0, 2.0)
        && within(sensor.column_noise_grey, 0.0, 20.0)
        && within(sensor.bloom, 0.0, 1.0)
        && within(sensor.exposure, 0.0, 0.5)
        && within(sensor.gain, 0.05, 10.0))
    {
        return Some(
            "sensor: background_grey lies in 0..200, texture_grey and read_noise_grey in 0..50, shot_noise_grey in 0..2, column_noise_grey in 0..20, bloom in 0..1, exposure in 0..0.5, gain in 0.05..10",
        );
    }
    if !(within(vibration.along_px, 0.0, 50.0)
        && within(vibration.across_px, 0.0, 50.0)
        && within(vibration.correlation, 0.0, 0.999))
    {
        return Some("vibration: along_px and across_px lie in 0..50, correlation in 0..0.999");
    }
    if !(within(recorder.repeated, 0.0, 0.9)
        && within(recorder.dropped, 0.0, 0.9)
        && recorder.jitter_s.is_finite()
        && recorder.jitter_s >= 0.0)
    {
        return Some("recorder: repeated and dropped lie in 0..0.9, jitter_s is not negative");
    }
    None
}
