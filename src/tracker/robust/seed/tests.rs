use super::*;
use crate::imgproc::{CentrelineSettings, extract_centreline};

/// A frame of 320 x 240 px with a stripe of SD 2 px in row `row(u)`; none where it has no value.
fn drawn(row: impl Fn(f64) -> Option<f64>) -> GrayFrame {
    let mut frame = GrayFrame::filled(320, 240, 12).unwrap();
    for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
        let (u, v) = ((i % 320) as f64, (i / 320) as f64);
        let light = row(u).map_or(0.0, |row| 180.0 * (-0.5 * ((v - row) / 2.0).powi(2)).exp());
        *pixel += light.round() as u8;
    }
    frame
}

fn found(frame: &GrayFrame, kind: Option<JointKind>) -> Vec<Seed> {
    find(frame, &extract_centreline(frame, &CentrelineSettings::default()), kind)
}

fn gap(u: f64) -> Option<f64> {
    ((u - 150.0).abs() > 6.0).then_some(100.0)
}

fn step(u: f64) -> Option<f64> {
    ((u - 150.0).abs() > 3.0).then_some(if u < 150.0 { 100.0 } else { 118.0 })
}

fn groove(u: f64) -> Option<f64> {
    Some(100.0 + (35.0 - 0.8 * (u - 150.0).abs()).max(0.0))
}

fn corner(u: f64) -> Option<f64> {
    Some(100.0 + 0.4 * (u - 150.0).abs())
}

#[test]
fn each_joint_is_found_as_what_it_is_where_it_is() {
    type Row = fn(f64) -> Option<f64>;
    let joints: [(JointKind, Row); 4] =
        [(JointKind::Butt, gap), (JointKind::Lap, step), (JointKind::VGroove, groove), (JointKind::Fillet, corner)];
    for (kind, row) in joints {
        let seeds = found(&drawn(row), None);
        let seed = seeds.first().unwrap_or_else(|| panic!("no {kind:?}"));
        assert_eq!(seed.model.kind, kind);
        assert!((seed.fit.centre.u_px - 150.0).abs() < 1.5, "{kind:?}: {:?}", seed.fit.centre);
    }
}

#[test]
fn a_plain_stripe_and_an_empty_frame_hold_none() {
    assert!(found(&drawn(|u| Some(100.0 + 0.05 * u)), None).is_empty());
    assert!(found(&drawn(|_| None), None).is_empty());
}

#[test]
fn the_shoulder_of_a_groove_with_a_steep_wall_is_no_fillet() {
    let bevel = |u: f64| Some(100.0 + (u - 110.0).clamp(0.0, 40.0) - 4.0 * (u - 150.0).clamp(0.0, 10.0));
    assert!(found(&drawn(bevel), None).iter().all(|seed| seed.model.kind != JointKind::Fillet));
    assert!(found(&drawn(corner), None).iter().any(|seed| seed.model.kind == JointKind::Fillet));
}

#[test]
fn the_toe_of_a_cap_is_no_gap_but_a_second_gap_makes_none_of_the_first() {
    let cap = |u: f64| {
        let from_px = (u - 160.0).abs();
        let flank = 100.0 + (62.0 - from_px).max(0.0);
        Some(if from_px < 53.0 { flank.min(94.0 + 10.0 * (from_px / 53.0).powi(2)) } else { flank })
    };
    assert!(found(&drawn(cap), None).iter().all(|seed| seed.model.kind != JointKind::Butt));
    let two = |u: f64| ((u - 110.0).abs() > 6.0 && (u - 210.0).abs() > 6.0).then_some(100.0);
    assert!(found(&drawn(two), None).iter().any(|seed| seed.model.kind == JointKind::Butt));
}

#[test]
fn a_fillet_with_a_wide_worn_toe_is_found_where_its_legs_would_meet() {
    let worn = |u: f64| {
        let away_px = (u - 150.0) / 12.0;
        let rounded = 12.0 * ((-away_px.abs()).exp().ln_1p() + away_px.max(0.0));
        Some(60.0 + 0.7 * (u - 150.0) - 1.4 * rounded)
    };
    let seeds = found(&drawn(|u| worn(u).map(|v| v + 60.0)), None);
    let seed = seeds.iter().find(|seed| seed.model.kind == JointKind::Fillet).expect("a fillet");
    assert!((seed.fit.centre.u_px - 150.0).abs() < 1.5, "{:?}", seed.fit.centre);
}

#[test]
fn a_step_that_is_higher_than_it_is_open_is_a_lap_however_low() {
    let low = |u: f64| ((u - 150.0).abs() > 1.0).then_some(if u < 150.0 { 100.0 } else { 107.0 });
    let seeds = found(&drawn(low), None);
    assert!(seeds.iter().any(|seed| seed.model.kind == JointKind::Lap && (seed.fit.centre.u_px - 150.0).abs() < 1.5));
    let ledge = |u: f64| ((u - 150.0).abs() > 6.0).then_some(if u < 150.0 { 100.0 } else { 105.0 });
    assert!(found(&drawn(ledge), None).iter().any(|seed| seed.model.kind == JointKind::Butt));
}

#[test]
fn between_two_grooves_and_on_an_arc_there_is_no_groove() {
    let two = |u: f64| {
        let depth_px = |root_px: f64| (35.0 - 0.8 * (u - root_px).abs()).max(0.0);
        Some(100.0 + depth_px(100.0) + depth_px(220.0))
    };
    let grooves = |row: &dyn Fn(f64) -> Option<f64>| -> Vec<f64> {
        let seeds = found(&drawn(row), None).into_iter();
        seeds.filter(|seed| seed.model.kind == JointKind::VGroove).map(|seed| seed.fit.centre.u_px).collect()
    };
    let roots = grooves(&two);
    assert!(roots.iter().all(|u| (u - 160.0).abs() > 30.0) && !roots.is_empty(), "{roots:?}");
    let close = |u: f64| {
        let depth_px = |root_px: f64| (35.0 - 0.8 * (u - root_px).abs()).max(0.0);
        Some(100.0 + depth_px(112.0) + depth_px(208.0))
    };
    assert!(grooves(&close).iter().all(|u| (u - 160.0).abs() > 30.0), "{:?}", grooves(&close));
    let arc = |u: f64| Some(60.0 + (u - 160.0).powi(2) / 500.0);
    assert!(grooves(&arc).is_empty());
}

#[test]
fn a_joint_of_another_kind_than_asked_for_is_not_offered() {
    assert!(found(&drawn(groove), Some(JointKind::Lap)).iter().all(|seed| seed.model.kind == JointKind::Lap));
    assert!(found(&drawn(gap), Some(JointKind::Fillet)).is_empty());
}

#[test]
fn a_place_is_believed_where_there_is_a_joint_and_only_there() {
    let frame = drawn(gap);
    let seed = at(&frame, None, PixelPoint::new(154.0, 100.0)).unwrap();
    assert!(seed.certain && (seed.fit.centre.u_px - 150.0).abs() < 1.0, "{:?}", seed.fit.centre);
    assert!(at(&frame, None, PixelPoint::new(250.0, 100.0)).is_none());
}
