//! What disturbs the stripe: arc, spatter, smoke, covers, a false stripe; and the levels of severity.

use serde::{Deserialize, Serialize};

/// How bad the light is after arc-on: fills the sections `arc`, `spatter`, `smoke` and `covers` a scenario leaves out.
/// The levels are those of the method's scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// No arc.
    #[default]
    Clean,
    /// Scenes A and B, as in the experiment of Du 2022.
    Mild,
    /// Scenes D to H and K.
    Medium,
    /// Scene C.
    Severe,
    /// Scenes I and J.
    Heavy,
}

/// Where the arc is, seen from the image (in the image's own directions, not the stripe's).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Drawn for each seed.
    #[default]
    Any,
    /// Above the image.
    Top,
    /// Below the image.
    Bottom,
    /// Left of the image.
    Left,
    /// Right of the image.
    Right,
}

/// Arc glare.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Arc {
    /// Mean glare at the border nearest to the arc \[grey\], 0 to 2000. Default 0.
    pub glare_grey: f64,
    /// Distance from the arc at which glare has fallen to half, as a fraction of the image's shorter side, 0.05 to 10.
    /// Default 0.8, chosen: about two thirds of the glare reach the stripe.
    pub reach: f64,
    /// Standard deviation of the flicker relative to the glare, 0 to 2. Default 0.3, chosen.
    pub flicker: f64,
    /// Correlation of the flicker from frame to frame, 0 to below 1. Default 0.6: all scenes.
    pub flicker_correlation: f64,
    /// Where the arc is. Default: drawn for each seed.
    pub side: Side,
}

impl Default for Arc {
    fn default() -> Self {
        Self { glare_grey: 0.0, reach: 0.8, flicker: 0.3, flicker_correlation: 0.6, side: Side::Any }
    }
}

/// Hot particles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Spatter {
    /// Mean number of tracks in a frame, 0 to 500. Default 0.
    pub tracks: f64,
    /// Share of the frames after arc-on that belong to a burst, 0 to 0.95. A burst lasts about three frames and brings
    /// three times the tracks (at least 8), a drop that lands near the stripe, and a flash. Default 0.
    pub burst_share: f64,
    /// Mean length of a track \[px\], 1 to 1000: motion blur. Default 28, chosen.
    pub length_px: f64,
    /// Fraction of the tracks that are slow, defocused blobs, 0 to 1. Default 0.2: real frames show both.
    pub blobs: f64,
    /// Thickness of the tracks and size of the blobs relative to those of a 640 × 480 image, 0.1 to 20. Default 1.
    pub thickness: f64,
}

impl Default for Spatter {
    fn default() -> Self {
        Self { tracks: 0.0, burst_share: 0.0, length_px: 28.0, blobs: 0.2, thickness: 1.0 }
    }
}

/// Smoke: it dims what lies behind and scatters the arc's light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Smoke {
    /// Share of the frames after arc-on with smoke in them, 0 to 0.95; a puff lasts about three frames. Default 0.
    pub share: f64,
    /// Mean opacity of a puff, 0 to 0.95; single wisps take up to about twice of it. Default 0.3, chosen; 0.38 and
    /// 0.45 when severe and heavy.
    pub opacity: f64,
    /// Size of the wisps \[px\], 2 to 2000. Default 70, chosen.
    pub wisp_px: f64,
    /// Brightness of fully opaque smoke at mean glare \[grey\], 0 to 255. Default 55, chosen.
    pub haze_grey: f64,
}

impl Default for Smoke {
    fn default() -> Self {
        Self { share: 0.0, opacity: 0.3, wisp_px: 70.0, haze_grey: 55.0 }
    }
}

/// Times at which nothing of the seam is seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Covers {
    /// Mean number of covers that begin in 100 frames, 0 to 50. Default 0.
    pub per_100_frames: f64,
    /// Shortest and longest cover \[frames\], 1 to 1000. Default 3 to 15: scene H of the method's description.
    pub frames: [usize; 2],
    /// Half the covered length along the stripe \[px\], 5 to 5000; the cover is centred near the seam. Default 110,
    /// chosen: more than a tracker's window.
    pub half_width_px: f64,
}

