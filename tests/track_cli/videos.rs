//! A decoder of a video that hangs or dies takes neither the run nor the results with it.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::broken_recordings::video;
use crate::program::{demo_frames, summary};

/// The processes that a process has started.
fn children(process: u32) -> Vec<String> {
    let listed = fs::read_to_string(format!("/proc/{process}/task/{process}/children")).unwrap_or_default();
    listed.split_whitespace().map(str::to_owned).collect()
}

/// Tracks the video; as soon as its decoder is there it gets the signal.
fn tracked_while_the_decoder_gets(signal: &str) -> (i32, String, Duration, bool) {
    let folder = tempfile::tempdir().unwrap();
    let film = video(folder.path(), demo_frames().len());
    let output = folder.path().join("out");
    let began = Instant::now();
    let run = Command::new(env!("CARGO_BIN_EXE_seamtrack"))
        .args(["track", "--joint", "butt", "--quiet", "-o"])
        .args([&output, &film])
        .env("SEAMTRACK_VIDEO_PATIENCE_S", "0.5")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let decoder = loop {
        // It is started by the main thread, or by one of those that work for it.
        let threads = fs::read_dir(format!("/proc/{}/task", run.id())).unwrap();
        let found = threads.flatten().find_map(|thread| {
            let listed = fs::read_to_string(thread.path().join("children")).unwrap_or_default();
            listed.split_whitespace().next().map(str::to_owned)
        });
        if let Some(found) = found {
            break found;
        }
        assert!(began.elapsed() < Duration::from_secs(60), "no decoder appears");
    };
    assert!(Command::new("kill").args([signal, &decoder]).status().unwrap().success());
    assert!(children(run.id()).len() <= 1);
    let ended = run.wait_with_output().unwrap();
    let is_gone = !fs::exists(format!("/proc/{decoder}")).unwrap();
    if output.exists() {
        assert!(summary(&output)["frames"]["unreadable"].as_u64().unwrap() > 0);
    }
    (ended.status.code().unwrap(), String::from_utf8(ended.stderr).unwrap(), began.elapsed(), is_gone)
}

#[test]
fn a_decoder_that_hangs_is_ended_and_named() {
    let (code, stderr, _, is_gone) = tracked_while_the_decoder_gets("-STOP");
    assert!(code == 1 || code == 3, "{code}: {stderr}");
    assert!(stderr.contains(".mp4") && stderr.contains("the decoder gave nothing for 0.5 s and was ended"), "{stderr}");
    assert!(is_gone && !stderr.contains("panicked"), "{stderr}");
}

#[test]
fn a_decoder_that_crashes_is_named() {
    let (code, stderr, _, is_gone) = tracked_while_the_decoder_gets("-SEGV");
    assert!(code == 1 || code == 3, "{code}: {stderr}");
    assert!(is_gone && stderr.contains(".mp4") && stderr.contains("the decoder broke off"), "{stderr}");
}
