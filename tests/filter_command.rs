//! `seamtrack filter` as a user meets it.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fmt::Write;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;

fn filter(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("seamtrack").unwrap();
    command.arg("filter").args(arguments);
    command
}

/// A ramp with a fixed ripple, a gap of three lines, and one outlier.
fn ramp(folder: &Path) -> PathBuf {
    let mut text = String::from("time_s,z1\n");
    for k in 0..120 {
        let time = 0.2 * f64::from(k);
        let outlier = if k == 80 { 40.0 } else { 0.0 };
        let z = 300.0 + 0.5 * f64::from(k) + (f64::from(k * k % 17) - 8.0) / 8.0 + outlier;
        let cell = if (30..33).contains(&k) { String::new() } else { z.to_string() };
        writeln!(text, "{time:.1},{cell}").unwrap();
    }
    let path = folder.join("ramp.csv");
    std::fs::write(&path, text).unwrap();
    path
}

fn column(folder: &Path, name: &str) -> Vec<Option<f64>> {
    let mut reader = csv::Reader::from_path(folder.join("filter.csv")).unwrap();
    let index = reader.headers().unwrap().iter().position(|header| header == name).unwrap();
    reader.records().map(|record| record.unwrap()[index].parse().ok()).collect()
}

fn summary(folder: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("filter.json")).unwrap()).unwrap()
}

#[test]
fn every_model_filters_and_smooths_a_series_with_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    let input = ramp(folder.path());
    for model in ["white", "coloured-measurement", "coloured-process", "adaptive"] {
        let out = folder.path().join(model);
        let arguments = [input.to_str().unwrap(), "--model", model, "--gate", "-o", out.to_str().unwrap()];
        filter(&arguments).args(["--fit"]).assert().success().stdout(contains("mean NIS"));
        let (x, smooth, nis) = (column(&out, "x"), column(&out, "smooth_x"), column(&out, "nis"));
        assert_eq!(x.len(), 120);
        assert!(nis[31].is_none() && x[31].is_some() && smooth[31].is_some(), "{model}");
        assert!((smooth[60].unwrap() - 330.0).abs() < 1.0, "{model}: {:?}", smooth[60]);
        assert!((smooth[80].unwrap() - 340.0).abs() < 3.0, "{model} follows the outlier: {:?}", smooth[80]);
        assert_eq!(summary(&out)["fitted"], true);
    }
}

#[test]
fn a_fit_is_at_least_as_likely_and_its_parameters_can_be_fed_back() {
    let folder = tempfile::tempdir().unwrap();
    let input = ramp(folder.path());
    let run = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let arguments = [input.to_str().unwrap(), "--model", "white", "-o", out.to_str().unwrap()];
        let printed = filter(&arguments).args(more).assert().success().get_output().stdout.clone();
        (summary(&out)["log_likelihood"].as_f64().unwrap(), String::from_utf8(printed).unwrap())
    };
    let (given, _) = run("given", &[]);
    let (fitted, printed) = run("fitted", &["--fit"]);
    assert!(fitted > given);
    let toml: Vec<&str> = printed.lines().filter(|line| line.contains(" = ")).collect();
    let config = folder.path().join("noise.toml");
    std::fs::write(&config, toml.join("\n")).unwrap();
    let (again, _) = run("again", &["--config", config.to_str().unwrap()]);
    assert!((again - fitted).abs() < 1e-6 * fitted.abs());
}

#[test]
fn the_printed_statistics_say_where_they_lose_definiteness() {
    let folder = tempfile::tempdir().unwrap();
    let input = ramp(folder.path());
    let out = folder.path().join("out");
    let arguments = [input.to_str().unwrap(), "--model", "adaptive", "--literal", "-o", out.to_str().unwrap()];
    filter(&arguments).assert().success().stderr(contains("is no covariance any more"));
    assert!(summary(&out)["lost_definiteness"]["measurement"].is_u64());
}

#[test]
fn results_are_not_overwritten_without_force() {
    let folder = tempfile::tempdir().unwrap();
    let input = ramp(folder.path());
    let out = folder.path().join("out");
    let arguments = [input.to_str().unwrap(), "--model", "white", "-o", out.to_str().unwrap()];
    filter(&arguments).assert().success();
    let before = std::fs::read(out.join("filter.csv")).unwrap();
    filter(&arguments).assert().code(1).stderr(contains("--force"));
    filter(&arguments).arg("--force").assert().success();
    assert_eq!(std::fs::read(out.join("filter.csv")).unwrap(), before, "two runs give the same bytes");
}