impl Default for Covers {
    fn default() -> Self {
        Self { per_100_frames: 0.0, frames: [3, 15], half_width_px: 110.0 }
    }
}

/// A second, false stripe from a reflection between the plates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FalseStripe {
    /// Distance across the stripe \[px\], −1000 to 1000, negative above.
    pub offset_px: f64,
    /// How far its break lies from the true one along the stripe \[px\], −1000 to 1000.
    pub shift_px: f64,
    /// Brightness relative to the true stripe, 0 to 1.
    pub strength: f64,
}

/// The disturbances with every section filled.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbances {
    /// Arc glare.
    pub arc: Arc,
    /// Hot particles.
    pub spatter: Spatter,
    /// Smoke.
    pub smoke: Smoke,
    /// Covers.
    pub covers: Covers,
}

impl Severity {
    /// The disturbances of a level: glare, tracks, bursts and smoke from the table of scenes in the method's
    /// description (section 5), the middle of a range where one is given.
    #[must_use]
    pub fn disturbances(self) -> Disturbances {
        let (glare_grey, tracks, burst_share, share, opacity, covers) = match self {
            Self::Clean => (0.0, 0.0, 0.0, 0.0, 0.3, 0.0),
            Self::Mild => (45.0, 3.25, 0.05, 0.22, 0.3, 0.0),
            Self::Medium => (75.0, 14.0, 0.075, 0.275, 0.3, 0.0),
            Self::Severe => (90.0, 18.0, 0.10, 0.34, 0.38, 0.0),
            Self::Heavy => (135.0, 38.0, 0.18, 0.50, 0.45, 3.0),
        };
        Disturbances {
            arc: Arc { glare_grey, ..Arc::default() },
            spatter: Spatter { tracks, burst_share, ..Spatter::default() },
            smoke: Smoke { share, opacity, ..Smoke::default() },
            covers: Covers { per_100_frames: covers, frames: [2, 5], ..Covers::default() },
        }
    }
}

impl Disturbances {
    /// What is wrong with the disturbances, if anything.
    pub(super) fn problem(&self) -> Option<&'static str> {
        let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
        let Self { arc, spatter, smoke, covers } = self;
        if !(within(arc.glare_grey, 0.0, 2000.0)
            && within(arc.reach, 0.05, 10.0)
            && within(arc.flicker, 0.0, 2.0)
            && within(arc.flicker_correlation, 0.0, 0.999))
        {
            return Some(
                "arc: glare_grey lies in 0..2000, reach in 0.05..10, flicker in 0..2, flicker_correlation in 0..0.999",
            );
        }
        if !(within(spatter.tracks, 0.0, 500.0)
            && within(spatter.burst_share, 0.0, 0.95)
            && within(spatter.length_px, 1.0, 1000.0)
            && within(spatter.blobs, 0.0, 1.0)
            && within(spatter.thickness, 0.1, 20.0))
        {
            return Some(
                "spatter: tracks lie in 0..500, burst_share in 0..0.95, blobs in 0..1, length_px in 1..1000, thickness in 0.1..20",
            );
        }
        if !(within(smoke.share, 0.0, 0.95)
            && within(smoke.opacity, 0.0, 0.95)
            && within(smoke.wisp_px, 2.0, 2000.0)
            && within(smoke.haze_grey, 0.0, 255.0))
        {
            return Some("smoke: share and opacity lie in 0..0.95, wisp_px in 2..2000, haze_grey in 0..255");
        }
        if !(within(covers.per_100_frames, 0.0, 50.0)
            && 1 <= covers.frames[0]
            && covers.frames[0] <= covers.frames[1]
            && covers.frames[1] <= 1000
            && within(covers.half_width_px, 5.0, 5000.0))
        {
            return Some(
                "covers: per_100_frames lie in 0..50, frames are [shortest, longest] in 1..1000, half_width_px in 5..5000",
            );
        }
        None
    }
}
