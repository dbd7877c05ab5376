//! The families of difficult plates: what is drawn over a scene must not move its truth, and must be where it says.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bare;

use bare::{light, ridge};
use rayon::prelude::*;
use seamtrack::eval::read_truth;
use seamtrack::frame::GrayFrame;
use seamtrack::output::Existing;
use seamtrack::synth::families::plate_scenes;
use seamtrack::synth::recording::write_recording;
use seamtrack::synth::scenario::Joint;
use seamtrack::synth::scenario::{
    Bead, DeadPixels, Edges, Finish, LineGap, MarkForm, Marks, OtherStripe, Plates, Rivals, SecondSeam, Shape, Vgroove,
    Vibration, View,
};
use seamtrack::synth::{Scenario, Scene, builtin};

/// The scene without anything random in it, 120 frames of it.
fn bare(name: &str) -> Scenario {
    Scenario { frames: 120, ..bare::bare(name) }
}

fn scene(scenario: &Scenario) -> Scene {
    Scene::new(scenario, 1).unwrap()
}

/// The parabola through three columns' ridges, at another column.
fn parabola(frame: &GrayFrame, columns: [usize; 3], at: f64) -> f64 {
    let [a, b, c] = columns.map(|u| u as f64);
    let [va, vb, vc] = columns.map(|u| ridge(frame, u));
    va * (at - b) * (at - c) / ((a - b) * (a - c))
        + vb * (at - a) * (at - c) / ((b - a) * (b - c))
        + vc * (at - a) * (at - b) / ((c - a) * (c - b))
}

#[test]
fn every_family_on_every_joint_renders_keeps_its_seam_inside_and_survives_being_written() {
    plate_scenes().unwrap().par_iter().for_each(|plates| {
        let (name, scenario) = (plates.name(), plates.scenario().unwrap());
        assert_eq!(builtin::scenario(&name).unwrap(), scenario, "{name}");
        assert_eq!(Scenario::from_toml(&scenario.to_toml().unwrap(), &name).unwrap(), scenario, "{name}");
        for seed in [1, 2] {
            let scene = Scene::new(&scenario, seed).unwrap();
            for i in 0..scene.frame_count() {
                let truth = scene.truth(i);
                assert_eq!(truth.seam.is_some(), plates.joint != "flat", "{name}");
                for seam in truth.seam.into_iter().chain(truth.second) {
                    let inside = |x: f64, size: f64| x > 4.0 && x < size - 4.0;
                    assert!(inside(seam.u_px, 640.0) && inside(seam.v_px, 480.0), "{name} {seam:?}");
                }
            }
        }
        assert_eq!(scene(&scenario).render(75), scene(&scenario).render(75), "{name}");
    });
}

#[test]
fn what_is_laid_over_a_scene_does_not_move_its_truth() {
    let mut plain = builtin::scenario("A-butt").unwrap();
    plain.frames = 60;
    let before = scene(&plain);
    plain.plates.marks = vec![Marks::default(), Marks { form: MarkForm::Bar, beside_px: 30.0, ..Marks::default() }];
    plain.plates.finish = Finish { scale: 0.5, right_brightness: 0.25, grinding: 0.4, ..Finish::default() };
    plain.rivals.stripes = vec![OtherStripe::default()];
    plain.view = View { dead: vec![DeadPixels::default()], line_gaps: vec![LineGap::default()], ..View::default() };
    let after = scene(&plain);
    for i in 0..60 {
        assert_eq!(before.truth(i), after.truth(i));
        assert_ne!(before.render(i), after.render(i));
    }
}

#[test]
fn on_a_pipe_the_stripe_is_a_circle_of_the_stated_radius() {
    for radius_px in [400.0, -400.0] {
        let mut pipe = bare("flat");
        pipe.plates = Plates { shape: Shape { radius_px: Some(radius_px), ..Shape::default() }, ..Plates::default() };
        let frame = scene(&pipe).render(0);
        let top = ridge(&frame, 320);
        for from_axis in [60.0_f64, 150.0, 230.0] {
            let drop = radius_px.signum() * (radius_px.abs() - (radius_px * radius_px - from_axis * from_axis).sqrt());
            for u in [320.0 - from_axis, 320.0 + from_axis] {
                let row = ridge(&frame, u as usize);
                assert!((row - top - drop).abs() < 0.12, "{radius_px} {from_axis}: {} {drop}", row - top);
            }
        }
    }
}

