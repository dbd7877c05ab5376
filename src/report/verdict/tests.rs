//! The rule, case by case.

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
    let table =
        |filtered, smoothed| ErrorTable { kcf: None, filtered: Some(wrong(filtered)), smoothed: Some(wrong(smoothed)) };
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
