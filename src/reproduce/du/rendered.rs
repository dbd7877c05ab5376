//! Du 2022, tables 2 and 3, from made-up frames: the whole program, from pixels to millimetres.
//!
//! The paper's frames are not published. The scenes `du-butt` and `du-lap` are its experiment (250 frames, 0.2 s,
//! 0.548 px/frame, 0.073 mm/px) with one number set: the raggedness of the edges, such that the KCF alone has about the
//! mean absolute error that the paper prints for it. Nothing was set by what the filters then make of it.

use rayon::prelude::*;

use super::{Joint, Runs, Score, table};
use crate::config::{self, Config, ConfigError, Preset};
use crate::regress::{Lane, follow};
use crate::reproduce::table::{Row, Table};
use crate::synth::{Scenario, ScenarioError, Scene, builtin};
use crate::tracker::{Method, TrackerError};

/// Seeds of the scenes, fixed in advance.
const SEEDS: [u64; 5] = [1, 2, 3, 4, 5];

/// The table's estimates: the preset, the name of its lane, and the table's own name for it.
const ESTIMATES: [(Preset, &str, &str); 4] = [
    (Preset::Paper, "KCF", "paper's method, KCF alone"),
    (Preset::Paper, "filtered", "paper's method, KCF and filter"),
    (Preset::Robust, "filtered", "ours, causal"),
    (Preset::Robust, "smoothed", "ours, smoothed"),
];

impl Joint {
    const fn scene(self) -> &'static str {
        match self {
            Self::Butt => "du-butt",
            Self::Lap => "du-lap",
        }
    }

    fn method(self, preset: Preset) -> Result<Method, ConfigError> {
        let joint = match self {
            Self::Butt => config::Joint::Butt,
            Self::Lap => config::Joint::Lap,
        };
        Config { preset, joint, ..Config::default() }.method()
    }
}

/// A scene that cannot be rendered or tracked, which the built-in ones do not cause.
#[derive(Debug, thiserror::Error)]
pub enum RenderedError {
    /// The scene cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The method cannot be built.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The tracker failed.
    #[error(transparent)]
    Tracker(#[from] TrackerError),
}

/// Both tables from the rendered scenes: the medians over the seeds, the worst of them, the paper's lines.
///
/// # Errors
/// When a scene cannot be rendered or the tracker fails (not: loses the seam).
pub fn tables() -> Result<Vec<Table>, RenderedError> {
    Joint::BOTH.into_iter().map(|joint| rendered(joint, &builtin::scenario(joint.scene())?, &SEEDS)).collect()
}

fn rendered(joint: Joint, scenario: &Scenario, seeds: &[u64]) -> Result<Table, RenderedError> {
    let recordings: Vec<Vec<Errors>> = seeds
        .par_iter()
        .map(|&seed| estimates(joint, &Scene::new(scenario, seed)?))
        .collect::<Result<_, RenderedError>>()?;
    let (mut runs, mut worst, mut missing) = (vec![], vec![], vec![]);
    for (i, (_, _, label)) in ESTIMATES.iter().enumerate() {
        let errors_mm: Vec<_> = recordings.iter().map(|estimates| estimates[i].errors_mm.clone()).collect();
        let scores: Vec<Score> = errors_mm.iter().map(|errors| Score::of(errors)).collect();
        let score = Score::worst(&scores);
        let figures = [score.mean_absolute, score.largest, score.deviation_of_absolute];
        worst.push(Row::new(format!("worst seed: {label}"), figures));
        missing.push(recordings.iter().map(|estimates| estimates[i].missing).sum::<usize>());
        runs.push(Runs { label: (*label).to_owned(), errors_mm });
    }
    let noise = format!(
        "rendered: scene {}, {} frames, seeds {seeds:?}, the median over the seeds and the worst of them; frames \
         without a value, line by line, over all seeds: {missing:?} (the KCF has none where it is seeded)",
        joint.scene(),
        scenario.frames,
    );
    let mut table = table(joint, "rendered frames", noise, &runs);
    table.rows.splice(runs.len()..runs.len(), worst);
    Ok(table)
}

/// The errors of one estimate of one recording.
#[derive(Default)]
struct Errors {
    errors_mm: Vec<f64>,
    /// Frames that have a truth but no value.
    missing: usize,
}

/// One for each of [`ESTIMATES`].
fn estimates(joint: Joint, scene: &Scene) -> Result<Vec<Errors>, RenderedError> {
    let paper = follow(scene, &joint.method(Preset::Paper)?)?;
    let robust = follow(scene, &joint.method(Preset::Robust)?)?;
    let errors = ESTIMATES.iter().map(|(preset, name, _)| {
        let lanes = if *preset == Preset::Paper { &paper } else { &robust };
        lanes.iter().find(|lane| lane.name == *name).map(|lane| errors(scene, lane)).unwrap_or_default()
    });
    Ok(errors.collect())
}

fn errors(scene: &Scene, lane: &Lane) -> Errors {
    let scale = scene.drawn_scenario().mm_per_px.get();
    let mut errors = Errors::default();
    for (i, estimate) in lane.estimates.iter().enumerate() {
        let truth_px = scene.truth(i).seam.map(|seam| scene.axis().along_px(seam));
        match (truth_px, estimate) {
            (Some(truth_px), Some(estimate)) => errors.errors_mm.push(scale * (estimate.position_px - truth_px)),
            (Some(_), None) => errors.missing += 1,
            (None, _) => {}
        }
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shortened_recording_gives_the_papers_order_kcf_filter_ours() {
        for joint in Joint::BOTH {
            let scenario = Scenario { frames: 60, ..builtin::scenario(joint.scene()).unwrap() };
            let table = rendered(joint, &scenario, &[1, 2]).unwrap();
            let mean = |label: &str| table.value(label, "MAE [mm]").unwrap();
            assert!(mean("paper's method, KCF alone") > mean("ours, causal"), "{table}");
            assert!(mean("ours, causal") > 0.001, "an error of nothing is no tracking: {table}");
            assert!(mean("worst seed: ours, causal") >= mean("ours, causal"), "{table}");
            assert_eq!(table.rows.len(), 10, "{table}");
            // Ours may wait three frames to confirm its seed; the paper's never waits, and its KCF has no value where it is seeded.
            assert!(table.noise.contains("[2, 0, "), "{table}");
        }
    }
}
