//! `seamtrack meltpool` from recording to results.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use seamtrack::report::pool::{PoolRow, read_pool_csv};
use seamtrack::report::results::Status;
use serde_json::Value;

use super::npy;

pub fn seamtrack() -> Command {
    Command::cargo_bin("seamtrack").unwrap()
}

pub fn meltpool(input: &Path, measure: &str, output: &Path) -> Command {
    let mut command = seamtrack();
    command.arg("meltpool").arg(input).args(["--measure", measure, "--quiet", "-o"]).arg(output);
    command
}

fn recording(folder: &Path, scene: &str, frames: &str) -> PathBuf {
    let recording = folder.join(scene);
    seamtrack().args(["synth", scene, "--frames", frames, "-o"]).arg(&recording).assert().success();
    recording
}

fn rows(output: &Path) -> Vec<PoolRow> {
    read_pool_csv(&output.join("path.csv")).unwrap()
}

fn summary(output: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(output.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn a_recorded_tip_is_followed_better_by_the_filter_and_best_by_the_smoother() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path(), "pool-tip", "120");
    let output = folder.path().join("out");
    let truth = recording.join("truth.csv");
    meltpool(&recording, "tip", &output).arg("--truth").arg(&truth).assert().success();
    let summary = summary(&output);
    let error = |estimate: &str| summary["errors"][estimate]["rmse_mm"].as_f64().unwrap();
    assert!(error("measured") > error("filtered") && error("filtered") > error("smoothed"), "{summary}");
    assert!(error("smoothed") < 0.005, "a pixel is 0.0088 mm: {summary}");
    assert!(summary["errors"]["filtered"]["coverage_2sigma"].as_f64().unwrap() > 0.8, "{summary}");
    let rows = rows(&output);
    assert_eq!(rows.len(), 120);
    let row = &rows[60];
    assert_eq!(row.status, Status::Tracked);
    let expected_mm = (row.filtered_px.unwrap() - 268.0) / 114.0;
    assert!((row.filtered_mm.unwrap() - expected_mm).abs() < 2e-5);
    assert!(fs::read_to_string(output.join("report.html")).unwrap().contains("Offset of the seam"));
}

#[test]
fn a_width_is_given_in_the_users_millimetres_and_the_page_can_be_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path(), "pool-width", "40");
    let output = folder.path().join("out");
    let overlay = folder.path().join("overlay");
    let mut command = meltpool(&recording, "width", &output);
    command.args(["--mm-per-px", "0.02", "--trace", "--overlay"]).arg(&overlay).assert().success();
    let rows = rows(&output);
    let row = &rows[20];
    assert!((row.filtered_mm.unwrap() - 0.02 * row.filtered_px.unwrap()).abs() < 2e-5);
    assert!((1.8..2.3).contains(&row.filtered_mm.unwrap()), "{row:?}");
    let drawn = fs::read_dir(overlay)
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().path().extension().is_some_and(|ending| ending == "png"));
    assert_eq!(drawn.count(), 40);
    let trace = fs::read_to_string(output.join("trace.csv")).unwrap();
    assert!(trace.starts_with("frame,refused,u1_px,v1_px,u2_px,v2_px\n") && trace.lines().count() == 41);
    let page = fs::read(output.join("report.html")).unwrap();
    fs::remove_file(output.join("report.html")).unwrap();
    seamtrack().arg("report").arg(&output).assert().success();
    assert_eq!(fs::read(output.join("report.html")).unwrap(), page);
}

