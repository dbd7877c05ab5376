//! The program, recordings to run it on, and what it leaves behind.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use image::GrayImage;
use predicates::prelude::*;
use seamtrack::report::results::{PathRow, read_path_csv};

/// The recording of the demonstration: 58 frames of 400 x 240 pixels.
pub fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/demo-butt")
}

pub fn seamtrack() -> Command {
    Command::cargo_bin("seamtrack").unwrap()
}

/// `seamtrack track INPUT -o OUTPUT --joint butt --mm-per-px 0.073 --quiet`.
pub fn track(input: &Path, output: &Path) -> Command {
    let mut command = without_scale(input, output);
    command.args(["--mm-per-px", "0.073"]);
    command
}

/// The same, nobody telling the scale.
pub fn without_scale(input: &Path, output: &Path) -> Command {
    let mut command = seamtrack();
    command.arg("track").arg(input).arg("-o").arg(output).args(["--joint", "butt", "--quiet"]);
    command
}

/// The rows of a run that must succeed.
pub fn tracked(input: &Path, output: &Path) -> Vec<PathRow> {
    track(input, output).assert().success();
    rows(output)
}

pub fn rows(output: &Path) -> Vec<PathRow> {
    read_path_csv(&output.join("path.csv")).unwrap()
}

pub fn summary(output: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(output.join("summary.json")).unwrap()).unwrap()
}

/// A summary without `timing`: how long things take is no two times the same.
pub fn untimed(summary: &[u8]) -> String {
    let mut summary: serde_json::Value = serde_json::from_slice(summary).unwrap();
    assert!(summary["timing"].take().is_object());
    summary.to_string()
}

/// The demonstration's frames in order.
pub fn demo_frames() -> Vec<PathBuf> {
    (0..58).map(|i| demo().join(format!("frames/frame_{i:06}.png"))).collect()
}

/// The first `count` of them, decoded.
pub fn pictures(count: usize) -> Vec<GrayImage> {
    demo_frames().iter().take(count).map(|file| image::open(file).unwrap().into_luma8()).collect()
}

/// A folder of the demonstration's first `count` frames, named 000.png and so on.
pub fn recording(folder: &Path, count: usize) -> PathBuf {
    let recording = folder.join("recording");
    fs::create_dir(&recording).unwrap();
    for (i, file) in demo_frames().iter().take(count).enumerate() {
        fs::copy(file, recording.join(name(i))).unwrap();
    }
    recording
}

pub fn name(frame: usize) -> String {
    format!("{frame:03}.png")
}

/// A message of one line that contains every part, and no panic.
pub fn line_with<'a>(parts: &'a [&'a str]) -> impl Predicate<str> + 'a {
    predicate::function(move |text: &str| {
        text.trim_end().lines().count() == 1
            && !text.contains("panicked")
            && parts.iter().all(|part| text.contains(part))
    })
}

/// The largest distance of the two filtered paths along the stripe \[px\], over frames that have both; the statuses
/// must be the same.
pub fn largest_difference_px(ours: &[PathRow], others: &[PathRow]) -> f64 {
    assert_eq!(ours.len(), others.len());
    let pairs = ours.iter().zip(others).inspect(|(a, b)| assert_eq!(a.status, b.status, "frame {}", a.frame));
    pairs.filter_map(|(a, b)| Some((a.u_px? - b.u_px?).abs())).fold(0.0, f64::max)
}
