//! Made-up recordings: what a renderer must keep to be trusted.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bare;

use std::path::Path;

use bare::{bare, ridge};
use rayon::prelude::*;
use seamtrack::frame::GrayFrame;
use seamtrack::synth::scenario::{Butt, Joint, Lap, Ramp, Recorder, Spatter};
use seamtrack::synth::{Scenario, Scene, builtin};
use seamtrack::units::{PixelPoint, StripeAxis};

fn built_in(name: &str) -> Scenario {
    builtin::scenario(name).unwrap()
}

/// Grey over the background, summed over a band of rows, for each column.
fn light_in_rows(frame: &GrayFrame, rows: std::ops::Range<usize>) -> Vec<f64> {
    (0..frame.width_px()).map(|u| rows.clone().map(|v| f64::from(frame.row(v)[u].saturating_sub(9))).sum()).collect()
}

/// Where a profile crosses half its height, going down or up, nearest to `from`.
fn half_crossing(profile: &[f64], from: f64, height: f64) -> f64 {
    let crossing = |i: usize| {
        let (a, b) = (profile[i] - 0.5 * height, profile[i + 1] - 0.5 * height);
        (a * b <= 0.0 && a != b).then(|| i as f64 + a / (a - b))
    };
    (0..profile.len() - 1).filter_map(crossing).min_by(|a, b| (a - from).abs().total_cmp(&(b - from).abs())).unwrap()
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads_in_any_order() {
    for name in ["I-butt-heavy", "hairline-arc", "recorder"] {
        let scene = Scene::new(&Scenario { frames: 24, ..built_in(name) }, 5).unwrap();
        let forwards: Vec<GrayFrame> = (0..24).map(|i| scene.render(i)).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let again = Scene::new(&Scenario { frames: 24, ..built_in(name) }, 5).unwrap();
        let backwards: Vec<GrayFrame> =
            pool.install(|| (0..24).into_par_iter().rev().map(|i| again.render(i)).collect());
        assert!(forwards.iter().eq(backwards.iter().rev()), "{name}");
        let other = Scene::new(&built_in(name), 6).unwrap();
        assert_ne!(forwards[3], other.render(3), "{name}: another seed is another recording");
    }
}

#[test]
fn every_built_in_scene_renders_and_keeps_its_seam_inside_the_image() {
    builtin::names().par_iter().for_each(|name| {
        for seed in 1..=3 {
            let scene = Scene::new(&built_in(name), seed).unwrap();
            let frame = scene.render(scene.frame_count() / 2);
            for seam in (0..scene.frame_count()).filter_map(|i| scene.truth(i).seam) {
                let inside = |x: f64, size: usize| x > 4.0 && x < size as f64 - 4.0;
                assert!(inside(seam.u_px, frame.width_px()) && inside(seam.v_px, frame.height_px()), "{name} {seam:?}");
            }
        }
    });
}

#[test]
fn the_truth_of_a_butt_joint_is_the_midpoint_of_the_two_edges_in_the_picture() {
    let scene = Scene::new(&bare("A-butt"), 1).unwrap();
    for i in [0, 7, 100] {
        let (seam, gap) = (scene.truth(i).seam.unwrap(), scene.truth(i).gap_px.unwrap());
        let v = seam.v_px.round() as usize;
        let plates = light_in_rows(&scene.render(i), v - 10..v + 14);
        let plate = plates[(seam.u_px - 30.0) as usize];
        let left = half_crossing(&plates, seam.u_px - 0.5 * gap, plate);
        let right = half_crossing(&plates, seam.u_px + 0.5 * gap, plate);
        assert!((0.5 * (left + right) - seam.u_px).abs() < 0.05, "frame {i}: {left} {right} {seam:?}");
        assert!((right - left - gap).abs() < 0.3, "frame {i}: {left} {right}");
    }
}

#[test]
fn the_truth_of_a_lap_joint_is_the_midpoint_between_the_stripes_ends() {
    let scene = Scene::new(&bare("B-lap"), 1).unwrap();
    let seam = scene.truth(20).seam.unwrap();
    let frame = scene.render(20);
    let v = seam.v_px.round() as usize;
    let (upper, lower) = (light_in_rows(&frame, v - 24..v), light_in_rows(&frame, v + 1..v + 25));
    let end = half_crossing(&upper, seam.u_px, upper[(seam.u_px - 40.0) as usize]);
    let start = half_crossing(&lower, seam.u_px, lower[(seam.u_px + 40.0) as usize]);
    assert!((0.5 * (end + start) - seam.u_px).abs() < 0.35, "{end} {start} {seam:?}");
}

/// The scene on a sensor of 5 million pixels, the stripe's standard width and tilt as given.
fn on_a_large_sensor(name: &str, sigma_px: f64, tilt: f64) -> Scenario {
    let mut scenario = bare(name);
    (scenario.image.width_px, scenario.image.height_px) = (2592, 2048);
    (scenario.stripe.sigma_px, scenario.stripe.tilt) = (sigma_px, tilt);
    scenario
}

#[test]
fn the_centroid_of_thin_and_thick_tilted_stripes_in_a_large_picture_is_where_the_truth_has_it() {
    for sigma_px in [0.8, 1.3, 5.0] {
        let scene = Scene::new(&on_a_large_sensor("A-butt", sigma_px, 0.268), 1).unwrap();
        let seam = scene.truth(9).seam.unwrap();
        let frame = scene.render(9);
        // From 120 px on nothing is left of the droop of the gap's edges.
        for u in (60..2540).step_by(31).filter(|&u| (u as f64 - seam.u_px).abs() > 120.0) {
            let expected = seam.v_px + 0.268 * (u as f64 - seam.u_px);
            assert!((ridge(&frame, u) - expected).abs() < 0.02, "σ {sigma_px}: {} {expected}", ridge(&frame, u));
        }
    }
}

#[test]
fn the_truth_of_a_gap_and_a_step_hundreds_of_pixels_wide_is_what_the_picture_shows() {
    let mut butt = on_a_large_sensor("A-butt", 3.0, 0.0);
    butt.joint = Joint::Butt(Butt { gap_px: Ramp::Constant(267.0), depth_px: 200.0, ..Butt::default() });
    let scene = Scene::new(&butt, 1).unwrap();
    let seam = scene.truth(5).seam.unwrap();
    assert_eq!(scene.truth(5).gap_px, Some(267.0));
    let v = seam.v_px.round() as usize;
    let plates = light_in_rows(&scene.render(5), v - 15..v + 20);
    let plate = plates[(seam.u_px - 300.0) as usize];
    let edges = [-133.5, 133.5].map(|half| half_crossing(&plates, seam.u_px + half, plate));
    assert!((0.5 * (edges[0] + edges[1]) - seam.u_px).abs() < 0.05, "{edges:?} {seam:?}");

    let mut lap = on_a_large_sensor("B-lap", 3.0, 0.0);
    lap.joint = Joint::Lap(Lap { step_px: Ramp::Constant(533.0), glint: 0.0, ..Lap::default() });
    let scene = Scene::new(&lap, 1).unwrap();
    let seam = scene.truth(5).seam.unwrap();
    let frame = scene.render(5);
    let rows = [-300, 300].map(|away| ridge(&frame, (seam.u_px as i64 + away) as usize));
    assert!((rows[0] - seam.v_px + 266.5).abs() < 0.02 && (rows[1] - seam.v_px - 266.5).abs() < 0.02, "{rows:?}");
}

#[test]
fn half_the_gain_is_half_the_light_and_thicker_spatter_covers_more() {
    let frame = |gain: f64, thickness: f64| {
        let mut scenario = bare("A-butt");
        // What overflows is not halved.
        (scenario.sensor.gain, scenario.sensor.bloom) = (gain, 0.0);
        scenario.arc_on_frame = 0;
        scenario.spatter = Some(Spatter { tracks: 15.0, thickness, ..Spatter::default() });
        Scene::new(&scenario, 1).unwrap().render(3)
    };
    let (full, half) = (frame(1.0, 1.0), frame(0.5, 1.0));
    for (full, half) in full.pixels().iter().zip(half.pixels()).filter(|(full, _)| **full < 255) {
        assert!((f64::from(*full) / 2.0 - f64::from(*half)).abs() <= 0.75, "{full} {half}");
    }
    let lit = |frame: &GrayFrame| frame.pixels().iter().filter(|grey| **grey > 60).count();
    assert!(lit(&frame(1.0, 3.0)) > 2 * lit(&full));
}

fn intersection_of_lines(frame: &GrayFrame, left: [usize; 2], right: [usize; 2]) -> PixelPoint {
    let slope = |[a, b]: [usize; 2]| (ridge(frame, b) - ridge(frame, a)) / (b as f64 - a as f64);
    let (l, r) = (slope(left), slope(right));
    let (vl, vr) = (ridge(frame, left[0]), ridge(frame, right[0]));
    let u = (vr - vl + l * left[0] as f64 - r * right[0] as f64) / (l - r);
    PixelPoint::new(u, vl + l * (u - left[0] as f64))
}

#[test]
fn the_truth_of_a_groove_and_a_fillet_is_where_the_lines_in_the_picture_meet() {
    for (name, near, far) in [("D-vgroove-sine", 8, 28), ("E-fillet", 40, 140)] {
        let scene = Scene::new(&bare(name), 1).unwrap();
        let seam = scene.truth(40).seam.unwrap();
        let u = seam.u_px.round() as usize;
        let met = intersection_of_lines(&scene.render(40), [u - far, u - near], [u + near, u + far]);
        assert!((met.u_px - seam.u_px).abs() < 0.1 && (met.v_px - seam.v_px).abs() < 0.1, "{name}: {met:?} {seam:?}");
    }
}

#[test]
fn a_vertical_stripe_is_the_horizontal_one_turned() {
    let mut vertical = bare("A-butt");
    vertical.image.stripe = StripeAxis::Vertical;
    (vertical.image.width_px, vertical.image.height_px) = (480, 640);
    let (a, b) = (Scene::new(&bare("A-butt"), 1).unwrap(), Scene::new(&vertical, 1).unwrap());
    assert_eq!(a.render(3).transposed(), b.render(3));
    assert_eq!(a.truth(3).seam.unwrap().transposed(), b.truth(3).seam.unwrap());
}

#[test]
fn covers_hide_the_seam_and_say_so() {
    let scene = Scene::new(&built_in("H-butt-covers"), 2).unwrap();
    let covered: Vec<usize> = (0..250).filter(|&i| scene.truth(i).occluded).collect();
    assert!(covered.len() > 15 && covered[0] >= 15, "{covered:?}");
    // What is left of the break of the stripe in a covered frame: nothing that depends on where the seam is.
    let i = covered[0];
    let seam = scene.truth(i).seam.unwrap();
    let frame = scene.render(i);
    let column = |u: f64| -> f64 {
        let v = seam.v_px as usize;
        (v - 4..v + 5).map(|row| f64::from(frame.row(row)[u as usize])).sum::<f64>() / 9.0
    };
    let above = |u: f64| -> f64 {
        let v = seam.v_px as usize - 20;
        (v - 4..v + 5).map(|row| f64::from(frame.row(row)[u as usize])).sum::<f64>() / 9.0
    };
    for offset in [-30.0, -15.0, 15.0, 30.0] {
        let contrast = column(seam.u_px + offset) - above(seam.u_px + offset);
        assert!(contrast.abs() < 45.0, "the stripe shines through the cover by {contrast} grey");
    }
}

#[test]
fn repeated_frames_are_equal_byte_for_byte_and_missing_ones_leave_a_gap_in_time() {
    let recorder = Recorder { repeated: 0.3, dropped: 0.2, jitter_s: 0.0 };
    let scene = Scene::new(&Scenario { recorder, frames: 60, ..built_in("B-lap") }, 3).unwrap();
    let repeats = (1..60).filter(|&i| scene.is_repeated(i)).count();
    assert!((8..30).contains(&repeats), "{repeats}");
    let mut gaps = 0;
    for i in 1..60 {
        let step_s = scene.timestamp_s(i) - scene.timestamp_s(i - 1);
        assert!(step_s > 0.19);
        gaps += usize::from(step_s > 0.39);
        if scene.is_repeated(i) {
            assert_eq!(scene.render(i), scene.render(i - 1));
            assert_eq!(scene.truth(i), scene.truth(i - 1));
        } else {
            assert_ne!(scene.render(i), scene.render(i - 1));
        }
    }
    assert!(gaps >= 4, "{gaps}");
}

#[test]
fn outside_its_extent_and_on_a_flat_plate_there_is_no_truth() {
    let scene = Scene::new(&built_in("joint-start-end"), 1).unwrap();
    assert!(scene.truth(29).seam.is_none() && scene.truth(30).seam.is_some());
    assert!(scene.truth(219).seam.is_some() && scene.truth(220).seam.is_none());
    let flat = Scene::new(&built_in("flat"), 1).unwrap();
    assert!((0..250).all(|i| flat.truth(i).seam.is_none()));
}

#[test]
fn what_is_committed_as_demonstration_is_what_the_scenario_renders() {
    for name in ["demo-butt", "demo-hairline"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name);
        let scenario = Scenario::load(&folder.join("scenario.toml")).unwrap();
        assert_eq!(scenario, built_in(name), "run `seamtrack synth {name} -o fixtures/{name} --force`");
        let scene = Scene::new(&scenario, scenario.seed).unwrap();
        for i in [0, 30, 57] {
            let committed = image::open(folder.join(format!("frames/frame_{i:06}.png"))).unwrap().to_luma8();
            let rendered = scene.render(i);
            let pairs = committed.as_raw().iter().zip(rendered.pixels());
            // Exponentials differ in the last place between processors, and so may one grey value in many.
            let different = pairs.filter(|(a, b)| a.abs_diff(**b) > 1).count();
            assert!(different * 10_000 < rendered.pixels().len(), "{name}, frame {i}: {different} pixels differ");
        }
    }
}

