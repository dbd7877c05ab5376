//! The whole chain on rendered boards: pictures → camera → plane → millimetres, against what was rendered.

use nalgebra::Vector2;
use rand_pcg::Pcg32;
use seamtrack::calib::check::{check_boards, check_plate, stripe_points};
use seamtrack::calib::file::CalibrationFile;
use seamtrack::calib::laser_camera::LaserCamera;
use seamtrack::calib::plane::LaserPlane;
use seamtrack::synth::board::{BoardSurface, StepSurface};

use crate::sensor::{Bench, SQUARE_MM, board};

/// Corners of a rendered board are where the lens puts them: the renderer, checked by the detector.
#[test]
fn a_rendered_boards_corners_lie_where_its_pose_says() {
    let bench = Bench::new();
    let mut random = Pcg32::new(5, 1);
    let scene = bench.renderer.scene();
    for pose in scene.draw_poses(board(), SQUARE_MM, 3, &mut random) {
        let surface = BoardSurface { size: board(), square_mm: SQUARE_MM, pose };
        let frame = bench.renderer.render(&surface, false, &mut random).unwrap();
        let corners = seamtrack::calib::corners::find_any(&frame).unwrap();
        assert_eq!(corners.size, board());
        let truth = board().points_mm(SQUARE_MM).into_iter().map(|p| scene.pixel(&pose.camera_from_board(&p)).unwrap());
        let errors: Vec<Vector2<f64>> = corners.pixels.iter().zip(truth).map(|(seen, truth)| seen - truth).collect();
        let mean = errors.iter().sum::<Vector2<f64>>() / errors.len() as f64;
        let worst = errors.iter().map(|e| e.norm()).fold(0.0, f64::max);
        assert!(mean.norm() < 0.03 && worst < 0.25, "mean {mean}, worst {worst} px");
    }
}

/// One seed in the suite; `cargo run --example sensor_truth -- 24` gives the figures of docs/calibration.md.
#[test]
fn a_rendered_sensor_is_calibrated_and_its_files_and_checks_agree() {
    let bench = Bench::new();
    let (dark, lit) = bench.pictures(1, 12);
    let (camera, laser) = bench.calibrate(dark, lit).unwrap();
    let trial = bench.compare(1, &camera, &laser).unwrap();
    println!("{trial}");
    assert!(trial.relative.iter().all(|e| e.norm() < 0.06), "{trial}");
    assert!(trial.lateral_error_mm.abs() < 0.02 && trial.step_error_mm.abs() < 0.2, "{trial}");
    assert!(trial.absolute.iter().all(|(e, s)| e.x.abs() < 5.0 * s.x && e.y.abs() < 5.0 * s.y), "{trial}");

    // The file gives the same sensor back.
    let mut file = CalibrationFile::default();
    file.set_camera(camera.size_px, laser.sensor.intrinsics());
    let n = laser.sensor.plane().normal();
    let section = seamtrack::calib::file::LaserSection {
        normal: [n.x, n.y, n.z],
        distance_mm: laser.sensor.plane().distance_mm(),
        rms_mm: None,
        views: None,
    };
    file.laser = Some(section);
    file.set_covariance(laser.sensor.covariance().unwrap());
    file.seal("2026-01-01".into());
    let again = CalibrationFile::parse(&file.to_toml().unwrap()).unwrap().laser_camera().unwrap();
    let pixel = seamtrack::units::PixelPoint::new(480.0, 380.0);
    let (a, b) = (again.point(pixel).unwrap(), laser.sensor.point(pixel).unwrap());
    assert!((a.height_mm - b.height_mm).abs() < 1e-9 && (a.lateral_mm - b.lateral_mm).abs() < 1e-9);

    // A flat plate in the calibrated range passes; a laser that was moved by a degree and a half does not.
    let mut random = Pcg32::new(9, 9);
    let plate = bench.renderer.render(&StepSurface { distance_mm: 250.0, step_mm: 0.0 }, true, &mut random).unwrap();
    let seen = |sensor: &LaserCamera| vec![stripe_points(sensor, &plate).unwrap()];
    let checked = check_plate(&laser.sensor, &seen(&laser.sensor), 0.2, 0.0).unwrap();
    let flat = checked.figures.iter().filter(|f| f.name != "outside the calibrated range");
    assert!(flat.clone().count() == 2 && flat.clone().all(|f| f.is_good()), "{checked:?}");
    let views: Vec<_> = laser.views.iter().map(|view| view.seen.clone()).collect();
    assert!(check_boards(&laser.sensor, (board(), SQUARE_MM), &views, 0.2).unwrap().is_good());
    let turned = laser.sensor.plane().varied([0.0, 0.026, 0.0]);
    let moved =
        LaserCamera::new(camera.size_px, *laser.sensor.intrinsics(), turned, laser.sensor.range().copied(), None);
    assert!(!check_boards(&moved, (board(), SQUARE_MM), &views, 0.2).unwrap().is_good());
    let lifted = LaserPlane::new(n, laser.sensor.plane().distance_mm() + 20.0).unwrap();
    let lifted =
        LaserCamera::new(camera.size_px, *laser.sensor.intrinsics(), lifted, laser.sensor.range().copied(), None);
    let out = check_plate(&lifted, &seen(&lifted), 0.2, 0.0).unwrap();
    assert!(!out.is_good(), "{out:?}");
}