#[test]
fn frames_without_a_pool_and_flooded_ones_get_a_reason_and_no_measure() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path(), "pool-flaws", "200");
    let output = folder.path().join("out");
    meltpool(&recording, "tip", &output).arg("--trace").assert().code(3);
    let rows = rows(&output);
    let hidden = (0..10).chain(60..67).chain(80..83);
    for frame in hidden {
        assert_eq!(rows[frame].measured_px, None, "frame {frame}");
    }
    assert_eq!(rows[5].status, Status::Seeking);
    assert_eq!(rows[81].status, Status::Coasting);
    assert!(rows[81].filtered_std_mm > rows[79].filtered_std_mm);
    let summary = summary(&output);
    assert_eq!(summary["refused"]["saturated"], 3);
    assert!(summary["refused"]["no-pool"].as_u64().unwrap() >= 17);
    assert!(fs::read_to_string(output.join("trace.csv")).unwrap().contains("\n81,saturated,,,,\n"));
}

#[test]
fn a_stack_is_read_in_every_number_type_with_one_stated_scale() {
    let folder = tempfile::tempdir().unwrap();
    let values = npy::discs(30);
    let raised: Vec<f32> = values.iter().map(|value| if *value < 500.0 { 0.0 } else { 1500.0 }).collect();
    let bytes = |of: &dyn Fn(f32) -> Vec<u8>| values.iter().flat_map(|&value| of(value)).collect::<Vec<u8>>();
    let stacks = [
        ("<f4", npy::float32(&values), "floating point"),
        ("<f8", bytes(&|value| f64::from(value).to_le_bytes().to_vec()), "floating point"),
        ("<f2", npy::float16(&raised), "floating point"),
        ("<u2", bytes(&|value| (value as u16).to_le_bytes().to_vec()), "16 bits"),
        (">u2", bytes(&|value| (value as u16).to_be_bytes().to_vec()), "16 bits"),
        ("|u1", bytes(&|value| vec![(value / 8.0) as u8]), "8 bits"),
    ];
    for (descr, data, rule) in stacks {
        let stack = npy::write(&folder.path().join("a.npy"), descr, false, "(30, 32, 40)", &data);
        let output = folder.path().join("out");
        meltpool(&stack, "width", &output).arg("--force").assert().success();
        let widths: Vec<f64> = rows(&output).iter().filter_map(|row| row.measured_px).collect();
        assert_eq!(widths.len(), 30, "{descr}");
        assert!(widths.iter().all(|width| (15.5..18.0).contains(width)), "{descr} {widths:?}");
        let summary = summary(&output);
        assert!(summary["input"]["scale"]["rule"].as_str().unwrap().starts_with(rule), "{summary}");
    }
}

#[test]
fn results_are_the_same_on_one_thread_and_on_many_and_are_kept_without_force() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path(), "pool-tip-plume", "40");
    let run = |name: &str, threads: &str| {
        let output = folder.path().join(name);
        let mut command = meltpool(&recording, "tip", &output);
        command.args(["--travel", "left", "--max-unavailable", "100"]).env("RAYON_NUM_THREADS", threads);
        command.env("OMP_NUM_THREADS", threads).env("OPENCV_FOR_THREADS_NUM", threads).assert().success();
        fs::read(output.join("path.csv")).unwrap()
    };
    assert_eq!(run("one", "1"), run("many", "7"));
    let refused = meltpool(&recording, "tip", &folder.path().join("one")).assert().code(1);
    let message = String::from_utf8(refused.get_output().stderr.clone()).unwrap();
    assert!(message.contains("already holds results") && message.lines().count() == 1, "{message}");
}

#[test]
fn several_recordings_get_a_folder_each() {
    let folder = tempfile::tempdir().unwrap();
    let data = npy::float32(&npy::discs(20));
    let stacks =
        ["a.npy", "b.npy"].map(|name| npy::write(&folder.path().join(name), "<f4", false, "(20, 32, 40)", &data));
    let output = folder.path().join("out");
    seamtrack().arg("meltpool").args(&stacks).args(["--measure", "width", "-q", "-o"]).arg(&output).assert().success();
    assert_eq!(fs::read(output.join("a/path.csv")).unwrap().len(), fs::read(output.join("b/path.csv")).unwrap().len());
}
