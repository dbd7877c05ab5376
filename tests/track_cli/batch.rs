//! Many recordings: an index of all, names that differ, a broken one among a hundred, and going on after a kill.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use predicates::prelude::*;

use crate::program::{demo, demo_frames, line_with, seamtrack, untimed};
use crate::users_files::tree;

/// A folder `name` of links to the demonstration's first `count` frames.
fn linked(folder: &Path, name: &str, count: usize) -> PathBuf {
    let recording = folder.join(name);
    fs::create_dir_all(&recording).unwrap();
    for (i, file) in demo_frames().iter().take(count).enumerate() {
        std::os::unix::fs::symlink(file, recording.join(format!("{i:03}.png"))).unwrap();
    }
    recording
}

fn batch(manifest: &Path, output: &Path) -> assert_cmd::Command {
    let mut command = seamtrack();
    command.arg("track").arg("--manifest").arg(manifest).arg("-o").arg(output).args(["--joint", "butt", "--jobs", "2"]);
    command
}

/// Every file below `folder` with its bytes, without what tells how long things took: `timing` of a summary, the page that
/// shows it, and the check sums of both.
fn results(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let kept = |(path, bytes): (PathBuf, Vec<u8>)| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let place = path.strip_prefix(folder).unwrap().to_owned();
        match name.as_str() {
            "summary.json" => Some((place, untimed(&bytes).into_bytes())),
            "report.html" | ".seamtrack.json" => None,
            _ => Some((place, bytes)),
        }
    };
    tree(folder).into_iter().filter_map(kept).collect()
}

#[test]
fn a_hundred_recordings_with_a_broken_one_killed_at_any_moment_go_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("list.csv");
    let mut lines = String::from("input\n");
    for i in 0..100 {
        let name = format!("r{i}");
        if i == 37 {
            fs::create_dir(folder.path().join(&name)).unwrap();
            fs::write(folder.path().join(&name).join("000.png"), "no picture").unwrap();
        } else {
            linked(folder.path(), &name, 3);
        }
        lines += &format!("{name}\n");
    }
    fs::write(&manifest, lines).unwrap();
    let whole = folder.path().join("whole");
    let began = Instant::now();
    let run = batch(&manifest, &whole).args(["--max-unavailable", "100"]).assert().code(1);
    let took = began.elapsed();
    let stderr = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    let told: Vec<&str> = stderr.lines().filter(|line| !line.contains("frame 0: 000.png")).collect();
    assert!(told.len() == 1 && told[0].contains("r37"), "one line for the broken one: {stderr}");
    let stdout = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
    assert!(stdout.lines().count() == 100 && stdout.contains("99 of 100 recordings have results"), "{stdout}");
    let undisturbed = results(&whole);
    assert_eq!(undisturbed.keys().filter(|file| file.ends_with("path.csv")).count(), 99);
    let table = String::from_utf8(undisturbed[Path::new("batch.csv")].clone()).unwrap();
    assert!(
        table.lines().count() == 101 && table.lines().nth(1).unwrap().starts_with("r37,"),
        "the gravest comes first"
    );

    let output = folder.path().join("resumed");
    // Moments that no two runs share.
    let noise = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().subsec_nanos();
    for kill in 0..4_u32 {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_seamtrack"));
        command.arg("track").arg("--manifest").arg(&manifest).arg("-o").arg(&output);
        command.args(["--joint", "butt", "--jobs", "2", "--quiet", "--max-unavailable", "100"]);
        let mut running = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(took * (noise.rotate_left(7 * kill) % 200) / 1000);
        let signal = if kill % 2 == 0 { "-KILL" } else { "-INT" };
        let _ = std::process::Command::new("kill").args([signal, &running.id().to_string()]).status().unwrap();
        running.wait().unwrap();
    }
    let stamp = |file: &Path| fs::metadata(file).unwrap().modified().unwrap();
    let done: Vec<PathBuf> =
        (0..100).map(|i| output.join(format!("r{i}/path.csv"))).filter(|file| file.exists()).collect();
    let before: Vec<_> = done.iter().map(|file| stamp(file)).collect();
    std::thread::sleep(Duration::from_millis(20));
    batch(&manifest, &output).args(["--max-unavailable", "100"]).assert().code(1);
    assert!(done.iter().map(|file| stamp(file)).eq(before), "what was finished is not done again");
    let resumed = results(&output);
    assert!(undisturbed.keys().eq(resumed.keys()));
    for (file, bytes) in &undisturbed {
        assert!(resumed[file] == *bytes, "{}", file.display());
    }
}

#[test]
fn recordings_of_one_name_are_told_apart_by_their_folders() {
    let folder = tempfile::tempdir().unwrap();
    linked(folder.path(), "mon/a", 3);
    linked(folder.path(), "tue/a", 4);
    linked(folder.path(), "tue/b/frames", 3);
    let manifest = folder.path().join("list.csv");
    fs::write(&manifest, "input;truth\nmon/a;\ntue/a;\ntue/b/frames;\n").unwrap();
    let output = folder.path().join("out");
    batch(&manifest, &output).args(["--max-unavailable", "100"]).assert().success();
    for (name, frames) in [("mon-a", 3), ("tue-a", 4), ("b", 3)] {
        let path = fs::read_to_string(output.join(name).join("path.csv")).unwrap();
        assert_eq!(path.lines().count(), frames + 1, "{name}");
    }
    let page = fs::read_to_string(output.join("index.html")).unwrap();
    assert!(page.contains("href=\"mon-a/report.html\"") && page.contains("3 recordings"));
}

