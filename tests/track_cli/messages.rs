//! What is said: which recording, why, and not more than a person reads.

use std::fs;

use predicates::prelude::*;
use predicates::str::contains;

use crate::program::{demo, line_with, name, recording, rows, seamtrack, track};

#[test]
fn a_frame_that_cannot_be_read_is_named_with_its_recording_and_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 20);
    fs::write(input.join(name(5)), b"no picture").unwrap();
    let said = line_with(&["recording: frame 5: 005.png cannot be decoded", "signature"]);
    track(&input, &folder.path().join("out")).args(["--max-unavailable", "50"]).assert().success().stderr(said);
}

#[test]
fn four_hundred_broken_frames_take_nine_lines() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 10);
    for frame in 10..410 {
        fs::write(input.join(name(frame)), b"").unwrap();
    }
    let run = track(&input, &folder.path().join("out")).assert().code(3);
    let stderr = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    assert_eq!(stderr.lines().count(), 9, "{stderr}");
    assert!(stderr.lines().last().unwrap().contains("recording: 392 more frames could not be read"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn control_characters_of_names_do_not_reach_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("a\u{1b}[31m\u{7}\nb\u{202e}");
    fs::rename(recording(folder.path(), 3), &input).unwrap();
    fs::write(input.join("1\u{1b}]0;title\u{7}.png"), b"").unwrap();
    let output = folder.path().join("out\u{1b}[2J");
    let run = |more: &[&str]| {
        let mut run = seamtrack();
        run.arg("track")
            .arg(&input)
            .arg("-o")
            .arg(&output)
            .args(["--joint", "butt", "--max-unavailable", "50"])
            .args(more);
        let run = run.output().unwrap();
        [run.stdout, run.stderr].concat()
    };
    for said in [run(&[]), run(&[]), run(&["--truth", "no\u{1b}[2Jtruth.csv", "--force"])] {
        let text = String::from_utf8(said).unwrap();
        assert!(
            !text.is_empty() && !text.chars().any(|c| (c.is_control() && c != '\n') || c == '\u{202e}'),
            "{text:?}"
        );
    }
    let mut compare = seamtrack();
    compare.arg("compare").args([&output, &output]).arg("-o").arg(folder.path().join("page.html"));
    let said = compare.assert().success().get_output().stdout.clone();
    assert!(!String::from_utf8(said).unwrap().contains('\u{1b}'));
}

#[test]
fn a_message_is_bounded_whatever_the_file_holds() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    let bounded = |text: &str| text.len() < 4000 && text.lines().count() == 1;
    fs::write(input.join("timestamps.csv"), "x".repeat(200_000)).unwrap();
    let run = track(&input, &folder.path().join("out")).assert().code(1);
    run.stderr(contains("timestamps.csv").and(predicate::function(bounded)));
    fs::remove_file(input.join("timestamps.csv")).unwrap();
    let truth = folder.path().join("truth.csv");
    fs::write(&truth, format!("frame,u_px\n0,{}\n", "y".repeat(200_000))).unwrap();
    let run = track(&input, &folder.path().join("out")).arg("--truth").arg(&truth).assert().code(1);
    run.stderr(contains("truth.csv").and(predicate::function(bounded)));
}

#[test]
fn a_truth_of_a_part_of_the_frames_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let truth = folder.path().join("short.csv");
    let text = fs::read_to_string(demo().join("truth.csv")).unwrap();
    fs::write(&truth, text.lines().take(21).collect::<Vec<_>>().join("\n")).unwrap();
    let run = track(&demo(), &folder.path().join("out")).arg("--truth").arg(&truth).assert().success();
    run.stderr(line_with(&["short.csv has lines for 20 of the 58 frames"]));
}

#[test]
fn a_manifest_may_use_semicolons_a_byte_order_mark_and_the_layout_of_made_up_recordings() {
    let folder = tempfile::tempdir().unwrap();
    for rec in ["r1", "r2"] {
        fs::create_dir(folder.path().join(rec)).unwrap();
        fs::rename(recording(folder.path(), 3), folder.path().join(rec).join("frames")).unwrap();
    }
    fs::write(folder.path().join("r1/truth.csv"), "frame,u_px\n0,185.6\n1,185.0\n2,184.7\n").unwrap();
    let manifest = folder.path().join("list.csv");
    for (n, text) in [
        "input,truth\nr1/frames,r1/truth.csv\nr2/frames\n",
        "\u{feff}input;truth\r\nr1/frames;r1/truth.csv\r\nr2/frames;\r\n",
    ]
    .into_iter()
    .enumerate()
    {
        fs::write(&manifest, text).unwrap();
        let output = folder.path().join(n.to_string());
        let mut run = seamtrack();
        run.arg("track").arg("--manifest").arg(&manifest).arg("-o").arg(&output).args(["--joint", "butt", "--quiet"]);
        run.assert().success();
        assert!(rows(&output.join("r1")).len() == 3 && rows(&output.join("r2")).len() == 3);
        assert!(output.join("r1/truth.csv").is_file() && !output.join("r2/truth.csv").exists());
    }
}

#[test]
fn thousands_of_recordings_in_a_manifest_are_looked_through_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("list.csv");
    let lines: String = (0..20_000).map(|i| format!("r{i}\n")).collect();
    // The last is the first again: found before anything is tracked.
    fs::write(&manifest, format!("input\n{lines}r0\n")).unwrap();
    let mut run = seamtrack();
    run.arg("track").arg("--manifest").arg(&manifest).arg("-o").arg(folder.path().join("out"));
    run.assert().code(1).stderr(line_with(&["r0", "one by one"]));
}

#[test]
fn words_that_mean_what_the_program_means_are_understood() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    track(&recording(folder.path(), 3), &output).args(["--origin", "center"]).assert().success();
    let truth = folder.path().join("truth.csv");
    fs::write(&truth, "frame,u_px\n0,185.6\n1,185.0\n2,184.7\n").unwrap();
    seamtrack().arg("eval").args([&output, &truth]).assert().success().stdout(contains("filtered"));
}
