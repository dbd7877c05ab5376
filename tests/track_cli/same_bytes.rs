//! The same recording and options give the same bytes, on whatever machine, in whatever language, from wherever.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::program::{demo, seamtrack, untimed};

/// What a run leaves, by name; of the summary without `timing`, of the page without what it shows of that: how long a frame takes
/// is no two times the same. The list of files holds the check sums of both.
fn results(folder: &Path) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file()) {
        let name = entry.file_name().unwrap().to_string_lossy().into_owned();
        let text = String::from_utf8_lossy(&fs::read(&entry).unwrap()).into_owned();
        let kept = match name.as_str() {
            ".seamtrack.json" => continue,
            "summary.json" => untimed(text.as_bytes()),
            "report.html" => without_times(&text),
            _ => text,
        };
        files.insert(name, kept);
    }
    files
}

/// The page without the cells of milliseconds and the sentence with the frames a second.
fn without_times(page: &str) -> String {
    let mut text = String::new();
    for part in page.split_inclusive("</") {
        let is_time = part.contains(" [ms]\">") && part.contains("data-head");
        let is_rate = part.contains(" frames a second by wall clock");
        text += if is_time || is_rate { "(time)" } else { part };
    }
    assert_ne!(text, page, "the page shows how long it took");
    text
}

#[test]
fn threads_language_time_zone_and_working_directory_change_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let elsewhere = folder.path().join("else where");
    fs::create_dir(&elsewhere).unwrap();
    let settings: [&[(&str, &str)]; 4] = [
        &[],
        &[("RAYON_NUM_THREADS", "1"), ("OPENCV_FOR_THREADS_NUM", "1"), ("LC_ALL", "C"), ("TZ", "UTC")],
        &[("RAYON_NUM_THREADS", "2"), ("OPENCV_FOR_THREADS_NUM", "2"), ("LC_ALL", "de_DE.UTF-8"), ("TZ", "Asia/Tokyo")],
        &[("LC_ALL", "tr_TR.UTF-8"), ("LANG", "tr_TR.UTF-8"), ("TZ", "America/St_Johns")],
    ];
    let run = |number: usize, environment: &[(&str, &str)]| {
        let output = folder.path().join(number.to_string()).join("out");
        let mut command = seamtrack();
        command.arg("track").arg(demo()).arg("-o").arg(&output).arg("--truth").arg(demo().join("truth.csv"));
        command.args(["--mm-per-px", "0.073", "--trace", "--tum", "--quiet"]).envs(environment.iter().copied());
        command.current_dir(if number.is_multiple_of(2) { folder.path() } else { &elsewhere }).assert().success();
        results(&output)
    };
    let first = run(0, settings[0]);
    assert!(!first["report.html"].contains("seamtrack-part"), "it is of the folder that was asked for");
    assert!(
        ["path.csv", "summary.json", "trace.csv", "report.html", "smoothed.tum"].iter().all(|f| first.contains_key(*f))
    );
    for (number, environment) in settings.iter().enumerate().skip(1) {
        let other = run(number, environment);
        for (name, text) in &first {
            assert!(other[name] == *text, "{name} under {environment:?}");
        }
    }
}
