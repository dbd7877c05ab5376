use super::*;
use crate::synth::families::plate_scenes;
use crate::synth::{Scene, builtin};

/// The frames of a scene, small enough to be quick, and where its seam is in the first.
fn scene(name: &str, frames: usize) -> Scene {
    let mut scenario = builtin::scenario(name).unwrap();
    scenario.frames = frames;
    Scene::new(&scenario, 1).unwrap()
}

/// What a seeker finds first, and in which frame.
fn first_found(seeker: &mut Seeker, scene: &Scene) -> Option<(usize, Found)> {
    (0..scene.frame_count()).find_map(|i| match seeker.look(&scene.render(i)) {
        Found::Nothing { .. } => None,
        found => Some((i, found)),
    })
}

fn seeker() -> Seeker {
    Seeker::new(None, Parts::default(), true, true)
}

fn place_of(found: &Found) -> PixelPoint {
    match found {
        Found::Joint { seed, .. } => seed.fit.centre,
        Found::Hairline { sighting, .. } => sighting.centre,
        Found::Nothing { .. } => panic!("nothing was found"),
    }
}

#[test]
fn a_gap_is_found_within_ten_frames_and_a_dark_frame_shows_not_even_a_stripe() {
    let mut seeker = seeker();
    let dark = GrayFrame::filled(320, 240, 10).unwrap();
    assert!(matches!(seeker.look(&dark), Found::Nothing { stripe_seen: false, .. }));
    let (frame, found) = first_found(&mut seeker, &scene("A-butt", 10)).unwrap();
    assert!(matches!(&found, Found::Joint { seed, .. } if seed.model.kind == JointKind::Butt), "in frame {frame}");
}

#[test]
fn a_place_that_was_given_is_where_the_joint_is_found_and_at_no_other() {
    let scene = scene("A-butt", ASKED_FRAMES + 1);
    let there = place_of(&first_found(&mut seeker(), &scene).unwrap().1);
    let mut told = seeker();
    told.seed_at(there, 1.0);
    let (frame, found) = first_found(&mut told, &scene).unwrap();
    assert!(frame == 0 && (place_of(&found).u_px - there.u_px).abs() < 12.0);

    let mut misled = seeker();
    misled.seed_at(PixelPoint::new(there.u_px - 170.0, there.v_px), 1.0);
    assert!(first_found(&mut misled, &scene).is_none());
    let (kind, seen) = misled.asked_in_vain().unwrap().unwrap();
    assert!(kind == JointKind::Butt && (seen.u_px - there.u_px).abs() < 30.0, "{seen:?}");
}

#[test]
fn a_place_is_remembered_while_there_is_no_stripe() {
    let scene = scene("A-butt", 12);
    let there = place_of(&first_found(&mut seeker(), &scene).unwrap().1);
    let mut told = seeker();
    told.seed_at(there, 1.0);
    for _ in 0..=ASKED_FRAMES {
        told.look(&GrayFrame::filled(320, 240, 10).unwrap());
    }
    assert!(told.asked_in_vain().is_none());
    assert_eq!(first_found(&mut told, &scene).unwrap().0, 0);
}

#[test]
fn at_the_toe_of_a_cap_no_hairline_is_found_however_often_one_frame_hides_the_cap() {
    let plates = plate_scenes().unwrap();
    let capped = plates.iter().find(|plate| plate.name() == "bead-cap-vgroove-severe").unwrap();
    let scene = Scene::new(&capped.scenario().unwrap(), 201).unwrap();
    let mut seeker = seeker();
    let found = (0..30).map(|i| seeker.look(&scene.render(i)));
    assert!(found.into_iter().all(|found| matches!(found, Found::Nothing { .. })));
}
