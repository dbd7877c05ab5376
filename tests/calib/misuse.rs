//! What goes wrong in a shop, each with its own name.

use nalgebra::{Rotation3, Vector3};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg32;
use seamtrack::calib::board::BoardSize;
use seamtrack::calib::camera::fit_camera;
use seamtrack::calib::detect::{BoardSighting, Detected, detect};
use seamtrack::calib::error::CalibrationError;
use seamtrack::calib::laser::{KnownCamera, fit_laser};
use seamtrack::calib::pairs::Pair;
use seamtrack::calib::pose::Pose;
use seamtrack::calib::stripes::find_stripes;
use seamtrack::frame::GrayFrame;
use seamtrack::synth::board::{BoardSurface, SensorScene};

use crate::sensor::{Bench, Memory, SQUARE_MM, board};

/// Corners as a perfect detector with noise would give them.
fn detected(poses: &[Pose], noise_px: f64) -> Detected {
    let scene = SensorScene::documented().unwrap();
    let mut random = Pcg32::new(3, 3);
    let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
    let sightings = poses.iter().enumerate().map(|(i, pose)| {
        let corner = |p| scene.pixel(&pose.camera_from_board(&p)).unwrap();
        let corners: Vec<_> = board().points_mm(SQUARE_MM).into_iter().map(corner).collect();
        let corners: Vec<_> = corners
            .into_iter()
            .map(|c| nalgebra::Vector2::new(c.x + noise_px * noise(), c.y + noise_px * noise()))
            .collect();
        let used = vec![true; corners.len()];
        Some(BoardSighting { name: format!("view_{i:02}.png"), sha256: i.to_string(), corners, used })
    });
    Detected { board: board(), size_px: scene.size_px, sightings: sightings.collect(), left_out: vec![] }
}

fn poses(count: usize) -> Vec<Pose> {
    SensorScene::documented().unwrap().draw_poses(board(), SQUARE_MM, count, &mut Pcg32::new(4, 4))
}

#[test]
fn one_pose_taken_many_times_is_one_pose() {
    let same = vec![poses(1)[0]; 12];
    let problem = fit_camera(detected(&same, 0.1), SQUARE_MM).unwrap_err();
    assert!(matches!(problem, CalibrationError::OnePose { pictures: 12, .. }), "{problem}");
    assert!(problem.to_string().contains("one pose"));
}

#[test]
fn parallel_boards_are_refused_whatever_their_residual() {
    let parallel = |tilt: f64| -> Vec<Pose> {
        let shift =
            |i: usize| Vector3::new(4.0 * (i % 4) as f64 - 6.0, 5.0 * (i / 4) as f64 - 5.0, 230.0 + 4.0 * i as f64);
        let rotation = |i: usize| Rotation3::new(Vector3::new(tilt, 0.01 * (i % 3) as f64, 0.05 * i as f64));
        (0..12).map(|i| Pose { rotation: rotation(i), translation_mm: shift(i) }).collect()
    };
    for tilt in [0.0, 0.02] {
        let problem = fit_camera(detected(&parallel(tilt), 0.1), SQUARE_MM).unwrap_err();
        assert!(matches!(problem, CalibrationError::ParallelBoards { .. }), "{problem}");
    }
}

#[test]
fn too_few_poses_are_counted_without_the_repeated_ones() {
    let mut few = poses(7);
    few.extend(few.clone());
    let problem = fit_camera(detected(&few, 0.1), SQUARE_MM).unwrap_err();
    assert!(matches!(problem, CalibrationError::TooFewViews { usable: 7, .. }), "{problem}");
    assert!(problem.to_string().contains("repeat the pose"), "{problem}");
}

#[test]
fn pictures_taken_three_times_do_not_make_the_camera_surer() {
    let once = poses(10);
    let thrice: Vec<Pose> = once.iter().cycle().take(30).copied().collect();
    let one = fit_camera(detected(&once, 0.1), SQUARE_MM).unwrap();
    let three = fit_camera(detected(&thrice, 0.1), SQUARE_MM).unwrap();
    assert_eq!(three.poses, 10);
    // New noise on each picture makes it a little surer; √3 it may not become by copies of systematic errors alone.
    assert!(three.covariance[(0, 0)].sqrt() > 0.5 * one.covariance[(0, 0)].sqrt());
}

#[test]
fn a_spoiled_corner_is_left_out_and_a_spoiled_view_is_named() {
    let mut seen = detected(&poses(12), 0.08);
    seen.sightings[2].as_mut().unwrap().corners[17].x += 22.0;
    for (i, corner) in seen.sightings[5].as_mut().unwrap().corners.iter_mut().enumerate() {
        corner.x += 2.0 * ((i % 6) as f64 - 2.5).powi(2);
    }
    let fit = fit_camera(seen, SQUARE_MM).unwrap();
    assert!(fit.rms_px < 0.15, "{}", fit.rms_px);
    assert!(fit.left_out.iter().any(|reason| reason.contains("view_05.png")), "{:?}", fit.left_out);
    let third = fit.views.iter().find(|view| view.sighting.name == "view_02.png").unwrap();
    assert!(!third.sighting.used[17] && third.sighting.used_corners() >= 40);
}

