//! From board images to a seam in millimetres: `track --calibration`.

use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use seamtrack::calib::file::{CalibrationFile, RangeSection};
use seamtrack::report::results::{PathRow, read_path_csv};
use serde_json::Value;

fn seamtrack(words: &[&str]) -> Command {
    let mut command = Command::cargo_bin("seamtrack").unwrap();
    command.args(words);
    command
}

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    /// A made-up recording before the documented sensor.
    fn synth(&self, scene: &str, frames: &str, more: &[&str]) {
        let rec = self.path("rec");
        seamtrack(&["synth", scene, "-o", &rec, "--frames", frames]).args(more).assert().success();
    }

    fn rows(&self, run: &str) -> Vec<PathRow> {
        read_path_csv(Path::new(&self.path(run)).join("path.csv").as_path()).unwrap()
    }

    fn summary(&self, run: &str) -> Value {
        serde_json::from_str(&std::fs::read_to_string(self.path(run) + "/summary.json").unwrap()).unwrap()
    }

    /// The scene's true sensor, known without error, in a file of this range.
    fn true_sensor(&self, scene: &str, range: Option<RangeSection>) -> String {
        let scenario = seamtrack::synth::builtin::scenario(scene).unwrap();
        let sensor = seamtrack::synth::true_sensor(&scenario).unwrap().unwrap();
        let mut file = seamtrack::synth::board::recording::true_calibration(&sensor);
        file.range = range;
        let path = self.path("sensor.toml");
        std::fs::write(&path, file.to_toml().unwrap()).unwrap();
        path
    }
}

const EVERYWHERE: RangeSection =
    RangeSection { u_px: [0.0, 1e4], v_px: [0.0, 1e4], lateral_mm: [-1e3, 1e3], height_mm: [-1e3, 0.0] };

/// The whole chain: boards are rendered, camera and plane calibrated from them, a seam is tracked, and the truth in millimetres
/// is compared with what comes out.
#[test]
fn boards_become_a_calibration_and_a_seam_true_millimetres_with_two_uncertainties() {
    let place = Place::new();
    let path = |name: &str| place.path(name);
    place.synth("sensor-butt", "60", &["--boards", "10", "--seed", "5"]);
    let camera = ["calibrate", "camera", &path("rec/boards"), "--square", "15", "-o", &path("camera.toml")];
    seamtrack(&camera).assert().success();
    let calibration = path("calibration.toml");
    let laser = ["calibrate", "laser", &path("rec/stripes"), "--camera", &path("camera.toml"), "-o", &calibration];
    seamtrack(&laser).assert().success();
    let (frames, truth, run) = (path("rec/frames"), path("rec/truth.csv"), path("run"));
    seamtrack(&["track", &frames, "--calibration", &calibration, "--truth", &truth, "-o", &run])
        .assert()
        .success()
        .stdout(contains("Lateral error in the laser's plane").and(contains("Millimetres by")));

    let summary = place.summary("run");
    assert!(summary["calibration"]["file"]["laser"]["distance_mm"].is_number(), "{}", summary["calibration"]);
    assert!(summary["calibration"].get("mm_per_px").is_none());
    for axis in ["lateral", "height"] {
        let errors = &summary["plane_errors"][axis];
        let of = |key: &str| errors[key].as_f64().unwrap();
        assert!(of("bias_in_calib_std").abs() < 4.0 && of("bias_mm").abs() < 0.4, "{axis}: {errors}");
        assert!(of("scatter_mm") < 1.5 * of("noise_std_mm"), "{axis}: {errors}");
        assert!(of("scatter_in_2sigma") > 0.9, "{axis}: {errors}");
    }
    let rows = place.rows("run");
    let inside = rows.iter().filter(|row| row.calibrated == Some(true)).count();
    assert!(inside * 10 > rows.len() * 9, "{inside} of {}", rows.len());
    let row = rows.iter().rfind(|row| row.lateral_mm.is_some()).unwrap();
    assert!(row.calib_lateral_std_mm.unwrap() > 0.0 && row.calib_height_std_mm.unwrap() > 0.0);
    // The two σ are told apart: the filter's does not hold the calibration's.
    assert_eq!(row.x_std_mm, row.lateral_std_mm);

    let eval = seamtrack(&["eval", &run, &truth, "--json"]).output().unwrap();
    let errors: Value = serde_json::from_slice(&eval.stdout).unwrap();
    assert!(errors["filtered"]["mae_mm"].as_f64().unwrap() < 0.15, "{errors}");
    assert_eq!(errors["plane"]["height"]["frames"], summary["plane_errors"]["height"]["frames"]);
    seamtrack(&["eval", &run, &truth]).assert().success().stdout(contains("in the plane"));
    seamtrack(&["report", &run]).assert().success();
}

