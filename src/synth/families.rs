//! Families of plates that fight back: each with the joints it is drawn on and three levels.
//!
//! A family's file (`fixtures/scenarios/plates`) says what is laid over the plain scene of a joint: the table `all`, then
//! that of the joint, then that of the level. Tables are merged key by key, lists of tables entry by entry.

use serde::Deserialize;
use toml::{Table, Value};

use super::builtin;
use super::scenario::{Scenario, ScenarioError};

macro_rules! families {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../fixtures/scenarios/plates/", $name, ".toml")))),*]
    };
}

/// All families, in the order of the tables.
const FAMILIES: [(&str, &str); 45] = families![
    "plain",
    "marks-dark",
    "marks-bright",
    "slag",
    "hole",
    "bar-dark",
    "bar-bright",
    "scratch",
    "spatter-stuck",
    "grinding",
    "mill-scale",
    "dark-plate",
    "pipe",
    "dished",
    "pipe-on-plate",
    "bead-root",
    "bead-fill",
    "bead-side",
    "bead-cap",
    "bevel",
    "tack",
    "change-gap",
    "change-bevel",
    "change-width",
    "reflection",
    "mirror",
    "mirror-parallel",
    "other-stripe",
    "two-seams",
    "plate-end",
    "standing-edge",
    "vibration",
    "exposure",
    "dirt",
    "dead-columns",
    "dead-block",
    "line-gap",
    "cable",
    "shadow",
    "drift",
    "standstill",
    "corrugated",
    "bend",
    "joggle",
    "texture",
];

/// The levels, and the light of the arc that goes with them where the family does not say otherwise.
const LEVELS: [&str; 3] = ["mild", "medium", "severe"];
/// Length of a recording \[frames\].
const FRAMES: i64 = 150;
/// The plain scene of a joint.
const ORIGINS: [(&str, &str); 5] =
    [("butt", "A-butt"), ("lap", "B-lap"), ("vgroove", "D-vgroove-sine"), ("fillet", "E-fillet"), ("flat", "flat")];

/// One family's scene on one joint in one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlateScene {
    /// Name of the family.
    pub family: &'static str,
    /// `butt`, `lap`, `vgroove`, `fillet`, or `flat` where there is no seam.
    pub joint: &'static str,
    /// `mild`, `medium` or `severe`.
    pub level: &'static str,
}

/// What a family's file says.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Family {
    /// Its name.
    #[serde(skip)]
    pub name: &'static str,
    /// One line that says what is laid over the plain scenes.
    pub description: String,
    /// The joints it is drawn on.
    pub joints: Vec<String>,
    #[serde(flatten)]
    overlays: Table,
}

impl Family {
    fn read(name: &'static str, text: &str) -> Result<Self, ScenarioError> {
        toml::from_str(text)
            .map(|family| Self { name, ..family })
            .map_err(|error| ScenarioError::Parse { file: name.to_owned(), message: error.to_string() })
    }
}

impl PlateScene {
    /// Its name: `marks-dark-butt-severe`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}-{}-{}", self.family, self.joint, self.level)
    }

    /// Its scenario.
    ///
    /// # Errors
    /// When a file of the program is damaged.
    pub fn scenario(&self) -> Result<Scenario, ScenarioError> {
        let unknown = || ScenarioError::Unknown(self.name());
        let (name, text) = FAMILIES.iter().find(|(name, _)| *name == self.family).ok_or_else(unknown)?;
        let family = Family::read(name, text)?;
        let origin = ORIGINS.iter().find(|(joint, _)| *joint == self.joint).ok_or_else(unknown)?.1;
        let damaged = |message: String| ScenarioError::Parse { file: self.name(), message };
        let plain = builtin::scenario(origin)?;
        let mut table = Table::try_from(&plain).map_err(|error| damaged(error.to_string()))?;
        table.insert("frames".to_owned(), Value::Integer(FRAMES));
        table.insert("severity".to_owned(), Value::String(self.level.to_owned()));
        let description = format!("{}, {}: {}", family.description, self.level, self.joint);
        table.insert("description".to_owned(), Value::String(description));
        for layer in ["all", self.joint, self.level] {
            if let Some(Value::Table(overlay)) = family.overlays.get(layer) {
                lay_over(&mut table, overlay);
            }
        }
        let scenario: Scenario = table.try_into().map_err(|error: toml::de::Error| damaged(error.to_string()))?;
        scenario.check()?;
        Ok(scenario)
    }
}

/// All families, in the order of the tables.
///
/// # Errors
/// When a file of the program is damaged.
pub fn families() -> Result<Vec<Family>, ScenarioError> {
    FAMILIES.iter().map(|(name, text)| Family::read(name, text)).collect()
}

/// All scenes, family by family.
///
/// # Errors
/// When a file of the program is damaged.
pub fn plate_scenes() -> Result<Vec<PlateScene>, ScenarioError> {
    let mut scenes = Vec::new();
    for family in families()? {
        for (joint, _) in ORIGINS.iter().filter(|(joint, _)| family.joints.iter().any(|named| named == joint)) {
            scenes.extend(LEVELS.map(|level| PlateScene { family: family.name, joint, level }));
        }
    }
    Ok(scenes)
}

/// The scene called `name`, whatever the case of its letters.
///
/// # Errors
/// When the family's file is damaged.
pub(super) fn plate_scene(name: &str) -> Result<Option<PlateScene>, ScenarioError> {
    for (family, text) in FAMILIES {
        let scenes = ORIGINS.iter().flat_map(|(joint, _)| LEVELS.map(|level| PlateScene { family, joint, level }));
        if let Some(scene) = scenes.into_iter().find(|scene| scene.name().eq_ignore_ascii_case(name)) {
            let family = Family::read(family, text)?;
            return Ok(family.joints.iter().any(|named| named == scene.joint).then_some(scene));
        }
    }
    Ok(None)
}

/// Lays one table over another.
fn lay_over(table: &mut Table, overlay: &Table) {
    for (key, value) in overlay {
        match (table.get_mut(key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => lay_over(below, above),
            (Some(Value::Array(below)), Value::Array(above)) => {
                for (i, entry) in above.iter().enumerate() {
                    match (below.get_mut(i), entry) {
                        (Some(Value::Table(below)), Value::Table(above)) => lay_over(below, above),
                        (Some(below), above) => *below = above.clone(),
                        (None, above) => below.push(above.clone()),
                    }
                }
            }
            _ => {
                table.insert(key.clone(), value.clone());
            }
        }
    }
}