#[test]
fn a_part_of_the_board_mixed_sizes_and_pictures_without_a_board_are_named() {
    let bench = Bench::new();
    let mut random = Pcg32::new(1, 1);
    let surface = BoardSurface { size: board(), square_mm: SQUARE_MM, pose: poses(1)[0] };
    let frame = bench.renderer.render(&surface, false, &mut random).unwrap();
    let blank = GrayFrame::filled(1000, 750, 90).unwrap();
    let problem = |pictures: Vec<(&str, GrayFrame)>, declared: Option<BoardSize>| {
        let pictures = Memory(pictures.into_iter().map(|(name, frame)| (name.to_owned(), frame)).collect());
        detect(&pictures, declared).unwrap_err().to_string()
    };
    let part = problem(vec![("a.png", frame.clone())], Some(BoardSize::new(4, 5).unwrap()));
    assert!(part.contains("6x7") && part.contains("4x5") && part.contains("a.png"), "{part}");
    let mixed = problem(vec![("a.png", frame.clone()), ("b.png", GrayFrame::filled(640, 480, 90).unwrap())], None);
    assert!(mixed.contains("b.png") && mixed.contains("640 x 480"), "{mixed}");
    assert!(problem(vec![("c.png", blank.clone())], None).contains("c.png"));
    let pictures = Memory(vec![("a.png".into(), frame.clone()), ("copy.png".into(), frame), ("c.png".into(), blank)]);
    let seen = detect(&pictures, None).unwrap();
    assert_eq!(seen.sightings.iter().flatten().count(), 1);
    assert!(seen.left_out[0].contains("copy.png is the same picture as a.png"), "{:?}", seen.left_out);
    assert!(seen.left_out[1].contains("c.png does not show the whole board"), "{:?}", seen.left_out);
}

/// Boards with the laser off and on, the latter only where `lit` says so.
fn stripes_on(poses: &[Pose], lit: impl Fn(usize) -> bool) -> CalibrationError {
    let bench = Bench::new();
    let scene = bench.renderer.scene().clone();
    let mut random = Pcg32::new(8, 8);
    let mut picture = |i: usize, laser_on: bool| {
        let surface = BoardSurface { size: board(), square_mm: SQUARE_MM, pose: poses[i] };
        let word = if laser_on { "on" } else { "off" };
        (format!("{word}_{i:02}.png"), bench.renderer.render(&surface, laser_on && lit(i), &mut random).unwrap())
    };
    let dark: Vec<_> = (0..poses.len()).map(|i| picture(i, false)).collect();
    let both = Memory(dark.into_iter().chain((0..poses.len()).map(|i| picture(i, true))).collect());
    let pairs: Vec<Pair> = (0..poses.len()).map(|i| Pair { lit: poses.len() + i, dark: Some(i) }).collect();
    let (views, left_out) = find_stripes(&both, &pairs, board(), &scene.intrinsics, scene.size_px).unwrap();
    let known = KnownCamera {
        size_px: scene.size_px,
        intrinsics: scene.intrinsics,
        covariance: None,
        views: vec![],
        rms_px: None,
    };
    fit_laser(&known, (board(), SQUARE_MM), views, left_out, poses.len()).unwrap_err()
}

#[test]
fn boards_without_a_stripe_and_too_few_with_one_are_counted() {
    let poses = poses(9);
    let problem = stripes_on(&poses, |_| false);
    assert!(matches!(problem, CalibrationError::NoStripe { found: 0, pictures: 9, .. }), "{problem}");
    assert!(problem.to_string().contains("no straight laser stripe"), "{problem}");
    let problem = stripes_on(&poses, |i| i < 7);
    assert!(matches!(problem, CalibrationError::NoStripe { found: 7, pictures: 9, .. }), "{problem}");
    assert!(problem.to_string().contains("8 are the least"), "{problem}");
}

#[test]
fn stripes_at_one_height_make_no_plane() {
    let turned = |i: usize| {
        let rotation = Rotation3::new(Vector3::new(0.12 * (i as f64 - 4.0), 0.0, 0.06 * (i % 3) as f64));
        Pose { rotation, translation_mm: Vector3::new(2.0 * (i % 4) as f64, 0.0, 250.0) }
    };
    let problem = stripes_on(&(0..9).map(turned).collect::<Vec<_>>(), |_| true);
    assert!(matches!(problem, CalibrationError::TooLittleDepth { .. }), "{problem}");
    assert!(problem.to_string().contains("Move the board nearer and farther"), "{problem}");
}
