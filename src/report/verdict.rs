//! Whether to trust the path, in one sentence.

use super::results::Estimator;
use super::run::Run;

/// `--max-unavailable` when the summary does not say \[%\]: the contract's default.
const MAX_UNAVAILABLE_PCT: f64 = 5.0;
/// Above this share of coasting frames a person should look \[%\]: chosen, the same as for unavailable ones.
const MAX_COASTING_PCT: f64 = 5.0;
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

fn doubts(run: &Run) -> (Trust, Vec<String>) {
    let unavailable = run.unavailable();
    let limit_pct = run.summary.limits.max_unavailable_pct.unwrap_or(MAX_UNAVAILABLE_PCT);
    let coasting_pct = 100.0 * run.summary.frames.coasting as f64 / run.summary.frames.total.max(1) as f64;
    let wrong = run.summary.errors.as_ref().and_then(|errors| errors.filtered).map_or(0, |e| e.wrong_frames);
    let mut found: Vec<(Trust, String)> = Vec::new();
    if unavailable.missing > 0 {
        let trust = if unavailable.percent() > limit_pct { Trust::Bad } else { Trust::Check };
        let percent = unavailable.percent();
        found.push((trust, format!("No value on {percent:.1} % of the frames (limit {limit_pct} %).")));
    }
    if wrong > 0 {
        found.push((Trust::Bad, format!("{wrong} values claim to be valid and are off by over 1 mm.")));
    }
    if coasting_pct > MAX_COASTING_PCT {
        found.push((Trust::Check, format!("{coasting_pct:.1} % of the frames are predictions only.")));
    }
    if let Some(consistency) = consistency(run)
        && consistency.below_95_pct < MIN_CONSISTENT_PCT
    {
        let trust = if consistency.below_95_pct < MIN_USABLE_PCT { Trust::Bad } else { Trust::Check };
        let percent = 100.0 - consistency.below_95_pct;
        found.push((trust, format!("{percent:.0} % of the measurements contradict the filter, 5 % expected.")));
    }
    let worst = found.iter().map(|&(trust, _)| trust).max().unwrap_or(Trust::Good);
    (worst, found.into_iter().map(|(_, doubt)| doubt).collect())
}

fn facts(run: &Run) -> Vec<String> {
    let summary = &run.summary;
    let mut facts = Vec::new();
    if let Some(errors) = &summary.errors {
        for estimator in [Estimator::Filtered, Estimator::Smoothed] {
            if let Some(e) = errors.of(estimator) {
                let name = estimator.name();
                facts.push(format!("Error {name}: mean {:.3} mm, maximum {:.3} mm.", e.mae_mm, e.max_mm));
            }
        }
    }
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
    let calibration = &summary.calibration;
    facts.push(format!(
        "{} mm/px ({}), {} stripe.",
        calibration.mm_per_px.get(),
        calibration.source,
        calibration.stripe
    ));
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
    use crate::report::results::{PathRow, Status};
    use crate::report::summary::{
        Calibration, FrameCounts, Input, Joint, Limits, Percentiles, SCHEMA_VERSION, Summary, Timing,
    };
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
            thumbnails: Vec::new(),
            summary: Summary {
                schema_version: SCHEMA_VERSION,
                program: String::new(),
                input: Input { path: String::new(), width_px: 1, height_px: 1, more: serde_json::Map::new() },
                config: serde_json::Value::Null,
                calibration: Calibration {
                    mm_per_px: MmPerPx::DU_2022,
                    stripe: StripeAxis::Horizontal,
                    origin_px: None,
                    source: "default".into(),
                    more: serde_json::Map::new(),
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
                joint: Joint { kind: "butt".into(), decided_at_frame: None, reason: String::new(), later: vec![] },
                timing: Timing { decode_ms: none, track_ms: none, frames_per_second: 0.0 },
                errors: None,
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

    #[test]
    fn a_recording_without_a_seam_is_bad() {
        let verdict = verdict(&run("ssss", 1.0));
        assert_eq!((verdict.trust, verdict.sentence.as_str()), (Trust::Bad, "No seam was found in 4 frames."));
    }
}
