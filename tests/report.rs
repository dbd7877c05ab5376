//! `seamtrack report` and `seamtrack compare` on made-up results.
#![expect(clippy::unwrap_used, reason = "a test that cannot do its part must fail")]

mod report_run;

use assert_cmd::Command;
use predicates::prelude::*;
use report_run::{GOOD, Noise, write_run};

fn seamtrack() -> Command {
    Command::cargo_bin("seamtrack").unwrap()
}

#[test]
fn a_report_is_rebuilt_byte_for_byte_and_the_terminal_summary_stands_on_its_own() {
    let dir = tempfile::tempdir().unwrap();
    write_run(dir.path(), 250, GOOD, true);
    let output = seamtrack().arg("report").arg(dir.path()).arg("--tum").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    println!("{text}");
    assert!(text.starts_with("BAD Tracked on 225 of 250 frames, 9 coasting, 12 lost"), "{text}");
    for part in ["KCF alone", "filtered", "smoothed", "mean abs. [mm]", "┤", "XX", "0.073 mm/px"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    assert!(!text.contains('\x1b'), "no colour when stdout is not a terminal");
    let page = std::fs::read(dir.path().join("report.html")).unwrap();
    seamtrack().arg("report").arg(dir.path()).assert().success();
    assert_eq!(std::fs::read(dir.path().join("report.html")).unwrap(), page);
    for name in ["kcf", "filtered", "smoothed", "truth"] {
        let tum = std::fs::read_to_string(dir.path().join(format!("{name}.tum"))).unwrap();
        assert!(tum.lines().all(|line| line.split(' ').count() == 8) && tum.lines().count() > 200, "{name}");
    }
}

#[test]
fn a_page_stays_within_its_limit_and_keeps_the_worst_frames() {
    let dir = tempfile::tempdir().unwrap();
    write_run(dir.path(), 250, GOOD, false);
    seamtrack().arg("report").arg(dir.path()).args(["--max-page-mb", "1"]).assert().success();
    let page = std::fs::read_to_string(dir.path().join("report.html")).unwrap();
    assert!(page.len() <= 1_000_000, "{} bytes", page.len());
    assert!(page.contains("\"frame\":126,\"stripe\""), "the first lost frame is stored");
    assert!(!page.contains("http://") || page.matches("http://").count() == page.matches("http://www.w3.org").count());
    assert!(!page.contains("https://"));
}

#[test]
fn several_runs_stand_in_one_table_and_one_page() {
    let dir = tempfile::tempdir().unwrap();
    let (paper, robust) = (dir.path().join("paper"), dir.path().join("robust"));
    write_run(&paper, 250, Noise { filtered_px: 0.6, ..GOOD }, true);
    write_run(&robust, 250, GOOD, true);
    let page = dir.path().join("comparison.html");
    let compare = || {
        let mut command = seamtrack();
        command.arg("compare").arg(&paper).arg(&robust).arg("-o").arg(&page);
        command
    };
    compare()
        .assert()
        .success()
        .stdout(predicate::str::contains("paper, filtered").and(predicate::str::contains("robust, smoothed")));
    assert!(std::fs::read_to_string(&page).unwrap().contains("2 runs on one recording"));
    compare().assert().code(1).stderr(predicate::str::contains("--force"));
    std::fs::remove_dir_all(&robust).unwrap();
    write_run(&robust, 100, GOOD, true);
    compare().arg("--force").assert().code(1).stderr(predicate::str::contains("compare runs on the same recording"));
}

#[test]
fn a_run_without_a_truth_is_held_against_the_others_and_mixed_scales_are_said() {
    let dir = tempfile::tempdir().unwrap();
    let (known, bare) = (dir.path().join("known"), dir.path().join("bare"));
    write_run(&known, 250, GOOD, true);
    write_run(&bare, 250, GOOD, false);
    let summary = std::fs::read_to_string(bare.join("summary.json")).unwrap();
    std::fs::write(bare.join("summary.json"), summary.replace("0.073", "0.05")).unwrap();
    let page = dir.path().join("comparison.html");
    let mut compare = seamtrack();
    compare.arg("compare").args([&bare, &known]).arg("-o").arg(&page);
    compare
        .assert()
        .success()
        .stdout(predicate::str::contains("bare, smoothed").and(predicate::str::contains("known, smoothed")))
        .stderr(predicate::str::contains("different scales (bare: 0.05 mm/px"));
    assert!(std::fs::read_to_string(&page).unwrap().contains("different scales"));
}

#[test]
fn every_run_of_a_comparison_has_its_places() {
    let dir = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..6).map(|k| format!("run{k}")).collect();
    for name in &names {
        write_run(&dir.path().join(name), 250, GOOD, false);
    }
    let mut compare = seamtrack();
    compare.current_dir(dir.path()).arg("compare").args(&names).assert().success();
    let page = std::fs::read_to_string(dir.path().join("comparison.html")).unwrap();
    for name in &names {
        assert!(page.contains(&format!("\"why\":\"{name}: ")), "{name}");
    }
    assert!(page.contains("seamtrack track --truth FILE"), "compare itself has no such option");
}

#[test]
fn a_folder_that_is_no_result_is_named() {
    let dir = tempfile::tempdir().unwrap();
    seamtrack().arg("report").arg(dir.path()).assert().code(1).stderr(predicate::str::contains("summary.json"));
}
