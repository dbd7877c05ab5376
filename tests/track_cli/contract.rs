//! What scripts rely on: columns, keys, millimetres, determinism.

use std::fs;
use std::path::Path;

use seamtrack::eval::read_truth;
use seamtrack::report::results::Status;
use serde_json::Value;

use crate::program::{demo, line_with, recording, rows, seamtrack, summary, track, without_scale};

const HEADER: &str = "frame,file,time_s,status,kcf_u_px,kcf_v_px,psr,template_updated,u_px,v_px,x_mm,x_std_mm,nis,\
                      smooth_u_px,smooth_v_px,smooth_x_mm,smooth_x_std_mm";

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn assert_has(value: &Value, wanted: &[&str]) {
    for key in wanted {
        assert!(keys(value).contains(key), "{key} is not among {:?}", keys(value));
    }
}

fn with_truth(output: &Path, preset: &str) {
    let truth = demo().join("truth.csv");
    track(&demo(), output).args(["--preset", preset, "--truth"]).arg(truth).assert().success();
}

#[test]
fn the_columns_begin_as_promised_and_there_is_one_row_a_frame() {
    let folder = tempfile::tempdir().unwrap();
    with_truth(folder.path(), "robust");
    let text = fs::read_to_string(folder.path().join("path.csv")).unwrap();
    let header = text.lines().next().unwrap();
    assert!(header == HEADER || header.starts_with(&format!("{HEADER},")), "{header}");
    let rows = rows(folder.path());
    assert_eq!(rows.len(), 58);
    for (i, row) in rows.iter().enumerate() {
        assert_eq!((row.frame, row.file.as_str()), (i, format!("frame_{i:06}.png").as_str()));
        let has_value = matches!(row.status, Status::Tracked | Status::Coasting);
        for value in [row.u_px, row.v_px, row.x_mm, row.x_std_mm] {
            assert_eq!(value.is_some(), has_value, "{row:?}");
        }
    }
}

#[test]
fn the_summary_has_the_promised_keys() {
    let folder = tempfile::tempdir().unwrap();
    with_truth(folder.path(), "robust");
    let summary = summary(folder.path());
    assert_has(&summary, &["schema_version", "program", "input", "config", "calibration", "frames", "joint", "timing"]);
    assert_eq!(summary["schema_version"], 1);
    assert!(summary["program"].as_str().unwrap().starts_with("seamtrack "));
    let statuses = ["seeking", "tracked", "coasting", "lost", "unreadable"];
    assert_has(&summary["frames"], &statuses);
    assert_has(&summary["frames"], &["total", "repeated", "saturated"]);
    let counted: u64 = statuses.iter().map(|status| summary["frames"][status].as_u64().unwrap()).sum();
    assert_eq!((counted, summary["frames"]["total"].as_u64()), (58, Some(58)));
    assert_has(&summary["joint"], &["kind", "decided_at_frame", "reason"]);
    assert_has(&summary["timing"], &["decode_ms", "track_ms", "frames_per_second"]);
    for timing in ["decode_ms", "track_ms"] {
        assert_has(&summary["timing"][timing], &["p50", "p99", "max"]);
    }
    assert_has(&summary["errors"], &["kcf", "filtered", "smoothed"]);
    for estimate in ["filtered", "smoothed"] {
        let figures = ["frames", "mae_mm", "max_mm", "std_mm", "rmse_mm", "p95_mm", "bias_mm", "coverage_2sigma"];
        assert_has(&summary["errors"][estimate], &figures);
        assert_has(&summary["errors"][estimate], &["wrong_frames", "unavailable_frames"]);
    }
}

#[test]
fn without_a_truth_there_are_no_errors() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    track(&recording(folder.path(), 5), &output).assert().success();
    assert!(summary(&output).get("errors").is_none());
}

#[test]
fn millimetres_are_the_scale_times_the_way_from_the_origin() {
    // Half a digit of each rounded column.
    let tolerance_mm = 0.5e-4 + 0.073 * 2.0 * 0.5e-3;
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 20);
    let first_px = {
        track(&input, &folder.path().join("first")).assert().success();
        rows(&folder.path().join("first")).iter().find_map(|row| row.u_px).unwrap()
    };
    for (origin, origin_px) in [("first", first_px), ("centre", 199.5), ("120.25", 120.25)] {
        let output = folder.path().join(origin);
        track(&input, &output).args(["--force", "--origin", origin]).assert().success();
        for row in rows(&output) {
            let (u_px, x_mm) = (row.u_px.unwrap(), row.x_mm.unwrap());
            assert!((x_mm - 0.073 * (u_px - origin_px)).abs() <= tolerance_mm, "{origin}: {row:?}");
        }
    }
}

