//! What looks like the stripe or like the seam and is not: reflections, other stripes, a second seam.

use serde::{Deserialize, Serialize};

/// Rivals of the stripe and of the seam. Default none.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rivals {
    /// Second and third reflections of shiny plates.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reflections: Vec<Reflection>,
    /// Stripes on other surfaces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stripes: Vec<OtherStripe>,
    /// A second joint of the same kind, parallel to the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_seam: Option<SecondSeam>,
    /// Where the plates end.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plate_ends: Vec<PlateEnd>,
}

/// A side of the seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SeamSide {
    /// Smaller coordinates along the stripe.
    #[default]
    Left,
    /// Greater ones.
    Right,
}

/// Light that one plate throws onto the other: a straight, patchy line that begins near the seam and follows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Reflection {
    /// The side on which it is seen.
    pub side: SeamSide,
    /// Where it begins, from the seam outwards \[px\], −500 to 500. Default 0.
    pub from_px: f64,
    /// How far below the seam it begins \[px\], −500 to 500. Default 6, chosen.
    pub below_px: f64,
    /// How steeply it falls from there outwards \[px/px\], −3 to 3. Default 0.1, chosen.
    pub slope: f64,
    /// Its length along the stripe \[px\], 2 to 2000. Default 70, chosen.
    pub length_px: f64,
    /// Brightness relative to the stripe, 0 to 3. Default 0.5, chosen.
    pub strength: f64,
    /// Width relative to the stripe's, 0.3 to 6. Default 1.3: a rolled surface spreads.
    pub width: f64,
    /// How much it comes and goes along its length and the travel (standard deviation of the logarithm of the
    /// brightness), 0 to 2. Default 0.4: rolled aluminium.
    pub patchiness: f64,
}

impl Default for Reflection {
    fn default() -> Self {
        Self {
            side: SeamSide::Left,
            from_px: 0.0,
            below_px: 6.0,
            slope: 0.1,
            length_px: 70.0,
            strength: 0.5,
            width: 1.3,
            patchiness: 0.4,
        }
    }
}

/// A stripe on another surface: a clamp, a table, a reflection of the whole line. It does not move with the plates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OtherStripe {
    /// How far below the plates' stripe it runs in the middle of the image \[px\], −2000 to 2000. Default 90, chosen.
    pub below_px: f64,
    /// Its tilt \[px/px\], −1 to 1. Default −0.05, chosen.
    pub tilt: f64,
    /// Where it begins and ends, as fractions of the image along the stripe, 0 to 1. Default all along.
    pub extent: [f64; 2],
    /// Brightness relative to the stripe, 0 to 10. Default 1.
    pub brightness: f64,
    /// Width relative to the stripe's, 0.3 to 6. Default 1.
    pub width: f64,
}

impl Default for OtherStripe {
    fn default() -> Self {
        Self { below_px: 90.0, tilt: -0.05, extent: [0.0, 1.0], brightness: 1.0, width: 1.0 }
    }
}

/// A second joint. The truth is the first one's; the second's coordinate along the stripe is written beside it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SecondSeam {
    /// Its place from the first \[px\], 20 to 2000 in size, right positive.
    pub beside_px: f64,
}

/// Where a plate of the joint ends: beyond it the laser meets a table, a clamp, or the top of a plate that stands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlateEnd {
    /// Its place from the seam, with which it moves \[px\], 20 to 2000 in size, right positive. Default 180, chosen.
    pub beside_px: f64,
    /// How far below the plate's end the light goes on \[px\], −500 to 500. Default 40, chosen.
    pub below_px: f64,
    /// How steeply it goes down outwards from there \[px/px\], −3 to 3. Default 0: as level as the plates.
    pub slope: f64,
    /// Brightness relative to the stripe, 0 to 10. Default 0.6, chosen.
    pub brightness: f64,
}

impl Default for PlateEnd {
    fn default() -> Self {
        Self { beside_px: 180.0, below_px: 40.0, slope: 0.0, brightness: 0.6 }
    }
}

impl Rivals {
    /// What is wrong with the rivals, if anything.
    pub(super) fn problem(&self) -> Option<&'static str> {
        let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
        if !self.reflections.iter().all(|r| {
            within(r.from_px, -500.0, 500.0)
                && within(r.below_px, -500.0, 500.0)
                && within(r.slope, -3.0, 3.0)
                && within(r.length_px, 2.0, 2000.0)
                && within(r.strength, 0.0, 3.0)
                && within(r.width, 0.3, 6.0)
                && within(r.patchiness, 0.0, 2.0)
        }) {
            return Some(
                "rivals.reflections: from_px and below_px lie in ±500, slope in ±3, length_px in 2..2000, strength in 0..3, width in 0.3..6, patchiness in 0..2",
            );
        }
        if !self.stripes.iter().all(|s| {
            within(s.below_px, -2000.0, 2000.0)
                && within(s.tilt, -1.0, 1.0)
                && within(s.extent[0], 0.0, s.extent[1])
                && within(s.extent[1], 0.0, 1.0)
                && within(s.brightness, 0.0, 10.0)
                && within(s.width, 0.3, 6.0)
        }) {
            return Some(
                "rivals.stripes: below_px lies in ±2000, tilt in ±1, extent is [begin, end] in 0..1, brightness lies in 0..10, width in 0.3..6",
            );
        }
        if !self.plate_ends.iter().all(|end| {
            within(end.beside_px.abs(), 20.0, 2000.0)
                && within(end.below_px, -500.0, 500.0)
                && within(end.slope, -3.0, 3.0)
                && within(end.brightness, 0.0, 10.0)
        }) {
            return Some(
                "rivals.plate_ends: beside_px lies in 20..2000 in size, below_px in ±500, slope in ±3, brightness in 0..10",
            );
        }
        self.second_seam
            .is_some_and(|seam| !within(seam.beside_px.abs(), 20.0, 2000.0))
            .then_some("rivals.second_seam: beside_px lies in 20..2000 in size")
    }
}
