//! Recordings that were cut, or hold what is no frame: nothing of that passes in silence.

use std::fs;
use std::path::{Path, PathBuf};

use predicates::str::contains;
use seamtrack::report::results::Status;

use crate::program::{line_with, name, pictures, recording, rows, summary, track};

/// A video of the demonstration's first frames at 25 frames a second, its list of frames before them as on the web.
pub fn video(folder: &Path, frames: usize) -> PathBuf {
    let film = folder.join("film.mp4");
    let drawn = track(&recording(folder, frames), &folder.join("drawn"))
        .args(["--period", "0.04", "--overlay"])
        .arg(&film)
        .assert();
    drawn.success();
    let bytes = fs::read(&film).unwrap();
    fs::write(&film, list_first(&bytes)).unwrap();
    film
}

/// Type, begin and end of each box of an MP4 file (ISO 14496-12).
fn boxes(bytes: &[u8]) -> Vec<(&[u8], usize, usize)> {
    let (mut found, mut begin) = (vec![], 0);
    while begin + 8 <= bytes.len() {
        let length = u32::from_be_bytes(bytes[begin..begin + 4].try_into().unwrap()) as usize;
        found.push((&bytes[begin + 4..begin + 8], begin, begin + length));
        begin += length;
    }
    found
}

/// The file with its `moov` before its `mdat`.
fn list_first(bytes: &[u8]) -> Vec<u8> {
    let found = boxes(bytes);
    let part = |kind: &[u8]| found.iter().find(|(name, ..)| *name == kind).map(|&(_, a, b)| &bytes[a..b]).unwrap();
    let mut moov = part(b"moov").to_vec();
    // The places of the frames move by its length.
    let places = moov.windows(4).position(|name| name == b"stco").unwrap();
    let count = u32::from_be_bytes(moov[places + 8..places + 12].try_into().unwrap()) as usize;
    let shift = moov.len() as u32;
    for place in moov[places + 12..places + 12 + 4 * count].chunks_exact_mut(4) {
        let moved = u32::from_be_bytes(place.try_into().unwrap()) + shift;
        place.copy_from_slice(&moved.to_be_bytes());
    }
    let first_data = found.iter().find(|(name, ..)| *name == b"mdat").unwrap().1;
    let end_of_data = first_data + part(b"mdat").len();
    [&bytes[..first_data], &moov, part(b"mdat")].concat().into_iter().chain(rest(bytes, end_of_data, &found)).collect()
}

/// What follows the data and is no `moov`.
fn rest(bytes: &[u8], from: usize, found: &[(&[u8], usize, usize)]) -> Vec<u8> {
    let others = found.iter().filter(|(name, begin, _)| *begin >= from && *name != b"moov");
    others.flat_map(|&(_, a, b)| bytes[a..b].to_vec()).collect()
}

fn run(input: &Path, output: &Path, more: &[&str]) -> (i32, String) {
    let run = track(input, output).args(more).output().unwrap();
    (run.status.code().unwrap(), String::from_utf8(run.stderr).unwrap())
}

#[test]
fn a_videos_frame_rate_gives_the_times_unless_a_period_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let film = video(folder.path(), 12);
    let at = |name: &str, more: &[&str]| {
        let output = folder.path().join(name);
        run(&film, &output, more);
        let period_s = summary(&output)["config"]["period_s"].as_f64().unwrap();
        (rows(&output)[10].time_s, period_s)
    };
    assert_eq!(at("own", &[]), (0.4, 0.04));
    assert_eq!(at("given", &["--period", "0.5"]), (5.0, 0.5));
    let config = folder.path().join("config.toml");
    fs::write(&config, "period_s = 0.2\n").unwrap();
    assert_eq!(at("file", &["--config", config.to_str().unwrap()]), (2.0, 0.2));
}

#[test]
fn a_video_that_is_cut_has_unreadable_frames_and_no_fewer() {
    let folder = tempfile::tempdir().unwrap();
    let film = video(folder.path(), 40);
    let bytes = fs::read(&film).unwrap();
    assert_eq!(
        (run(&film, &folder.path().join("whole"), &[]).1, rows(&folder.path().join("whole")).len()),
        (String::new(), 40)
    );
    for percent in [50, 70, 90] {
        let (cut, output) = (folder.path().join(format!("{percent}.mp4")), folder.path().join(percent.to_string()));
        fs::write(&cut, &bytes[..bytes.len() * percent / 100]).unwrap();
        let (code, stderr) = run(&cut, &output, &[]);
        let rows = rows(&output);
        let unreadable = rows.iter().filter(|row| row.status == Status::Unreadable).count();
        assert!(rows.len() == 40 && unreadable >= 2, "{percent} %: {unreadable} of {}", rows.len());
        assert!(
            stderr.contains(&format!("{percent}.mp4: frame ")) && stderr.contains("40 frames that its header promises")
        );
        assert_eq!(code == 3, unreadable > 2, "{percent} %: {unreadable}");
    }
}

