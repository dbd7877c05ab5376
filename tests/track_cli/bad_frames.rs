//! Frames that cannot be read or make no sense: the run goes on where it can, and nothing panics.

use std::fs;
use std::path::Path;

use image::{GrayImage, Luma};
use predicates::prelude::*;
use predicates::str::contains;
use seamtrack::report::results::Status;

use crate::program::{line_with, name, pictures, recording, rows, track};

/// Tracks a recording of 20 frames of which one was spoilt, under both presets: that frame is unreadable, one line
/// of the diagnostics names it, and both frames beside it are tracked.
fn goes_on_without(frame: usize, spoil: impl Fn(&Path), reason: &str) {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 20);
    spoil(&input.join(name(frame)));
    for preset in ["robust", "paper"] {
        let output = folder.path().join(preset);
        track(&input, &output)
            .args(["--preset", preset, "--max-unavailable", "10"])
            .assert()
            .success()
            .stderr(line_with(&[&name(frame), reason]));
        let rows = rows(&output);
        assert_eq!(rows.len(), 20);
        for row in &rows {
            let expected = if row.frame == frame { Status::Unreadable } else { Status::Tracked };
            assert_eq!(row.status, expected, "{preset}, frame {}", row.frame);
        }
        assert!(rows[frame].u_px.is_none() && rows[frame].kcf_u_px.is_none());
        let step_px = rows[frame + 1].u_px.unwrap() - rows[frame - 1].u_px.unwrap();
        assert!(step_px.abs() < 3.0, "{preset}: the filter predicts through it, not {step_px} px away");
    }
}

#[test]
fn an_empty_file_in_the_middle_is_unreadable_and_the_run_goes_on() {
    goes_on_without(9, |file| fs::write(file, b"").unwrap(), "copy it again");
}

#[test]
fn a_truncated_picture_in_the_middle_is_unreadable_and_the_run_goes_on() {
    let truncate = |file: &Path| {
        let bytes = fs::read(file).unwrap();
        fs::write(file, &bytes[..bytes.len() / 2]).unwrap();
    };
    goes_on_without(9, truncate, "copy it again");
}

#[test]
fn a_picture_of_another_size_is_unreadable_and_the_run_goes_on() {
    let reason = "keep one size a recording";
    goes_on_without(9, |file| GrayImage::from_pixel(320, 240, Luma([9])).save(file).unwrap(), reason);
}

#[test]
fn a_picture_that_claims_three_and_a_half_gigapixels_is_refused_before_it_is_decoded() {
    goes_on_without(9, |file| fs::write(file, bomb()).unwrap(), "60000 x 60000");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bomb.png");
    fs::write(&file, bomb()).unwrap();
    let output = folder.path().join("out");
    track(&file, &output).assert().code(1).stderr(contains("bomb.png").and(contains("crop or bin")));
    assert!(!output.join("path.csv").exists());
}

/// A PNG whose header says 60000 x 60000 grey pixels and whose data are a few bytes.
fn bomb() -> Vec<u8> {
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let side = 60_000_u32.to_be_bytes();
    let header = [&side[..], &side[..], &[8, 0, 0, 0, 0]].concat();
    // An empty zlib stream.
    let data = [0x78, 0x9c, 0x03, 0x00, 0x00, 0x00, 0x00, 0x01];
    for (kind, content) in [(b"IHDR", &header[..]), (b"IDAT", &data[..]), (b"IEND", &[])] {
        file.extend((content.len() as u32).to_be_bytes());
        let checked = [&kind[..], content].concat();
        file.extend(&checked);
        file.extend(crc32(&checked).to_be_bytes());
    }
    file
}

/// The check sum of PNG chunks (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn a_recording_whose_first_frame_is_broken_starts_at_the_second() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 20);
    fs::write(input.join(name(0)), b"").unwrap();
    let output = folder.path().join("out");
    track(&input, &output).assert().success().stderr(line_with(&[&name(0)]));
    let rows = rows(&output);
    assert_eq!((rows[0].status, rows[1].status), (Status::Unreadable, Status::Tracked));
}