/// Share of the frames in which a measure lies within twice its σ of what was drawn, and its mean error.
fn against(rows: &[PathRow], truth: f64, of: impl Fn(&PathRow) -> Option<(f64, f64)>) -> (f64, f64, usize) {
    let found: Vec<(f64, f64)> = rows.iter().filter_map(of).collect();
    let within = found.iter().filter(|(value, std)| (value - truth).abs() <= 2.0 * std).count();
    let mean = found.iter().map(|(value, _)| value - truth).sum::<f64>() / found.len() as f64;
    (within as f64 / found.len() as f64, mean, found.len())
}

#[test]
fn a_grooves_width_depth_angle_and_area_are_those_that_were_drawn() {
    let place = Place::new();
    place.synth("sensor-vgroove", "60", &[]);
    let sensor = place.true_sensor("sensor-vgroove", Some(EVERYWHERE));
    seamtrack(&["track", &place.path("rec/frames"), "--calibration", &sensor, "-o", &place.path("run")])
        .assert()
        .success();
    let rows = place.rows("run");
    let angle_deg = 2.0 * (5.6f64 / 12.0).atan().to_degrees();
    let figures = [
        ("width", against(&rows, 11.2, |r| r.groove_width_mm.zip(r.groove_width_std_mm)), 0.15),
        ("depth", against(&rows, 12.0, |r| r.depth_mm.zip(r.depth_std_mm)), 0.2),
        ("angle", against(&rows, angle_deg, |r| r.opening_angle_deg.zip(r.opening_angle_std_deg)), 0.5),
        ("area", against(&rows, 67.2, |r| r.area_mm2.zip(r.area_std_mm2)), 1.5),
        ("hi-lo", against(&rows, 0.5, |r| r.hi_lo_mm.zip(r.hi_lo_std_mm)), 0.3),
    ];
    for (name, (within, mean, frames), tolerance) in figures {
        println!("{name}: {mean:+.3}, {:.0} % of {frames} within 2σ", 100.0 * within);
        assert!(mean.abs() < tolerance && frames > 50, "{name}: {mean} over {frames}");
    }
    assert!(figures[0].1.0 > 0.85 && figures[1].1.0 > 0.85 && figures[3].1.0 > 0.85, "{figures:?}");
    assert!(rows.iter().all(|row| row.gap_mm.is_none() && row.root_opening_mm.is_none()));
}

#[test]
fn a_butt_joints_gap_and_mismatch_are_those_that_were_drawn() {
    let place = Place::new();
    place.synth("sensor-butt", "60", &[]);
    let sensor = place.true_sensor("sensor-butt", Some(EVERYWHERE));
    seamtrack(&["track", &place.path("rec/frames"), "--calibration", &sensor, "-o", &place.path("run")])
        .assert()
        .success();
    let rows = place.rows("run");
    let gap = against(&rows, 1.6, |r| r.gap_mm.zip(r.gap_std_mm));
    let hi_lo = against(&rows, 0.6, |r| r.hi_lo_mm.zip(r.hi_lo_std_mm));
    println!("gap {gap:?}, hi-lo {hi_lo:?}");
    assert!(gap.1.abs() < 0.1 && gap.0 > 0.9 && gap.2 > 50, "gap {gap:?}");
    assert!(hi_lo.1.abs() < 0.25 && hi_lo.0 > 0.85 && hi_lo.2 > 50, "hi-lo {hi_lo:?}");
    assert!(rows.iter().all(|row| row.root_opening_mm == row.gap_mm && row.area_mm2.is_none()));
}

