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
fn a_folder_that_is_no_result_is_named() {
    let dir = tempfile::tempdir().unwrap();
    seamtrack().arg("report").arg(dir.path()).assert().code(1).stderr(predicate::str::contains("summary.json"));
}
