//! Regression runs: built-in scenes, several seeds, any tracker, one table.
//!
//! What tracks is the caller's: a function from a [`Scene`] to one [`Lane`] for each estimate it makes. So the table of
//! the program ([`follow`]) and that of the peers come from the same frames and the same figures.

use std::time::Instant;

use rayon::prelude::*;

use crate::calib::Sensor;
use crate::eval::{Errors, Estimate, WRONG_MM, errors};
use crate::synth::{Scenario, ScenarioError, Scene};
use crate::tracker::{JointDecision, Method, SeamEstimate, SeamPath, Session, SessionSettings, TrackerError};
use crate::units::{PixelPoint, StripeAxis};

/// Which coordinate of the seam is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// Along the stripe.
    Along,
    /// Across the stripe: the height.
    Across,
}

impl Coordinate {
    /// This coordinate of a point in an image whose stripe runs along `axis` \[px\].
    #[must_use]
    pub const fn px(self, axis: StripeAxis, point: PixelPoint) -> f64 {
        match self {
            Self::Along => axis.along_px(point),
            Self::Across => axis.across_px(point),
        }
    }

    /// This coordinate of an estimate, with its σ.
    #[must_use]
    pub const fn of(self, seam: &SeamEstimate, axis: StripeAxis) -> Estimate {
        let std_px = match self {
            Self::Along => seam.std_px,
            Self::Across => seam.std_across_px,
        };
        Estimate { position_px: self.px(axis, seam.centre), std_px: Some(std_px) }
    }
}

/// One estimator's answer for a whole recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Lane {
    /// Name of the estimator.
    pub name: String,
    /// What it estimates.
    pub coordinate: Coordinate,
    /// One a frame; none where the estimator gives no value.
    pub estimates: Vec<Option<Estimate>>,
    /// Time for each frame \[ms\]; empty when it was not taken.
    pub frame_ms: Vec<f64>,
}

/// How one estimator did on one scene with one seed.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// Name of the scene.
    pub scene: String,
    /// Its seed.
    pub seed: u64,
    /// Name of the estimator.
    pub lane: String,
    /// Accuracy one frame can have along the stripe, from the raggedness of the edges \[mm\]; 0 across it.
    pub noise_floor_mm: f64,
    /// The errors; none when no frame has both a value and a truth.
    pub errors: Option<Errors>,
    /// Frames with a truth whose value is missing or off by more than 1 mm: what a peer has lost.
    pub lost_frames: usize,
    /// Frames with a value although there is no joint.
    pub invented_frames: usize,
    /// Median time for a frame \[ms\], where it was taken.
    pub frame_ms: Option<f64>,
}

/// A regression run that failed.
#[derive(Debug, thiserror::Error)]
pub enum RegressError<E> {
    /// A scene cannot be rendered.
    #[error(transparent)]
    Scenario(ScenarioError),
    /// The tracker failed (not: lost the seam).
    #[error("the tracker failed on {scene}, seed {seed}")]
    Track {
        /// Name of the scene.
        scene: String,
        /// Its seed.
        seed: u64,
        /// Why.
        source: E,
    },
}

/// Seeds as the command line gives them: `5` is 1 to 5, `11-15` is 11 to 15.
///
/// # Errors
/// When the text is neither.
pub fn parse_seeds(text: &str) -> Result<std::ops::RangeInclusive<u64>, String> {
    let number = |text: &str| text.trim().parse::<u64>().map_err(|_| format!("{text:?} is no seed; give 5 or 11-15"));
    match text.split_once('-') {
        None => Ok(1..=number(text)?),
        Some((first, last)) => Ok(number(first)?..=number(last)?),
    }
}

/// Renders, tracks and scores every scene with every seed, in parallel on rayon's current threads. The scores come in
/// the order of scenes, seeds and lanes, whatever the threads do.
///
/// # Errors
/// When a scene cannot be rendered or `track` fails.
pub fn run<E: Send>(
    scenes: &[(String, Scenario)],
    seeds: &[u64],
    track: impl Fn(&Scene) -> Result<Vec<Lane>, E> + Sync,
) -> Result<Vec<Score>, RegressError<E>> {
    let cases: Vec<_> = scenes.iter().flat_map(|scene| seeds.iter().map(move |&seed| (scene, seed))).collect();
    let scores: Vec<Vec<Score>> = cases
        .into_par_iter()
        .map(|((name, scenario), seed)| {
            let scene = Scene::new(scenario, seed).map_err(RegressError::Scenario)?;
            let lanes = track(&scene).map_err(|source| RegressError::Track { scene: name.clone(), seed, source })?;
            Ok(lanes.iter().map(|lane| score(name, seed, &scene, lane)).collect())
        })
        .collect::<Result<_, RegressError<E>>>()?;
    Ok(scores.into_iter().flatten().collect())
}

