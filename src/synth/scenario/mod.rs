//! One text file is the single source of truth for rendering, truth and scoring.

mod camera;
mod joint;
mod light;
mod path;
mod plates;
mod rivals;
mod view;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use camera::{Image, Recorder, Sensor, Stripe, Vibration};
pub use joint::{Butt, Change, Edges, Extent, Fillet, Hairline, Joint, Lap, Tack, Vgroove};
pub use light::{Arc, Covers, Disturbances, FalseStripe, Severity, Side, Smoke, Spatter};
pub use path::{PathTerm, Ramp};
pub use plates::{Bead, Finish, MarkForm, Marks, Plates, Shape};
pub use rivals::{OtherStripe, PlateEnd, Reflection, Rivals, SeamSide, SecondSeam};
pub use view::{Cable, DeadPixels, Dirt, LineGap, Shadow, View};

use super::projection::lengths_in_px;
use crate::calib::file::{CameraSection, LaserSection};
use crate::units::MmPerPx;

/// A recording to be made up: joint, path, light, camera. Only `description`, `joint` and `path` have no default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// One line that says what the scene is.
    pub description: String,
    /// Seed of everything random, below 2⁶³. Default 1.
    #[serde(default = "one")]
    pub seed: u64,
    /// Length of the recording \[frames\], 1 to 1 000 000. Default 250: the experiment of Du 2022.
    #[serde(default = "two_hundred_and_fifty")]
    pub frames: usize,
    /// Time between two frames \[s\], above 0. Default 0.2: Du 2022.
    #[serde(default = "fifth_of_a_second")]
    pub period_s: f64,
    /// Scale, for the millimetres of truth.csv. Default 0.073: Du 2022.
    #[serde(default = "du_2022")]
    pub mm_per_px: MmPerPx,
    /// By how much the numbers of the scene are drawn afresh for each seed, 0 to 0.5; 0 leaves every number as written.
    /// Default 0.15: the method's ±10–20 %. Counts, frame numbers and straight drifts are never varied.
    #[serde(default = "fifteen_percent")]
    pub variation: f64,
    /// Level of the disturbances not given below. Default clean.
    #[serde(default)]
    pub severity: Severity,
    /// First frame with arc, spatter, smoke and covers. Default 15: all scenes.
    #[serde(default = "fifteen")]
    pub arc_on_frame: usize,
    /// Path of the joint along the stripe: the sum of its terms, centred in the image.
    pub path: Vec<PathTerm>,
    /// Path of the plates across the stripe: the sum of its terms. Default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub height: Vec<PathTerm>,
    /// What lies under the stripe.
    pub joint: Joint,
    /// Raggedness of its edges.
    #[serde(default)]
    pub edges: Edges,
    /// Where along the travel it exists.
    #[serde(default)]
    pub extent: Extent,
    /// Image size and direction of the stripe.
    #[serde(default)]
    pub image: Image,
    /// The laser stripe.
    #[serde(default)]
    pub stripe: Stripe,
    /// Sensor and ambient light.
    #[serde(default)]
    pub sensor: Sensor,
    /// Real motion.
    #[serde(default)]
    pub vibration: Vibration,
    /// Repeated and missing frames.
    #[serde(default)]
    pub recorder: Recorder,
    /// Arc glare; default: that of the severity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arc: Option<Arc>,
    /// Hot particles; default: those of the severity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spatter: Option<Spatter>,
    /// Smoke; default: that of the severity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smoke: Option<Smoke>,
    /// Covers; default: those of the severity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covers: Option<Covers>,
    /// A false second stripe. Default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub false_stripe: Option<FalseStripe>,
    /// Tack welds. Default none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tacks: Vec<Tack>,
    /// The joint's preparation changes on the way. Default: it does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub change: Option<Change>,
    /// Shape and finish of the plates, and what lies on them.
    #[serde(default, skip_serializing_if = "is_default")]
    pub plates: Plates,
    /// What looks like the stripe or the seam and is not.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rivals: Rivals,
    /// What lies between the plates and the picture.
    #[serde(default, skip_serializing_if = "is_default")]
    pub view: View,
    /// The camera that sees the section, as in a calibration file. With it and [`Self::laser`] the section lies in the plane of
    /// the laser: joint, path, height, edges and plates are drawn in steps of `mm_per_px` and go through plane and lens into the
    /// picture. Default: the picture is the section.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSection>,
    /// The laser's plane in the camera's frame, as in a calibration file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub laser: Option<LaserSection>,
}

fn is_default<T: Default + PartialEq>(section: &T) -> bool {
    *section == T::default()
}

const fn one() -> u64 {
    1
}
const fn two_hundred_and_fifty() -> usize {
    250
}
const fn fifth_of_a_second() -> f64 {
    0.2
}
const fn du_2022() -> MmPerPx {
    MmPerPx::DU_2022
}
const fn fifteen_percent() -> f64 {
    0.15
}
const fn fifteen() -> usize {
    15
}

