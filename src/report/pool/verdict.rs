//! Whether to trust a melt pool's series: one rule for badge, first sentence and exit code.

use super::results::PoolRow;
use super::summary::PoolSummary;
use crate::report::verdict::Trust;

/// Above this share of frames a person should look \[%\]: chosen, the same as for a seam.
const MAX_DOUBTFUL_PCT: f64 = 5.0;

/// The verdict on a melt pool's run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PoolVerdict {
    /// How far the series can be trusted.
    pub trust: Trust,
    /// The frames in one sentence.
    pub sentence: String,
    /// What speaks against trust, each with what to change.
    pub doubts: Vec<String>,
}

/// Judge a run by its summary and rows.
#[must_use]
pub fn pool_verdict(summary: &PoolSummary, rows: &[PoolRow]) -> PoolVerdict {
    let frames = &summary.frames;
    let total = frames.total.max(1);
    let percent = |count: usize| 100.0 * count as f64 / total as f64;
    let unfiltered = rows.iter().filter(|row| row.filtered_px.is_none());
    // The filter begins with two measures: those frames have a value, but none of its.
    let (began, without_value) = unfiltered.fold((0, 0), |(began, without), row| match row.measured_px {
        Some(_) => (began + 1, without),
        None => (began, without + 1),
    });
    let mut sentence = format!(
        "Measured in {} of {} frames, predicted in {}, no value in {without_value}",
        frames.tracked, frames.total, frames.coasting
    );
    if began > 0 {
        sentence += &format!("; {began} measured without the filter");
    }
    sentence.push('.');
    let mut found: Vec<(Trust, String)> = vec![];
    let limit = summary.max_unavailable_pct;
    let grave = |count: usize| if percent(count) > limit { Trust::Bad } else { Trust::Check };
    let at_border: usize =
        summary.refused.iter().filter(|(reason, _)| reason.starts_with("border")).map(|(_, count)| count).sum();
    if percent(at_border) > MAX_DOUBTFUL_PCT {
        let text = format!(
            "The picture cuts the pool on {at_border} frames: record a larger part of the sensor, or move it over the pool."
        );
        found.push((grave(without_value), text));
    }
    if percent(without_value) > limit.min(MAX_DOUBTFUL_PCT) {
        found.push((
            grave(without_value),
            format!("No value on {:.1} % of the frames (limit {limit} %).", percent(without_value)),
        ));
    }
    if percent(frames.coasting) > MAX_DOUBTFUL_PCT {
        found.push((Trust::Check, format!("{:.1} % of the frames are predictions only.", percent(frames.coasting))));
    }
    let is_width = summary.config.get("measure").and_then(|value| value.as_str()) == Some("width");
    let negative = rows.iter().filter(|row| row.filtered_px.is_some_and(|px| px < 0.0)).count();
    if is_width && negative > 0 {
        let text = format!(
            "The filtered width is below 0 on {negative} frames: the pool comes and goes there; use what is measured."
        );
        found.push((Trust::Bad, text));
    }
    if summary.calibration.assumed {
        let text = "Millimetres are by the scale of the infrared paper, which is not this sensor's: give --mm-per-px.";
        found.push((Trust::Check, text.into()));
    }
    let trust = found.iter().map(|&(trust, _)| trust).max().unwrap_or(Trust::Good);
    PoolVerdict { trust, sentence, doubts: found.into_iter().map(|(_, doubt)| doubt).collect() }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::report::pool::{PoolCalibration, PoolInput, SENSOR};
    use crate::report::results::Status;
    use crate::report::summary::{FrameCounts, Percentiles, SCHEMA_VERSION, Timing};
    use crate::units::MmPerPx;

    fn judged(change: impl Fn(&mut PoolSummary, &mut Vec<PoolRow>)) -> PoolVerdict {
        let none = Percentiles::default();
        let row = |frame| PoolRow {
            frame,
            file: String::new(),
            time_s: 0.0,
            status: Status::Tracked,
            measured_px: Some(5.0),
            filtered_px: Some(5.0),
            filtered_mm: Some(5.0),
            filtered_std_mm: Some(0.1),
            nis: None,
            smooth_px: None,
            smooth_mm: None,
            smooth_std_mm: None,
        };
        let mut rows: Vec<PoolRow> = (0..100).map(row).collect();
        let mut summary = PoolSummary {
            schema_version: SCHEMA_VERSION,
            program: String::new(),
            sensor: SENSOR.into(),
            input: PoolInput {
                path: String::new(),
                width_px: 1,
                height_px: 1,
                kind: String::new(),
                scale: serde_json::Value::Null,
            },
            config: serde_json::json!({ "measure": "width" }),
            calibration: PoolCalibration { mm_per_px: MmPerPx::INFRARED, zero_px: 0.0, assumed: false },
            noise: serde_json::Value::Null,
            frames: FrameCounts { total: 100, tracked: 100, ..FrameCounts::default() },
            refused: BTreeMap::new(),
            max_unavailable_pct: 5.0,
            timing: Timing { decode_ms: none, track_ms: none, frames_per_second: 0.0 },
            errors: None,
        };
        change(&mut summary, &mut rows);
        pool_verdict(&summary, &rows)
    }

    #[test]
    fn a_pool_measured_everywhere_is_good_and_the_sentence_counts() {
        let verdict = judged(|_, _| ());
        let sentence = "Measured in 100 of 100 frames, predicted in 0, no value in 0.";
        assert_eq!((verdict.trust, verdict.sentence.as_str(), verdict.doubts.len()), (Trust::Good, sentence, 0));
    }

    #[test]
    fn a_picture_that_cuts_the_pool_says_so_first_and_what_to_change() {
        let verdict = judged(|summary, rows| {
            summary.refused.insert("border-side".into(), 60);
            rows.iter_mut().take(60).for_each(|row| (row.measured_px, row.filtered_px) = (None, None));
        });
        assert!(verdict.trust == Trust::Bad && verdict.doubts[0].starts_with("The picture cuts the pool on 60 frames"));
    }

    #[test]
    fn a_width_below_zero_is_bad_and_a_scale_that_nobody_gave_is_to_be_checked() {
        assert_eq!(judged(|_, rows| rows[7].filtered_px = Some(-0.5)).trust, Trust::Bad);
        assert_eq!(judged(|summary, _| summary.calibration.assumed = true).trust, Trust::Check);
        assert_eq!(judged(|summary, _| summary.frames.coasting = 6).trust, Trust::Check);
        let late = judged(|_, rows| {
            rows.iter_mut().take(20).for_each(|row| (row.measured_px, row.filtered_px) = (None, None))
        });
        assert_eq!(late.trust, Trust::Bad, "frames before the first value count");
        let begins = judged(|_, rows| rows.iter_mut().take(20).for_each(|row| row.filtered_px = None));
        assert!(
            begins.trust == Trust::Good && begins.sentence.ends_with("no value in 0; 20 measured without the filter.")
        );
    }
}
