//! The built-in scenes: the text files of `fixtures/scenarios`, and each joint's family from clean to severe.

use super::families::plate_scene;
use super::pool::PoolScenario;
use super::scenario::{Scenario, ScenarioError, Severity};

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../fixtures/scenarios/", $name, ".toml")))),*]
    };
}

/// Scenes A to K of the method's description, then those that cover what they do not.
const SCENES: [(&str, &str); 25] = built_in![
    "A-butt",
    "B-lap",
    "C-butt-severe",
    "C-lap-severe",
    "D-vgroove-sine",
    "E-fillet",
    "F-lap-false-stripe",
    "G-butt-widening",
    "H-butt-covers",
    "I-butt-heavy",
    "J-lap-heavy",
    "K-butt-narrow",
    "flat",
    "tack",
    "joint-start-end",
    "hi-lo",
    "corner",
    "recorder",
    "hairline",
    "hairline-arc",
    "demo-butt",
    "demo-hairline",
    "large",
    "du-butt",
    "du-lap",
];

/// Scenes of a melt pool: the papers' other two sensors.
const POOL_SCENES: [(&str, &str); 7] =
    built_in!["pool-tip", "pool-tip-plume", "pool-tip-16bit", "pool-width", "pool-flaws", "infrared", "jiang",];

/// Scenes before a calibrated camera and laser plane.
const SENSOR_SCENES: [(&str, &str); 2] = built_in!["sensor-butt", "sensor-vgroove"];

/// A family's name and the scene it is made from.
const FAMILIES: [(&str, &str); 5] = [
    ("butt", "A-butt"),
    ("lap", "B-lap"),
    ("vgroove", "D-vgroove-sine"),
    ("fillet", "E-fillet"),
    ("hairline", "hairline-arc"),
];

const LEVELS: [(&str, Severity); 5] = [
    ("clean", Severity::Clean),
    ("mild", Severity::Mild),
    ("medium", Severity::Medium),
    ("severe", Severity::Severe),
    ("heavy", Severity::Heavy),
];

/// Names of the single scenes, A to K first.
#[must_use]
pub fn scene_names() -> Vec<String> {
    SCENES.iter().map(|(name, _)| (*name).to_owned()).collect()
}

/// All names: the scenes, then `butt-clean`, `butt-mild` and so on.
#[must_use]
pub fn names() -> Vec<String> {
    let levels =
        FAMILIES.iter().flat_map(|(family, _)| LEVELS.iter().map(move |(level, _)| format!("{family}-{level}")));
    scene_names().into_iter().chain(levels).collect()
}

/// Names of the scenes before a calibrated camera and laser plane.
#[must_use]
pub fn sensor_names() -> Vec<String> {
    SENSOR_SCENES.iter().map(|(name, _)| (*name).to_owned()).collect()
}

/// Names of the scenes of a melt pool.
#[must_use]
pub fn pool_names() -> Vec<String> {
    POOL_SCENES.iter().map(|(name, _)| (*name).to_owned()).collect()
}

/// A built-in scene of a melt pool by its name; case does not matter.
///
/// # Errors
/// When there is no such scene.
pub fn pool_scenario(name: &str) -> Result<PoolScenario, ScenarioError> {
    let found = POOL_SCENES.iter().find(|(scene, _)| scene.eq_ignore_ascii_case(name));
    let (found, text) = found.ok_or_else(|| ScenarioError::Unknown(name.to_owned()))?;
    PoolScenario::from_toml(text, found)
}

/// A built-in scene by its name; case does not matter, and the letter alone is enough where only one scene has it.
///
/// # Errors
/// When there is no such scene.
pub fn scenario(name: &str) -> Result<Scenario, ScenarioError> {
    if let Some((found, text)) = SCENES.iter().chain(&SENSOR_SCENES).find(|(scene, _)| scene.eq_ignore_ascii_case(name))
    {
        return Scenario::from_toml(text, found);
    }
    for (family, origin) in FAMILIES {
        for (level, severity) in LEVELS {
            if format!("{family}-{level}").eq_ignore_ascii_case(name) {
                let origin = scenario(origin)?;
                let description = format!("{family} joint, {level}: {}", origin.description);
                return Ok(Scenario { description, severity, ..origin });
            }
        }
    }
    if let Some(scene) = plate_scene(name)? {
        return scene.scenario();
    }
    let is_letter = |scene: &str| scene.split_once('-').is_some_and(|(letter, _)| letter.eq_ignore_ascii_case(name));
    let mut lettered = SCENES.iter().filter(|(scene, _)| is_letter(scene));
    match (lettered.next(), lettered.next()) {
        (Some((found, text)), None) if name.len() == 1 => Scenario::from_toml(text, found),
        _ => Err(ScenarioError::Unknown(name.to_owned())),
    }
}
