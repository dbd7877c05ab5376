//! The whole program on two real scans of a hairline butt joint, against their hand-made reference.
//!
//! `SEAMTRACK_REAL_DATA=… cargo test --test real_scans -- --nocapture` prints the figures of the README.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use seamtrack::report::results::{Estimator, PathRow, read_path_csv};
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
    let results = tempfile::tempdir().unwrap();
    Command::cargo_bin("seamtrack")
        .unwrap()
        .args(["track", "--quiet", "--max-unavailable", "100", "--preset", preset, "-o"])
        .arg(results.path().join("run"))
        .arg(scan.join("frames"))
        .assert()
        .success();
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
