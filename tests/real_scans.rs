//! The whole program on two real scans of a hairline butt joint, against their hand-made reference.
//!
//! `SEAMTRACK_REAL_DATA=… cargo test --test real_scans -- --nocapture` prints the figures of the README.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use seamtrack::frame::GrayFrame;
use seamtrack::report::results::{Estimator, PathRow, read_path_csv};
use seamtrack::synth::{Scene, builtin};
use seamtrack::units::StripeAxis;

/// The recordings, or a loud word that the test was skipped.
fn recordings() -> Option<PathBuf> {
    let folder = std::env::var_os("SEAMTRACK_REAL_DATA").map(PathBuf::from).filter(|folder| folder.is_dir());
    if folder.is_none() {
        eprintln!("SKIPPED: SEAMTRACK_REAL_DATA names no folder, so nothing was tracked on real steel");
    }
    folder
}

/// The reference position along the vertical stripe by file name \[px\].
fn reference(scan: &Path) -> BTreeMap<String, f64> {
    let mut table = csv::Reader::from_path(scan.join("seam_reference.csv")).unwrap();
    let rows = table.deserialize::<BTreeMap<String, String>>().map(Result::unwrap);
    rows.filter_map(|row| Some((row["file"].clone(), row["seam_y"].parse().ok()?))).collect()
}

fn track(scan: &Path, preset: &str) -> Vec<PathRow> {
    track_folder(&scan.join("frames"), preset)
}

fn track_folder(frames: &Path, preset: &str) -> Vec<PathRow> {
    let results = tempfile::tempdir().unwrap();
    Command::cargo_bin("seamtrack")
        .unwrap()
        .args(["track", "--quiet", "--max-unavailable", "100", "--preset", preset, "-o"])
        .arg(results.path().join("run"))
        .arg(frames)
        .assert()
        // The verdict on the paper's preset is BAD here, and its path is what it is.
        .code(predicates::prelude::predicate::in_iter([0, 3]));
    read_path_csv(&results.path().join("run/path.csv")).unwrap()
}

/// Mean and worst distance from the reference \[px\], and the frames off by over 10 px.
fn errors_px(rows: &[PathRow], reference: &BTreeMap<String, f64>, estimator: Estimator) -> Option<(f64, f64, usize)> {
    let error = |row: &PathRow| {
        let position_px = row.along_px(estimator, StripeAxis::Vertical)?;
        Some((position_px - reference.get(&row.file)?).abs())
    };
    let errors: Vec<f64> = rows.iter().filter_map(error).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let worst = errors.iter().copied().reduce(f64::max)?;
    Some((mean, worst, errors.iter().filter(|error| **error > 10.0).count()))
}

#[test]
fn hairlines_on_real_steel_are_found_by_themselves_and_never_given_wrongly() {
    let Some(folder) = recordings() else { return };
    for name in ["abb-butt-scan1", "abb-butt-scan4"] {
        let scan = folder.join(name);
        let reference = reference(&scan);
        let rows = track(&scan, "robust");
        let visible = rows.iter().position(|row| reference.contains_key(&row.file)).unwrap();
        let found = rows.iter().position(|row| row.u_px.is_some()).unwrap();
        let filtered = errors_px(&rows, &reference, Estimator::Filtered).unwrap();
        let smoothed = errors_px(&rows, &reference, Estimator::Smoothed).unwrap();
        eprintln!(
            "{name} robust: found {} frames after it shows; causal {filtered:.2?}, smoothed {smoothed:.2?} px",
            found - visible
        );
        let paper = track(&scan, "paper");
        let lost = paper.iter().filter(|row| row.u_px.is_none()).count();
        eprintln!(
            "{name} paper: {:.2?} px, {lost} frames without a value",
            errors_px(&paper, &reference, Estimator::Filtered)
        );
        assert!(found >= visible && found - visible <= 25, "found at {found}, visible from {visible}");
        assert!(filtered.0 <= 1.5 && filtered.1 <= 5.0 && filtered.2 == 0, "{filtered:?}");
        assert!(smoothed.0 <= 1.4 && smoothed.1 <= 4.0 && smoothed.2 == 0, "{smoothed:?}");
        let unavailable = rows[found..].iter().filter(|row| row.u_px.is_none()).count();
        assert_eq!(unavailable, 0);
    }
}

