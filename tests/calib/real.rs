//! Real boards and stripes outside the repository, through `SEAMTRACK_REAL_DATA`: the folders `abb-calibration` and
//! `abb-butt-scan1`. `cargo test --test calib real -- --nocapture` prints the figures of docs/calibration.md.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use seamtrack::calib::file::CalibrationFile;

fn data() -> Option<PathBuf> {
    let folder =
        std::env::var_os("SEAMTRACK_REAL_DATA").map(PathBuf::from).filter(|f| f.join("abb-calibration").is_dir());
    if folder.is_none() {
        eprintln!(
            "SKIPPED: SEAMTRACK_REAL_DATA names no folder with abb-calibration, so no real sensor was calibrated"
        );
    }
    folder
}

fn calibrate(words: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::cargo_bin("seamtrack").unwrap();
    command.arg("calibrate").args(words).assert()
}

fn shown(assert: &assert_cmd::assert::Assert) {
    eprintln!("{}", String::from_utf8_lossy(&assert.get_output().stdout));
}

#[test]
fn a_real_sensor_is_calibrated_and_contradictions_are_rejected() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let of = |name: &str| data.join(name).to_str().unwrap().to_owned();
    let boards = of("abb-calibration/Checkerboard_calib_cam");
    let stripes = of("abb-calibration/Checkerboard_calib_laser");
    let camera = calibrate(&["camera", &boards, "--square", "30", "-o", &path("camera.toml")]).success();
    shown(&camera);
    let file = CalibrationFile::read(Path::new(&path("camera.toml"))).unwrap();
    let section = file.camera.unwrap();
    assert!(section.rms_px.unwrap() <= 0.12 && section.left_out_rms_px.unwrap() <= 0.16);
    // mrcal 2.2 on the same boards.
    assert!((section.fx - 1430.45).abs() < 2.5, "{}", section.fx);
    let laser =
        calibrate(&["laser", &stripes, "--camera", &path("camera.toml"), "-o", &path("calibration.toml")]).success();
    shown(&laser);
    let text = String::from_utf8_lossy(&laser.get_output().stdout).into_owned();
    let contradicting: Vec<&str> = text.lines().filter(|line| line.contains("CONTRADICTS")).collect();
    assert!(contradicting.iter().any(|line| line.contains("laser_12")), "{contradicting:?}");
    let calibration = CalibrationFile::read(Path::new(&path("calibration.toml"))).unwrap();
    assert!(calibration.laser.unwrap().rms_mm.unwrap() <= 0.28);
    shown(&calibrate(&["check", &path("calibration.toml"), &stripes]).code(0).stdout(contains("GOOD")));

    // The plane that came with the pictures: z = 46.932 x − .86924 y + 2227.48.
    let theirs = "schema_version = 1\n[image]\nwidth = 1700\nheight = 1200\n[camera]\nfx = 1432.24163\nfy = 1433.29492\ncx = 930.97241\ncy = 586.67870\n\
        k1 = -0.1089308\nk2 = 0.1665885\np1 = -0.00043356\np2 = -0.00106477\nk3 = 0.1662276\n[laser]\nnormal = [46.93203, -0.86924, -1.0]\ndistance_mm = -2227.48098\n";
    std::fs::write(path("theirs.toml"), theirs).unwrap();
    let check = ["check", &path("theirs.toml"), &stripes, "--square", "30", "--board", "6x7"];
    shown(&calibrate(&check).code(3).stdout(contains("contradicts its images")));

    // A scan that was made after the laser had been moved.
    let scan = of("abb-butt-scan1");
    let check = ["check", &path("calibration.toml"), &scan, "--plate", "--crop-at", "560x400"];
    shown(&calibrate(&check).code(3).stdout(contains("BAD tilt").and(contains("BAD outside the calibrated range"))));
}

#[test]
fn the_scale_of_a_real_scan_comes_from_its_robot() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scale.toml");
    let (scan, poses) = (data.join("abb-butt-scan1"), data.join("abb-butt-scan1/robot_pose_per_frame.txt"));
    let words = ["scale", scan.to_str().unwrap(), "--poses", poses.to_str().unwrap(), "-o", file.to_str().unwrap()];
    let scale = calibrate(&words).success();
    shown(&scale);
    let scale = CalibrationFile::read(&file).unwrap().scale.unwrap();
    assert!((0.2145..=0.2169).contains(&scale.mm_per_px), "{}", scale.mm_per_px);
    eprintln!("scale of scan 1: {} ± {} mm/px", scale.mm_per_px, scale.std_mm_per_px);
    assert_eq!(scale.axis, "u");
}