/// The program's own tracker on a scene, told its scale. Five lanes: `KCF`, its correlation filter's own peak; `filtered`;
/// `smoothed`, which is empty by a method without a smoother; and `height`, `smoothed height`, the coordinate across the
/// stripe.
///
/// # Errors
/// When the method cannot be built or fails.
pub fn follow(scene: &Scene, method: &Method) -> Result<Vec<Lane>, TrackerError> {
    Ok(follow_with(scene, method, SeamPath::default())?.0)
}

/// The same with a smoother of one's own, and the joints that were found.
///
/// # Errors
/// When the method cannot be built or fails.
pub fn follow_with(
    scene: &Scene,
    method: &Method,
    mut path: SeamPath,
) -> Result<(Vec<Lane>, Vec<JointDecision>), TrackerError> {
    let sensor = Sensor::Scale(scene.drawn_scenario().mm_per_px);
    let mut session = Session::new(&SessionSettings { sensor, ..SessionSettings::new(method.clone()) })?;
    let axis = scene.axis();
    let (mut kcf, mut seams, mut frame_ms, mut joints) = (vec![], vec![], vec![], vec![]);
    for i in 0..scene.frame_count() {
        let frame = scene.render(i);
        let began = Instant::now();
        let estimate = session.step(&frame, scene.timestamp_s(i))?;
        frame_ms.push(began.elapsed().as_secs_f64() * 1e3);
        joints.extend(session.joint().filter(|joint| joint.frame == i).cloned());
        kcf.push(estimate.kcf.map(|kcf| Estimate { position_px: axis.along_px(kcf.peak), std_px: None }));
        seams.push(estimate.seam);
        path.push(&estimate);
    }
    let smoothed = path.smoothed()?;
    let of = |seams: &[Option<SeamEstimate>], coordinate: Coordinate| -> Vec<Option<Estimate>> {
        seams.iter().map(|seam| seam.map(|seam| coordinate.of(&seam, axis))).collect()
    };
    let lane =
        |name: &str, coordinate, estimates, frame_ms| Lane { name: name.to_owned(), coordinate, estimates, frame_ms };
    let lanes = vec![
        lane("KCF", Coordinate::Along, kcf, vec![]),
        lane("filtered", Coordinate::Along, of(&seams, Coordinate::Along), frame_ms),
        lane("smoothed", Coordinate::Along, of(&smoothed, Coordinate::Along), vec![]),
        lane("height", Coordinate::Across, of(&seams, Coordinate::Across), vec![]),
        lane("smoothed height", Coordinate::Across, of(&smoothed, Coordinate::Across), vec![]),
    ];
    Ok((lanes, joints))
}

/// A coordinate of the true seam in each frame \[px\], where there is one.
#[must_use]
pub fn truth_px(scene: &Scene, coordinate: Coordinate) -> Vec<Option<f64>> {
    (0..scene.frame_count()).map(|i| scene.truth(i).seam.map(|seam| coordinate.px(scene.axis(), seam))).collect()
}

/// Scores one lane.
///
/// # Panics
/// When the lane has not one estimate for each frame of the scene.
#[must_use]
pub fn score(name: &str, seed: u64, scene: &Scene, lane: &Lane) -> Score {
    let scenario = scene.drawn_scenario();
    let scale = scenario.mm_per_px;
    let truth = truth_px(scene, lane.coordinate);
    let lost_frames = lane
        .estimates
        .iter()
        .zip(&truth)
        .filter(|(estimate, truth)| {
            truth.is_some_and(|t| estimate.is_none_or(|e| scale.get() * (e.position_px - t).abs() > WRONG_MM))
        })
        .count();
    Score {
        scene: name.to_owned(),
        seed,
        lane: lane.name.clone(),
        noise_floor_mm: match lane.coordinate {
            Coordinate::Along => scale.get() * scenario.noise_floor_px(),
            Coordinate::Across => 0.0,
        },
        errors: errors(&lane.estimates, &truth, scale),
        lost_frames,
        invented_frames: lane.estimates.iter().zip(&truth).filter(|(e, t)| e.is_some() && t.is_none()).count(),
        frame_ms: (!lane.frame_ms.is_empty()).then(|| median(&lane.frame_ms)),
    }
}