#[test]
fn a_calibration_of_other_pictures_is_an_error_of_one_line() {
    let place = Place::new();
    let sensor = place.true_sensor("sensor-butt", None);
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/demo-butt");
    let run = place.path("run");
    let track = |more: &[&str]| {
        let mut command = seamtrack(&["track", demo.to_str().unwrap(), "-o", &run]);
        command.args(more).assert()
    };
    track(&["--calibration", &sensor]).code(1).stderr(contains("1000 x 750").and(contains("400 x 240")));
    track(&["--calibration", &sensor, "--stripe", "vertical"]).code(1).stderr(contains("leave --stripe out"));
    track(&["--calibration", &sensor, "--mm-per-px", "0.1"]).code(2);
    track(&["--calibration", &place.path("none.toml")]).code(1).stderr(contains("none.toml"));
    std::fs::write(place.path("camera.toml"), "schema_version = 1\n").unwrap();
    track(&["--calibration", &place.path("camera.toml")]).code(1).stderr(contains("calibrate camera"));
    assert!(!Path::new(&run).exists());
}

#[test]
fn pictures_cut_out_of_the_calibrated_ones_give_the_same_millimetres() {
    let place = Place::new();
    place.synth("sensor-butt", "24", &[]);
    let sensor = place.true_sensor("sensor-butt", Some(EVERYWHERE));
    let (at, size) = ([150, 200], [700, 400]);
    std::fs::create_dir(place.path("cut")).unwrap();
    for frame in std::fs::read_dir(place.path("rec/frames")).unwrap().map(|entry| entry.unwrap().path()) {
        let cut = image::open(&frame).unwrap().crop_imm(at[0], at[1], size[0], size[1]);
        cut.save(Path::new(&place.path("cut")).join(frame.file_name().unwrap())).unwrap();
    }
    let (whole, cut, truth) = (place.path("rec/frames"), place.path("cut"), place.path("rec/truth.csv"));
    let track = |frames: &str, run: &str, more: &[&str]| {
        let run = place.path(run);
        seamtrack(&["track", frames, "--calibration", &sensor, "-o", &run]).args(more).assert()
    };
    track(&whole, "whole", &["--truth", &truth]).success();
    track(&cut, "cut-run", &[]).code(1).stderr(contains("--crop-at"));
    track(&cut, "cut-run", &["--crop-at", "400x200"]).code(1).stderr(contains("beyond the calibrated picture"));
    track(&cut, "cut-run", &["--crop-at", "150x200"]).success().stdout(contains("cut out at 150x200"));
    let (whole, cut) = (place.rows("whole"), place.rows("cut-run"));
    let both: Vec<_> =
        whole.iter().zip(&cut).filter(|(a, b)| a.lateral_mm.is_some() && b.lateral_mm.is_some()).collect();
    assert!(both.len() > 12, "{} of {}", both.len(), whole.len());
    for (a, b) in both {
        // The same light, looked at from another corner of the picture.
        assert!((a.lateral_mm.unwrap() - b.lateral_mm.unwrap()).abs() < 0.15, "{a:?} {b:?}");
        assert!((a.u_px.unwrap() - b.u_px.unwrap() - f64::from(at[0])).abs() < 1.0, "{a:?} {b:?}");
        assert_eq!(b.calibrated, Some(true));
    }
    // What was kept of the calibration belongs to the cut pictures.
    let camera = &place.summary("cut-run")["calibration"]["file"]["camera"];
    assert_eq!(camera["cx"].as_f64(), Some(507.0 - f64::from(at[0])));
}

