use super::super::candidate::LEDGE_DOUBT;
use super::*;
use crate::synth::{Scene, builtin};

/// A stripe of SD 2 px in the row that `row_px` says for each column, if there is one.
fn stripe(row_px: impl Fn(f64) -> Option<f64>) -> GrayFrame {
    let (width_px, height_px) = (1280, 960);
    let mut frame = GrayFrame::filled(width_px, height_px, 12).unwrap();
    for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
        let (u, v) = ((i % width_px) as f64, (i / width_px) as f64);
        if let Some(row_px) = row_px(u) {
            *pixel += (180.0 * (-0.5 * ((v - row_px) / 2.0).powi(2)).exp()).round() as u8;
        }
    }
    frame
}

/// A level stripe with a gap round column `middle_px`.
fn with_gap(middle_px: f64, gap_px: f64) -> GrayFrame {
    stripe(|u| ((u - middle_px).abs() > 0.5 * gap_px).then_some(480.0))
}

/// The raster in which a gap that moves by 2 px a frame is found, and its middle in the picture's last column.
fn found(gap_px: f64) -> (Raster, f64) {
    let settings = RobustSettings { joint: Some(JointKind::Butt), ..RobustSettings::default() };
    let mut levels = Levels::new(&settings, false);
    for frame in 0..10 {
        let middle_px = 600.0 + 2.0 * f64::from(frame);
        let (raster, found) = levels.look(&with_gap(middle_px, gap_px));
        if let Found::Joint { seed, .. } = found {
            return (raster, raster.picture_from_raster(seed.fit.centre).u_px - middle_px);
        }
    }
    panic!("a gap of {gap_px} px was not found");
}

#[test]
fn a_gap_belongs_to_the_finest_raster_that_holds_it() {
    let (raster, off_px) = found(12.0);
    assert!(raster == Raster::PICTURE && off_px.abs() < 1.0, "{off_px}");
    let (raster, off_px) = found(150.0);
    assert!(raster != Raster::PICTURE && off_px.abs() < 4.0, "{off_px}");
}

#[test]
fn a_high_step_that_a_coarse_raster_holds_does_not_hide_the_gap_that_a_fine_one_shows() {
    let mut levels = Levels::new(&RobustSettings::default(), true);
    let found = (0..20).find_map(|frame| {
        let middle_px = 500.0 + 2.0 * f64::from(frame);
        // The plate lies high above a table, which shows in the gap.
        let is_plate = |u: f64| (u - middle_px).abs() > 6.0 && u < middle_px + 420.0;
        match levels.look(&stripe(|u| Some(if is_plate(u) { 480.0 } else { 600.0 }))) {
            (raster, Found::Joint { seed, .. }) => {
                Some((seed.model.kind, raster.picture_from_raster(seed.fit.centre).u_px - middle_px))
            }
            _ => None,
        }
    });
    assert!(found.is_some_and(|(_, off_px)| off_px.abs() < 2.0), "{found:?}");
}

#[test]
fn a_frame_too_small_for_the_coarse_rasters_is_looked_at_in_its_own() {
    let mut levels = Levels::new(&RobustSettings::default(), false);
    let (raster, found) = levels.look(&GrayFrame::filled(200, 130, 12).unwrap());
    assert!(raster == Raster::PICTURE && matches!(found, Found::Nothing { stripe_seen: false, .. }));
}

/// What is found first in a scene: the kind, how far from the truth \[px\], and its doubt.
fn told(name: &str) -> (JointKind, f64, Option<&'static str>) {
    let mut scenario = builtin::scenario(name).unwrap();
    scenario.frames = 12;
    let scene = Scene::new(&scenario, 1).unwrap();
    let mut levels = Levels::new(&RobustSettings::default(), true);
    let looks = (0..scene.frame_count()).map(|frame| (frame, levels.look(&scene.render(frame)).1));
    let (frame, found) = looks.into_iter().find(|(_, found)| !matches!(found, Found::Nothing { .. })).unwrap();
    let Found::Joint { seed, doubt, .. } = found else { panic!("no joint with edges or a corner in {name}") };
    let truth = scene.truth(frame).seam.unwrap();
    (seed.model.kind, (seed.fit.centre.u_px - truth.u_px).abs(), doubt)
}

#[test]
fn beside_a_gap_the_end_of_a_plate_is_no_lap_joint_but_it_is_told() {
    for name in ["plate-end-butt-mild", "plate-end-butt-medium"] {
        let (found, off_px, doubt) = told(name);
        let is_so = found == JointKind::Butt && off_px < 3.0 && doubt == Some(OTHER_DOUBT);
        assert!(is_so, "{name}: {found:?} {off_px} {doubt:?}");
    }
}

#[test]
fn of_two_steps_or_corners_that_nearer_to_the_middle_is_meant_and_the_other_is_told() {
    for (name, kind) in [("plate-end-lap-medium", JointKind::Lap), ("standing-edge-fillet-mild", JointKind::Fillet)] {
        let (found, off_px, doubt) = told(name);
        assert!(found == kind && off_px < 3.0 && doubt.is_some(), "{name}: {found:?} {off_px} {doubt:?}");
    }
    assert_eq!(told("B-lap").2, None);
    assert_eq!(told("E-fillet").2, None);
}

/// The doubts of what is found in a stripe with the rows that `row_px` says, which moves by 2 px a frame.
fn doubts(row_px: impl Fn(f64) -> Option<f64>) -> Vec<Option<&'static str>> {
    let mut levels = Levels::new(&RobustSettings::default(), false);
    let found = (0..14).map(|frame| levels.look(&stripe(|u| row_px(u - 2.0 * f64::from(frame)))).1);
    found.filter_map(|found| if let Found::Joint { doubt, .. } = found { Some(doubt) } else { None }).collect()
}

#[test]
fn a_rib_or_a_clamp_on_a_plate_without_a_gap_is_doubted() {
    let rib = |u: f64| Some(if (u - 600.0).abs() < 20.0 { 462.0 } else { 480.0 });
    assert_eq!(doubts(rib).first(), Some(&Some(LEDGE_DOUBT)));
    let clamp = |u: f64| Some(if (u - 600.0).abs() < 70.0 { 380.0 } else { 480.0 });
    assert_eq!(doubts(clamp).first(), Some(&Some(LEDGE_DOUBT)));
}

#[test]
fn beside_a_gap_in_one_raster_nothing_is_found_in_another_without_a_doubt() {
    let clamp_and_gap = |u: f64| match u {
        u if (u - 640.0).abs() < 6.0 => None,
        u if (330.0..470.0).contains(&u) => Some(400.0),
        _ => Some(480.0),
    };
    assert!(doubts(clamp_and_gap).iter().all(Option::is_some));
    let gap = |u: f64| ((u - 640.0).abs() > 6.0).then_some(480.0);
    assert!(!doubts(gap).is_empty());
}
