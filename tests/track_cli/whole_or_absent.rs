//! A result is wholly there or wholly absent, whenever the program ends.
#![cfg(unix)]

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use predicates::str::contains;

use crate::program::{demo, demo_frames, line_with, recording, rows, summary, track, tracked};
use crate::users_files::tree;

/// `seamtrack track` under way.
fn started(input: &Path, output: &Path, more: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_seamtrack"))
        .arg("track")
        .arg(input)
        .arg("-o")
        .arg(output)
        .args(["--joint", "butt", "--quiet"])
        .args(more)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// A recording of many times the frames that are done before a test ends it.
fn long_recording(folder: &Path) -> PathBuf {
    let long = folder.join("long");
    fs::create_dir(&long).unwrap();
    let frames = demo_frames();
    for i in 0..20_000 {
        std::os::unix::fs::symlink(&frames[i % frames.len()], long.join(format!("{i}.png"))).unwrap();
    }
    long
}

/// The names in a folder, hidden ones too.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn wait_for(path: &Path) {
    let started = Instant::now();
    while !path.exists() {
        assert!(started.elapsed() < Duration::from_secs(60), "{} does not appear", path.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_run_that_is_killed_at_any_moment_leaves_the_old_results_or_the_new_ones() {
    let folder = tempfile::tempdir().unwrap();
    let (short, output) = (recording(folder.path(), 6), folder.path().join("out"));
    let began = Instant::now();
    tracked(&demo(), &folder.path().join("timed"));
    let whole = began.elapsed();
    for kill in 0..12 {
        let _ = fs::remove_dir_all(&output);
        track(&short, &output).arg("--trace").assert().success();
        let before = tree(&output);
        let mut run = started(&demo(), &output, &["--force", "--tum"]);
        std::thread::sleep(whole * (kill + 1) / 12);
        run.kill().unwrap();
        run.wait().unwrap();
        if tree(&output) != before {
            assert_eq!((rows(&output).len(), summary(&output)["frames"]["total"].as_u64()), (58, Some(58)));
            assert!(!output.join("trace.csv").exists() && output.join("filtered.tum").is_file());
        }
        // Whatever it left, the next run sets right.
        track(&short, &output).args(["--trace", "--force"]).assert().success();
        let names: Vec<String> = names(folder.path()).into_iter().filter(|name| name.starts_with('.')).collect();
        assert_eq!(names, [""; 0], "nothing of it stays");
    }
}

#[test]
fn a_second_run_into_one_folder_is_refused_while_the_first_one_works_and_not_after_it_died() {
    let folder = tempfile::tempdir().unwrap();
    let (long, output) = (long_recording(folder.path()), folder.path().join("out"));
    let short = recording(folder.path(), 4);
    let mut first = started(&long, &output, &[]);
    wait_for(&folder.path().join(".out.seamtrack-part"));
    track(&short, &output).arg("--force").assert().code(1).stderr(line_with(&["out", "another run"]));
    first.kill().unwrap();
    first.wait().unwrap();
    tracked(&short, &output);
    assert_eq!(names(folder.path()), ["long", "out", "recording"]);
}

#[test]
fn a_run_that_is_told_to_end_leaves_nothing_and_ends_as_other_programs_do() {
    let folder = tempfile::tempdir().unwrap();
    let long = long_recording(folder.path());
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        let output = folder.path().join("results/deep/out");
        let overlay = folder.path().join("film.mp4");
        let run = started(&long, &output, &["--overlay", overlay.to_str().unwrap()]);
        wait_for(&folder.path().join("results/deep/.out.seamtrack-part"));
        std::thread::sleep(Duration::from_millis(100));
        assert!(Command::new("kill").args([&format!("-{name}"), &run.id().to_string()]).status().unwrap().success());
        let ended = run.wait_with_output().unwrap();
        assert_eq!(ended.status.signal(), Some(number), "{}", String::from_utf8_lossy(&ended.stderr));
        assert_eq!(String::from_utf8_lossy(&ended.stderr).lines().count(), 1);
        assert_eq!(names(folder.path()), ["long"], "not even the folders made for it");
    }
}

#[test]
fn results_of_a_batch_that_is_told_to_end_stay_where_they_were_complete() {
    let folder = tempfile::tempdir().unwrap();
    let (short, long) = (recording(folder.path(), 4), long_recording(folder.path()));
    let output = folder.path().join("results");
    let run = started(&short, &output, &[long.to_str().unwrap()]);
    wait_for(&output.join("recording"));
    wait_for(&output.join(".long.seamtrack-part"));
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    run.wait_with_output().unwrap();
    assert_eq!((names(&output), rows(&output.join("recording")).len()), (vec!["recording".to_owned()], 4));
}

/// A limit on the size of files stands for a full disk.
#[test]
fn a_video_that_does_not_fit_on_the_disk_is_an_error_and_the_old_one_and_the_old_results_stay() {
    let folder = tempfile::tempdir().unwrap();
    let (output, film) = (folder.path().join("out"), folder.path().join("film.mp4"));
    let short = recording(folder.path(), 6);
    track(&short, &output).arg("--overlay").arg(&film).assert().success();
    let before = tree(folder.path());
    let bytes = fs::metadata(&film).unwrap().len();
    // Results fit, the video of ten times the frames does not.
    let blocks = (bytes * 2).max(120_000) / 512;
    let mut script = Command::new("sh");
    script.args(["-c", &format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\""), "sh"]);
    script.arg(env!("CARGO_BIN_EXE_seamtrack")).arg("track").arg(demo()).arg("-o").arg(&output);
    script.args(["--joint", "butt", "--quiet", "--force", "--overlay"]).arg(&film);
    let run = assert_cmd::Command::from_std(script).assert().code(1);
    let stderr = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert!(stderr.contains("film.mp4") || stderr.contains("report.html"), "{stderr}");
    assert!(tree(folder.path()) == before);
}

#[test]
fn the_working_directory_itself_may_take_results_and_keeps_being_the_working_directory() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 4);
    let here = folder.path().join("here");
    fs::create_dir(&here).unwrap();
    let run = |more: &[&str]| track(&input, Path::new(".")).current_dir(&here).args(more).assert();
    // A handle on the folder sees whether it is still the same one.
    let number = |folder: &Path| std::os::unix::fs::MetadataExt::ino(&fs::metadata(folder).unwrap());
    let before = number(&here);
    run(&["--trace"]).success();
    run(&[]).code(1).stderr(contains("--force"));
    run(&["--force"]).success();
    assert_eq!((number(&here), rows(&here).len()), (before, 4));
    assert!(!here.join("trace.csv").exists() && !names(&here).iter().any(|name| name.contains("-part")));
    fs::write(here.join("mine.txt"), "mine").unwrap();
    run(&["--force"]).code(1).stderr(contains("mine.txt"));
}

