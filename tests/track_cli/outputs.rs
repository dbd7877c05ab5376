//! What becomes of the results: kept, replaced only when asked, complete or absent.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use seamtrack::report::results::PathRow;

use crate::program::{demo, demo_frames, line_with, recording, rows, seamtrack, track, tracked};

/// Every file of a folder with its bytes, but for the list of them.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let files = entries.filter(|entry| entry.path().is_file() && entry.file_name() != ".seamtrack.json");
    files.map(|file| (file.file_name().into_string().unwrap(), fs::read(file.path()).unwrap())).collect()
}

#[test]
fn results_are_not_overwritten_without_force() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (recording(folder.path(), 6), folder.path().join("out"));
    tracked(&input, &output);
    for file in ["path.csv", "summary.json", "report.html"] {
        assert!(output.join(file).is_file(), "{file}");
    }
    let before = contents(&output);
    track(&input, &output).assert().code(1).stderr(line_with(&["out", "--force"]));
    assert!(contents(&output) == before);
    track(&input, &output).args(["--force", "--origin", "centre"]).assert().success();
    assert!(contents(&output)["path.csv"] != before["path.csv"]);
    let parts = contents(&output).keys().filter(|name| name.ends_with(".part")).count();
    assert_eq!(parts, 0, "no temporary file stays behind");
}

#[test]
fn the_recording_itself_is_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("mine");
    fs::create_dir_all(&input).unwrap();
    fs::rename(recording(folder.path(), 3), input.join("frames")).unwrap();
    fs::write(input.join("truth.csv"), "frame,u_px\n0,185.6\n1,185.0\n2,184.7\n").unwrap();
    let before = contents(&input);
    for input in [&input, &input.join("frames")] {
        let output = folder.path().join("mine");
        track(input, &output).arg("--force").assert().code(1).stderr(line_with(&["mine", "which is read"]));
    }
    for overlay in [input.clone(), input.join("frames")] {
        let output = folder.path().join("out");
        track(&input, &output)
            .arg("--overlay")
            .arg(&overlay)
            .assert()
            .code(1)
            .stderr(line_with(&["--overlay", "mine"]));
    }
    assert!(contents(&input) == before && fs::read_dir(input.join("frames")).unwrap().count() == 3);
}

#[test]
fn the_truth_beside_the_results_is_that_of_the_last_run() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let run = |more: &[&str]| track(&demo(), &output).args(more).assert().success();
    let truth = demo().join("truth.csv");
    run(&["--truth", truth.to_str().unwrap()]);
    let copy = output.join("truth.csv");
    assert!(fs::read(&copy).unwrap() == fs::read(truth).unwrap());
    run(&["--force", "--truth", copy.to_str().unwrap()]);
    assert!(copy.is_file());
    run(&["--force", "--trace", "--tum"]);
    assert!(!copy.exists(), "a run without a truth is not judged by an earlier one's");
    let trace = fs::read_to_string(output.join("trace.csv")).unwrap();
    let header = "frame,observation,nis,support,residual_px,cost,margin,presence,psr_ratio,measured_px\n";
    assert!(trace.starts_with(header) && trace.lines().count() == 59);
    assert!(fs::read_to_string(output.join("filtered.tum")).unwrap().lines().count() > 50);
}

#[test]
fn an_overlay_folder_holds_one_picture_a_frame() {
    let folder = tempfile::tempdir().unwrap();
    let overlay = folder.path().join("marks");
    track(&recording(folder.path(), 4), &folder.path().join("out")).arg("--overlay").arg(&overlay).assert().success();
    let names: Vec<String> = contents(&overlay).into_keys().collect();
    assert_eq!(names, ["000000.png", "000001.png", "000002.png", "000003.png"]);
}

#[test]
fn an_output_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    let file = folder.path().join("taken");
    fs::write(&file, "mine").unwrap();
    track(&input, &file).assert().code(1).stderr(line_with(&["taken"]));
    track(&input, &file.join("below")).assert().code(1).stderr(line_with(&["taken"]));
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    // Not even an administrator makes folders here.
    if cfg!(target_os = "linux") {
        track(&input, Path::new("/proc/seamtrack")).assert().code(1).stderr(line_with(&["/proc/seamtrack"]));
    }
}

#[test]
fn a_run_that_fails_leaves_the_earlier_results_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (recording(folder.path(), 6), folder.path().join("out"));
    tracked(&input, &output);
    let before = contents(&output);
    let truth = folder.path().join("truth.csv");
    fs::write(&truth, "frame,u_px\n900,1\n").unwrap();
    track(&input, &output).arg("--force").arg("--truth").arg(&truth).assert().code(1);
    track(&folder.path().join("nowhere"), &output).arg("--force").assert().code(1);
    for file in fs::read_dir(&input).unwrap() {
        fs::write(file.unwrap().path(), "no picture").unwrap();
    }
    track(&input, &output).arg("--force").assert().code(1);
    assert!(contents(&output) == before);
}

#[cfg(unix)]
#[test]
fn a_run_that_is_killed_leaves_the_earlier_results_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    tracked(&recording(folder.path(), 6), &output);
    let before = contents(&output);
    // Many times the frames that are done by then.
    let long = folder.path().join("long");
    fs::create_dir(&long).unwrap();
    let frames = demo_frames();
    for i in 0..20_000 {
        std::os::unix::fs::symlink(&frames[i % frames.len()], long.join(format!("{i}.png"))).unwrap();
    }
    let mut running = std::process::Command::new(env!("CARGO_BIN_EXE_seamtrack"))
        .arg("track")
        .arg(&long)
        .arg("-o")
        .arg(&output)
        .args(["--force", "--quiet"])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(500));
    assert!(running.try_wait().unwrap().is_none(), "it is still running");
    running.kill().unwrap();
    running.wait().unwrap();
    assert!(contents(&output) == before);
}

