//! Whether to trust the path, in one sentence.

use super::results::Estimator;
use super::run::Run;
use super::summary::{FrameCounts, Joint};
use super::tolerance::Reference;
use crate::eval::wrong_limit;
use crate::units::LengthUnit;

/// `--max-unavailable` when the summary does not say \[%\]: the contract's default.
const MAX_UNAVAILABLE_PCT: f64 = 5.0;
/// Above this share of coasting frames a person should look \[%\]: chosen, the same as for unavailable ones.
const MAX_COASTING_PCT: f64 = 5.0;
/// Above this share of frames outside of `--tolerance` a person should look \[%\]: chosen, the same as for unavailable ones.
const MAX_OUTSIDE_PCT: f64 = 5.0;
/// Fewer measurements say nothing of the share: chosen, one in twenty has to be expected at all.
const LEAST_MEASURED: usize = 20;
/// Below this share within 2 σ of the truth σ is not to be believed: chosen.
const MIN_COVERAGE: f64 = 0.8;
/// A seam that moves by less than this over at least so many frames does not move \[px\]: plate edges are ragged and arms
/// shake by more. Measured on what is fixed to the picture: .04 to .12 px; on straight seams from 1 px up.
const STILL_RANGE_PX: f64 = 0.5;
const LEAST_MOVING_FRAMES: usize = 30;
/// 95 % quantile of χ² with one degree of freedom: a consistent filter's NIS is below it on 95 % of the frames.
pub const NIS_95: f64 = 3.841;
/// Below this share of NIS under [`NIS_95`] the filter's σ is doubtful \[%\]: chosen, five points under the expected 95.
const MIN_CONSISTENT_PCT: f64 = 90.0;
/// Below this share the filter does not follow its measurements \[%\]: chosen, four times the expected contradictions.
const MIN_USABLE_PCT: f64 = 80.0;

/// How far the path can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Trust {
    /// Nothing speaks against it.
    Good,
    /// Something should be looked at.
    Check,
    /// It cannot be used as it is.
    Bad,
}

impl Trust {
    /// One word, also the class name in the page.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Check => "check",
            Self::Bad => "bad",
        }
    }
}

/// The verdict on a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// How far the path can be trusted.
    pub trust: Trust,
    /// The frames in one sentence.
    pub sentence: String,
    /// What speaks against trust, each a short sentence.
    pub doubts: Vec<String>,
    /// What else there is to know: errors, consistency, calibration.
    pub facts: Vec<String>,
}

/// Judge `run`.
#[must_use]
pub fn verdict(run: &Run) -> Verdict {
    let counts = &run.summary.frames;
    let unavailable = run.unavailable();
    let Some(found_at) = unavailable.found_at else {
        let sentence = format!("No seam was found in {} frames.", counts.total);
        return Verdict { trust: Trust::Bad, sentence, doubts: Vec::new(), facts: facts(run) };
    };
    let mut sentence = format!("Tracked on {} of {} frames", counts.tracked, counts.total);
    for (count, what) in [
        (counts.coasting, "coasting"),
        (counts.lost, "lost"),
        (counts.unreadable, "unreadable"),
        (found_at, "before the seam was found"),
    ] {
        if count > 0 {
            sentence += &format!(", {count} {what}");
        }
    }
    if unavailable.missing == 0 {
        sentence += ", none lost";
    }
    let (trust, doubts) = doubts(run);
    Verdict { trust, sentence: sentence + ".", doubts, facts: facts(run) }
}

/// What speaks against trust. The one place that decides on badge, first sentence and exit code.
fn doubts(run: &Run) -> (Trust, Vec<String>) {
    let found: Vec<(Trust, String)> = [
        availability(run),
        camera(run),
        truth(run),
        tolerance(run),
        joint(run),
        consistency_doubts(run),
        motion(run),
        scale(run),
    ]
    .into_iter()
    .flatten()
    .collect();
    let worst = found.iter().map(|&(trust, _)| trust).max().unwrap_or(Trust::Good);
    (worst, found.into_iter().map(|(_, doubt)| doubt).collect())
}

type Doubts = Vec<(Trust, String)>;

/// Bad above the limit of the run, to be checked below it.
fn beyond(run: &Run, percent: f64) -> Trust {
    if percent > limit_pct(run) { Trust::Bad } else { Trust::Check }
}

fn limit_pct(run: &Run) -> f64 {
    run.summary.limits.max_unavailable_pct.unwrap_or(MAX_UNAVAILABLE_PCT)
}