#[test]
fn a_scale_with_its_uncertainty_comes_from_a_file_too() {
    let place = Place::new();
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/demo-butt");
    let (scale, run) = (place.path("scale.toml"), place.path("run"));
    std::fs::write(&scale, "schema_version = 1\n[scale]\nmm_per_px = 0.073\nstd_mm_per_px = 0.0004\naxis = \"u\"\n")
        .unwrap();
    seamtrack(&["track", demo.to_str().unwrap(), "--calibration", &scale, "-o", &run])
        .assert()
        .success()
        .stdout(contains("0.073 ± 0.000400 mm/px"));
    let calibration = &place.summary("run")["calibration"];
    assert_eq!((calibration["mm_per_px"].as_f64(), calibration["std_mm_per_px"].as_f64()), (Some(0.073), Some(0.0004)));
    let rows = place.rows("run");
    assert!(rows.iter().all(|row| row.x_mm.is_some() && row.lateral_mm.is_none() && row.calibrated.is_none()));
    std::fs::write(place.path("poses.csv"), "1 2 3 0 0 0\n").unwrap();
    seamtrack(&[
        "track",
        demo.to_str().unwrap(),
        "--calibration",
        &scale,
        "--poses",
        &place.path("poses.csv"),
        "-o",
        &run,
    ])
    .assert()
    .code(1)
    .stderr(contains("calibrate laser"));
}

#[test]
fn outside_the_calibrated_range_the_row_and_the_verdict_say_so_and_poses_lead_into_the_base() {
    let place = Place::new();
    place.synth("sensor-butt", "24", &[]);
    let narrow = RangeSection { height_mm: [-10.0, 0.0], ..EVERYWHERE };
    let sensor = place.true_sensor("sensor-butt", Some(narrow));
    let (frames, poses) = (place.path("rec/frames"), place.path("poses.csv"));
    // The flange looks down from 500 mm and goes along x by 2 mm a frame; the camera hangs 100 mm below it.
    let line = |i: usize| format!("{},20,500,180,0,0\n", 300 + 2 * i);
    std::fs::write(&poses, "x,y,z,rx,ry,rz\n".to_owned() + &(0..24).map(line).collect::<String>()).unwrap();
    std::fs::write(place.path("hand.txt"), "1 0 0 0\n0 1 0 0\n0 0 1 100\n0 0 0 1\n").unwrap();
    let hand = place.path("hand.txt");
    let track = |more: &[&str]| {
        let words = ["track", &frames, "--calibration", &sensor, "--force", "-o", &place.path("run")];
        seamtrack(&words).args(more).assert()
    };
    track(&["--poses", &poses]).code(1).stderr(contains("--hand-eye"));
    track(&["--poses", &poses, "--hand-eye", &hand])
        .success()
        .stdout(contains("CHECK").and(contains("outside of what was calibrated")));
    let rows = place.rows("run");
    assert!(rows.iter().all(|row| row.u_px.is_none() == row.calibrated.is_none() && row.calibrated != Some(true)));

    let sensor = CalibrationFile::read(Path::new(&sensor)).unwrap().laser_camera().unwrap();
    let tum = std::fs::read_to_string(place.path("run/base-filtered.tum")).unwrap();
    assert_eq!(tum.lines().count(), rows.iter().filter(|row| row.u_px.is_some()).count());
    let row = &rows[10];
    let pixel = seamtrack::units::PixelPoint::new(row.u_px.unwrap(), row.v_px.unwrap());
    let camera_mm = sensor.camera_point_mm(pixel).unwrap();
    let expected_mm = [320.0 + camera_mm.x, 20.0 - camera_mm.y, 400.0 - camera_mm.z];
    let line = tum.lines().nth(10).unwrap();
    let numbers: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
    assert_eq!(numbers[0], row.time_s);
    for (found, expected) in numbers[1..4].iter().zip(expected_mm) {
        // path.csv has three decimals of a pixel, and a pixel half a millimetre of height.
        assert!((1000.0 * found - expected).abs() < 1e-3, "{line}: {expected_mm:?}");
    }
    std::fs::write(&poses, "1 2 3 0 0 0\n").unwrap();
    track(&["--poses", &poses, "--hand-eye", &hand]).code(1).stderr(contains("1 poses for 24 frames"));
    std::fs::write(&poses, "1 2 3 0\n").unwrap();
    track(&["--poses", &poses, "--hand-eye", &hand]).code(1).stderr(contains("poses.csv").and(contains("line 1")));
}
