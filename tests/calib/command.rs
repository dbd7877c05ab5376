//! `seamtrack calibrate` as a user runs it.

use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use seamtrack::calib::file::CalibrationFile;
use seamtrack::calib::laser_camera::PlanePoint;
use seamtrack::frame::GrayFrame;
use seamtrack::synth::board::StepSurface;

use crate::sensor::Bench;

fn seamtrack(words: &[&str]) -> Command {
    let mut command = Command::cargo_bin("seamtrack").unwrap();
    command.arg("calibrate").args(words);
    command
}

fn save(folder: &Path, name: &str, frame: &GrayFrame) {
    std::fs::create_dir_all(folder).unwrap();
    image::GrayImage::from_raw(frame.width_px() as u32, frame.height_px() as u32, frame.pixels().to_vec())
        .unwrap()
        .save(folder.join(name))
        .unwrap();
}

#[test]
fn a_board_is_drawn_and_an_existing_file_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("board.svg");
    let file = file.to_str().unwrap();
    let words = ["board", "--squares", "7x8", "--square", "30", "-o", file];
    seamtrack(&words).assert().success().stdout(contains("6 x 7 inner corners"));
    assert!(std::fs::read_to_string(file).unwrap().starts_with("<svg"));
    seamtrack(&words).assert().code(1).stderr(contains("--force"));
    seamtrack(&["board", "--squares", "seven", "--square", "30", "-o", file]).assert().code(2);
}

#[test]
fn a_scale_comes_with_its_interval_and_refuses_what_determines_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let rows = |count: usize| {
        let row = |i: usize| {
            format!("{:.2};{:.1}\n", 5.0 * i as f64, 812.0 - 5.0 * i as f64 / 0.2 + 0.3 * ((i * 7) % 5) as f64)
        };
        "shift_mm;v_px\n".to_owned() + &(0..count).map(row).collect::<String>()
    };
    std::fs::write(path("gauge.csv"), rows(9)).unwrap();
    let words = ["scale", &path("gauge.csv"), "--axis", "v", "-o", &path("scale.toml")];
    seamtrack(&words).assert().success().stdout(contains("95 % between")).stdout(contains("left out"));
    let scale = CalibrationFile::read(Path::new(&path("scale.toml"))).unwrap().scale.unwrap();
    assert!((scale.mm_per_px - 0.2).abs() < 0.002 && scale.axis == "v" && scale.std_mm_per_px > 0.0);
    std::fs::write(path("few.csv"), rows(3)).unwrap();
    seamtrack(&["scale", &path("few.csv"), "-o", &path("few.toml")])
        .assert()
        .code(1)
        .stderr(contains("3 positions are too few"));
    assert!(!Path::new(&path("few.toml")).exists());
}

#[test]
fn nothing_is_written_over_what_is_read_or_what_nobody_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let rows: String = (0..9).map(|i| format!("{},{:.1}\n", 5 * i, 2.0 * f64::from(i))).collect();
    std::fs::write(path("gauge.csv"), format!("px,mm\n{rows}")).unwrap();
    let before = std::fs::read(path("gauge.csv")).unwrap();
    let over_input = ["scale", &path("gauge.csv"), "-o", &path("gauge.csv"), "--force"];
    seamtrack(&over_input).assert().code(1).stderr(contains("which is read"));
    assert_eq!(std::fs::read(path("gauge.csv")).unwrap(), before);
    // The page of camera.toml is camera.html.
    std::fs::create_dir(path("boards")).unwrap();
    std::fs::write(path("camera.html"), "mine").unwrap();
    let camera = |output: &str| {
        seamtrack(&["camera", &path("boards"), "--square", "15", "-o", &path(output), "--force"]).assert().code(1)
    };
    camera("camera.toml").stderr(contains("camera.html is no page of this program"));
    camera("other.html").stderr(contains("name a .toml"));
    camera("boards/camera.toml").stderr(contains("which is read"));
    assert_eq!(std::fs::read(path("camera.html")).unwrap(), b"mine");
}

#[test]
fn a_camera_goes_to_opencv_and_ros_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let text = "schema_version = 1\n[image]\nwidth = 1000\nheight = 750\n[camera]\nfx = 1250.0\nfy = 1252.0\ncx = 507.0\ncy = 371.0\nk1 = -0.11\nk2 = 0.15\n";
    std::fs::write(path("camera.toml"), text).unwrap();
    for dialect in ["opencv", "ros"] {
        let (yaml, back) = (path(&format!("{dialect}.yaml")), path(&format!("{dialect}.toml")));
        seamtrack(&["export", &path("camera.toml"), "--to", dialect, "-o", &yaml]).assert().success();
        seamtrack(&["import", &yaml, "-o", &back]).assert().success();
        let file = CalibrationFile::read(Path::new(&back)).unwrap();
        assert_eq!(file.size_px(), Some((1000, 750)));
        assert_eq!(file.intrinsics().unwrap().k1, -0.11);
    }
    seamtrack(&["import", &path("camera.toml"), "-o", &path("x.toml")])
        .assert()
        .code(1)
        .stderr(contains("camera.toml"));
}