#[test]
fn results_made_otherwise_are_not_taken_for_finished_ones() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (linked(folder.path(), "a", 3), linked(folder.path(), "b", 3));
    let output = folder.path().join("out");
    let run = |more: &[&str]| {
        let mut command = seamtrack();
        command.arg("track").arg(&a).arg(&b).arg("-o").arg(&output).args(["--joint", "butt"]).args(more);
        command.assert()
    };
    run(&[]).success();
    run(&[]).success().stdout(predicate::str::contains("(as it was)").count(2));
    run(&["--mm-per-px", "0.05"]).code(1).stderr(line_with(&["already holds results", "--force"]));
    run(&["--mm-per-px", "0.05", "--force"]).success();
    // Another frame, and a file that was changed.
    linked(folder.path(), "more", 4);
    fs::rename(folder.path().join("more/003.png"), b.join("003.png")).unwrap();
    run(&["--mm-per-px", "0.05"]).code(1).stderr(line_with(&["out/b", "already holds results"]));
}

#[test]
fn an_index_of_the_users_own_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (linked(folder.path(), "a", 3), linked(folder.path(), "b", 3));
    let output = folder.path().join("out");
    fs::create_dir(&output).unwrap();
    fs::write(output.join("index.html"), "mine").unwrap();
    let mut run = seamtrack();
    run.arg("track").arg(a).arg(b).arg("-o").arg(&output);
    run.assert().code(1).stderr(line_with(&["index.html", "move it away"]));
    assert_eq!(fs::read_dir(&output).unwrap().count(), 1);
}

#[test]
fn a_truth_beside_the_frames_is_hinted_at() {
    let folder = tempfile::tempdir().unwrap();
    for input in [demo(), demo().join("frames")] {
        let mut run = seamtrack();
        run.arg("track").arg(&input).arg("-o").arg(folder.path().join("out")).args(["--force", "--joint", "butt"]);
        run.assert().success().stderr(line_with(&["--truth", "demo-butt/truth.csv"]));
    }
}

#[test]
fn batches_of_methods_stand_in_one_table_over_their_recordings() {
    let folder = tempfile::tempdir().unwrap();
    linked(folder.path(), "a", 8);
    linked(folder.path(), "b", 9);
    let manifest = folder.path().join("list.csv");
    fs::write(&manifest, format!("input,truth\na,{0}\nb,{0}\n", demo().join("truth.csv").display())).unwrap();
    let methods = ["robust", "paper"].map(|preset| {
        let output = folder.path().join(preset);
        batch(&manifest, &output).args(["--preset", preset, "--max-unavailable", "100", "--quiet"]).output().unwrap();
        output
    });
    let page = folder.path().join("methods.html");
    let mut compare = seamtrack();
    let said = compare.arg("compare").args(&methods).arg("-o").arg(&page).assert().success();
    let text = String::from_utf8_lossy(&said.get_output().stdout).into_owned();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines.len() == 5 && lines[0].contains("robust") && lines[0].contains("paper"), "{text}");
    assert!(lines[2].starts_with('a') && lines[3].starts_with('b') && lines[4].starts_with("all"), "{text}");
    assert!(fs::read_to_string(&page).unwrap().contains("2 methods on 2 recordings"));
    let mut mixed = seamtrack();
    mixed.arg("compare").arg(&methods[0]).arg(methods[1].join("a")).arg("-o").arg(folder.path().join("x.html"));
    mixed.assert().code(1).stderr(line_with(&["batches and single runs"]));
}

#[test]
fn a_second_batch_into_a_folder_is_refused_while_the_first_one_works() {
    let folder = tempfile::tempdir().unwrap();
    let inputs: Vec<PathBuf> = (0..8).map(|i| linked(folder.path(), &format!("r{i}"), 58)).collect();
    let output = folder.path().join("out");
    let mut first = std::process::Command::new(env!("CARGO_BIN_EXE_seamtrack"));
    first.arg("track").args(&inputs).arg("-o").arg(&output).args(["--joint", "butt", "--quiet"]);
    let mut first = first.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let began = Instant::now();
    while !output.join(".batch.seamtrack-part").exists() {
        assert!(began.elapsed() < Duration::from_secs(60) && first.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(1));
    }
    let mut second = seamtrack();
    second.arg("track").args(&inputs[..2]).arg("-o").arg(&output).args(["--joint", "butt", "--force"]);
    second.assert().code(1).stderr(line_with(&["out", "another run"]));
    assert!(first.wait().unwrap().success());
    let table = fs::read_to_string(output.join("batch.csv")).unwrap();
    assert_eq!(table.lines().count(), 9);
    assert!(!output.join(".batch.seamtrack-part").exists());
}