#[test]
fn a_recording_without_one_readable_frame_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 2);
    for frame in 0..2 {
        fs::write(input.join(name(frame)), b"no picture").unwrap();
    }
    let output = folder.path().join("out");
    let last = predicates::function::function(|text: &str| {
        text.lines().last().is_some_and(|line| line.contains("none of the 2 frames could be read"))
    });
    track(&input, &output).assert().code(1).stderr(last);
    assert!(!output.join("path.csv").exists());
}

#[test]
fn a_folder_without_pictures_says_what_it_should_hold() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("empty");
    fs::create_dir(&input).unwrap();
    let output = folder.path().join("out");
    track(&input, &output).assert().code(1).stderr(line_with(&["empty", "png, jpg, bmp or tif"]));
    assert!(!output.exists());
}

#[test]
fn a_file_that_is_no_recording_says_what_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("notes.txt");
    fs::write(&input, "not a recording").unwrap();
    let output = track(&input, &folder.path().join("out")).assert().code(1).get_output().stderr.clone();
    let text = String::from_utf8(output).unwrap();
    let last = text.lines().last().unwrap();
    assert!(last.contains("notes.txt") && last.contains("convert it"), "{text}");
    fs::write(folder.path().join("broken.tif"), "II*\0").unwrap();
    track(&folder.path().join("broken.tif"), &folder.path().join("out"))
        .assert()
        .code(1)
        .stderr(contains("broken.tif"));
}

#[test]
fn frames_of_one_pixel_or_one_row_hold_no_seam_and_break_nothing() {
    for (width, height) in [(1, 1), (2, 2), (640, 1), (1, 480), (7, 5), (40, 12)] {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("tiny");
        fs::create_dir(&input).unwrap();
        for i in 0..3_u8 {
            let picture = GrayImage::from_fn(width, height, |u, v| Luma([(u * 37 + v * 91) as u8 ^ (i * 55)]));
            picture.save(input.join(name(i.into()))).unwrap();
        }
        for preset in ["robust", "paper"] {
            let output = folder.path().join(preset);
            let run = track(&input, &output).args(["--preset", preset]).output().unwrap();
            let stderr = String::from_utf8_lossy(&run.stderr);
            assert!(matches!(run.status.code(), Some(0 | 3)), "{width} x {height}, {preset}: {stderr}");
            assert!(!stderr.contains("panicked") && rows(&output).len() == 3);
        }
    }
}

#[test]
fn a_frame_of_twenty_megapixels_is_tracked_like_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("large");
    fs::create_dir(&input).unwrap();
    let small = pictures(3);
    let (width, height) = (5472, 3648);
    for (i, picture) in small.iter().enumerate() {
        // The demonstration's frame in the middle, its stripe continued to both sides.
        let large = GrayImage::from_fn(width, height, |u, v| {
            let u = (i64::from(u) - 2500).clamp(0, i64::from(picture.width()) - 1) as u32;
            let v = (i64::from(v) - 1700).clamp(0, i64::from(picture.height()) - 1) as u32;
            *picture.get_pixel(u, v)
        });
        large.save(input.join(format!("{i}.bmp"))).unwrap();
    }
    let reference = folder.path().join("small");
    track(&recording(folder.path(), 3), &reference).args(["--preset", "paper"]).assert().success();
    let output = folder.path().join("out");
    track(&input, &output).args(["--preset", "paper"]).assert().success();
    for (large, small) in rows(&output).iter().zip(rows(&reference)) {
        let difference_px = large.u_px.unwrap() - 2500.0 - small.u_px.unwrap();
        assert!(difference_px.abs() < 1.0, "frame {}: {difference_px} px", large.frame);
    }
    let robust = track(&input, &folder.path().join("robust")).output().unwrap();
    let stderr = String::from_utf8_lossy(&robust.stderr);
    assert!(matches!(robust.status.code(), Some(0 | 3)) && !stderr.contains("panicked"), "{stderr}");
}