/// A limit on the size of files stands for a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_of_one_line_and_the_earlier_results_stay() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    tracked(&recording(folder.path(), 6), &output);
    let before = contents(&output);
    let script = "trap '' XFSZ; ulimit -f 2; exec \"$@\"";
    let run = assert_cmd::Command::new("sh")
        .args(["-c", script, "sh", env!("CARGO_BIN_EXE_seamtrack"), "track"])
        .arg(demo())
        .arg("-o")
        .arg(&output)
        .args(["--joint", "butt", "--force", "--quiet"])
        .assert();
    run.code(1).stderr(line_with(&["path.csv", "cannot write"]));
    assert!(contents(&output) == before);
}

#[test]
fn a_manifest_of_two_recordings_gives_each_what_it_gets_alone() {
    let folder = tempfile::tempdir().unwrap();
    let short = recording(folder.path(), 20);
    let manifest = folder.path().join("list.csv");
    let truth = demo().join("truth.csv");
    let lines = format!("input,truth\nrecording,\n{},{}\n", demo().display(), truth.display());
    fs::write(&manifest, lines).unwrap();
    let output = folder.path().join("out");
    let all = || {
        let mut command = seamtrack();
        command.arg("track").arg("--manifest").arg(&manifest).arg("-o").arg(&output);
        command.args(["--joint", "butt", "--mm-per-px", "0.073", "--jobs", "2", "--quiet"]);
        command
    };
    all().assert().success();
    for (name, input) in [("recording", &short), ("demo-butt", &demo())] {
        let alone = folder.path().join(format!("{name}-alone"));
        tracked(input, &alone);
        let both = [&output.join(name), &alone].map(|folder| fs::read(folder.join("path.csv")).unwrap());
        assert!(both[0] == both[1], "{name}");
    }
    assert!(crate::program::summary(&output.join("demo-butt"))["errors"]["filtered"].is_object());
    assert!(crate::program::summary(&output.join("recording")).get("errors").is_none());
    let written = fs::metadata(output.join("recording/path.csv")).unwrap().modified().unwrap();
    all().assert().success();
    let now = fs::metadata(output.join("recording/path.csv")).unwrap().modified().unwrap();
    assert_eq!(now, written, "what is finished is not done again");

    // One that fails does not take the other's results.
    fs::write(&manifest, "input\nrecording\nnowhere\n").unwrap();
    fs::remove_dir_all(&output).unwrap();
    all().assert().code(1).stderr(line_with(&["nowhere", "is the path right"]));
    assert!(output.join("recording/path.csv").is_file());
}

#[test]
fn two_recordings_that_would_share_a_folder_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    let mut command = seamtrack();
    command.arg("track").arg(&input).arg(&input).arg("-o").arg(folder.path().join("out"));
    command.assert().code(1).stderr(line_with(&["recording", "one by one"]));
}

#[test]
fn gap_mismatch_and_travel_stand_in_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    track(&recording(folder.path(), 20), &output).args(["--speed", "5"]).assert().success();
    let rows = rows(&output);
    for row in rows.iter().filter(|row| row.gap_px.is_some()) {
        let (gap_px, gap_mm) = (row.gap_px.unwrap(), row.gap_mm.unwrap());
        // In millimetres it is measured along the plates, which may be tilted by some degrees.
        assert!((1.0..1.005).contains(&(gap_mm / (0.073 * gap_px) + 2e-4)) && (5.0..25.0).contains(&gap_px), "{row:?}");
        assert!(row.gap_std_mm.unwrap() < 0.2 && row.hi_lo_std_mm.unwrap() < 0.2, "{row:?}");
        assert!(row.mismatch_px.unwrap().abs() < 6.0, "{row:?}");
    }
    assert!(rows.iter().filter(|row| row.gap_px.is_some()).count() > 10);
    assert!((rows[10].travel_mm.unwrap() - 5.0 * rows[10].time_s).abs() < 1e-9);
}

#[test]
fn a_fixed_lag_lies_between_the_filter_and_the_whole_recording() {
    let folder = tempfile::tempdir().unwrap();
    let input = demo().join("frames");
    let path = |name: &str, arguments: &[&str]| {
        let output = folder.path().join(name);
        track(&input, &output).args(arguments).assert().success();
        rows(&output)
    };
    let (whole, lag) = (path("whole", &[]), path("lag", &["--fixed-lag", "10"]));
    let mean_std = |rows: &[PathRow], std: fn(&PathRow) -> Option<f64>| {
        let values: Vec<f64> = rows.iter().filter_map(std).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    assert_eq!(
        whole.iter().map(|row| row.x_mm).collect::<Vec<_>>(),
        lag.iter().map(|row| row.x_mm).collect::<Vec<_>>()
    );
    assert!(mean_std(&lag, |row| row.smooth_x_std_mm) < mean_std(&lag, |row| row.x_std_mm));
    assert!(lag.iter().zip(&whole).any(|(lag, whole)| lag.smooth_x_mm != whole.smooth_x_mm));
    assert!(lag.iter().filter(|row| row.u_px.is_some()).all(|row| row.smooth_x_mm.is_some()));
    let paper = track(&input, &folder.path().join("paper")).args(["--preset", "paper", "--fixed-lag", "10"]).assert();
    paper.code(1).stderr(line_with(&["fixed lag", "robust"]));
}