#[test]
fn results_go_neither_into_a_folder_of_the_users_nor_over_the_series() {
    let folder = tempfile::tempdir().unwrap();
    let input = ramp(folder.path());
    let run = |output: &Path| {
        let arguments = [input.to_str().unwrap(), "--model", "white", "--force", "-o", output.to_str().unwrap()];
        filter(&arguments).assert().code(1)
    };
    run(folder.path()).stderr(contains("which is read"));
    let mine = folder.path().join("mine");
    std::fs::create_dir(&mine).unwrap();
    std::fs::write(mine.join("filter.csv"), "mine").unwrap();
    run(&mine).stderr(contains("filter.csv is not of an earlier run"));
    assert_eq!(std::fs::read(mine.join("filter.csv")).unwrap(), b"mine");
}

#[test]
fn numbers_that_overflow_are_an_error_and_not_results() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("huge.csv");
    let lines: String = (0..30).map(|i| format!("{i},{}e160\n", i % 7 - 3)).collect();
    std::fs::write(&input, format!("time_s,z1\n{lines}")).unwrap();
    let out = folder.path().join("out");
    for model in ["white", "coloured-measurement", "coloured-process", "adaptive"] {
        for more in [&[][..], &["--gate"], &["--fixed-lag", "18446744073709551615"]] {
            let arguments = [input.to_str().unwrap(), "--model", model, "-o", out.to_str().unwrap()];
            let run = filter(&arguments).args(more).assert();
            let output = run.get_output();
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.code() == Some(1) && !stderr.contains("panicked"), "{model} {more:?}: {stderr}");
            assert!(stderr.trim_end().lines().count() == 1 && !out.exists(), "{stderr}");
        }
    }
}

#[test]
fn a_lag_longer_than_the_series_is_the_whole_series() {
    let folder = tempfile::tempdir().unwrap();
    let input = ramp(folder.path());
    let smoothed = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let arguments = [input.to_str().unwrap(), "--model", "white", "-o", out.to_str().unwrap()];
        filter(&arguments).args(more).assert().success();
        column(&out, "smooth_x")
    };
    assert_eq!(smoothed("lag", &["--fixed-lag", "1000"]), smoothed("whole", &[]));
    let huge = [input.to_str().unwrap(), "--model", "white", "--fixed-lag", "18446744073709551615"];
    filter(&huge).assert().code(1).stderr(contains("at most 1000 lines"));
}

#[test]
fn bad_input_gets_one_line_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let input = ramp(folder.path());
    let input = input.to_str().unwrap();
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let config = folder.path().join("noise.toml");
    std::fs::write(&config, "white-variance = 1.0\nwhite-varianc = 2.0\n").unwrap();
    let cases: [(&[&str], &str); 7] = [
        (&["missing.csv", "--model", "white"], "missing.csv"),
        (&[input, "--model", "white", "--white-variance", "0"], "both measurement noises are 0"),
        (&[input, "--model", "white", "--acceleration-variance", "nan"], "is not finite"),
        (&[input, "--model", "coloured-measurement", "--colour-coefficient", "1"], "between -1 and 1"),
        (&[input, "--model", "coloured-measurement", "--period", "0"], "greater than 0"),
        (&[input, "--model", "white", "--period", "1"], "has no period"),
        (&[input, "--model", "white", "--config", config.to_str().unwrap()], "line 2: unknown field"),
    ];
    for (arguments, reason) in cases {
        let one_line = predicate::function(|text: &str| text.trim_end().lines().count() == 1);
        filter(arguments).args(["-o", out]).assert().code(1).stderr(contains(reason)).stderr(one_line);
        assert!(!Path::new(out).join("filter.csv").exists());
    }
    filter(&[input, "--model", "quadratic"]).assert().code(2);
}

#[test]
fn the_table_has_no_more_than_nine_digits() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let input = ramp(folder.path());
    filter(&[input.to_str().unwrap(), "--model", "white", "-o", out.to_str().unwrap()]).assert().success();
    let text = std::fs::read_to_string(out.join("filter.csv")).unwrap();
    // The first three columns are the user's own.
    let cells = text.lines().skip(1).flat_map(|line| line.split(',').skip(3));
    let significant = |cell: &str| {
        let mantissa = cell.split('e').next().unwrap_or_default().replace(['-', '.'], "");
        mantissa.trim_start_matches('0').trim_end_matches('0').len()
    };
    let longest = cells.map(significant).max().unwrap();
    assert!((5..=9).contains(&longest), "{longest} digits");
}
