//! Configurations and manifests that cannot be used: one line that names the file and the key, and no results.

use std::fs;

use crate::program::{line_with, recording, track};

#[test]
fn a_configuration_that_cannot_be_used_names_the_file_and_the_key() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    let config = folder.path().join("noise.toml");
    let cases = [
        ("period_s = nan", "period_s"),
        ("period_s = -1.0", "period_s"),
        ("mm_per_px = nan", "mm_per_px"),
        ("mm_per_px = 0.0", "mm_per_px"),
        ("perod_s = 0.2", "perod_s"),
        ("[paper]\nlearning_rte = 0.1", "learning_rte"),
        ("preset = \"paper\"\n[paper]\nlearning_rate = nan", "learning_rate"),
        ("preset = \"paper\"\n[paper]\nmedian_px = 4", "median_px"),
        ("preset = \"paper\"\n[paper]\nwindow_px = [0, 0]", "window"),
        ("preset = \"paper\"\n[paper]\nwhite_variance_px2 = inf", "white"),
        ("joint = \"weld\"", "weld"),
        ("seed_at = [nan, 3.0]", "seed_at"),
        ("preset = ", "preset"),
    ];
    for (text, key) in cases {
        fs::write(&config, text).unwrap();
        let output = folder.path().join("out");
        let mut command = crate::program::seamtrack();
        command.arg("track").arg(&input).arg("-o").arg(&output).arg("--config").arg(&config);
        command.assert().code(1).stderr(line_with(&["noise.toml", key]));
        assert!(!output.join("path.csv").exists(), "{text}");
    }
    fs::remove_file(&config).unwrap();
    track(&input, &folder.path().join("out"))
        .arg("--config")
        .arg(&config)
        .assert()
        .code(1)
        .stderr(line_with(&["noise.toml", "cannot read"]));
}

#[test]
fn a_manifest_that_cannot_be_used_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("list.csv");
    let track = || {
        let mut command = crate::program::seamtrack();
        command.arg("track").arg("--manifest").arg(&manifest).arg("-o").arg(folder.path().join("out"));
        command.assert().code(1)
    };
    track().stderr(line_with(&["list.csv", "cannot read"]));
    fs::write(&manifest, "recording\na\n").unwrap();
    track().stderr(line_with(&["list.csv", "`input`"]));
    fs::write(&manifest, "input,truth\n,t.csv\n").unwrap();
    track().stderr(line_with(&["list.csv", "no input"]));
    fs::write(&manifest, "input\n").unwrap();
    track().stderr(line_with(&["list.csv", "lists no recording"]));
}

#[test]
fn a_truth_that_cannot_be_used_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    let truth = folder.path().join("truth.csv");
    for (text, part) in [
        ("frame,a\n0,1\n", "truth.csv"),
        ("frame,u_px\n0,nan\n", "frame 0"),
        ("frame,u_px\n0,abc\n", "truth.csv"),
        ("frame,u_px\n900,1\n", "no frame of this recording"),
    ] {
        fs::write(&truth, text).unwrap();
        let output = folder.path().join("out");
        track(&input, &output).arg("--truth").arg(&truth).assert().code(1).stderr(line_with(&["truth.csv", part]));
        assert!(!output.join("path.csv").exists(), "{text}");
    }
}
