//! What a session remembers does not grow with the recording.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::ops::Range;

use seamtrack::config::Config;
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::{Session, SessionSettings, Status};

/// Allocations of one step while seeking, tracked, coasting, lost.
const MOST_ALLOCATIONS: [u64; 4] = [0, 0, 0, 0];

/// Bytes that `frames` more frames leave behind.
fn growth(session: &mut Session, scene: &Scene, frames: Range<usize>) -> i64 {
    let mut bytes = 0;
    for i in frames {
        let frame = scene.render(i);
        let used = allocation_counter::measure(|| {
            session.step(&frame, 0.2 * i as f64).unwrap();
        });
        bytes += used.bytes_current;
    }
    bytes
}

#[test]
fn a_session_holds_no_more_after_240_frames_than_after_120() {
    let mut scenario = builtin::scenario("H-butt-covers").unwrap();
    (scenario.frames, scenario.image.width_px, scenario.image.height_px) = (240, 400, 300);
    let scene = Scene::new(&scenario, 1).unwrap();
    let mut session = Session::new(&SessionSettings::new(Config::default().method().unwrap())).unwrap();
    growth(&mut session, &scene, 0..120);
    let later = growth(&mut session, &scene, 120..240);
    assert!(later < 64 * 1024, "120 frames left {later} bytes");
}

/// The most allocations of a step that ends in `status`, among `frames`.
fn most_allocations(session: &mut Session, scene: &Scene, frames: Range<usize>) -> [u64; 4] {
    let mut most = [0; 4];
    for i in frames {
        let frame = scene.render(i);
        let mut status = Status::Seeking;
        let used = allocation_counter::measure(|| status = session.step(&frame, 0.2 * i as f64).unwrap().status);
        let place = match status {
            Status::Seeking => 0,
            Status::Tracked => 1,
            Status::Coasting => 2,
            Status::Lost => 3,
        };
        most[place] = used.count_total.max(most[place]);
    }
    most
}

#[test]
fn a_step_allocates_no_more_often_late_in_a_recording_than_early() {
    let mut scenario = builtin::scenario("H-butt-covers").unwrap();
    (scenario.frames, scenario.image.width_px, scenario.image.height_px) = (240, 400, 300);
    let scene = Scene::new(&scenario, 1).unwrap();
    let mut session = Session::new(&SessionSettings::new(Config::default().method().unwrap())).unwrap();
    let early = most_allocations(&mut session, &scene, 0..120);
    let late = most_allocations(&mut session, &scene, 120..240);
    eprintln!("{early:?} {late:?}");
    for most in [early, late] {
        assert!(most.iter().zip(MOST_ALLOCATIONS).all(|(count, most)| *count <= most), "{most:?}");
    }
}
