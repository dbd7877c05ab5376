use super::*;
use crate::synth::{Scene, builtin};
use crate::tracker::{RobustSettings, SeamPath};
use crate::units::MmPerPx;

fn scene(name: &str, frames: usize) -> Scene {
    let mut scenario = builtin::scenario(name).unwrap();
    scenario.frames = frames;
    Scene::new(&scenario, 1).unwrap()
}

fn session() -> Session {
    let method = Method::Robust(RobustSettings::default());
    let sensor = Sensor::Scale(MmPerPx::DU_2022);
    Session::new(&SessionSettings { sensor, ..SessionSettings::new(method) }).unwrap()
}

/// The estimates of a scene's frames, 0.2 s apart.
fn follow(session: &mut Session, scene: &Scene) -> Vec<Estimate> {
    let frames = 0..scene.frame_count();
    frames.map(|i| session.step(&scene.render(i), 0.2 * i as f64).unwrap()).collect()
}

#[test]
fn a_camera_that_freezes_is_believed_for_a_moment_then_coasts_then_is_lost() {
    let (scene, mut session) = (scene("butt-clean", 60), session());
    let seen = follow(&mut session, &scene);
    let last = scene.render(59);
    let frozen: Vec<Estimate> = (60..260).map(|i| session.step(&last, 0.2 * f64::from(i)).unwrap()).collect();
    assert!(frozen[..5].iter().all(|estimate| estimate.status == Status::Tracked && estimate.repeated));
    assert_eq!((frozen[5].status, frozen[5].observation), (Status::Coasting, Observation::Frozen));
    let std_px = |estimate: &Estimate| estimate.seam.unwrap().std_px;
    assert!(std_px(&frozen[6]) > std_px(&seen[59]), "σ must grow");
    assert!(frozen[60..].iter().all(|estimate| estimate.status == Status::Lost && estimate.seam.is_none()));
}

#[test]
fn after_misses_the_picture_from_before_them_is_no_sighting() {
    let (scene, mut session) = (scene("butt-clean", 40), session());
    follow(&mut session, &scene);
    for i in 40..70 {
        session.miss(0.2 * f64::from(i)).unwrap();
    }
    let again = session.step(&scene.render(39), 14.0).unwrap();
    assert!(again.status != Status::Tracked && again.observation == Observation::Frozen, "{again:?}");
}

#[test]
fn a_seam_that_leaves_the_picture_is_lost_there_and_no_value_is_given_beside_the_picture() {
    let (scene, mut session) = (scene("butt-clean", 120), session());
    // The camera is led away by 6 px a frame: what it sees is cut out further and further to the right.
    let seen = |i: usize| {
        let (wide, left) = (scene.render(i), if i < 20 { 0 } else { 6 * (i - 20) }.min(240));
        let pixels = (0..wide.height_px()).flat_map(|v| wide.row(v)[left..left + 400].to_vec()).collect();
        GrayFrame::new(400, wide.height_px(), pixels).unwrap()
    };
    let estimates: Vec<Estimate> = (0..120).map(|i| session.step(&seen(i), 0.2 * i as f64).unwrap()).collect();
    assert!(estimates[40].status == Status::Tracked);
    let points = estimates.iter().filter_map(|estimate| estimate.seam).map(|seam| seam.centre.u_px);
    assert!(points.clone().all(|u_px| (0.0..400.0).contains(&u_px)), "{points:?}");
}

#[test]
fn one_stamp_out_of_place_costs_next_to_nothing() {
    let scene = scene("butt-clean", 140);
    let largest_px = |stamp: &dyn Fn(usize) -> f64| {
        let mut session = session();
        let error = |i: usize| {
            let estimate = session.step(&scene.render(i), stamp(i)).unwrap();
            estimate.seam.map_or(0.0, |seam| (seam.centre.u_px - scene.truth(i).seam.unwrap().u_px).abs())
        };
        (0..140).map(error).fold(0.0, f64::max)
    };
    let even = largest_px(&|i| 0.2 * i as f64);
    let hurried = largest_px(&|i| if i == 70 { 0.2 * 71.0 - 0.03 } else { 0.2 * i as f64 });
    let backwards = largest_px(&|i| if i == 70 { 3.0 } else { 0.2 * i as f64 });
    let ahead = largest_px(&|i| if i == 70 { 3600.0 } else { 0.2 * i as f64 });
    for odd in [hurried, backwards, ahead] {
        assert!(odd < even + 0.7, "{odd} px against {even} px");
    }
}

#[test]
fn a_frame_of_another_size_is_an_error_and_the_session_goes_on() {
    let (scene, mut session) = (scene("hairline-clean", 12), session());
    for i in 0..6 {
        session.step(&scene.render(i), 0.2 * i as f64).unwrap();
    }
    let small = GrayFrame::filled(64, 48, 9).unwrap();
    assert!(matches!(session.step(&small, 1.2), Err(TrackerError::FrameSize { now: (64, 48), .. })));
    assert!(session.step(&scene.render(7), 1.4).is_ok());
}