#[test]
fn a_wide_groove_among_spatter_shows_its_root_and_its_shoulders() {
    let Some(folder) = recordings() else { return };
    let input = tempfile::tempdir().unwrap();
    let frame = input.path().join("weld2.png");
    std::fs::copy(folder.join("vgroove-spatter-single/weld2.png"), frame).unwrap();
    let rows = track_folder(input.path(), "robust");
    let row = &rows[0];
    eprintln!("weld2.png: {row:?}");
    let near = |u: Option<f64>, v: Option<f64>, (u0, v0): (f64, f64), tolerance_px: f64| {
        (u.unwrap() - u0).hypot(v.unwrap() - v0) < tolerance_px
    };
    // Read off the picture by eye, the root where the flanks' edges, drawn on, meet; the flanks bow by some pixels.
    assert!(near(row.u_px, row.v_px, (778.0, 622.0), 8.0));
    assert!(near(row.shoulder_before_u_px, row.shoulder_before_v_px, (519.0, 386.0), 8.0));
    assert!(near(row.shoulder_behind_u_px, row.shoulder_behind_v_px, (1042.0, 394.0), 10.0));
}

/// The arc, smoke and spatter of the built-in hairline scenes, as large as the scans.
fn arc(level: &str, width_px: usize, height_px: usize, frames: usize) -> Scene {
    let mut scenario = builtin::scenario(&format!("hairline-{level}")).unwrap();
    (scenario.image.width_px, scenario.image.height_px) = (width_px, height_px);
    scenario.path.clear();
    scenario.recorder.repeated = 0.0;
    scenario.frames = frames;
    Scene::new(&scenario, 1).unwrap()
}

#[test]
fn a_made_up_arc_over_real_steel_costs_accuracy_but_gives_no_wrong_place() {
    let Some(folder) = recordings() else { return };
    for name in ["abb-butt-scan1", "abb-butt-scan4"] {
        let scan = folder.join(name);
        let reference = reference(&scan);
        for (level, most_mean_px, most_px) in [("mild", 1.6, 6.0), ("medium", 1.6, 6.0), ("severe", 2.0, 12.0)] {
            let input = tempfile::tempdir().unwrap();
            let mut clean: Option<image::GrayImage> = None;
            let mut scene = None;
            for (i, file) in reference.keys().enumerate() {
                let picture = image::open(scan.join("frames").join(file)).unwrap().into_luma8();
                let (width_px, height_px) = (picture.width() as usize, picture.height() as usize);
                // A frame that the recorder repeated is left out: its arc would differ.
                if clean.as_ref() == Some(&picture) {
                    continue;
                }
                let scene = scene.get_or_insert_with(|| arc(level, width_px, height_px, reference.len()));
                let frame = GrayFrame::new(width_px, height_px, picture.as_raw().clone()).unwrap();
                let lit = scene.composite(i, &frame);
                let size = (width_px as u32, height_px as u32);
                let lit = image::GrayImage::from_raw(size.0, size.1, lit.pixels().to_vec()).unwrap();
                lit.save(input.path().join(file)).unwrap();
                clean = Some(picture);
            }
            let rows = track_folder(input.path(), "robust");
            let (mean_px, worst_px, _) = errors_px(&rows, &reference, Estimator::Filtered).unwrap();
            let without = rows.iter().filter(|row| row.u_px.is_none()).count();
            eprintln!(
                "{name}, {level} arc: mean {mean_px:.2}, worst {worst_px:.2} px; {without} of {} without a value",
                rows.len()
            );
            assert!(mean_px <= most_mean_px && worst_px <= most_px);
        }
    }
}
