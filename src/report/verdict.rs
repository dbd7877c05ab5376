//! Whether to trust the path, in one sentence.

use super::facts::{Consistency, consistency, facts};
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
    if unavailable.of == 0 {
        let values = run.rows.iter().filter(|row| row.has_value()).count();
        return vec![(Trust::Bad, format!("{values} values, and the truth has a seam in no frame."))];
    }
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

#[cfg(test)]
mod tests;