#[test]
fn frames_before_the_first_stripe_do_not_shift_the_smoothed_path() {
    const DARK: usize = 5;
    let (scene, mut session, mut path) = (scene("butt-clean", 20), session(), SeamPath::default());
    let first = scene.render(0);
    for i in 0..DARK {
        // Its noise makes each a picture of its own.
        let mut dark = GrayFrame::filled(first.width_px(), first.height_px(), 7).unwrap();
        dark.pixels_mut()[i] = 8;
        let estimate = session.step(&dark, 0.2 * i as f64).unwrap();
        assert_eq!(estimate.status, Status::Seeking);
        path.push(&estimate);
    }
    for i in 0..scene.frame_count() {
        path.push(&session.step(&scene.render(i), 0.2 * (DARK + i) as f64).unwrap());
    }
    let smoothed = path.smoothed().unwrap();
    assert_eq!(smoothed.len(), DARK + scene.frame_count());
    assert_eq!(session.joint().unwrap().frame, DARK);
    for (i, seam) in smoothed[DARK..].iter().enumerate() {
        let (seam, truth) = (seam.unwrap(), scene.truth(i).seam.unwrap());
        assert!((seam.centre.u_px - truth.u_px).abs() < 0.5, "frame {i}: {seam:?} against {truth:?}");
        assert!((seam.centre.v_px - truth.v_px).abs() < 1.0, "frame {i}: {seam:?} against {truth:?}");
    }
}

#[test]
fn a_joint_found_after_repeated_pictures_has_the_number_of_its_own_frame() {
    let (scene, mut session) = (scene("hairline-clean", 60), session());
    let mut frame = 0_u32;
    for i in 0..60 {
        let picture = scene.render(i);
        for _ in 0..2 {
            let was_known = session.joint().is_some();
            session.step(&picture, 0.2 * f64::from(frame)).unwrap();
            if let Some(joint) = session.joint().filter(|_| !was_known) {
                assert_eq!(joint.frame, frame as usize);
                return;
            }
            frame += 1;
        }
    }
    panic!("no joint was found");
}

#[test]
fn a_joint_asked_for_that_is_not_the_joint_seen_is_contradicted() {
    let scene = scene("vgroove-clean", 25);
    let robust = RobustSettings { joint: Some(crate::imgproc::geometry::JointKind::Butt), ..RobustSettings::default() };
    let mut session = Session::new(&SessionSettings::new(Method::Robust(robust))).unwrap();
    follow(&mut session, &scene);
    assert!(session.joint().is_none_or(|joint| joint.contradicted_by == Some("vgroove")), "{:?}", session.joint());
}

/// A picture as large as those of the scene, with a bright line from top to bottom.
fn lamp(scene: &Scene) -> GrayFrame {
    let (width, height) = size_px(&scene.render(0));
    let mut lamp = GrayFrame::filled(width, height, 8).unwrap();
    for (i, pixel) in lamp.pixels_mut().iter_mut().enumerate() {
        let off_px = (i % width) as f64 - 200.0 - 0.1 * (i / width) as f64;
        *pixel += (180.0 * (-0.5 * (off_px / 2.0).powi(2)).exp()) as u8;
    }
    lamp
}

#[test]
fn a_lamp_in_the_first_frames_does_not_hide_the_stripe_that_runs_the_other_way() {
    let (scene, mut session) = (scene("butt-clean", 60), session());
    assert_eq!(session.step(&lamp(&scene), 0.0).unwrap().status, Status::Seeking);
    assert_eq!(session.axis(), Some(StripeAxis::Vertical));
    let estimates: Vec<Estimate> = (1..60).map(|i| session.step(&scene.render(i), 0.2 * i as f64).unwrap()).collect();
    assert_eq!(session.axis(), Some(StripeAxis::Horizontal));
    let last = estimates.last().unwrap();
    let truth = scene.truth(59).seam.unwrap();
    assert!((last.seam.unwrap().centre.u_px - truth.u_px).abs() < 2.0, "{last:?}");
}

#[test]
fn a_place_that_was_given_still_holds_when_the_stripe_turns_out_to_run_the_other_way() {
    let scene = scene("butt-clean", 80);
    let seam = scene.truth(0).seam.unwrap();
    let seed_at = Some(PixelPoint::new(seam.u_px - 150.0, seam.v_px));
    let settings = SessionSettings { seed_at, ..SessionSettings::new(Method::Robust(RobustSettings::default())) };
    let mut session = Session::new(&settings).unwrap();
    session.step(&lamp(&scene), 0.0).unwrap();
    let refused = (1..80).find_map(|i| session.step(&scene.render(i), 0.2 * i as f64).err());
    assert_eq!(session.axis(), Some(StripeAxis::Horizontal));
    assert!(matches!(refused, Some(TrackerError::NothingAtSeed { .. })), "there is no joint at that place");
}