/// The scores as a Markdown table, one row for each scene and lane: medians and worst values over the seeds.
#[must_use]
pub fn table(scores: &[Score]) -> String {
    let mut text = String::from(
        "| scene | floor mm | estimator | mean abs mm: median / worst | max mm: median / worst | std mm | in 2σ | wrong | unavailable | lost | invented | ms/frame |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut keys: Vec<(&str, &str)> = Vec::new();
    for score in scores {
        if !keys.contains(&(score.scene.as_str(), score.lane.as_str())) {
            keys.push((&score.scene, &score.lane));
        }
    }
    for (scene, lane) in keys {
        let rows: Vec<&Score> = scores.iter().filter(|s| s.scene == scene && s.lane == lane).collect();
        let of = |figure: fn(&Errors) -> f64| -> Vec<f64> {
            rows.iter().filter_map(|row| row.errors.as_ref().map(figure)).collect()
        };
        let pair = |figure: fn(&Errors) -> f64| {
            let values = of(figure);
            if values.is_empty() {
                return "– / –".to_owned();
            }
            format!("{:.3} / {:.3}", median(&values), values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
        };
        let cell = |values: &[f64], decimals: usize| {
            if values.is_empty() { "–".to_owned() } else { format!("{:.decimals$}", median(values)) }
        };
        let floors: Vec<f64> = rows.iter().map(|row| row.noise_floor_mm).collect();
        let coverages: Vec<f64> = rows.iter().filter_map(|row| row.errors?.coverage_2sigma).collect();
        let times: Vec<f64> = rows.iter().filter_map(|row| row.frame_ms).collect();
        let sum = |count: fn(&Score) -> usize| rows.iter().map(|row| count(row)).sum::<usize>();
        text += &format!(
            "| {scene} | {} | {lane} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
            cell(&floors, 3),
            pair(|e| e.mae),
            pair(|e| e.max),
            cell(&of(|e| e.std), 3),
            cell(&coverages, 2),
            sum(|s| s.errors.map_or(0, |e| e.wrong_frames)),
            sum(|s| s.errors.map_or(0, |e| e.unavailable_frames)),
            sum(|s| s.lost_frames),
            sum(|s| s.invented_frames),
            cell(&times, 2),
        );
    }
    text
}

/// The median of at least one value.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::synth::builtin;

    /// An estimator that is `px` off, and claims a σ of 1 px.
    fn off_by(px: f64, coordinate: Coordinate) -> impl Fn(&Scene) -> Result<Vec<Lane>, Infallible> {
        move |scene| {
            let claim = |truth: Option<f64>| Estimate { position_px: truth.unwrap_or(100.0) + px, std_px: Some(1.0) };
            let estimates = truth_px(scene, coordinate).into_iter().map(|truth| Some(claim(truth))).collect();
            Ok(vec![Lane { name: "off".to_owned(), coordinate, estimates, frame_ms: vec![] }])
        }
    }

    fn short(name: &str, frames: usize) -> (String, Scenario) {
        (name.to_owned(), Scenario { frames, ..builtin::scenario(name).unwrap() })
    }

    #[test]
    fn an_estimator_that_is_off_by_two_pixels_scores_two_pixels() {
        let scores =
            run(&[short("A-butt", 20), short("recorder", 20)], &[1, 2], off_by(2.0, Coordinate::Along)).unwrap();
        assert_eq!(scores.len(), 4);
        for score in &scores {
            let errors = score.errors.unwrap();
            assert!((errors.mae - 0.146).abs() < 1e-9 && errors.std < 1e-9, "{score:?}");
        }
        assert_eq!(table(&scores).lines().count(), 4);
    }

    #[test]
    fn the_height_is_scored_across_the_stripe_whichever_way_it_runs() {
        let (_, mut vertical) = short("A-butt", 20);
        vertical.image.stripe = StripeAxis::Vertical;
        let scenes = [short("A-butt", 20), ("turned".to_owned(), vertical)];
        let near = run(&scenes, &[1], off_by(1.5, Coordinate::Across)).unwrap();
        let far = run(&scenes, &[1], off_by(2.5, Coordinate::Across)).unwrap();
        for (near, far) in near.iter().zip(&far) {
            let (near, far) = (near.errors.unwrap(), far.errors.unwrap());
            assert!((near.mae - 0.1095).abs() < 1e-9, "{near:?}");
            assert_eq!((near.coverage_2sigma, far.coverage_2sigma), (Some(1.0), Some(0.0)));
        }
    }

    #[test]
    fn values_on_a_plate_without_a_joint_count_as_invented() {
        let scores = run(&[short("flat", 5)], &[1], off_by(0.0, Coordinate::Along)).unwrap();
        assert_eq!((scores[0].invented_frames, scores[0].errors), (5, None));
    }
}
