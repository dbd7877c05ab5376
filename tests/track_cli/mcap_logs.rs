//! Recordings in MCAP logs, and runs written as such.

use std::collections::BTreeMap;
use std::fs;
use std::io::BufWriter;
use std::path::Path;

use mcap::records::MessageHeader;
use mcap::{Compression, MessageStream, WriteOptions};

use crate::program::{largest_difference_px, line_with, pictures, recording, rows, seamtrack, track, tracked};

const FRAMES: usize = 30;
/// Time from frame to frame in the logs, and where they begin \[ns\].
const STEP_NS: u64 = 200_000_000;
const START_NS: u64 = 1_700_000_000_000_000_000;

/// A log of the demonstration's first frames as `sensor_msgs/msg/Image`, beside a topic of text and one of fewer pictures.
fn ros_log(path: &Path, compression: Option<Compression>) {
    let file = BufWriter::new(fs::File::create(path).unwrap());
    let mut writer = WriteOptions::new().compression(compression).profile("ros2").create(file).unwrap();
    let schema = writer.add_schema("sensor_msgs/msg/Image", "ros2msg", b"").unwrap();
    let text = writer.add_schema("std_msgs/msg/String", "ros2msg", b"").unwrap();
    let no_metadata = BTreeMap::new();
    let laser = writer.add_channel(schema, "/laser/image_raw", "cdr", &no_metadata).unwrap();
    let other = writer.add_channel(schema, "/overview/image_raw", "cdr", &no_metadata).unwrap();
    let log = writer.add_channel(text, "/log", "cdr", &no_metadata).unwrap();
    for (frame, picture) in pictures(FRAMES).iter().enumerate() {
        let (width, height) = (picture.width(), picture.height());
        let mut data = vec![0, 1, 0, 0];
        // Stamp, frame of reference "cam", size, encoding with its padding.
        for number in [0, 0, 4] {
            data.extend(u32::to_le_bytes(number));
        }
        data.extend(b"cam\0");
        for number in [height, width, 6] {
            data.extend(u32::to_le_bytes(number));
        }
        data.extend(b"mono8\0\0\0");
        for number in [width, width * height] {
            data.extend(u32::to_le_bytes(number));
        }
        data.extend(picture.as_raw());
        let log_time = START_NS + frame as u64 * STEP_NS;
        let mut send = |channel_id: u16, data: &[u8]| {
            let header = MessageHeader { channel_id, sequence: frame as u32, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, data).unwrap();
        };
        send(log, b"\0\x01\0\0\x03\0\0\0hi\0");
        send(laser, &data);
        if frame % 3 == 0 {
            send(other, &data);
        }
    }
    writer.finish().unwrap();
}

#[test]
fn a_ros_log_is_a_recording_with_the_logs_stamps() {
    let folder = tempfile::tempdir().unwrap();
    let reference = tracked(&recording(folder.path(), FRAMES), &folder.path().join("reference"));
    for (name, compression) in [("zstd", Some(Compression::Zstd)), ("lz4", Some(Compression::Lz4)), ("plain", None)] {
        let log = folder.path().join(format!("{name}.mcap"));
        ros_log(&log, compression);
        let output = folder.path().join(name);
        track(&log, &output).assert().success().stderr(line_with(&["/laser/image_raw", "/overview/image_raw"]));
        let path = rows(&output);
        assert_eq!(largest_difference_px(&path, &reference), 0.0);
        assert_eq!((path[3].file.clone(), path[3].time_s), (format!("{name}.mcap[3]"), 0.6));
    }
    // Cut in a copy: what can be read is tracked, and the end is said.
    let bytes = fs::read(folder.path().join("plain.mcap")).unwrap();
    let cut = folder.path().join("cut.mcap");
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let run = track(&cut, &folder.path().join("cut")).args(["--max-unavailable", "50"]).output().unwrap();
    let stderr = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.code().is_some_and(|code| code <= 3) && stderr.contains("ends early"), "{stderr}");
}

#[test]
fn a_log_without_pictures_says_what_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("none.mcap");
    let mut writer = mcap::Writer::new(BufWriter::new(fs::File::create(&log).unwrap())).unwrap();
    writer.finish().unwrap();
    fs::write(folder.path().join("junk.mcap"), "no log").unwrap();
    for name in ["none", "junk"] {
        let run = track(&folder.path().join(format!("{name}.mcap")), &folder.path().join("out")).assert();
        run.code(1).stderr(line_with(&[name, "no pictures", "sensor_msgs/Image"]));
    }
}

#[test]
fn a_run_written_for_foxglove_reads_back_as_the_same_recording_with_its_marks_and_path() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), FRAMES);
    let (output, log) = (folder.path().join("out"), folder.path().join("logs/run.mcap"));
    track(&input, &output).arg("--mcap").arg(&log).assert().success();
    let path = rows(&output);
    let bytes = fs::read(&log).unwrap();
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let value: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        let row = &path[message.sequence as usize];
        assert_eq!(message.log_time, (row.time_s * 1e9).round() as u64);
        match message.channel.topic.as_str() {
            "/seam/path" => {
                assert_eq!(
                    (value["u_px"].is_null(), value["status"].as_str()),
                    (row.u_px.is_none(), Some(row.status.name()))
                );
                let difference = value["smooth_u_px"].as_f64().zip(row.smooth_u_px).map_or(0.0, |(a, b)| (a - b).abs());
                assert!(difference < 1e-3);
            }
            "/seam/marks" => {
                let circle = &value["circles"][0]["position"]["x"];
                assert_eq!(circle.is_null(), row.u_px.is_none());
                assert!(circle.as_f64().is_none_or(|x| (x - 0.5 - row.u_px.unwrap()).abs() < 1e-3));
            }
            _ => assert_eq!(value["format"], "png"),
        }
        *seen.entry(message.channel.topic.clone()).or_default() += 1;
    }
    let expected = ["/camera/image", "/seam/marks", "/seam/path"].map(|topic| (topic.to_owned(), FRAMES));
    assert_eq!(seen, BTreeMap::from(expected));

    let again = folder.path().join("again");
    track(&log, &again).assert().success();
    assert_eq!(largest_difference_px(&rows(&again), &path), 0.0);
}

#[test]
fn a_log_is_not_written_over_anything_nor_into_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    let run = |log: &Path| {
        let mut run = seamtrack();
        run.arg("track").arg(&input).arg("-o").arg(folder.path().join("out")).arg("--mcap").arg(log);
        run.args(["--joint", "butt", "--quiet"]).assert()
    };
    let mine = folder.path().join("mine.mcap");
    fs::write(&mine, "mine").unwrap();
    run(&mine).code(1).stderr(line_with(&["mine.mcap", "--force"]));
    run(&input.join("x.mcap")).code(1).stderr(line_with(&["--mcap"]));
    run(&folder.path().join("run.bag")).code(1).stderr(line_with(&[".mcap"]));
    assert_eq!(fs::read_to_string(&mine).unwrap(), "mine");
}