#[test]
fn a_stack_of_pages_that_is_cut_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stack.tif");
    let mut encoder = tiff::encoder::TiffEncoder::new(fs::File::create(&path).unwrap()).unwrap();
    for picture in pictures(20) {
        let (width, height) = picture.dimensions();
        encoder.write_image::<tiff::encoder::colortype::Gray8>(width, height, picture.as_raw()).unwrap();
    }
    drop(encoder);
    let bytes = fs::read(&path).unwrap();
    for percent in [51, 75, 99] {
        fs::write(&path, &bytes[..bytes.len() * percent / 100]).unwrap();
        let output = folder.path().join(percent.to_string());
        let (_, stderr) = run(&path, &output, &[]);
        let rows = rows(&output);
        assert_eq!(rows.last().unwrap().status, Status::Unreadable, "{percent} %");
        assert!(stderr.contains("stack.tif: frame ") && stderr.lines().count() <= 2, "{stderr}");
        assert_eq!(summary(&output)["frames"]["unreadable"], rows.iter().filter(|row| row.u_px.is_none()).count());
    }
    fs::write(&path, &bytes[..200]).unwrap();
    track(&path, &folder.path().join("out")).assert().code(1).stderr(line_with(&["stack.tif", "copy it again"]));
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_nowhere_and_a_pipe_are_unreadable_frames_and_no_other_is_renumbered() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, holed) = (recording(folder.path(), 20), folder.path().join("holed"));
    track(&whole, &folder.path().join("reference")).assert().success();
    fs::rename(&whole, &holed).unwrap();
    fs::remove_file(holed.join(name(7))).unwrap();
    std::os::unix::fs::symlink("/nowhere/7.png", holed.join(name(7))).unwrap();
    fs::remove_file(holed.join(name(12))).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(holed.join(name(12))).status().unwrap().success());
    let output = folder.path().join("out");
    let (_, stderr) = run(&holed, &output, &[]);
    assert!(
        stderr.contains("holed: frame 7: 007.png cannot be decoded") && stderr.contains("leads nowhere"),
        "{stderr}"
    );
    assert!(stderr.contains("frame 12: 012.png"), "{stderr}");
    let reference = rows(&folder.path().join("reference"));
    for (row, whole) in rows(&output).iter().zip(&reference) {
        assert_eq!((row.frame, row.time_s), (whole.frame, whole.time_s));
        assert_eq!(row.status == Status::Unreadable, [7, 12].contains(&row.frame), "frame {}", row.frame);
    }
    // As a whole recording, and in the place of the time stamps.
    let pipe = holed.join(name(12));
    track(&pipe, &folder.path().join("pipe")).assert().code(1).stderr(line_with(&["012.png", "neither a file nor"]));
    fs::rename(&pipe, holed.join("timestamps.csv")).unwrap();
    track(&holed, &folder.path().join("stamps")).assert().code(1).stderr(contains("timestamps.csv"));
}

#[test]
fn sixteen_bits_are_scaled_by_the_whole_recording() {
    let folder = tempfile::tempdir().unwrap();
    let deep = folder.path().join("deep");
    fs::create_dir(&deep).unwrap();
    // Ten bits; the arc is lit after eight frames.
    for (i, picture) in pictures(24).iter().enumerate() {
        let gain = if i < 8 { 0 } else { 4 };
        let picture = image::ImageBuffer::from_fn(picture.width(), picture.height(), |u, v| {
            image::Luma([u16::from(picture.get_pixel(u, v).0[0]) * gain + 3])
        });
        picture.save(deep.join(name(i))).unwrap();
    }
    fs::write(deep.join(name(0)), b"").unwrap();
    let output = folder.path().join("out");
    track(&deep, &output).args(["--max-unavailable", "50"]).assert().success();
    assert_eq!(summary(&output)["input"]["sixteen_bit_white"], 1023);
    assert!(rows(&output).iter().filter(|row| row.u_px.is_some()).count() >= 12);
}

#[test]
fn stamps_that_do_not_rise_are_said_once_and_stamps_that_are_none_name_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 12);
    let stamps = |time: &dyn Fn(i64) -> String| {
        let lines: String = (0..12).map(|i| format!("{},{}\n", time(i), name(i as usize))).collect();
        fs::write(input.join("timestamps.csv"), format!("\u{feff}#timestamp [ns],filename\n{lines}")).unwrap();
    };
    let output = folder.path().join("out");
    for (file, back_ms) in [("equal", 200), ("backward", 500)] {
        stamps(&|i| ((200 * i - if i == 6 { back_ms } else { 0 }) * 1_000_000).to_string());
        for preset in ["robust", "paper"] {
            let output = folder.path().join(format!("{file}-{preset}"));
            let (code, stderr) = run(&input, &output, &["--preset", preset]);
            assert!(matches!(code, 0 | 1 | 3) && !stderr.contains("panicked"), "{file} {preset}: {stderr}");
            assert_eq!(stderr.matches("first 006.png").count(), 1, "{stderr}");
        }
    }
    for time in ["nan", "1e9", "soon", ""] {
        stamps(&|i| if i == 6 { time.into() } else { (200_000_000 * i).to_string() });
        track(&input, &output).assert().code(1).stderr(line_with(&["timestamps.csv", "line 8"]));
    }
    assert!(!output.exists());
}
