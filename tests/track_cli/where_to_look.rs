//! More than one stripe in the picture, and the part of it that is to be looked at.

use std::fs;
use std::path::{Path, PathBuf};

use image::{GrayImage, Luma};
use seamtrack::report::results::PathRow;

use crate::program::{demo_frames, largest_difference_px, line_with, name, pictures, recording, rows, track, tracked};

const FRAMES: usize = 58;
/// Rows of the demonstration's pictures, and of those with the table below the plate.
const PLATE_ROWS: u32 = 240;
const ALL_ROWS: u32 = 420;

/// The demonstration with the laser's light on a table beside the plate: a stripe without a joint, wider and brighter.
fn with_table(folder: &Path) -> PathBuf {
    let input = folder.join("with-table");
    fs::create_dir(&input).unwrap();
    for (i, plate) in pictures(FRAMES).iter().enumerate() {
        let picture = GrayImage::from_fn(plate.width(), ALL_ROWS, |u, v| {
            if v < PLATE_ROWS {
                return *plate.get_pixel(u, v);
            }
            // Speckle that is new in each frame.
            let noise = f64::from((u * 7919 + v * 104_729 + i as u32 * 1_299_709) % 97) / 97.0;
            let light = 190.0 * (-0.5 * ((f64::from(v) - 350.0 - 0.02 * f64::from(u)) / 6.0).powi(2)).exp();
            Luma([(9.0 + 6.0 * noise + light * (0.8 + 0.4 * noise)).min(255.0) as u8])
        });
        picture.save(input.join(name(i))).unwrap();
    }
    input
}

/// Largest difference of the smoothed paths along the stripe \[px\].
fn smoothed_difference_px(a: &[PathRow], b: &[PathRow]) -> f64 {
    let pairs = a.iter().zip(b).filter_map(|(a, b)| Some((a.smooth_u_px?, b.smooth_u_px?)));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_stripe_that_carries_the_joint_is_found_beside_a_brighter_one_and_followed_back_to_the_first_frame() {
    let folder = tempfile::tempdir().unwrap();
    let alone = tracked(&recording(folder.path(), FRAMES), &folder.path().join("alone"));
    let input = with_table(folder.path());
    // The joint is found late, which the verdict counts.
    track(&input, &folder.path().join("both")).args(["--max-unavailable", "60"]).assert().success();
    let both = rows(&folder.path().join("both"));
    assert!(both.iter().any(|row| row.u_px.is_none()), "nothing to follow back through");
    assert!(both.iter().all(|row| row.smooth_u_px.is_some()), "{both:?}");
    let tracked = both.iter().zip(&alone).filter_map(|(both, alone)| Some((both.u_px? - alone.u_px?).abs()));
    assert!(tracked.fold(0.0, f64::max) < 1.0);
    assert!(smoothed_difference_px(&both, &alone) < 0.5, "{}", smoothed_difference_px(&both, &alone));
}

#[test]
fn a_part_of_the_picture_gives_the_path_it_gives_alone() {
    let folder = tempfile::tempdir().unwrap();
    let alone = tracked(&recording(folder.path(), FRAMES), &folder.path().join("alone"));
    let output = folder.path().join("part");
    track(&with_table(folder.path()), &output).args(["--roi", "0,0,400,240"]).assert().success();
    assert!(largest_difference_px(&rows(&output), &alone) < 1e-9);
}

#[test]
fn a_part_outside_the_picture_and_a_seed_outside_the_part_are_errors_that_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let input = demo_frames()[0].parent().unwrap().to_owned();
    let refused = |arguments: &[&str], words: &[&str]| {
        let assert = track(&input, &folder.path().join("refused")).args(arguments).assert();
        assert.code(1).stderr(line_with(words));
        assert!(!folder.path().join("refused").exists());
    };
    refused(&["--roi", "500,0,100,100"], &["100 x 100 pixels from (500, 0)", "outside the picture of 400 x 240"]);
    refused(&["--roi", "0,0,4,100"], &["roi"]);
    refused(&["--roi", "0,0,100,100", "--seed-at", "200,100"], &["seed 200, 100", "outside the part"]);
    track(&input, &folder.path().join("refused")).args(["--roi", "1,2,3"]).assert().code(2);
}
