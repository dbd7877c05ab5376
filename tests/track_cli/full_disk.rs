//! Whatever command cannot write says so in one line, and what stood there stays.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::program::{recording, seamtrack, tracked};
use crate::users_files::tree;

/// Every command that writes, without its `--force`; all of their inputs and outputs lie in one folder.
const COMMANDS: [&[&str]; 8] = [
    &["track", "recording", "-o", "tracked", "--joint", "butt", "--quiet"],
    &["track", "recording", "-o", "logged", "--joint", "butt", "--quiet", "--mcap", "a.mcap"],
    &["track", "recording", "-o", "filmed", "--joint", "butt", "--quiet", "--overlay", "a.mp4"],
    &["synth", "demo-butt", "--frames", "2", "-o", "made"],
    &["meltpool", "pool", "--measure", "width", "--quiet", "--max-unavailable", "100", "-o", "measured"],
    &["filter", "series.csv", "--model", "white", "-o", "filtered"],
    &["calibrate", "scale", "gauge.csv", "-o", "scale.toml"],
    &["compare", "run", "run-too", "-o", "two.html"],
];

fn run(words: &[&str], folder: &Path) -> assert_cmd::Command {
    let mut command = seamtrack();
    command.args(words).current_dir(folder);
    command
}

/// What every command reads, and what each wrote before.
fn written() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let input = recording(folder.path(), 6);
    tracked(&input, &at("run"));
    tracked(&input, &at("run-too"));
    run(&["synth", "pool-width", "--frames", "6", "-o", "pool"], folder.path()).assert().success();
    let lines = |scale: f64| (0..30).map(|i| format!("{i},{:.3}\n", scale * f64::from(i))).collect::<String>();
    fs::write(at("series.csv"), format!("time_s,z1\n{}", lines(0.5))).unwrap();
    fs::write(at("gauge.csv"), format!("px,mm\n{}", lines(0.07))).unwrap();
    for words in COMMANDS {
        run(words, folder.path()).assert().success();
    }
    folder
}

/// A limit on the size of files stands for the full disk.
#[test]
fn on_a_full_disk_every_command_fails_in_one_line_and_the_old_result_stays() {
    let folder = written();
    let before = tree(folder.path());
    for words in COMMANDS {
        let mut script = Command::new("sh");
        script.args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_seamtrack")]);
        script.args(words).arg("--force").current_dir(folder.path());
        let ended = script.output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert!(ended.status.code() == Some(1) && said.lines().count() == 1, "{words:?}: {said}");
        assert!(tree(folder.path()) == before, "{words:?}");
    }
}

#[test]
fn what_a_dead_process_left_is_no_trouble_and_goes() {
    let folder = written();
    let before: Vec<_> = tree(folder.path()).into_keys().collect();
    for name in [".scale.toml", ".two.html", ".a.mcap", ".a.mp4"] {
        fs::write(folder.path().join(format!("{name}.seamtrack-part")), "half").unwrap();
    }
    fs::write(folder.path().join(".a.mp4.seamtrack-part.mp4"), "half").unwrap();
    // In a folder of results it is no file of the user's.
    fs::write(folder.path().join("tracked/.report.html.seamtrack-part"), "half").unwrap();
    for words in COMMANDS {
        run(words, folder.path()).arg("--force").assert().success();
    }
    assert_eq!(tree(folder.path()).into_keys().collect::<Vec<_>>(), before);
}