fn percent_of(run: &Run, count: usize) -> f64 {
    100.0 * count as f64 / run.summary.frames.total.max(1) as f64
}

/// Frames without a value, those before the seam was found included, and frames with a prediction only.
fn availability(run: &Run) -> Doubts {
    let unavailable = run.unavailable();
    let mut doubts = vec![];
    let percent = unavailable.percent();
    if unavailable.missing > 0 || percent > limit_pct(run).min(MAX_UNAVAILABLE_PCT) {
        let limit_pct = limit_pct(run);
        doubts.push((beyond(run, percent), format!("No value on {percent:.1} % of the frames (limit {limit_pct} %).")));
    }
    let coasting_pct = percent_of(run, run.summary.frames.coasting);
    if coasting_pct > MAX_COASTING_PCT {
        doubts.push((Trust::Check, format!("{coasting_pct:.1} % of the frames are predictions only.")));
    }
    doubts
}

/// A camera that stood still, and stamps that tell no time.
fn camera(run: &Run) -> Doubts {
    let FrameCounts { frozen, bad_stamps, .. } = run.summary.frames;
    let mut doubts = vec![];
    if frozen > 0 {
        let text = format!("The camera froze: on {frozen} frames the picture had not changed for long.");
        doubts.push((beyond(run, percent_of(run, frozen)), text));
    }
    if bad_stamps > 0 {
        let text = format!(
            "{bad_stamps} time stamps are no number or do not rise: their frames count as not seen. Mend timestamps.csv, or take it away and give --period."
        );
        doubts.push((beyond(run, percent_of(run, bad_stamps)), text));
    }
    doubts
}

/// Values that the truth contradicts, filtered or smoothed.
fn truth(run: &Run) -> Doubts {
    let Some(errors) = &run.summary.errors else { return vec![] };
    let mut doubts = vec![];
    for estimator in [Estimator::Filtered, Estimator::Smoothed] {
        let Some(errors) = errors.of(estimator) else { continue };
        let name = estimator.name();
        if errors.wrong_frames > 0 {
            let wrong = errors.wrong_frames;
            doubts.push((
                Trust::Bad,
                format!("{wrong} {name} values claim to be valid and are off by over {}.", wrong_limit(errors.unit)),
            ));
        }
        if let Some(coverage) = errors.coverage_2sigma.filter(|coverage| *coverage < MIN_COVERAGE) {
            let percent = 100.0 * coverage;
            doubts
                .push((Trust::Check, format!("Only {percent:.0} % of the {name} values lie within 2 σ of the truth.")));
        }
    }
    doubts
}

/// A path that the truth puts outside of the tolerance more often than σ allows. How far the seam itself wanders from x = 0 says
/// nothing of trust.
fn tolerance(run: &Run) -> Doubts {
    let Some(tolerance) = run.tolerance().filter(|tolerance| tolerance.reference == Reference::Truth) else {
        return vec![];
    };
    let outside_pct = 100.0 - tolerance.inside_pct;
    if outside_pct <= MAX_OUTSIDE_PCT {
        return vec![];
    }
    let text = format!("The path is outside of ±{} mm on {outside_pct:.1} % of the frames.", tolerance.tolerance_mm);
    vec![(Trust::Check, text)]
}

/// A joint that is not the one asked for, or may be none.
fn joint(run: &Run) -> Doubts {
    let Joint { kind, contradicted_by, doubt, .. } = &run.summary.joint;
    let contradiction = |seen: &String| {
        (Trust::Bad, format!("A {kind} joint was asked for, but the frames show a {seen}: try --joint {seen} or auto."))
    };
    let may_be_none =
        |doubt: &String| (Trust::Check, format!("Is it a joint? {doubt}; --joint {kind} says that it is one."));
    contradicted_by.iter().map(contradiction).chain(doubt.iter().map(may_be_none)).collect()
}

/// Measurements that the filter's own σ does not explain.
fn consistency_doubts(run: &Run) -> Doubts {
    let Some(Consistency { below_95_pct, .. }) = consistency(run) else { return vec![] };
    let measured = run.rows.iter().filter(|row| row.nis.is_some()).count();
    if measured < LEAST_MEASURED || below_95_pct >= MIN_CONSISTENT_PCT {
        return vec![];
    }
    let trust = if below_95_pct < MIN_USABLE_PCT { Trust::Bad } else { Trust::Check };
    let percent = 100.0 - below_95_pct;
    vec![(trust, format!("{percent:.0} % of the measurements contradict the filter, 5 % expected."))]
}