#[test]
fn of_two_runs_into_one_folder_at_once_one_is_there_whole_and_the_other_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let (short, output) = (recording(folder.path(), 12), folder.path().join("out"));
    for pair in 0..4 {
        let more: &[&str] = if pair % 2 == 0 { &[] } else { &["--force"] };
        let inputs = [(&short, 12), (&demo(), 58)];
        let runs = inputs.map(|(input, frames)| (started(input, &output, more), frames));
        let ended = runs.map(|(run, frames)| (run.wait_with_output().unwrap(), frames));
        let done: Vec<usize> = ended.iter().filter(|(ended, _)| ended.status.success()).map(|(_, n)| *n).collect();
        assert!(!done.is_empty(), "one of them is done");
        let there = rows(&output).len();
        assert!(done.contains(&there), "{there} rows are there, done were {done:?}");
        assert_eq!(summary(&output)["frames"]["total"].as_u64(), Some(there as u64));
        for (ended, _) in ended.iter().filter(|(ended, _)| !ended.status.success()) {
            let said = String::from_utf8_lossy(&ended.stderr);
            assert!(said.lines().count() == 1 && said.contains("out"), "{said}");
        }
        // Every other pair finds older results.
        if pair % 2 == 1 {
            fs::remove_dir_all(&output).unwrap();
        }
    }
}

#[test]
fn an_output_that_is_deleted_under_a_run_is_an_error_of_one_line_or_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let (short, output) = (recording(folder.path(), 6), folder.path().join("out"));
    let unfinished = folder.path().join(".out.seamtrack-part");
    tracked(&short, &output);
    let before = tree(&output);
    let run = started(&demo(), &output, &["--force"]);
    wait_for(&unfinished);
    let _ = fs::remove_dir_all(&unfinished);
    let ended = run.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.code() == Some(1) && said.lines().count() == 1 && said.contains("out"), "{said}");
    assert!(tree(&output) == before, "the old results stay");

    let run = started(&demo(), &output, &["--force"]);
    wait_for(&unfinished);
    fs::remove_dir_all(&output).unwrap();
    let ended = run.wait_with_output().unwrap();
    let is_there = output.exists();
    assert_eq!(ended.status.success(), is_there, "{}", String::from_utf8_lossy(&ended.stderr));
    assert!(!is_there || rows(&output).len() == 58);
}