/// The whole way of a user: pictures in folders, three commands, a check, and pages beside the files.
#[test]
fn boards_in_folders_become_a_calibration_that_passes_and_fails_its_checks() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let bench = Bench::new();
    let (dark, lit) = bench.pictures(2, 9);
    for (name, frame) in &dark.0 {
        save(&folder.path().join("camera"), name, frame);
        save(&folder.path().join("laser"), name, frame);
    }
    for (name, frame) in &lit.0 {
        save(&folder.path().join("laser"), name, frame);
    }
    std::fs::write(folder.path().join("camera/broken_99.png"), b"no picture").unwrap();
    let camera = ["camera", &path("camera"), "--square", "15", "-o", &path("camera.toml")];
    seamtrack(&camera)
        .assert()
        .success()
        .stdout(contains("views left out").and(contains("9 views: 14 are a good number")))
        .stderr(contains("broken_99.png"));
    let laser = ["laser", &path("laser"), "--camera", &path("camera.toml"), "-o", &path("calibration.toml")];
    seamtrack(&laser).assert().success().stdout(contains("laser plane").and(contains("together with the camera")));
    for page in ["camera.html", "calibration.html"] {
        let page = std::fs::read_to_string(path(page)).unwrap();
        assert!(page.contains("<svg") && !page.contains("NaN") && !page.contains("://"), "{}", &page[..200]);
    }
    let file = CalibrationFile::read(Path::new(&path("calibration.toml"))).unwrap();
    assert_eq!((file.images.len(), file.views.len()), (18, 9));
    assert!(file.id.len() == 12 && file.date.len() == 10);
    let sensor = file.laser_camera().unwrap();
    assert!(sensor.covariance().is_some() && sensor.range().is_some());
    let scene = bench.renderer.scene();
    let middle = scene.intrinsics.project(&scene.plane.axes().camera_from_plane(0.0, -230.0)).unwrap();
    let PlanePoint { lateral_mm, height_mm } = sensor.point(middle).unwrap();
    assert!(lateral_mm.abs() < 0.3 && (height_mm + 230.0).abs() < 0.6, "{lateral_mm} {height_mm}");

    // Its own boards, a flat plate, a step of 5 mm.
    seamtrack(&["check", &path("calibration.toml"), &path("laser")]).assert().code(0).stdout(contains("GOOD"));
    let mut random = rand_pcg::Pcg32::new(7, 7);
    for (name, step_mm) in [("plate", 0.0), ("step", 5.0)] {
        let frame = bench.renderer.render(&StepSurface { distance_mm: 250.0, step_mm }, true, &mut random).unwrap();
        save(&folder.path().join(name), "frame_0.png", &frame);
    }
    let in_plane = format!("{:.4}", 5.0 / scene.plane.axes().height.z.abs());
    let step = seamtrack(&["check", &path("calibration.toml"), &path("step"), "--step", &in_plane, "--json"])
        .output()
        .unwrap();
    let json: serde_json::Value = serde_json::from_slice(&step.stdout).unwrap();
    assert!(json["figures"][0]["value"].as_f64().unwrap().abs() < 0.2, "{json}");
    seamtrack(&["check", &path("calibration.toml"), &path("step"), "--step", "8"])
        .assert()
        .code(3)
        .stdout(contains("comes out as"));
    // A calibration whose laser was moved, and pictures of another size.
    let text = std::fs::read_to_string(path("calibration.toml")).unwrap();
    let distance = file.laser.unwrap().distance_mm;
    let moved = text.replace(&format!("distance_mm = {distance}"), &format!("distance_mm = {}", distance + 8.0));
    std::fs::write(path("moved.toml"), moved).unwrap();
    seamtrack(&["check", &path("moved.toml"), &path("laser")])
        .assert()
        .code(3)
        .stdout(contains("contradicts its images"));
    seamtrack(&["check", &path("moved.toml"), &path("plate"), "--plate"])
        .assert()
        .code(3)
        .stdout(contains("calibrated range"));
    save(&folder.path().join("small"), "frame_0.png", &GrayFrame::filled(640, 480, 50).unwrap());
    let other_size = ["check", &path("calibration.toml"), &path("small"), "--plate"];
    seamtrack(&other_size).assert().code(1).stderr(contains("640 x 480").and(contains("--crop-at")));
}

#[test]
fn folders_without_boards_and_files_that_are_no_calibration_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::create_dir(path("empty")).unwrap();
    seamtrack(&["camera", &path("empty"), "--square", "30", "-o", &path("c.toml")])
        .assert()
        .code(1)
        .stderr(contains("empty"));
    seamtrack(&["camera", &path("empty"), "--square", "-3", "-o", &path("c.toml")]).assert().code(2);
    save(&folder.path().join("blank"), "blank_1.png", &GrayFrame::filled(640, 480, 50).unwrap());
    seamtrack(&["camera", &path("blank"), "--square", "30", "-o", &path("c.toml")])
        .assert()
        .code(1)
        .stderr(contains("blank_1.png"));
    std::fs::write(path("bad.toml"), "fx = 3").unwrap();
    seamtrack(&["check", &path("bad.toml"), &path("blank"), "--plate"]).assert().code(1).stderr(contains("bad.toml"));
    std::fs::write(path("scale.toml"), "schema_version = 1\n[scale]\nmm_per_px = 0.2\n").unwrap();
    seamtrack(&["check", &path("scale.toml"), &path("blank"), "--plate"])
        .assert()
        .code(1)
        .stderr(contains("calibrate camera"));
}
