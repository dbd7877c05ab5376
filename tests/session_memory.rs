//! What a session remembers does not grow with the recording.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use seamtrack::config::Config;
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::{Session, SessionSettings};

/// Bytes that `frames` more frames leave behind.
fn growth(session: &mut Session, scene: &Scene, frames: std::ops::Range<usize>) -> i64 {
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