#[test]
fn a_scenario_survives_being_written_and_read() {
    for name in builtin::names() {
        let scenario = built_in(&name);
        assert_eq!(Scenario::from_toml(&scenario.to_toml().unwrap(), &name).unwrap(), scenario, "{name}");
    }
}

#[test]
fn unknown_keys_and_numbers_out_of_range_are_refused_by_name() {
    let text = built_in("A-butt").to_toml().unwrap();
    for (from, to, named) in [
        ("frames = 250", "frames = 250\nframse = 3", "framse"),
        ("frames = 250", "frames = 0", "frames"),
        ("gap_px = 13.0", "gap_px = -1.0", "gap_px"),
        ("gap_px = 13.0", "gap_px = nan", "gap_px"),
        ("gap_px = 13.0", "gap_with = 3.0", "gap_with"),
        ("tilt = 0.03", "tilt = inf", "tilt"),
        ("width_px = 640", "width_px = 2593", "width_px"),
        ("gain = 1.0", "gain = 0.0", "gain"),
        ("bent_length_px = 11.0", "bent_length_px = 0.0", "bent_length_px"),
        ("px_per_frame = 0.548", "px_per_frame = nan", "px_per_frame"),
    ] {
        assert!(text.contains(from), "{from} in {text}");
        let error = Scenario::from_toml(&text.replacen(from, to, 1), "my.toml").unwrap_err().to_string();
        assert!(error.contains(named), "{to}: {error}");
    }
}

#[test]
fn a_path_that_leaves_the_image_is_refused_with_the_remedy() {
    let mut scenario = built_in("A-butt");
    scenario.frames = 2000;
    let error = Scene::new(&scenario, 1).unwrap_err().to_string();
    assert!(error.contains("path shorter"), "{error}");
    scenario.joint = Joint::Flat;
    assert!(Scene::new(&scenario, 1).is_ok(), "a plate without a joint has no path to leave the image");
}

#[test]
fn from_level_to_level_the_picture_gets_worse() {
    let spoiled = |level: &str| -> usize {
        let clean = Scene::new(&built_in("butt-clean"), 1).unwrap();
        let scene = Scene::new(&built_in(&format!("butt-{level}")), 1).unwrap();
        (20..40)
            .map(|i| {
                let (a, b) = (clean.render(i), scene.render(i));
                a.pixels().iter().zip(b.pixels()).filter(|(a, b)| a.abs_diff(**b) > 60).count()
            })
            .sum()
    };
    let counts = ["mild", "medium", "severe", "heavy"].map(spoiled);
    assert!(counts.is_sorted() && counts[0] > 0, "{counts:?}");
}