#[test]
fn the_truth_of_a_fillet_on_a_pipe_is_where_the_bent_legs_meet() {
    for shape in [
        Shape { radius_px: Some(400.0), ..Shape::default() },
        Shape { left_radius_px: Some(400.0), right_radius_px: Some(-600.0), ..Shape::default() },
    ] {
        let mut pipe = bare("E-fillet");
        pipe.plates = Plates { shape, ..Plates::default() };
        let scene = scene(&pipe);
        for i in [0, 60, 119] {
            let (seam, frame) = (scene.truth(i).seam.unwrap(), scene.render(i));
            let u = seam.u_px.round() as usize;
            // The legs differ by .78 in slope: a tenth of a pixel in rows is an eighth along the stripe.
            for columns in [[u - 95, u - 65, u - 35], [u + 35, u + 65, u + 95]] {
                let met = parabola(&frame, columns, seam.u_px);
                assert!((met - seam.v_px).abs() < 0.25, "frame {i}: {met} {seam:?}");
            }
        }
    }
}

#[test]
fn a_bead_keeps_the_grooves_truth_and_its_toes_are_where_it_leaves_the_flanks() {
    let mut filled = bare("D-vgroove-sine");
    let groove = Vgroove { half_width_px: 62.0, depth_px: 58.0, ..Vgroove::default() };
    filled.joint = Joint::Vgroove(groove.clone());
    let open = scene(&filled);
    let bead = Bead { beside_px: 5.0, top_px: 34.0, half_width_px: 50.0, wander_px: 0.0, ..Bead::default() };
    filled.plates.beads = vec![bead];
    let scene = scene(&filled);
    for i in [0, 40] {
        let truth = scene.truth(i);
        assert_eq!(truth.seam, open.truth(i).seam);
        let (seam, [left, right]) = (truth.seam.unwrap(), truth.bead_toes_px.unwrap());
        let frame = scene.render(i);
        let plate = seam.v_px - groove.depth_px;
        let flank = |u: f64| plate + groove.depth_px * (1.0 - (u - seam.u_px).abs() / groove.half_width_px);
        // Outside the toes the flanks are seen, inside the bead above them.
        for u in [left - 9.0, left - 5.0, right + 5.0, right + 9.0] {
            assert!((ridge(&frame, u.round() as usize) - flank(u.round())).abs() < 0.3, "frame {i}, column {u}");
        }
        for u in [left + 6.0, right - 6.0] {
            assert!(ridge(&frame, u.round() as usize) < flank(u.round()) - 2.0, "frame {i}, column {u}");
        }
    }
}

#[test]
fn a_mark_passes_with_the_plates_and_what_is_fixed_to_the_picture_stays() {
    let mut plate = bare("flat");
    plate.plates.travel_px_per_frame = 2.0;
    plate.plates.marks = vec![Marks {
        per_100_frames: 1.0,
        width_px: 40.0,
        length_px: 60.0,
        reflectance: 0.1,
        near_seam_px: Some(100.0),
        ..Marks::default()
    }];
    plate.view.line_gaps = vec![LineGap { along: Some(0.1), transmission: 0.1, ..LineGap::default() }];
    let scene = scene(&plate);
    let dark = |frame: &GrayFrame, u: usize| light(frame, u) < 0.5 * light(frame, 590);
    let seen: Vec<Vec<usize>> = (0..120)
        .into_par_iter()
        .map(|i| {
            let frame = scene.render(i);
            assert!(dark(&frame, 64) && !dark(&frame, 44), "the gap of the laser's line stays where it is");
            (90..560).filter(|&u| dark(&frame, u)).collect()
        })
        .collect();
    let visible: Vec<usize> = (0..120).filter(|&i| seen[i].len() > 10).collect();
    assert!((9..=60).contains(&visible.len()), "a mark of 36 to 90 px passes at 2 px a frame: {visible:?}");
    let middle = |i: usize| seen[i].iter().sum::<usize>() as f64 / seen[i].len() as f64;
    let (first, last) = (middle(visible[0]), middle(visible[visible.len() - 1]));
    assert!((first - last).abs() < 15.0, "it does not move along the stripe: {first} {last}");
}

#[test]
fn a_dark_plate_has_its_stated_brightness() {
    let mut plates = bare("D-vgroove-sine");
    plates.plates.finish.right_brightness = 0.25;
    let scene = scene(&plates);
    let (seam, frame) = (scene.truth(0).seam.unwrap(), scene.render(0));
    let (left, right) = ((seam.u_px - 60.0) as usize, (seam.u_px + 60.0) as usize);
    let ratio = light(&frame, right) / light(&frame, left);
    assert!((ratio - 0.25).abs() < 0.02, "{ratio}");
}

