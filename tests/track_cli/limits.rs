//! Nothing from outside hangs the program, makes it panic, or takes its memory.

use std::fs;
use std::path::Path;
use std::time::Duration;

use predicates::str::contains;

use crate::program::{demo, line_with, recording, rows, seamtrack, track, without_scale};

/// Long beyond what a sound run takes; a run that hangs ends here.
const PATIENCE: Duration = Duration::from_secs(120);

fn numpy(path: &Path, header: &str) {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    fs::write(path, bytes).unwrap();
}

#[test]
fn brackets_within_brackets_do_not_hang_the_reader_of_a_numpy_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.npy");
    for bracket in ["(", "[", "{", "([{"] {
        numpy(&path, &format!("{{'descr': {}", bracket.repeat(60)));
        let mut run = seamtrack();
        run.args(["meltpool", "--measure", "tip", "-o"]).arg(folder.path().join("out")).arg(&path).timeout(PATIENCE);
        run.assert().code(1).stderr(line_with(&["deep.npy", "brackets"]));
    }
    let mut long = b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec();
    long.resize(9000, b' ');
    fs::write(&path, long).unwrap();
    let mut run = seamtrack();
    run.args(["meltpool", "--measure", "tip", "-o"]).arg(folder.path().join("out")).arg(&path).timeout(PATIENCE);
    run.assert().code(1).stderr(line_with(&["deep.npy", "header is longer"]));
}

#[test]
fn a_picture_with_a_side_that_no_camera_has_is_refused_before_it_is_used() {
    let folder = tempfile::tempdir().unwrap();
    for (width, height) in [(1_000_000, 1), (1, 100_000), (16_385, 2)] {
        let path = folder.path().join(format!("{width}x{height}.png"));
        image::GrayImage::from_pixel(width, height, image::Luma([9])).save(&path).unwrap();
        let run = track(&path, &folder.path().join("out")).timeout(PATIENCE).assert();
        run.code(1).stderr(contains(format!("{width} x {height} pixels")).and(contains("16384 a side")));
    }
}

use predicates::prelude::PredicateBooleanExt;

#[test]
fn options_at_their_extremes_are_taken_or_refused_and_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 8);
    let cases: [&[&str]; 7] = [
        &["--fixed-lag", "18446744073709551615"],
        &["--fixed-lag", "0"],
        &["--jobs", "65535"],
        &["--speed", "1e308"],
        &["--mm-per-px", "1e-300"],
        &["--mm-per-px", "-1"],
        &["--period", "3600"],
    ];
    for (n, case) in cases.into_iter().enumerate() {
        let run =
            without_scale(&input, &folder.path().join(n.to_string())).args(case).timeout(PATIENCE).output().unwrap();
        let stderr = String::from_utf8_lossy(&run.stderr);
        assert!(matches!(run.status.code(), Some(0..=3)) && !stderr.contains("panicked"), "{case:?}: {stderr}");
        assert!(!stderr.contains("tip:"), "{case:?}: {stderr}");
        assert!(n > 0 || (run.status.code() == Some(1) && stderr.contains("at most 1000 frames")), "{stderr}");
    }
    assert_eq!(rows(&folder.path().join("1")).len(), 8);
}

#[test]
fn more_jobs_than_recordings_are_as_quick_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = seamtrack();
    run.arg("track").arg(demo()).arg(recording(folder.path(), 3)).arg("-o").arg(folder.path().join("out"));
    run.args(["--jobs", "65535", "--quiet"]).timeout(PATIENCE).assert().success();
}

/// `/dev/full` takes nothing, as a full disk does.
#[cfg(target_os = "linux")]
#[test]
fn full_or_closed_standard_streams_lose_no_results_and_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 6);
    fs::write(input.join("003.png"), "no picture").unwrap();
    for (n, streams) in
        [">/dev/full", "2>/dev/full", ">/dev/full 2>&1", ">&-", "2>&-", ">&- 2>&-"].into_iter().enumerate()
    {
        let output = folder.path().join(n.to_string());
        let script = format!("\"$0\" track \"$1\" -o \"$2\" --joint butt --max-unavailable 50 {streams}");
        let run = std::process::Command::new("sh")
            .args(["-c", &script, env!("CARGO_BIN_EXE_seamtrack")])
            .args([&input, &output])
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&run.stderr);
        let expected = i32::from(streams.starts_with(">/dev/full"));
        assert!(run.status.code() == Some(expected) && !stderr.contains("panicked"), "{streams}: {stderr}");
        assert_eq!((rows(&output).len(), output.join("report.html").is_file()), (6, true), "{streams}");
        if streams == ">/dev/full" {
            assert!(stderr.contains("the results are written") && stderr.lines().count() == 2, "{stderr}");
        }
    }
    for command in ["synth --list", "config --print", "reproduce infrared", "--help"] {
        let script = format!("\"$0\" {command} >/dev/full");
        let run =
            std::process::Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_seamtrack")]).output().unwrap();
        assert!(!String::from_utf8_lossy(&run.stderr).contains("panicked"), "{command}");
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_leaves_after_one_line_ends_no_batch() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = folder.path().join("recs");
    fs::create_dir(&inputs).unwrap();
    for n in 0..4 {
        fs::rename(recording(folder.path(), 3), inputs.join(n.to_string())).unwrap();
    }
    let script = "( \"$0\" track \"$1\"/* -o \"$2\" --joint butt; echo status $? >&2 ) | head -1";
    let run = std::process::Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_seamtrack")])
        .args([&inputs, &folder.path().join("out")])
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&run.stderr), "status 0\n");
    for n in 0..4 {
        assert_eq!(rows(&folder.path().join("out").join(n.to_string())).len(), 3);
    }
}
