//! The same recording seen by another camera: mirrored, turned, finer, faster, darker. The path in millimetres stays
//! what it is.
//!
//! What is compared, and how close it must be, says `compare.rs`. The joint is not told.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod compare;
mod follow;
mod pictures;
mod scenes;

use compare::assert_same_paths;
use follow::{Path, follow};
use pictures::{binned, dimmed, mirrored, upside_down};
use scenes::{Camera, Recording, SCALE_FREE, SCENES, recorded};
use seamtrack::frame::GrayFrame;

/// The path in a recording whose every picture is changed by `change`, which leaves the scale as it is.
fn changed(recording: &Recording, change: impl Fn(&GrayFrame) -> GrayFrame) -> Path {
    let frames: Vec<GrayFrame> = recording.frames.iter().map(change).collect();
    follow(&frames, recording.period_s, recording.mm_per_px)
}

fn path(recording: &Recording) -> Path {
    follow(&recording.frames, recording.period_s, recording.mm_per_px)
}

#[test]
fn in_a_mirror_the_path_is_mirrored() {
    assert_same_paths(&SCENES, |scene| {
        let recording = recorded(scene, Camera::default());
        let last_mm = recording.mm_per_px * (recording.along_px as f64 - 1.0);
        let other = changed(&recording, |frame| mirrored(frame, recording.axis)).map_mm(|mm| last_mm - mm);
        (path(&recording), other)
    });
}

#[test]
fn upside_down_the_path_stays() {
    assert_same_paths(&SCENES, |scene| {
        let recording = recorded(scene, Camera::default());
        (path(&recording), changed(&recording, |frame| upside_down(frame, recording.axis)))
    });
}

#[test]
fn with_rows_and_columns_exchanged_the_path_stays() {
    assert_same_paths(&SCENES, |scene| {
        let recording = recorded(scene, Camera::default());
        (path(&recording), changed(&recording, GrayFrame::transposed))
    });
}

#[test]
fn at_half_the_exposure_the_path_stays() {
    assert_same_paths(&SCENES, |scene| {
        let recording = recorded(scene, Camera::default());
        (path(&recording), changed(&recording, dimmed))
    });
}

#[test]
fn at_twice_the_resolution_the_path_stays() {
    assert_same_paths(&SCALE_FREE, |scene| {
        // What the fine camera sees, and what it would give with 2 × 2 pixels read out as one.
        let fine = recorded(scene, Camera { fineness: 2, ..Camera::default() });
        let frames: Vec<GrayFrame> = fine.frames.iter().map(binned).collect();
        // The middle of the first coarse pixel lies half a fine one behind that of the first fine one.
        let shift_mm = 0.5 * fine.mm_per_px;
        (follow(&frames, fine.period_s, 2.0 * fine.mm_per_px), path(&fine).map_mm(|mm| mm - shift_mm))
    });
}

#[test]
fn at_twice_the_frame_rate_the_path_stays() {
    assert_same_paths(&SCALE_FREE, |scene| {
        // What the fast camera sees, and every second picture of it.
        let fast = recorded(scene, Camera { rate: 2, ..Camera::default() });
        let frames: Vec<GrayFrame> = fast.frames.iter().step_by(2).cloned().collect();
        (follow(&frames, 2.0 * fast.period_s, fast.mm_per_px), path(&fast).every_second())
    });
}