#[test]
fn a_second_seam_is_drawn_where_its_truth_says() {
    let mut two = bare("B-lap");
    two.rivals = Rivals { second_seam: Some(SecondSeam { beside_px: 120.0 }), ..Rivals::default() };
    let scene = scene(&two);
    let (truth, frame) = (scene.truth(10), scene.render(10));
    let (first, second) = (truth.seam.unwrap(), truth.second.unwrap());
    assert!((second.u_px - first.u_px - 120.0).abs() < 1e-9);
    for seam in [first, second] {
        let (left, right) = ((seam.u_px - 30.0) as usize, (seam.u_px + 30.0) as usize);
        let step = ridge(&frame, right) - ridge(&frame, left);
        assert!((step.abs() - 24.0).abs() < 0.2, "{step}");
        assert!((0.5 * (ridge(&frame, left) + ridge(&frame, right)) - seam.v_px).abs() < 0.2, "{seam:?}");
    }
}

#[test]
fn a_changing_preparation_goes_from_one_joint_to_the_other_without_a_jump_of_the_truth() {
    let bevel = builtin::scenario("change-bevel-butt-medium").unwrap();
    let scene = scene(&Scenario {
        edges: Edges { raggedness_px: 0.0, ..Edges::default() },
        vibration: Vibration { along_px: 0.0, across_px: 0.0, ..Vibration::default() },
        variation: 0.0,
        ..bevel
    });
    let truth: Vec<_> = (0..150).map(|i| scene.truth(i)).collect();
    assert_eq!(truth[0].gap_px, Some(13.0));
    assert_eq!(truth[149].gap_px, Some(3.0));
    for pair in truth.windows(2) {
        let (a, b) = (pair[0].seam.unwrap(), pair[1].seam.unwrap());
        assert!((b.u_px - a.u_px - 0.548).abs() < 1e-9);
        assert!((b.v_px - a.v_px).abs() < 3.0, "{a:?} {b:?}");
    }
    let deeper = truth[149].seam.unwrap().v_px - truth[0].seam.unwrap().v_px;
    assert!((deeper - 34.0).abs() < 3.0, "the truth of a groove is its root: {deeper}");
}

#[test]
fn a_standstill_leaves_nothing_but_the_sensors_noise() {
    let mut still = bare("A-butt");
    still.stripe.speckle = 0.33;
    still.view.standstill_from_frame = Some(20);
    let quiet = scene(&still);
    assert_ne!(quiet.render(18), quiet.render(20));
    assert_eq!(quiet.render(20), quiet.render(60));
    assert_eq!(quiet.truth(20), quiet.truth(119));
    still.sensor.read_noise_grey = 1.6;
    let noisy = scene(&still);
    assert_ne!(noisy.render(20), noisy.render(60));
}

#[test]
fn sections_that_do_not_fit_the_joint_are_refused_by_name() {
    let mut scenario = bare("A-butt");
    scenario.plates.beads = vec![Bead::default()];
    assert!(scenario.check().unwrap_err().to_string().contains("beads need a V-groove"));
    let mut scenario = bare("E-fillet");
    scenario.rivals.second_seam = Some(SecondSeam { beside_px: 100.0 });
    assert!(scenario.check().unwrap_err().to_string().contains("second_seam needs"));
    let mut scenario = bare("flat");
    scenario.plates.shape.radius_px = Some(50.0);
    assert!(scenario.check().unwrap_err().to_string().contains("radii"));
}

#[test]
fn the_written_truth_has_columns_for_toes_and_a_second_seam_only_where_there_are_any() {
    let folder = tempfile::tempdir().unwrap();
    for (name, columns) in [
        ("A-butt", "frame,u_px,v_px,x_mm,occluded,gap_px"),
        ("bead-cap-vgroove-mild", "frame,u_px,v_px,x_mm,occluded,gap_px,bead_left_px,bead_right_px"),
        ("two-seams-lap-mild", "frame,u_px,v_px,x_mm,occluded,gap_px,second_px"),
    ] {
        let scenario = Scenario { frames: 3, ..builtin::scenario(name).unwrap() };
        let target = folder.path().join(name);
        write_recording(&scenario, &target, Existing::Keep, None, || {}).unwrap();
        let text = std::fs::read_to_string(target.join("truth.csv")).unwrap();
        assert_eq!(text.lines().next().unwrap(), columns);
        assert!(text.lines().all(|line| line.split(',').count() == columns.split(',').count()), "{text}");
        assert_eq!(read_truth(&target.join("truth.csv")).unwrap().len(), 3);
    }
}
