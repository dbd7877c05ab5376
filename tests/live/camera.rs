//! `seamtrack live` through aravis at our own camera double: packets lost, a stall, a death.

use std::process::{Child, Output};
use std::time::{Duration, Instant};

use crate::page::Run;
use crate::program::{done, end, numbers, seamtrack, text};

/// The double has the protocol's only port: one test at a time.
static PORT: std::sync::Mutex<()> = std::sync::Mutex::new(());

fn double(arguments: &[&str]) -> Child {
    let child = seamtrack().arg("camera-double").args(arguments).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    child
}

fn ended(child: Child) -> Output {
    end(&child, "-INT");
    child.wait_with_output().unwrap()
}

const CAMERA: &str = "gige:127.0.0.1";

#[test]
#[ignore = "20 s: make live-test"]
fn of_the_pictures_of_a_network_that_loses_packets_nearly_all_come_whole() {
    let _port = PORT.lock();
    let camera = double(&["--fps", "60", "--lose", "0.5", "--trouble", "stall@8:0.5"]);
    let run = Run::at(CAMERA, "[genicam]\npacket_bytes = 8000");
    std::thread::sleep(Duration::from_secs(20));
    let report = run.end();
    let sent = done(&ended(camera));
    println!("{sent}{report}");
    let (pictures, whole) = (numbers(&sent, "pictures:")[0], numbers(&report, "pictures:")[0]);
    assert!(numbers(&sent, "packets:")[1] > 50.0 && numbers(&sent, "packets:")[2] > 0.0, "{sent}");
    assert!(pictures > 300.0 && whole >= 0.99 * pictures, "{whole} of {pictures} came whole\n{report}");
}

#[test]
#[ignore = "15 s: make live-test"]
fn a_dead_camera_that_returns_gives_a_value_within_two_seconds() {
    let _port = PORT.lock();
    const DEAD_S: f64 = 3.0;
    let camera = double(&["--fps", "60", "--trouble", "dead@4:3"]);
    let run = Run::at(CAMERA, "");
    // The longest pause between two seams seen is the death and what came after.
    let (mut last, mut seen, mut longest_s) = (Instant::now(), 0, 0.0_f64);
    let began = Instant::now();
    for event in run.events() {
        let tracked = event["frames"][1].as_u64().unwrap_or(0);
        if tracked > seen {
            if seen > 0 {
                longest_s = longest_s.max(last.elapsed().as_secs_f64());
            }
            (last, seen) = (Instant::now(), tracked);
        }
        if began.elapsed() > Duration::from_secs(14) {
            break;
        }
    }
    let report = run.end();
    let sent = done(&ended(camera));
    println!("first value {:.2} s after the camera's return\n{sent}{report}", longest_s - DEAD_S);
    assert_eq!(numbers(&sent, "deaths:")[0], 1.0);
    assert!(longest_s > DEAD_S, "it was dead: {longest_s}");
    // Events come each 0.1 s.
    assert!(longest_s - DEAD_S <= 2.1, "{longest_s}");
}

/// Memory that a process holds \[MB\].
fn resident_mb(pid: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    numbers(&status, "VmRSS:")[0] / 1024.0
}

#[test]
#[ignore = "6 minutes: make live-test"]
fn an_hour_of_cycles_sped_up_ten_times_takes_no_memory() {
    let _port = PORT.lock();
    let folder = tempfile::tempdir().unwrap();
    let camera = double(&["--fps", "200", "--lose", "0.5"]);
    // 360,000 cycles, as in an hour of 10 ms each; a record that is soon full, and a page that is looked at.
    let record = folder.path().join("run.mcap");
    let more = format!("record = {record:?}\nrecord_most_mb = 50\n[robot]\ncycle_s = 0.001\nspeed_mm_s = 100");
    let run = Run::at(CAMERA, &more);
    let (mut samples, began) = (vec![], Instant::now());
    for event in run.events() {
        if began.elapsed().as_secs() / 10 > samples.len() as u64 {
            run.request("GET", "/picture.jpg", "");
            samples.push(resident_mb(run.pid()));
            println!(
                "{:.0} s: {:.1} MB, {} cycles",
                began.elapsed().as_secs_f64(),
                samples[samples.len() - 1],
                event["cycle"]
            );
        }
        if began.elapsed() > Duration::from_secs(370) {
            break;
        }
    }
    println!("{}{}", run.end(), done(&ended(camera)));
    // The first minute fills rings and the allocator's arenas.
    let (early, late) = (samples[5], samples[samples.len() - 1]);
    assert!(late - early < 5.0, "{early} MB after a minute, {late} MB at the end");
}

#[test]
#[ignore = "needs programs of others: make live-test"]
fn the_fake_camera_of_aravis_is_seen_too() {
    let _port = PORT.lock();
    let mut fake = std::process::Command::new("arv-fake-gv-camera-0.8");
    let Ok(mut fake) = fake.args(["-i", "127.0.0.1"]).spawn() else {
        eprintln!("skipped: no arv-fake-gv-camera-0.8; on Debian: apt-get install aravis-tools");
        return;
    };
    std::thread::sleep(Duration::from_millis(500));
    let run = Run::at(CAMERA, "");
    std::thread::sleep(Duration::from_secs(5));
    let report = run.end();
    fake.kill().unwrap();
    fake.wait().unwrap();
    println!("{report}");
    assert!(numbers(&report, "pictures:")[0] > 20.0, "{report}");
}

#[test]
fn a_double_that_cannot_be_is_one_clear_error() {
    let told = |arguments: &[&str]| {
        let output = seamtrack().arg("camera-double").args(arguments).output().unwrap();
        assert!(!output.status.success());
        text(&output.stderr)
    };
    assert!(told(&["--show", "nothing"]).contains("file:PATH or scene:NAME"));
    assert!(told(&["--address", "192.0.2.1"]).contains("an address of this machine"));
    assert!(told(&["--trouble", "dead"]).contains("dead@5:2"));
}
