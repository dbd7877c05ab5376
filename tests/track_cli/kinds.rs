//! The same frames in other files give the same path.

use std::fs;
use std::fs::File;
use std::path::Path;

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb};
use tiff::encoder::{TiffEncoder, colortype};

use crate::program::{
    demo, largest_difference_px, line_with, name, pictures, recording, rows, seamtrack, track, tracked,
};

const FRAMES: usize = 30;

/// Writes each of the first frames through `change`.
fn changed(folder: &Path, change: impl Fn(&GrayImage) -> DynamicImage) {
    fs::create_dir(folder).unwrap();
    for (i, picture) in pictures(FRAMES).iter().enumerate() {
        change(picture).save(folder.join(name(i))).unwrap();
    }
}

fn sixteen_bit(picture: &GrayImage, factor: u16) -> DynamicImage {
    ImageBuffer::from_fn(picture.width(), picture.height(), |u, v| {
        Luma([u16::from(picture.get_pixel(u, v).0[0]) * factor])
    })
    .into()
}

#[test]
fn sixteen_bits_and_colour_give_nearly_the_same_path() {
    let folder = tempfile::tempdir().unwrap();
    let reference = tracked(&recording(folder.path(), FRAMES), &folder.path().join("reference"));
    let difference_px = |kind: &str, change: &dyn Fn(&GrayImage) -> DynamicImage| {
        let input = folder.path().join(kind);
        changed(&input, change);
        largest_difference_px(&tracked(&input, &folder.path().join(format!("{kind}-out"))), &reference)
    };
    // 257 · 255 = 65535: the very same greys.
    assert_eq!(difference_px("sixteen", &|picture| sixteen_bit(picture, 257)), 0.0);
    // A 12-bit camera: 4080 of 4095, so greys differ by at most one.
    let twelve_px = difference_px("twelve", &|picture| sixteen_bit(picture, 16));
    assert!(twelve_px < 0.1, "{twelve_px}");
    let grey_px = difference_px("rgb", &|picture| DynamicImage::from(picture.clone()).into_rgb8().into());
    assert!(grey_px < 0.1, "{grey_px}");
    // A green laser through a colour camera: darker by the weight of green, 0.7152.
    let green = |picture: &GrayImage| {
        let buffer = ImageBuffer::from_fn(picture.width(), picture.height(), |u, v| {
            let grey = picture.get_pixel(u, v).0[0];
            Rgb([grey / 8, grey, grey / 8])
        });
        buffer.into()
    };
    let green_px = difference_px("green", &green);
    assert!(green_px < 0.5, "{green_px}");
}

#[test]
fn every_format_that_is_promised_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let reference = tracked(&recording(folder.path(), 10), &folder.path().join("reference"));
    for extension in ["bmp", "tif", "TIFF", "jpg"] {
        let input = folder.path().join(extension);
        fs::create_dir(&input).unwrap();
        for (i, picture) in pictures(10).iter().enumerate() {
            picture.save(input.join(format!("{i}.{extension}"))).unwrap();
        }
        let path = tracked(&input, &folder.path().join(format!("{extension}-out")));
        let difference_px = largest_difference_px(&path, &reference);
        // JPEG of quality 75 changes the greys.
        assert!(difference_px <= if extension == "jpg" { 0.5 } else { 0.0 }, "{extension}: {difference_px}");
    }
}

#[test]
fn time_stamps_beside_the_frames_are_those_of_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 5);
    let stamps: String =
        (0..5).map(|i| format!("{},{}\n", 7_000_000_000_u64 + i * i * 50_000_000, name(i as usize))).collect();
    fs::write(input.join("timestamps.csv"), format!("#timestamp [ns],filename\n{stamps}")).unwrap();
    let times: Vec<f64> = tracked(&input, &folder.path().join("out")).iter().map(|row| row.time_s).collect();
    assert_eq!(times, [0.0, 0.05, 0.2, 0.45, 0.8]);
    fs::remove_file(input.join("timestamps.csv")).unwrap();
    let output = folder.path().join("period");
    track(&input, &output).args(["--period", "0.04"]).assert().success();
    assert!((rows(&output)[4].time_s - 0.16).abs() < 1e-9);
}

#[cfg(unix)]
#[test]
fn names_of_any_bytes_are_read_and_written_as_one_cell() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("a,\"b\" <i>");
    fs::create_dir(&input).unwrap();
    let names: [&[u8]; 3] = [b"1 \xff.png", b"2,\"<script>.png", "3 ü\u{202e}.png".as_bytes()];
    for (name, picture) in names.iter().zip(pictures(3)) {
        let mut file = File::create(input.join(std::ffi::OsStr::from_bytes(name))).unwrap();
        picture.write_to(&mut file, image::ImageFormat::Png).unwrap();
    }
    let output = folder.path().join("out");
    let path = tracked(&input, &output);
    assert_eq!(path[1].file, "2,\"<script>.png");
    assert!(!fs::read_to_string(output.join("report.html")).unwrap().contains("2,\"<script>.png"));
}

#[test]
fn names_are_taken_in_natural_order_with_numbers_missing() {
    let folder = tempfile::tempdir().unwrap();
    let reference = tracked(&recording(folder.path(), 14), &folder.path().join("reference"));
    let input = folder.path().join("gaps");
    fs::create_dir(&input).unwrap();
    // 1, 2, 4, 8 … 8192: as text, 1024 comes before 2. Written last to first, between other files.
    for (i, picture) in pictures(14).iter().enumerate().rev() {
        picture.save(input.join(format!("scan {}.png", 1 << i))).unwrap();
    }
    fs::write(input.join("notes.txt"), "not a frame").unwrap();
    fs::write(input.join(".hidden.png"), "not a frame").unwrap();
    let path = tracked(&input, &folder.path().join("out"));
    assert_eq!(path[10].file, "scan 1024.png");
    assert_eq!(largest_difference_px(&path, &reference), 0.0);
}