#[test]
fn without_a_scale_every_millimetre_is_empty_and_one_line_says_what_to_give() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let mut run = without_scale(&demo(), &output);
    run.arg("--truth").arg(demo().join("truth.csv")).assert().success();
    let text = fs::read_to_string(output.join("path.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().unwrap();
    for line in lines {
        for (name, cell) in names.iter().zip(&line).filter(|(name, _)| name.contains("_mm") || **name == "calibrated") {
            assert_eq!(*cell, "", "{name}");
        }
    }
    let rows = rows(&output);
    assert!(rows.iter().all(|row| row.u_px.is_some() && row.along_std_px.is_some() && row.smooth_u_px.is_some()));
    let summary = summary(&output);
    assert!(summary["calibration"].get("mm_per_px").is_none(), "{}", summary["calibration"]);
    let errors = &summary["errors"]["filtered"];
    assert!(errors.get("mae_mm").is_none() && errors["mae_px"].as_f64().unwrap() < 0.5, "{errors}");
    assert!(errors["coverage_2sigma"].as_f64().unwrap() > 0.8, "{errors}");
    let report = || {
        let mut command = seamtrack();
        command.arg("report").arg(&output);
        String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
    };
    let told = report();
    assert!(told.starts_with("CHECK") && told.contains("mean abs. [px]") && !told.contains(" mm"), "{told}");
    assert_eq!(told.lines().filter(|line| line.contains("--mm-per-px")).count(), 1, "{told}");
    let page = fs::read_to_string(output.join("report.html")).unwrap();
    assert!(page.contains("\"unit\":\"px\"") && !page.contains("\"unit\":\"mm\""));
    let mut eval = seamtrack();
    eval.arg("eval").arg(&output).arg(demo().join("truth.csv"));
    eval.assert().success().stdout(predicates::str::contains("error in px"));
    without_scale(&demo(), &folder.path().join("tum"))
        .arg("--tum")
        .assert()
        .code(1)
        .stderr(line_with(&["--mm-per-px"]));
}

#[test]
fn the_papers_preset_states_the_papers_scale() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    without_scale(&recording(folder.path(), 5), &output).args(["--preset", "paper"]).assert().success();
    let calibration = &summary(&output)["calibration"];
    assert_eq!(calibration["mm_per_px"], 0.073);
    assert!(calibration["source"].as_str().unwrap().contains("Du 2022"), "{calibration}");
}

#[test]
fn the_errors_are_those_computed_from_the_two_files_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    with_truth(folder.path(), "paper");
    let truth = read_truth(&demo().join("truth.csv")).unwrap();
    let errors_mm: Vec<f64> = rows(folder.path())
        .iter()
        .zip(&truth)
        .map(|(row, truth)| 0.073 * (row.u_px.unwrap() - truth.u_px.unwrap()))
        .collect();
    let n = errors_mm.len() as f64;
    let mae_mm = errors_mm.iter().map(|e| e.abs()).sum::<f64>() / n;
    let bias_mm = errors_mm.iter().sum::<f64>() / n;
    let max_mm = errors_mm.iter().map(|e| e.abs()).fold(0.0, f64::max);
    let filtered = &summary(folder.path())["errors"]["filtered"];
    for (key, by_hand) in [("mae_mm", mae_mm), ("bias_mm", bias_mm), ("max_mm", max_mm)] {
        // path.csv has three decimals of a pixel.
        assert!((filtered[key].as_f64().unwrap() - by_hand).abs() < 0.073 * 0.5e-3, "{key}: {filtered} not {by_hand}");
    }
}

#[test]
fn equal_runs_give_equal_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for preset in ["robust", "paper"] {
        let run = |name: &str, threads: &str| {
            let output = folder.path().join(preset).join(name);
            track(&demo(), &output).args(["--preset", preset]).env("RAYON_NUM_THREADS", threads).assert().success();
            let mut summary = summary(&output);
            summary.as_object_mut().unwrap().remove("timing");
            (fs::read(output.join("path.csv")).unwrap(), summary)
        };
        let first = run("first", "4");
        assert!(first == run("again", "4"), "{preset}: a second run");
        assert!(first == run("one", "1"), "{preset}: one thread");
    }
}

#[test]
fn locale_time_zone_working_directory_and_threads_change_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("recording");
    let copied = recording(folder.path(), 20);
    assert_eq!(copied, input);
    let run = |name: &str, threads: &str, locale: &str, zone: &str, from: &Path| {
        let output = folder.path().join(name);
        let mut command = track(&input, &output);
        command.args(["--trace", "--tum"]).current_dir(from).env("RAYON_NUM_THREADS", threads);
        command.env("LC_ALL", locale).env("LANG", locale).env("TZ", zone).assert().success();
        let mut summary = summary(&output);
        summary.as_object_mut().unwrap().remove("timing");
        let bytes = ["path.csv", "trace.csv", "filtered.tum"].map(|file| fs::read(output.join(file)).unwrap());
        (bytes, summary)
    };
    let first = run("first", "1", "C", "UTC", folder.path());
    let others = [
        ("two", "2", "C", "UTC", folder.path()),
        ("german", "1", "de_DE.UTF-8", "Europe/Berlin", folder.path()),
        ("turkish", "2", "tr_TR.UTF-8", "Asia/Istanbul", Path::new("/")),
        ("far", "1", "ja_JP.UTF-8", "Pacific/Kiritimati", &input),
    ];
    for (name, threads, locale, zone, from) in others {
        assert!(first == run(name, threads, locale, zone, from), "{name}");
    }
}

#[test]
fn a_truth_without_a_seam_in_any_frame_gives_no_errors_and_says_what_the_values_are() {
    let folder = tempfile::tempdir().unwrap();
    let truth = folder.path().join("truth.csv");
    let lines: String = (0..58).map(|frame| format!("{frame},,\n")).collect();
    fs::write(&truth, format!("frame,u_px,v_px\n{lines}")).unwrap();
    let output = folder.path().join("run");
    let told = line_with(&["truth.csv", "no seam in any frame", "values of what is no seam"]);
    track(&demo(), &output).arg("--truth").arg(&truth).assert().code(3).stderr(told);
    assert!(summary(&output).get("errors").is_none_or(Value::is_null));
    fs::write(&truth, "frame,u_px,v_px\n900,1,1\n").unwrap();
    let other = folder.path().join("other");
    track(&demo(), &other)
        .arg("--truth")
        .arg(&truth)
        .assert()
        .code(1)
        .stderr(line_with(&["truth.csv", "no frame of this recording"]));
}
