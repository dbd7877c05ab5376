//! `seamtrack synth` and `seamtrack eval` as a user meets them.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;

fn seamtrack() -> Command {
    Command::cargo_bin("seamtrack").unwrap()
}

#[test]
fn a_recording_holds_frames_truth_and_the_scenario_used() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("rec");
    seamtrack().args(["synth", "recorder", "--frames", "6", "--seed", "9", "-o"]).arg(&out).assert().success();
    assert_eq!(fs::read_dir(out.join("frames")).unwrap().count(), 6);
    assert_eq!(fs::read_to_string(out.join("truth.csv")).unwrap().lines().count(), 7);
    let stamps = fs::read_to_string(out.join("timestamps.csv")).unwrap();
    assert!(stamps.starts_with("#timestamp [ns],filename\n0,frame_000000.png\n"), "{stamps}");
    // The scenario beside the frames renders the same frames again.
    let again = folder.path().join("again");
    seamtrack().arg("synth").arg(out.join("scenario.toml")).arg("-o").arg(&again).assert().success();
    for file in ["truth.csv", "scenario.toml", "timestamps.csv", "frames/frame_000005.png"] {
        assert_eq!(fs::read(out.join(file)).unwrap(), fs::read(again.join(file)).unwrap(), "{file}");
    }
}

#[test]
fn an_existing_folder_is_kept_unless_forced_and_then_only_a_recording_goes() {
    let folder = tempfile::tempdir().unwrap();
    let synth = |more: &[&str]| {
        let mut command = seamtrack();
        command.args(["synth", "flat", "--frames", "1", "-o"]).arg(folder.path().join("rec")).args(more);
        command
    };
    synth(&[]).assert().success();
    synth(&[]).assert().code(1).stderr(contains("--force"));
    synth(&["--force"]).assert().success();
    // What was added or changed since is the user's.
    for file in ["notes.txt", "frames/frame_000000.png", "scenario.toml"] {
        let path = folder.path().join("rec").join(file);
        let before = fs::read(&path).ok();
        fs::write(&path, "mine").unwrap();
        synth(&["--force"]).assert().code(1).stderr(contains(file).and(contains("move it away")));
        assert_eq!(fs::read(&path).unwrap(), b"mine");
        match before {
            Some(bytes) => fs::write(&path, bytes).unwrap(),
            None => fs::remove_file(&path).unwrap(),
        }
    }
    synth(&["--force"]).assert().success();
}

#[test]
fn a_scenario_in_a_project_does_not_make_the_project_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("proj");
    seamtrack().args(["synth", "flat", "--frames", "1", "-o"]).arg(folder.path().join("rec")).assert().success();
    fs::create_dir_all(project.join("src")).unwrap();
    fs::copy(folder.path().join("rec/scenario.toml"), project.join("scenario.toml")).unwrap();
    fs::write(project.join("src/main.py"), "years of work").unwrap();
    let scenario = project.join("scenario.toml");
    for target in [project.clone(), project.join("src/..")] {
        let run = seamtrack().arg("synth").arg(&scenario).arg("-o").arg(target).arg("--force").assert();
        run.code(1).stderr(contains("scenario.toml, which is read"));
    }
    assert_eq!(fs::read_to_string(project.join("src/main.py")).unwrap(), "years of work");
    // Nor does one that came from elsewhere.
    seamtrack().args(["synth", "flat", "--frames", "1", "--force", "-o"]).arg(&project).assert().code(1);
    assert!(project.join("src/main.py").is_file() && scenario.is_file());
}

#[test]
fn the_list_names_every_scene_in_one_line_and_an_unknown_one_is_told_apart() {
    seamtrack().args(["synth", "--list"]).assert().success().stdout(contains("A-butt").and(contains("K-butt-narrow")));
    seamtrack().args(["synth", "Z", "-o", "nowhere"]).assert().code(1).stderr(contains("--list"));
    seamtrack().arg("synth").assert().code(2);
}

#[test]
fn eval_prints_the_errors_of_a_path_against_a_truth() {
    let folder = tempfile::tempdir().unwrap();
    let (path, truth) = (folder.path().join("path.csv"), folder.path().join("truth.csv"));
    fs::write(
        &path,
        "frame,file,time_s,status,kcf_u_px,kcf_v_px,psr,template_updated,u_px,v_px,x_mm,x_std_mm,nis,smooth_u_px,smooth_v_px,smooth_x_mm,smooth_x_std_mm\n\
         0,a.png,0.0,tracked,12,5,9,1,11,5,0,0.2,1,,,,\n\
         1,b.png,0.2,tracked,12,5,9,1,13,5,0.2,0.2,1,,,,\n",
    )
    .unwrap();
    fs::write(&truth, "frame,u_px,v_px,x_mm,occluded\n0,10,5,0,0\n1,12,5,0.2,0\n").unwrap();
    let eval = || {
        let mut command = seamtrack();
        command.arg("eval").args([&path, &truth]);
        command
    };
    eval().assert().code(1).stderr(contains("--mm-per-px"));
    let output = eval().args(["--mm-per-px", "0.1", "--stripe", "horizontal", "--json"]).output().unwrap();
    let table: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!((table["filtered"]["bias_mm"].as_f64().unwrap() - 0.1).abs() < 1e-9);
    assert_eq!(table["filtered"]["coverage_2sigma"], 1.0);
    assert!((table["kcf"]["max_mm"].as_f64().unwrap() - 0.2).abs() < 1e-9);
    assert!(table.get("smoothed").is_none());
}
