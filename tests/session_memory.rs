//! What a session remembers does not grow with the recording.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::ops::Range;

use seamtrack::config::Config;
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::{Observation, Session, SessionSettings};

/// Most allocations of a step that sees the seam near its prediction, and of one that does not, up to a search of the whole frame. Measured: 0 and 33,111; of the second
/// a quarter more, as another compiler may count otherwise.
const MOST_ALLOCATIONS: [u64; 2] = [0, 42_000];
/// Frames after which what is remembered has its full length.
const WARM_UP: usize = 60;

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

/// A recording of 240 frames, and a session that has seen none of them.
fn recording() -> (Scene, Session) {
    let mut scenario = builtin::scenario("H-butt-covers").unwrap();
    (scenario.frames, scenario.image.width_px, scenario.image.height_px) = (240, 400, 300);
    let settings = SessionSettings::new(Config::default().method().unwrap());
    (Scene::new(&scenario, 1).unwrap(), Session::new(&settings).unwrap())
}

#[test]
fn a_session_holds_no_more_after_240_frames_than_after_120() {
    let (scene, mut session) = recording();
    growth(&mut session, &scene, 0..120);
    let later = growth(&mut session, &scene, 120..240);
    assert!(later < 64 * 1024, "120 frames left {later} bytes");
}

/// The most allocations of a step near the prediction, seen in this frame and in the one before, and of one that searches whole
/// frames.
fn most_allocations(session: &mut Session, scene: &Scene, frames: Range<usize>) -> [u64; 2] {
    let (mut most, mut was_seen) = ([0; 2], false);
    for i in frames {
        let frame = scene.render(i);
        let mut is_seen = false;
        let used = allocation_counter::measure(|| {
            is_seen = session.step(&frame, 0.2 * i as f64).unwrap().observation == Observation::Geometry;
        });
        let most = &mut most[usize::from(!(is_seen && was_seen))];
        *most = used.count_total.max(*most);
        was_seen = is_seen;
    }
    most
}

#[test]
fn a_step_near_the_prediction_allocates_nothing_and_a_search_no_more_often_late_in_a_recording_than_early() {
    let (scene, mut session) = recording();
    growth(&mut session, &scene, 0..WARM_UP);
    for frames in [WARM_UP..150, 150..240] {
        let most = most_allocations(&mut session, &scene, frames);
        assert!(most.iter().zip(MOST_ALLOCATIONS).all(|(count, most)| *count <= most), "{most:?}");
    }
}
