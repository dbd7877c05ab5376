//! Where the user says the seam is, there it is sought and nowhere else.

use std::fs;

use image::{GrayImage, Luma};

use crate::program::{line_with, name, pictures, recording, rows, track};

/// Where the demonstration's seam is in its first frame, and a place on its plain stripe.
const SEAM: &str = "--seed-at=185.5,90.7";
const PLATE: &str = "--seed-at=60,90";

#[test]
fn the_seam_is_found_in_the_first_frame_where_it_is_said_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    track(&recording(folder.path(), 12), &output).arg(SEAM).assert().success();
    let u_px = rows(&output)[0].u_px.unwrap();
    assert!((u_px - 185.5).abs() < 6.0, "{u_px}");
}

#[test]
fn where_there_is_none_the_run_ends_and_says_where_one_was_seen() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let run = track(&recording(folder.path(), 58), &output).arg(PLATE).assert();
    run.code(1).stderr(line_with(&["the seed 60, 90", "in 40 frames", "a butt joint shows at", "leave it out"]));
    assert!(!output.join("path.csv").exists());
}

#[test]
fn a_joint_that_first_shows_after_some_frames_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("late");
    fs::create_dir(&input).unwrap();
    for (i, picture) in pictures(30).into_iter().enumerate() {
        // The joint is covered at first; the stripe shows to the left of it.
        let hide = |u: u32| i < 6 && u > 130;
        let covered = GrayImage::from_fn(picture.width(), picture.height(), |u, v| {
            if hide(u) { Luma([8]) } else { *picture.get_pixel(u, v) }
        });
        covered.save(input.join(name(i))).unwrap();
    }
    let output = folder.path().join("out");
    track(&input, &output).args([SEAM, "--max-unavailable", "100"]).assert().success();
    let rows = rows(&output);
    assert!(rows[..6].iter().all(|row| row.u_px.is_none()));
    assert!(rows[20..].iter().all(|row| row.u_px.is_some()));
}