/// A scenario that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("cannot read the scenario {file}")]
    Read {
        /// The file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// The file is not a scenario.
    #[error("{file} is not a scenario: {message}")]
    Parse {
        /// The file, or the built-in scene's name.
        file: String,
        /// The parser's explanation, with the line.
        message: String,
    },
    /// A number lies outside its range.
    #[error("the scenario \"{description}\" cannot be rendered: {problem}")]
    Invalid {
        /// The scenario's own description.
        description: String,
        /// Which numbers, and their range.
        problem: String,
    },
    /// There is no built-in scene of this name.
    #[error(
        "there is no built-in scene called \"{0}\" and no such file; `seamtrack synth --list` shows the built-in ones"
    )]
    Unknown(String),
}

impl Scenario {
    /// The scenario in a TOML text; `file` names it in errors. Lengths of joint, path, height, edges and plates may be given in
    /// millimetres: `gap_mm` for `gap_px`.
    ///
    /// # Errors
    /// When the text is not a scenario or a number lies outside its range.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, ScenarioError> {
        let parse = |message: String| ScenarioError::Parse { file: file.to_owned(), message };
        let scenario: Self = if text.contains("_mm") || text.contains("mm_per_frame") {
            let mut table: toml::Table =
                text.parse().map_err(|e: toml::de::Error| parse(e.to_string().trim_end().to_owned()))?;
            lengths_in_px(&mut table).map_err(parse)?;
            table.try_into().map_err(|e: toml::de::Error| parse(e.to_string().trim_end().to_owned()))?
        } else {
            toml::from_str(text).map_err(|e| parse(e.to_string().trim_end().to_owned()))?
        };
        scenario.check()?;
        Ok(scenario)
    }

    /// The scenario in a TOML file.
    ///
    /// # Errors
    /// As [`Self::from_toml`], and when the file cannot be read.
    pub fn load(file: &Path) -> Result<Self, ScenarioError> {
        let name = file.display().to_string();
        let text =
            std::fs::read_to_string(file).map_err(|source| ScenarioError::Read { file: name.clone(), source })?;
        Self::from_toml(&text, &name)
    }

    /// The scenario as TOML.
    ///
    /// # Errors
    /// When the seed is 2⁶³ or more, which TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }

    /// The disturbances: the sections given, and the severity's for the others.
    #[must_use]
    pub fn disturbances(&self) -> Disturbances {
        let level = self.severity.disturbances();
        Disturbances {
            arc: self.arc.clone().unwrap_or(level.arc),
            spatter: self.spatter.clone().unwrap_or(level.spatter),
            smoke: self.smoke.clone().unwrap_or(level.smoke),
            covers: self.covers.clone().unwrap_or(level.covers),
        }
    }

    /// The accuracy one frame can have: a single edge's raggedness over √2 \[px\]. 0 where no edge enters the truth.
    #[must_use]
    pub fn noise_floor_px(&self) -> f64 {
        match self.joint {
            Joint::Butt(_) | Joint::Lap(_) | Joint::Vgroove(_) => self.edges.raggedness_px / std::f64::consts::SQRT_2,
            Joint::Fillet(_) | Joint::Hairline(_) | Joint::Flat => 0.0,
        }
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
        if !(1..=1_000_000).contains(&self.frames) {
            return Some("frames lie in 1..1000000");
        }
        if !(self.period_s.is_finite() && self.period_s > 0.0) {
            return Some("period_s is above 0");
        }
        if !(0.0..=0.5).contains(&self.variation) {
            return Some("variation lies in 0..0.5");
        }
        if self.recorder.jitter_s > self.period_s / 3.0 {
            return Some("recorder: jitter_s is at most a third of period_s");
        }
        if !((0.0..=20.0).contains(&self.edges.raggedness_px) && (0.0..=0.999).contains(&self.edges.correlation)) {
            return Some("edges: raggedness_px lies in 0..20, correlation in 0..0.999");
        }
        if let Some(stripe) = &self.false_stripe
            && !(stripe.offset_px.abs() <= 1000.0
                && stripe.shift_px.abs() <= 1000.0
                && (0.0..=1.0).contains(&stripe.strength))
        {
            return Some("false_stripe: offset_px and shift_px lie in ±1000, strength in 0..1");
        }
        if self.tacks.iter().any(|tack| {
            !(tack.from_frame < tack.to_frame
                && tack.height_px.abs() <= 100.0
                && (1.0..=500.0).contains(&tack.half_width_px))
        }) {
            return Some("tacks: from_frame is below to_frame, height_px lies in ±100, half_width_px in 1..500");
        }
        if !self.plates.beads.is_empty() && !matches!(self.joint, Joint::Vgroove(_)) {
            return Some("plates.beads need a V-groove");
        }
        if self.camera.is_some() && matches!(self.joint, Joint::Hairline(_)) {
            return Some("a hairline is drawn in the picture: it has no [camera] and [laser]");
        }
        if self.rivals.second_seam.is_some() && matches!(self.joint, Joint::Fillet(_) | Joint::Flat) {
            return Some("rivals.second_seam needs a butt, lap, V-groove or hairline joint");
        }
        self.image
            .problem()
            .or_else(|| self.path.iter().chain(&self.height).find_map(PathTerm::problem))
            .or_else(|| self.joint.problem())
            .or_else(|| self.change.as_ref().and_then(|change| change.problem(&self.joint)))
            .or_else(|| self.plates.problem())
            .or_else(|| self.rivals.problem())
            .or_else(|| self.view.problem())
            .or_else(|| camera::problem(&self.stripe, &self.sensor, &self.vibration, &self.recorder))
            .or_else(|| self.disturbances().problem())
    }
}