/// A seam that never moves is a mark fixed to the picture, or the recording shows a plate at rest.
fn motion(run: &Run) -> Doubts {
    let axis = run.summary.calibration.stripe;
    let along: Vec<f64> = run.rows.iter().filter_map(|row| row.along_px(Estimator::Filtered, axis)).collect();
    let (least, most) = along.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    if along.len() < LEAST_MOVING_FRAMES || most - least > STILL_RANGE_PX {
        return vec![];
    }
    let text = format!(
        "The seam stays within {:.2} px over the whole recording: a plate at rest, or dirt on the glass, a dead column or a gap in the laser's line.",
        most - least
    );
    vec![(Trust::Check, text)]
}

/// Lengths in pixels, and millimetres beyond what was calibrated.
fn scale(run: &Run) -> Doubts {
    let calibration = &run.summary.calibration;
    if calibration.sensor().unit() == LengthUnit::Px {
        let text = "Lengths are in pixels, since no scale was given: --mm-per-px, or --calibration with a file of `seamtrack calibrate`.";
        return vec![(Trust::Check, text.into())];
    }
    let outside = run.rows.iter().filter(|row| row.calibrated == Some(false)).count();
    if outside == 0 {
        return vec![];
    }
    let text = format!(
        "On {outside} frames the seam lies outside of what was calibrated: their millimetres are extrapolated."
    );
    vec![(Trust::Check, text)]
}

fn facts(run: &Run) -> Vec<String> {
    let summary = &run.summary;
    let mut facts = Vec::new();
    if let Some(errors) = &summary.errors {
        for estimator in [Estimator::Filtered, Estimator::Smoothed] {
            if let Some(e) = errors.of(estimator) {
                let name = estimator.name();
                facts.push(format!(
                    "Error {name}: mean {:.3} {unit}, maximum {:.3} {unit}.",
                    e.mae,
                    e.max,
                    unit = e.unit
                ));
            }
        }
    }
    if let Some(plane) = &summary.plane_errors {
        for (name, e) in [("Lateral", &plane.lateral), ("Height", &plane.height)] {
            facts.push(format!(
                "{name} error in the laser's plane: mean {:+.3} mm (σ of the calibration {}), scatter {:.3} mm (σ of the noise {:.3}).",
                e.bias_mm,
                e.calib_std_mm.map_or_else(|| "unknown".to_owned(), |std| format!("{std:.3}")),
                e.scatter_mm,
                e.noise_std_mm
            ));
        }
    }
    facts.extend(run.tolerance().map(|tolerance| tolerance.sentence()));
    if let Some(consistency) = consistency(run) {
        let Consistency { mean, below_95_pct } = consistency;
        facts.push(format!(
            "NIS {mean:.2} on average (1 expected), {below_95_pct:.0} % below {NIS_95} (95 % expected)."
        ));
    }
    for (count, what) in
        [(summary.frames.repeated, "repeat their predecessor"), (summary.frames.saturated, "are saturated")]
    {
        if count > 0 {
            facts.push(format!("{count} frames {what}."));
        }
    }
    facts.push(format!("{}, {} stripe.", summary.calibration.words(), summary.calibration.stripe));
    facts.push(format!("Joint: {}; {}.", summary.joint.kind, summary.joint.reason.trim_end_matches('.')));
    facts
}

/// How well the filter's innovations fit its σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Consistency {
    /// Mean NIS; 1 for a consistent filter of one observation.
    pub mean: f64,
    /// Share of NIS below [`NIS_95`] \[%\].
    pub below_95_pct: f64,
}

