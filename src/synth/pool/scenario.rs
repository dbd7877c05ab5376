//! The text file of a melt-pool scene.

use serde::{Deserialize, Serialize};

use crate::synth::ScenarioError;
use crate::synth::scenario::{PathTerm, Spatter};
use crate::units::{MmPerPx, Travel};

/// A melt-pool recording to be made up. Only `description` and `pool` have no default; positions and sizes are given
/// across and along the travel, whichever way that is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoolScenario {
    /// One line that says what the scene is.
    pub description: String,
    /// Seed of everything random, below 2⁶³. Default 1.
    #[serde(default = "one")]
    pub seed: u64,
    /// Length of the recording \[frames\], 1 to 1 000 000. Default 250.
    #[serde(default = "two_hundred_and_fifty")]
    pub frames: usize,
    /// Time between two frames \[s\], above 0. Default 0.001: the infrared paper.
    #[serde(default = "millisecond")]
    pub period_s: f64,
    /// Scale, for the millimetres of truth.csv. Default 1/114: the infrared paper.
    #[serde(default = "infrared")]
    pub mm_per_px: MmPerPx,
    /// Where the seam, and so the tip, runs across the travel \[px\]: the sum of the terms about the pool's middle.
    /// Default: it stays there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<PathTerm>,
    /// How the width changes \[px\]: the sum of the terms is added to the body's. Default: not at all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub width: Vec<PathTerm>,
    /// Size and depth of the frames, and the direction of travel.
    #[serde(default)]
    pub image: PoolImage,
    /// The pool's shape.
    pub pool: Body,
    /// What shines.
    #[serde(default)]
    pub light: Light,
    /// How the light of the whole pool changes.
    #[serde(default)]
    pub emissivity: Emissivity,
    /// Hot particles. Default: none.
    #[serde(default)]
    pub spatter: Spatter,
    /// Frames without a pool, and frames flooded by light. Default: none.
    #[serde(default)]
    pub flaws: Flaws,
}

/// Size and depth of the frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PoolImage {
    /// Columns, 16 to 4096. Default 320: the infrared paper's kind of camera.
    pub width_px: usize,
    /// Rows, 16 to 4096. Default 256.
    pub height_px: usize,
    /// Bits a pixel, 8 or 16. Default 8.
    pub bits: u8,
    /// Where the torch travels to. Default up.
    pub travel: Travel,
    /// Where the pool's middle lies across and along the travel, as parts of the frame, from the left and from the
    /// front. Default the middle.
    pub pool_at: [f64; 2],
}

impl Default for PoolImage {
    fn default() -> Self {
        Self { width_px: 320, height_px: 256, bits: 8, travel: Travel::Up, pool_at: [0.5, 0.5] }
    }
}

/// The pool's shape: an ellipse with a corner at its front.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Body {
    /// Length along the travel, without the corner \[px\], 4 to 4000. Default 110.
    pub length_px: f64,
    /// Width across the travel \[px\], 4 to 4000. Default 90.
    pub width_px: f64,
    /// How far the corner protrudes from the ellipse \[px\], 0 to 500; 0 is a round front. Default 16.
    pub tip_height_px: f64,
    /// Half the corner's base \[px\], 1 to 500. Default 14.
    pub tip_half_base_px: f64,
    /// Standard deviation of the outline's raggedness \[px\], 0 to 20, different in each frame. Default 0.4.
    pub raggedness_px: f64,
    /// Length over which the raggedness changes \[px\], 1 to 500. Default 9.
    pub raggedness_length_px: f64,
    /// Standard deviation of the tip about the seam \[px\], 0 to 50: the melt's own motion, an error to a sensor. Default
    /// 0.
    pub tip_jitter_px: f64,
    /// Standard deviation of the width about its course \[px\], 0 to 50. Default 0.
    pub width_jitter_px: f64,
    /// Correlation of both jitters from frame to frame, 0 to below 1. Default 0: white.
    pub jitter_correlation: f64,
}

impl Default for Body {
    fn default() -> Self {
        Self {
            length_px: 110.0,
            width_px: 90.0,
            tip_height_px: 16.0,
            tip_half_base_px: 14.0,
            raggedness_px: 0.4,
            raggedness_length_px: 9.0,
            tip_jitter_px: 0.0,
            width_jitter_px: 0.0,
            jitter_correlation: 0.0,
        }
    }
}

/// What shines, in grey values of 8 bits; 255 and above is saturated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Light {
    /// Surroundings \[grey\], 0 to 200. Default 12.
    pub background_grey: f64,
    /// How much brighter the surroundings are on the right border than on the left \[grey\], −100 to 100. Default 0.
    pub gradient_grey: f64,
    /// The pool \[grey\], 1 to 2000. Default 150.
    pub pool_grey: f64,
    /// The hot spot in the pool's middle, above the pool \[grey\], 0 to 4000. Default 60.
    pub hot_spot_grey: f64,
    /// The plume over the pool's front \[grey\], 0 to 1000. Default 0.
    pub plume_grey: f64,
    /// The hot track behind the pool \[grey\], 0 to 1000. Default 0.
    pub track_grey: f64,
    /// The seam in front of the pool reflects \[grey\], 0 to 1000. Default 0.
    pub seam_grey: f64,
    /// Standard deviation of the blur \[px\], 0.3 to 10. Default 1.2.
    pub blur_px: f64,
    /// Read noise \[grey\], 0 to 50. Default 2.
    pub read_noise_grey: f64,
    /// Shot noise: variance per grey value \[grey\], 0 to 2. Default 0.05.
    pub shot_noise_grey: f64,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            background_grey: 12.0,
            gradient_grey: 0.0,
            pool_grey: 150.0,
            hot_spot_grey: 60.0,
            plume_grey: 0.0,
            track_grey: 0.0,
            seam_grey: 0.0,
            blur_px: 1.2,
            read_noise_grey: 2.0,
            shot_noise_grey: 0.05,
        }
    }
}

