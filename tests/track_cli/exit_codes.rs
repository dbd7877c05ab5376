//! 0 done, 1 error, 2 usage, 3 done but the seam was unavailable too often.

use std::fs;

use image::GrayImage;
use predicates::str::contains;

use crate::program::{line_with, name, recording, rows, seamtrack, summary, track};

#[test]
fn a_path_that_does_not_exist_is_an_error_of_one_line() {
    let folder = tempfile::tempdir().unwrap();
    track(&folder.path().join("nowhere"), &folder.path().join("out"))
        .assert()
        .code(1)
        .stderr(line_with(&["nowhere", "is the path right"]));
}

#[test]
fn a_command_line_that_says_nothing_sensible_is_a_usage_error() {
    let cases: [&[&str]; 9] = [
        &[],
        &["track"],
        &["track", "x", "--preset", "nonsense"],
        &["track", "x", "--jobs", "0"],
        &["track", "x", "--seed-at", "12"],
        &["track", "x", "--mm-per-px", "-1"],
        &["track", "x", "--origin", "nan"],
        &["track", "x", "--max-unavailable", "nan"],
        &["follow", "x"],
    ];
    for arguments in cases {
        seamtrack().args(arguments).assert().code(2).stderr(contains("--help"));
    }
}

#[test]
fn a_seed_outside_the_frames_is_an_error_of_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    for seed in ["400,90", "180,240", "1e300,90", "nan,90", "-1,90"] {
        for preset in ["robust", "paper"] {
            let seed = format!("--seed-at={seed}");
            let output = folder.path().join("out");
            let run = track(&input, &output).args(["--preset", preset, &seed]).assert();
            run.code(1).stderr(line_with(&["a point of the image"]));
            assert!(!output.join("path.csv").exists());
        }
    }
    track(&input, &folder.path().join("out")).args(["--seed-at", "185.5,90.7"]).assert().success();
}

/// As in `seamtrack synth --list | head -1`.
#[cfg(unix)]
#[test]
fn a_reader_that_has_seen_enough_ends_the_program_without_a_panic() {
    for arguments in ["synth --list", "config --print", "reproduce infrared"] {
        let script = format!("( \"$0\" {arguments}; echo status $? >&2 ) | true");
        let run = assert_cmd::Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_seamtrack")]).assert();
        let stderr = String::from_utf8(run.get_output().stderr.clone()).unwrap();
        assert_eq!(stderr, "status 0\n", "{arguments}");
    }
}

#[test]
fn black_frames_are_a_finished_run_without_a_seam() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("black");
    fs::create_dir(&input).unwrap();
    for i in 0..8 {
        GrayImage::new(320, 240).save(input.join(name(i))).unwrap();
    }
    for preset in ["robust", "paper"] {
        let output = folder.path().join(preset);
        track(&input, &output).args(["--preset", preset]).assert().code(3);
        let rows = rows(&output);
        assert!(rows.len() == 8 && rows.iter().all(|row| row.u_px.is_none() && row.kcf_u_px.is_none()));
        assert_eq!(summary(&output)["frames"]["seeking"], 8);
    }
}

#[test]
fn one_unreadable_frame_is_too_many_where_none_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 12);
    fs::write(input.join(name(6)), b"no picture").unwrap();
    let with_limit = |percent: &str| {
        let output = folder.path().join(percent);
        track(&input, &output).args(["--max-unavailable", percent]).assert()
    };
    with_limit("0").code(3);
    with_limit("5").code(3);
    with_limit("10").success();
}