#[test]
fn transposed_frames_give_the_transposed_path() {
    let folder = tempfile::tempdir().unwrap();
    let upright = recording(folder.path(), FRAMES);
    let lying = folder.path().join("lying");
    changed(&lying, |picture| {
        GrayImage::from_fn(picture.height(), picture.width(), |u, v| *picture.get_pixel(v, u)).into()
    });
    for preset in ["robust", "paper"] {
        let run = |input: &Path, name: &str| {
            let output = folder.path().join(format!("{preset}-{name}"));
            track(input, &output).args(["--preset", preset]).assert().success();
            assert_eq!(crate::program::summary(&output)["calibration"]["stripe"], name);
            rows(&output)
        };
        let (horizontal, vertical) = (run(&upright, "horizontal"), run(&lying, "vertical"));
        for (h, v) in horizontal.iter().zip(&vertical) {
            assert_eq!((h.u_px, h.v_px, h.x_mm, h.x_std_mm), (v.v_px, v.u_px, v.x_mm, v.x_std_mm));
            assert_eq!((h.kcf_u_px, h.kcf_v_px, h.psr, h.nis), (v.kcf_v_px, v.kcf_u_px, v.psr, v.nis));
            assert_eq!((h.smooth_u_px, h.smooth_v_px, h.smooth_x_mm), (v.smooth_v_px, v.smooth_u_px, v.smooth_x_mm));
        }
    }
}

#[test]
fn the_pages_of_a_tiff_are_frames() {
    let folder = tempfile::tempdir().unwrap();
    let reference = tracked(&recording(folder.path(), FRAMES), &folder.path().join("reference"));
    let stack = folder.path().join("stack.tif");
    let mut encoder = TiffEncoder::new(File::create(&stack).unwrap()).unwrap();
    for picture in pictures(FRAMES) {
        encoder.write_image::<colortype::Gray8>(picture.width(), picture.height(), picture.as_raw()).unwrap();
    }
    drop(encoder);
    let path = tracked(&stack, &folder.path().join("out"));
    assert_eq!(path[3].file, "stack.tif[3]");
    assert_eq!(largest_difference_px(&path, &reference), 0.0);

    // A stack cut short in a copy: what can be read is tracked, and nothing panics.
    let bytes = fs::read(&stack).unwrap();
    let cut = folder.path().join("cut.tif");
    fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let run = track(&cut, &folder.path().join("cut")).output().unwrap();
    let stderr = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.code().is_some_and(|code| code <= 3) && !stderr.contains("panicked"), "{stderr}");
}

#[test]
fn a_video_is_a_recording_and_the_overlay_is_a_video() {
    let folder = tempfile::tempdir().unwrap();
    let video = folder.path().join("overlay.mp4");
    let run = track(&demo(), &folder.path().join("out")).arg("--overlay").arg(&video).output().unwrap();
    let stderr = String::from_utf8_lossy(&run.stderr);
    if stderr.contains("OpenCV needs FFmpeg") {
        eprintln!("SKIPPED: this OpenCV cannot write MPEG-4, so no video was tracked");
        return;
    }
    assert!(run.status.success(), "{stderr}");
    let output = folder.path().join("again");
    let run = track(&video, &output).output().unwrap();
    assert!(matches!(run.status.code(), Some(0 | 3)), "{}", String::from_utf8_lossy(&run.stderr));
    let rows = rows(&output);
    assert_eq!(rows.len(), 58);
    assert!((rows[57].time_s - 57.0 * 0.2).abs() < 1e-9);
    assert_eq!(crate::program::summary(&output)["input"]["kind"], "video");
    // The marks in the picture do not hide the stripe: the seam is found near where it was.
    assert!(rows.iter().filter(|row| row.u_px.is_some()).count() > 29);
}

#[test]
fn a_part_of_a_recording_keeps_its_names_its_times_and_its_truth() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let truth = demo().join("truth.csv");
    let run =
        |range: &str| track(&demo(), &output).args(["--force", "--frames", range, "--truth"]).arg(&truth).assert();
    run("20..50").success();
    let path = rows(&output);
    assert_eq!((path.len(), path[0].frame, path[0].file.as_str()), (30, 0, "frame_000020.png"));
    assert!((path[0].time_s - 4.0).abs() < 1e-9 && (path[29].time_s - 49.0 * 0.2).abs() < 1e-9);
    let summary = crate::program::summary(&output);
    assert_eq!(summary["input"]["first_frame"], 20);
    let worst = summary["errors"]["filtered"]["max_mm"].as_f64().unwrap();
    assert!(worst < 0.3, "held against the truth of the same frames: {worst} mm");
    let mut eval = seamtrack();
    let said = eval.arg("eval").arg(&output).arg(&truth).arg("--json").output().unwrap().stdout;
    let said: serde_json::Value = serde_json::from_slice(&said).unwrap();
    assert!((said["filtered"]["max_mm"].as_f64().unwrap() - worst).abs() < 1e-3);
    run("50..").success();
    assert_eq!(rows(&output).len(), 8);
    run("58..").code(1).stderr(line_with(&["--frames 58..", "58 frames"]));
    run("9..3").code(2);
}