/// The consistency of a run, if it has any NIS.
#[must_use]
pub fn consistency(run: &Run) -> Option<Consistency> {
    let nis: Vec<f64> = run.rows.iter().filter_map(|row| row.nis).collect();
    let count = nis.len() as f64;
    let below = nis.iter().filter(|&&nis| nis < NIS_95).count() as f64;
    (!nis.is_empty())
        .then(|| Consistency { mean: nis.iter().sum::<f64>() / count, below_95_pct: 100.0 * below / count })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::Errors;
    use crate::report::results::{PathRow, Status};
    use crate::report::summary::ErrorTable;
    use crate::report::summary::{Calibration, Input, Limits, Percentiles, SCHEMA_VERSION, Summary, Timing};
    use crate::units::{MmPerPx, StripeAxis};

    /// A run with one letter a frame: t, c, l, s as in the page.
    fn run(statuses: &str, nis: f64) -> Run {
        let row = |(frame, letter): (usize, char)| {
            let status = match letter {
                't' => Status::Tracked,
                'c' => Status::Coasting,
                'l' => Status::Lost,
                _ => Status::Seeking,
            };
            let has_value = matches!(status, Status::Tracked | Status::Coasting);
            let (x_mm, nis) = (has_value.then_some(0.0), (status == Status::Tracked).then_some(nis));
            PathRow { x_mm, nis, ..PathRow::empty(frame, String::new(), 0.0, status) }
        };
        let count = |letter: char| statuses.chars().filter(|&other| other == letter).count();
        let none = Percentiles::default();
        Run {
            dir: "run".into(),
            name: "run".into(),
            rows: statuses.chars().enumerate().map(row).collect(),
            truth_px: None,
            measures: Vec::new(),
            thumbnails: Vec::new(),
            summary: Summary {
                schema_version: SCHEMA_VERSION,
                program: String::new(),
                input: Input { path: String::new(), width_px: 1, height_px: 1, more: serde_json::Map::new() },
                config: serde_json::Value::Null,
                calibration: Calibration {
                    mm_per_px: Some(MmPerPx::DU_2022),
                    source: "default".into(),
                    ..Calibration::unknown(StripeAxis::Horizontal)
                },
                limits: Limits::default(),
                frames: FrameCounts {
                    total: statuses.len(),
                    seeking: count('s'),
                    tracked: count('t'),
                    coasting: count('c'),
                    lost: count('l'),
                    ..FrameCounts::default()
                },
                joint: Joint {
                    kind: "butt".into(),
                    decided_at_frame: None,
                    reason: String::new(),
                    doubt: None,
                    contradicted_by: None,
                    later: vec![],
                },
                timing: Timing { decode_ms: none, track_ms: none, frames_per_second: 0.0 },
                errors: None,
                plane_errors: None,
                tolerance: None,
            },
        }
    }

    #[test]
    fn a_seam_tracked_from_where_it_was_found_is_good() {
        let verdict = verdict(&run(&("ss".to_owned() + &"t".repeat(98)), 1.0));
        assert_eq!(verdict.trust, Trust::Good);
        assert_eq!(verdict.sentence, "Tracked on 98 of 100 frames, 2 before the seam was found, none lost.");
    }

    #[test]
    fn a_short_loss_is_to_be_checked_and_a_long_one_is_bad() {
        assert_eq!(verdict(&run(&("t".repeat(97) + "lll"), 1.0)).trust, Trust::Check);
        assert_eq!(verdict(&run(&("t".repeat(90) + "llllllssss"), 1.0)).trust, Trust::Bad);
    }

    #[test]
    fn many_predictions_raise_doubts_and_a_filter_that_leaves_its_measurements_is_bad() {
        assert_eq!(verdict(&run(&("t".repeat(90) + &"c".repeat(10)), 1.0)).trust, Trust::Check);
        let overconfident = verdict(&run(&"t".repeat(100), 5.0));
        assert_eq!(overconfident.trust, Trust::Bad);
        assert!(overconfident.doubts[0].contains("contradict"), "{:?}", overconfident.doubts);
    }

    fn trust_of(change: impl Fn(&mut Run)) -> (Trust, Vec<String>) {
        let mut run = run(&"t".repeat(100), 1.0);
        change(&mut run);
        let Verdict { trust, doubts, .. } = verdict(&run);
        (trust, doubts)
    }

    #[test]
    fn long_seeking_is_bad_though_everything_was_tracked_afterwards() {
        assert_eq!(verdict(&run(&("s".repeat(50) + &"t".repeat(50)), 1.0)).trust, Trust::Bad);
    }

    #[test]
    fn long_seeking_is_to_be_checked_also_where_the_user_allows_it() {
        let mut long = run(&("s".repeat(50) + &"t".repeat(50)), 1.0);
        long.summary.limits.max_unavailable_pct = Some(100.0);
        assert_eq!(verdict(&long).trust, Trust::Check);
    }

    #[test]
    fn a_frozen_camera_and_stamps_that_tell_no_time_are_said_and_many_of_them_are_bad() {
        let (few, many) = (2, 30);
        assert_eq!(trust_of(|run| run.summary.frames.frozen = few).0, Trust::Check);
        let (trust, doubts) = trust_of(|run| run.summary.frames.frozen = many);
        assert!(trust == Trust::Bad && doubts[0].contains("froze"), "{doubts:?}");
        assert_eq!(trust_of(|run| run.summary.frames.bad_stamps = few).0, Trust::Check);
        assert_eq!(trust_of(|run| run.summary.frames.bad_stamps = many).0, Trust::Bad);
    }

    #[test]
    fn a_joint_that_is_not_the_one_asked_for_is_bad() {
        let (trust, doubts) = trust_of(|run| run.summary.joint.contradicted_by = Some("vgroove".into()));
        assert!(trust == Trust::Bad && doubts[0].contains("--joint vgroove"), "{doubts:?}");
    }

    #[test]
    fn a_seam_that_never_moves_is_to_be_checked() {
        let along = |u_px: fn(f64) -> f64| {
            move |run: &mut Run| {
                for row in &mut run.rows {
                    (row.u_px, row.v_px) = (Some(u_px(row.frame as f64)), Some(240.0));
                }
            }
        };
        let (trust, doubts) = trust_of(along(|frame| 100.0 + 0.0005 * frame));
        assert!(trust == Trust::Check && doubts[0].contains("dirt on the glass"), "{doubts:?}");
        assert_eq!(trust_of(along(|frame| frame)).0, Trust::Good);
    }

    #[test]
    fn a_path_in_pixels_is_to_be_checked_and_says_what_to_give() {
        let (trust, doubts) = trust_of(|run| run.summary.calibration = Calibration::unknown(StripeAxis::Horizontal));
        assert!(trust == Trust::Check && doubts[0].contains("--mm-per-px"), "{doubts:?}");
    }

    #[test]
    fn millimetres_outside_of_the_calibrated_range_are_to_be_checked() {
        let (trust, doubts) = trust_of(|run| run.rows[7].calibrated = Some(false));
        assert!(trust == Trust::Check && doubts[0].contains("On 1 frames"), "{doubts:?}");
    }

    #[test]
    fn smoothed_values_that_are_wrong_are_as_bad_as_filtered_ones() {
        let wrong = |wrong_frames| Errors {
            unit: LengthUnit::Mm,
            frames: 100,
            mae: 0.02,
            max: 2.6,
            std: 0.1,
            rmse: 0.1,
            p95: 0.1,
            bias: 0.0,
            coverage_2sigma: Some(0.95),
            wrong_frames,
            unavailable_frames: 0,
        };
        let table = |filtered, smoothed| ErrorTable {
            kcf: None,
            filtered: Some(wrong(filtered)),
            smoothed: Some(wrong(smoothed)),
        };
        assert_eq!(trust_of(|run| run.summary.errors = Some(table(0, 0))).0, Trust::Good);
        assert_eq!(trust_of(|run| run.summary.errors = Some(table(0, 3))).0, Trust::Bad);
        assert_eq!(trust_of(|run| run.summary.errors = Some(table(1, 0))).0, Trust::Bad);
    }

    #[test]
    fn a_path_that_leaves_the_tolerance_round_the_truth_is_to_be_checked_and_a_seam_that_wanders_is_not() {
        let wandering = |truth_px: Option<f64>| {
            move |run: &mut Run| {
                run.summary.limits.tolerance_mm = Some(0.3);
                for row in &mut run.rows {
                    // 0.073 mm from frame to frame.
                    (row.u_px, row.v_px) = (Some(row.frame as f64), Some(240.0));
                }
                let truth =
                    |row: &PathRow| truth_px.map(|off_px| row.frame as f64 + if row.frame < 10 { off_px } else { 0.0 });
                run.truth_px = truth_px.map(|_| run.rows.iter().map(truth).collect());
            }
        };
        let (trust, doubts) = trust_of(wandering(Some(5.0)));
        assert!(trust == Trust::Check && doubts[0].contains("±0.3 mm on 10.0 %"), "{doubts:?}");
        assert_eq!(trust_of(wandering(Some(4.0))).0, Trust::Good);
        assert_eq!(trust_of(wandering(None)).0, Trust::Good);
    }

    #[test]
    fn a_recording_without_a_seam_is_bad() {
        let verdict = verdict(&run("ssss", 1.0));
        assert_eq!((verdict.trust, verdict.sentence.as_str()), (Trust::Bad, "No seam was found in 4 frames."));
    }
}
