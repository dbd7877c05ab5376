//! Tracks one recording of the campaign and says how it went.

use anyhow::{Context, Result};
use seamtrack::config::Config;
use seamtrack::eval::{Errors, Estimate, WRONG_MM, errors};
use seamtrack::regress::{Coordinate, follow_with, truth_px};
use seamtrack::synth::Scene;
use seamtrack::tracker::SeamPath;

use crate::draw::Recording;

/// Frames in which the seam should have been found.
const FOUND_FRAMES: usize = 10;
/// Share of the later frames that may have no value.
const MOST_UNAVAILABLE: f64 = 0.05;
/// Beyond these a value is far off, in pixels and in its own σ.
const FAR_PX: f64 = 8.0;
const FAR_SIGMAS: f64 = 5.0;

/// What became of a recording.
pub struct Outcome {
    /// The recording.
    pub recording: Recording,
    /// The joint that was found first, if any.
    pub found: Option<&'static str>,
    /// Values off by over 1 mm.
    pub wrong: usize,
    /// Values off by over 8 px, or over 5 of their own σ.
    pub far: usize,
    /// Smoothed values off by over 1 mm.
    pub smoothed_wrong: usize,
    /// Share of the frames after the tenth without a value, 0 to 1.
    pub unavailable: f64,
    /// Errors of the causal path; none when it has no value.
    pub causal: Option<Errors>,
    /// Errors of the smoothed path.
    pub smoothed: Option<Errors>,
    /// Errors of the height.
    pub height: Option<Errors>,
}

impl Outcome {
    /// No wrong value, and the seam available on all but 5 % of the frames after the tenth.
    pub fn passed(&self) -> bool {
        self.wrong == 0 && self.unavailable <= MOST_UNAVAILABLE
    }

    /// Millimetres of this recording in pixels.
    pub fn px(&self, mm: f64) -> f64 {
        mm / self.recording.scenario.mm_per_px.get()
    }

    /// Whether the joint found is the joint drawn.
    pub fn is_right_kind(&self) -> bool {
        self.found == Some(self.recording.kind)
    }
}

/// Tracks a recording: the scale is told, the joint is not.
pub fn tracked(recording: Recording) -> Result<Outcome> {
    let scenario = &recording.scenario;
    let scene = Scene::new(scenario, scenario.seed)?;
    let config = Config { mm_per_px: Some(scenario.mm_per_px), period_s: scenario.period_s, ..Config::default() };
    let (lanes, joints) = follow_with(&scene, &config.method()?, SeamPath::default())?;
    let lane = |name: &str| {
        let lane = lanes.iter().find(|lane| lane.name == name);
        lane.map(|lane| lane.estimates.as_slice()).with_context(|| format!("the tracker has no path {name:?}"))
    };
    let truth = truth_px(&scene, Coordinate::Along);
    let scale = scenario.mm_per_px;
    let causal = lane("filtered")?;
    let smoothed = errors(lane("smoothed")?, &truth, scale);
    let late = causal.iter().zip(&truth).skip(FOUND_FRAMES);
    let missing = late.clone().filter(|(estimate, truth)| estimate.is_none() && truth.is_some()).count();
    Ok(Outcome {
        found: joints.first().map(|joint| joint.kind),
        wrong: count(causal, &truth, |_, error_px| scale.get() * error_px > WRONG_MM),
        far: count(causal, &truth, |estimate, error_px| {
            error_px > FAR_PX || estimate.std_px.is_some_and(|std_px| error_px > FAR_SIGMAS * std_px)
        }),
        smoothed_wrong: smoothed.map_or(0, |errors| errors.wrong_frames),
        unavailable: missing as f64 / late.count().max(1) as f64,
        causal: errors(causal, &truth, scale),
        smoothed,
        height: errors(lane("height")?, &truth_px(&scene, Coordinate::Across), scale),
        recording,
    })
}

/// Values with a truth of which `is(estimate, absolute error in px)` holds.
fn count(estimates: &[Option<Estimate>], truth: &[Option<f64>], is: impl Fn(&Estimate, f64) -> bool) -> usize {
    let both = estimates.iter().zip(truth).filter_map(|(estimate, truth)| Some((estimate.as_ref()?, (*truth)?)));
    both.filter(|(estimate, truth)| is(estimate, (estimate.position_px - truth).abs())).count()
}
