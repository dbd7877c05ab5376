//! What lies between the plates and the picture, and does not move with the plates.

use serde::{Deserialize, Serialize};

/// Glass, sensor, laser line, and what hangs in between. Default nothing.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct View {
    /// From this camera frame on nothing moves any more: path, height, travel, speckle. The sensor's noise goes on.
    /// Default: never.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standstill_from_frame: Option<usize>,
    /// How much the camera's automatic exposure takes back of the arc's light, 0 to 1: with 1 a glare of
    /// 100 grey halves the exposure, a few frames later. Default 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub exposure_follows_arc: f64,
    /// Dirt on the protective glass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dirt: Option<Dirt>,
    /// Dead parts of the sensor.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dead: Vec<DeadPixels>,
    /// Dark places in the laser's line.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub line_gaps: Vec<LineGap>,
    /// Shadows in the laser's light.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shadows: Vec<Shadow>,
    /// Cables and hoses that hang before the camera.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cables: Vec<Cable>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it with a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Spots on the glass: blurred, fixed to the picture, dimming what is behind and glowing in the arc's light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Dirt {
    /// Number of spots, 0 to 500; the first lies on the stripe, the others anywhere. Default 6, chosen.
    pub spots: usize,
    /// Radius of a spot \[px\], 1 to 500; each spot's own lies between 0.5 and 1.5 of it. Default 14, chosen.
    pub radius_px: f64,
    /// Share of the light that passes its middle, 0 to 1. Default 0.25, chosen.
    pub transmission: f64,
    /// Share of the arc's glare that it scatters into the picture, 0 to 2. Default 0.3, chosen.
    pub glow: f64,
}

impl Default for Dirt {
    fn default() -> Self {
        Self { spots: 6, radius_px: 14.0, transmission: 0.25, glow: 0.3 }
    }
}

/// A dead part of the sensor: a rectangle of one grey value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DeadPixels {
    /// Its middle along the stripe as a fraction of the image, 0 to 1. Default: drawn for each seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub along: Option<f64>,
    /// Extent along the stripe \[px\], 1 to 500. Default 2.
    pub along_px: usize,
    /// Extent across the stripe \[px\], centred on the stripe's mean row, 1 to 4096. Default: the whole image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub across_px: Option<usize>,
    /// Its grey value. Default 0.
    pub grey: u8,
}

impl Default for DeadPixels {
    fn default() -> Self {
        Self { along: None, along_px: 2, across_px: None, grey: 0 }
    }
}

/// A dark place in the laser's line, from dirt on the laser's lens: fixed to the picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LineGap {
    /// Its middle along the stripe as a fraction of the image, 0 to 1. Default: drawn for each seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub along: Option<f64>,
    /// Width at half depth \[px\], 1 to 1000. Default 12, chosen.
    pub width_px: f64,
    /// Share of the light in its middle, 0 to 1. Default 0.05, chosen.
    pub transmission: f64,
    /// How soft its edges are \[px\], 0.3 to 200. Default 1.5, chosen.
    pub edge_px: f64,
}

impl Default for LineGap {
    fn default() -> Self {
        Self { along: None, width_px: 12.0, transmission: 0.05, edge_px: 1.5 }
    }
}

/// A shadow's edge: the laser's light is weaker on its right.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Shadow {
    /// Where it is at first along the stripe, as a fraction of the image, −2 to 3. Default: drawn for each seed, 0.25 to 0.75.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub along: Option<f64>,
    /// How it moves \[px/frame\], −100 to 100. Default 0: that of the torch stays where it is.
    pub px_per_frame: f64,
    /// Share of the light beyond, 0 to 1. Default 0.3, chosen.
    pub transmission: f64,
    /// How soft the edge is \[px\], 0.3 to 1000. Default 3, chosen; 60 and more is drifting reflectance.
    pub edge_px: f64,
}

impl Default for Shadow {
    fn default() -> Self {
        Self { along: None, px_per_frame: 0.0, transmission: 0.3, edge_px: 3.0 }
    }
}

/// A dark thing that crosses the picture and hides all behind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cable {
    /// Width \[px\], 1 to 500. Default 16, chosen.
    pub width_px: f64,
    /// Angle against the direction across the stripe \[degrees\], −80 to 80. Default 15, chosen.
    pub angle_deg: f64,
    /// Where it crosses the stripe's mean row in frame 0, as a fraction of the image, −5 to 6. Default 0.1.
    pub along: f64,
    /// How it moves along the stripe \[px/frame\], −100 to 100. Default 3, chosen.
    pub px_per_frame: f64,
    /// Amplitude of its swinging about that \[px\], 0 to 1000, with a period of 40 frames. Default 0.
    pub swing_px: f64,
    /// Its grey value in ambient light, 0 to 255. Default 5.
    pub grey: f64,
}

impl Default for Cable {
    fn default() -> Self {
        Self { width_px: 16.0, angle_deg: 15.0, along: 0.1, px_per_frame: 3.0, swing_px: 0.0, grey: 5.0 }
    }
}

impl View {
    /// What is wrong with the view, if anything.
    pub(super) fn problem(&self) -> Option<&'static str> {
        let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
        let share = |value: Option<f64>| value.is_none_or(|value| within(value, 0.0, 1.0));
        if !within(self.exposure_follows_arc, 0.0, 1.0) {
            return Some("view: exposure_follows_arc lies in 0..1");
        }
        if self.dirt.as_ref().is_some_and(|d| {
            !(d.spots <= 500
                && within(d.radius_px, 1.0, 500.0)
                && within(d.transmission, 0.0, 1.0)
                && within(d.glow, 0.0, 2.0))
        }) {
            return Some("view.dirt: spots lie in 0..500, radius_px in 1..500, transmission in 0..1, glow in 0..2");
        }
        if !self.dead.iter().all(|d| {
            share(d.along) && (1..=500).contains(&d.along_px) && d.across_px.is_none_or(|px| (1..=4096).contains(&px))
        }) {
            return Some("view.dead: along lies in 0..1, along_px in 1..500, across_px in 1..4096");
        }
        if !self.line_gaps.iter().all(|g| {
            share(g.along)
                && within(g.width_px, 1.0, 1000.0)
                && within(g.transmission, 0.0, 1.0)
                && within(g.edge_px, 0.3, 200.0)
        }) {
            return Some(
                "view.line_gaps: along and transmission lie in 0..1, width_px in 1..1000, edge_px in 0.3..200",
            );
        }
        if !self.shadows.iter().all(|s| {
            s.along.is_none_or(|along| within(along, -2.0, 3.0))
                && within(s.px_per_frame, -100.0, 100.0)
                && within(s.transmission, 0.0, 1.0)
                && within(s.edge_px, 0.3, 1000.0)
        }) {
            return Some(
                "view.shadows: along lies in -2..3, px_per_frame in ±100, transmission in 0..1, edge_px in 0.3..1000",
            );
        }
        (!self.cables.iter().all(|c| {
            within(c.width_px, 1.0, 500.0)
                && within(c.angle_deg, -80.0, 80.0)
                && within(c.along, -5.0, 6.0)
                && within(c.px_per_frame, -100.0, 100.0)
                && within(c.swing_px, 0.0, 1000.0)
                && within(c.grey, 0.0, 255.0)
        }))
        .then_some("view.cables: width_px lies in 1..500, angle_deg in ±80, along in -5..6, px_per_frame in ±100, swing_px in 0..1000, grey in 0..255")
    }
}
