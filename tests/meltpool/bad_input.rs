//! What bad input gets: one line that names the file and the remedy.

use std::fs;
use std::path::Path;

use seamtrack::report::pool::read_pool_csv;
use seamtrack::report::results::Status;

use super::command::{meltpool, seamtrack};
use super::npy;

/// The one line on stderr of a run that must fail with code 1.
fn message(input: &Path) -> String {
    let folder = tempfile::tempdir().unwrap();
    let failed = meltpool(input, "width", &folder.path().join("out")).assert().code(1);
    let text = String::from_utf8(failed.get_output().stderr.clone()).unwrap();
    assert!(text.lines().count() == 1 && !text.contains("panicked"), "{text}");
    assert!(text.contains(&*input.file_name().unwrap().to_string_lossy()), "{text}");
    text
}

#[test]
fn a_file_that_is_no_stack_of_frames_is_refused_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let data = npy::float32(&npy::discs(3));
    let cases = [
        (npy::write(&at("cut.npy"), "<f4", false, "(9, 32, 40)", &data), "promises 9 frames, it holds 3"),
        (npy::write(&at("flat.npy"), "<f4", false, "(96, 40)", &data), "2 dimensions"),
        (npy::write(&at("empty.npy"), "<f4", false, "(0, 32, 40)", &data), "no pixel"),
        (npy::write(&at("fortran.npy"), "<f4", true, "(3, 32, 40)", &data), "ascontiguousarray"),
        (npy::write(&at("object.npy"), "|O", false, "(3, 32, 40)", &data), "not read"),
        (npy::write(&at("complex.npy"), "<c8", false, "(3, 32, 40)", &data), "not read"),
        (
            npy::write(&at("huge.npy"), "<f4", false, "(99999999999, 99999999999, 99999999999)", &data),
            "larger than any",
        ),
        (npy::write(&at("bomb.npy"), "<f4", false, "(1, 99999, 99999)", &data), "more than any camera"),
    ];
    for (path, part) in cases {
        let text = message(&path);
        assert!(text.contains(part), "{text}");
    }
    fs::write(at("text.npy"), "hello").unwrap();
    assert!(message(&at("text.npy")).contains("no NumPy file"));
    fs::write(at("zero.npy"), "").unwrap();
    assert!(message(&at("zero.npy")).contains("no NumPy file"));
    fs::write(at("header.npy"), b"\x93NUMPY\x01\x00\x20\x00{'descr': 3}                    \n").unwrap();
    assert!(message(&at("header.npy")).contains("header"));
    assert!(message(&at("missing.npy")).contains("is the path right"));
}

#[test]
fn a_frame_with_a_pixel_that_is_no_number_is_unreadable_and_the_others_are_measured() {
    let folder = tempfile::tempdir().unwrap();
    let mut values = npy::discs(30);
    values[12 * 40 * 32 + 77] = f32::NAN;
    let stack = npy::write(&folder.path().join("nan.npy"), "<f4", false, "(30, 32, 40)", &npy::float32(&values));
    let output = folder.path().join("out");
    let run = meltpool(&stack, "width", &output).assert().success();
    let text = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    assert!(text.contains("frame 12: nan.npy[12] has a pixel that is not a finite number"), "{text}");
    let rows = read_pool_csv(&output.join("path.csv")).unwrap();
    for (frame, row) in rows.iter().enumerate() {
        assert_eq!(row.measured_px.is_some(), frame != 12, "frame {frame}");
        assert_eq!(row.status == Status::Unreadable, frame == 12, "frame {frame}");
    }
}

#[test]
fn a_stack_without_a_number_and_an_empty_folder_end_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let nothing = npy::float32(&[f32::NAN; 3 * 32 * 40]);
    let stack = npy::write(&folder.path().join("nan.npy"), "<f4", false, "(3, 32, 40)", &nothing);
    let failed = meltpool(&stack, "tip", &folder.path().join("out")).assert().code(1);
    let text = String::from_utf8(failed.get_output().stderr.clone()).unwrap();
    assert!(text.lines().last().unwrap().contains("none of the 3 frames could be read"), "{text}");
    let empty = folder.path().join("empty");
    fs::create_dir(&empty).unwrap();
    assert!(message(&empty).contains("holds no png"));
}

#[test]
fn wrong_usage_has_code_2() {
    for arguments in [
        vec!["meltpool", "x"],
        vec!["meltpool", "x", "--measure", "length"],
        vec!["meltpool", "x", "--measure", "tip", "--travel", "north"],
        vec!["meltpool", "x", "--measure", "tip", "--threshold", "warm"],
        vec!["meltpool", "x", "--measure", "tip", "--period", "0"],
        vec!["meltpool", "x", "--measure", "tip", "--zero", "nan"],
    ] {
        seamtrack().args(&arguments).assert().code(2);
    }
}