/// How the light of the whole pool changes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Emissivity {
    /// Standard deviation of its flicker, 0 to 0.5. Default 0.02.
    pub flicker: f64,
    /// Correlation of the flicker from frame to frame, 0 to below 1. Default 0.8.
    pub correlation: f64,
    /// Its value after a step, relative to that before, 0.05 to 5. Default 1: no step.
    pub step: f64,
    /// Where the step is, as a part of the recording. Default 0.5.
    pub step_at: f64,
}

impl Default for Emissivity {
    fn default() -> Self {
        Self { flicker: 0.02, correlation: 0.8, step: 1.0, step_at: 0.5 }
    }
}

/// Frames that show nothing to measure: first and last of each stretch.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Flaws {
    /// Without a pool.
    pub absent: Vec<[usize; 2]>,
    /// All white.
    pub flooded: Vec<[usize; 2]>,
}

const fn one() -> u64 {
    1
}
const fn two_hundred_and_fifty() -> usize {
    250
}
const fn millisecond() -> f64 {
    1e-3
}
fn infrared() -> MmPerPx {
    MmPerPx::INFRARED
}

impl PoolScenario {
    /// The scenario in a TOML text; `file` names it in errors.
    ///
    /// # Errors
    /// When the text is not a scenario or a number lies outside its range.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text).map_err(|e| ScenarioError::Parse {
            file: file.to_owned(),
            message: e.to_string().trim_end().to_owned(),
        })?;
        scenario.check()?;
        Ok(scenario)
    }

    /// The scenario as TOML.
    ///
    /// # Errors
    /// When the seed is 2⁶³ or more, which TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// Whether every number lies in its range.
    ///
    /// # Errors
    /// Naming the numbers and the range.
    pub fn check(&self) -> Result<(), ScenarioError> {
        match self.problem() {
            None => Ok(()),
            Some(problem) => {
                Err(ScenarioError::Invalid { description: self.description.clone(), problem: problem.to_owned() })
            }
        }
    }

    fn problem(&self) -> Option<&'static str> {
        let (image, pool, light, emissivity) = (&self.image, &self.pool, &self.light, &self.emissivity);
        let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
        let rules = [
            ((1..=1_000_000).contains(&self.frames), "frames lie in 1..1000000"),
            (self.period_s.is_finite() && self.period_s > 0.0, "period_s is above 0"),
            (
                (16..=4096).contains(&image.width_px) && (16..=4096).contains(&image.height_px),
                "image: width_px and height_px lie in 16..4096",
            ),
            (matches!(image.bits, 8 | 16), "image: bits is 8 or 16"),
            (image.pool_at.iter().all(|&part| within(part, -1.0, 2.0)), "image: pool_at lies in -1..2"),
            (
                within(pool.length_px, 4.0, 4000.0) && within(pool.width_px, 4.0, 4000.0),
                "pool: length_px and width_px lie in 4..4000",
            ),
            (
                within(pool.tip_height_px, 0.0, 500.0) && within(pool.tip_half_base_px, 1.0, 500.0),
                "pool: tip_height_px lies in 0..500, tip_half_base_px in 1..500",
            ),
            (
                within(pool.raggedness_px, 0.0, 20.0) && within(pool.raggedness_length_px, 1.0, 500.0),
                "pool: raggedness_px lies in 0..20, raggedness_length_px in 1..500",
            ),
            (
                within(pool.tip_jitter_px, 0.0, 50.0)
                    && within(pool.width_jitter_px, 0.0, 50.0)
                    && within(pool.jitter_correlation, 0.0, 0.999),
                "pool: the jitters lie in 0..50 px, jitter_correlation in 0..0.999",
            ),
            (
                within(light.background_grey, 0.0, 200.0)
                    && within(light.gradient_grey, -100.0, 100.0)
                    && within(light.pool_grey, 1.0, 2000.0)
                    && within(light.hot_spot_grey, 0.0, 4000.0),
                "light: background_grey lies in 0..200, gradient_grey in ±100, pool_grey in 1..2000, hot_spot_grey in 0..4000",
            ),
            (
                [light.plume_grey, light.track_grey, light.seam_grey].iter().all(|&grey| within(grey, 0.0, 1000.0)),
                "light: plume_grey, track_grey and seam_grey lie in 0..1000",
            ),
            (
                within(light.blur_px, 0.3, 10.0)
                    && within(light.read_noise_grey, 0.0, 50.0)
                    && within(light.shot_noise_grey, 0.0, 2.0),
                "light: blur_px lies in 0.3..10, read_noise_grey in 0..50, shot_noise_grey in 0..2",
            ),
            (
                within(emissivity.flicker, 0.0, 0.5)
                    && within(emissivity.correlation, 0.0, 0.999)
                    && within(emissivity.step, 0.05, 5.0)
                    && within(emissivity.step_at, 0.0, 1.0),
                "emissivity: flicker lies in 0..0.5, correlation in 0..0.999, step in 0.05..5, step_at in 0..1",
            ),
            (
                within(self.spatter.tracks, 0.0, 500.0)
                    && within(self.spatter.length_px, 1.0, 1000.0)
                    && within(self.spatter.blobs, 0.0, 1.0),
                "spatter: tracks lies in 0..500, length_px in 1..1000, blobs in 0..1",
            ),
        ];
        let rule = rules.into_iter().find(|(holds, _)| !holds).map(|(_, rule)| rule);
        rule.or_else(|| self.path.iter().chain(&self.width).find_map(PathTerm::problem))
    }
}
