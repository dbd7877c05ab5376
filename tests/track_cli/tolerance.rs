//! `--tolerance`: how much of the path stays within a band, and where it does not.

use std::fs;

use crate::program::{demo, summary, track};

#[test]
fn a_tolerance_is_held_against_the_truth_and_without_one_against_the_origin() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let run = |more: &[&str]| {
        let printed = track(&demo(), &output).args(["--force", "--tolerance"]).args(more).assert().success();
        drop(printed);
        summary(&output)["tolerance"].clone()
    };
    let truth = demo().join("truth.csv");
    let with_truth = run(&["0.3", "--truth", truth.to_str().unwrap()]);
    assert_eq!((with_truth["reference"].as_str(), with_truth["inside_pct"].as_f64()), (Some("truth"), Some(100.0)));
    assert_eq!(with_truth["outside"].as_array().map(Vec::len), Some(0));

    // The demonstration's seam wanders by more than half a millimetre.
    let without = run(&["0.05"]);
    assert_eq!(without["reference"], "origin");
    assert!(without["inside_pct"].as_f64().unwrap() < 90.0, "{without}");
    let outside = without["outside"].as_array().unwrap();
    assert!(outside.iter().all(|place| place["worst_mm"].as_f64().unwrap().abs() > 0.05) && !outside.is_empty());
    let page = fs::read_to_string(output.join("report.html")).unwrap();
    assert!(page.contains("Within ±0.05 mm of x = 0 on") && page.contains("\"tolerance\":0.05"));
}

#[test]
fn a_tolerance_that_is_no_length_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for wrong in ["0", "-1", "nan", "wide"] {
        track(&demo(), &folder.path().join("out")).arg(format!("--tolerance={wrong}")).assert().code(2);
    }
}
