//! The closed loop: `seamtrack live` at the simulated cell. What depends on the machine's speed is printed, not asserted, but
//! for the long runs of `make live-test`.

use std::path::Path;
use std::process::{Child, Output};

use crate::program::{configured, done, end, free_tcp, free_udp, numbers, seamtrack, text};

/// Largest step of the guide's defaults \[mm\].
const CAP_MM: f64 = 0.1;

/// A live run and a cell with `arguments`; their reports.
fn weld(folder: &Path, arguments: &[&str], while_welding: impl FnOnce(&Child)) -> (String, Output) {
    weld_by("rsi", folder, arguments, while_welding)
}

fn weld_by(link: &str, folder: &Path, arguments: &[&str], while_welding: impl FnOnce(&Child)) -> (String, Output) {
    let (camera, corrections) = (free_tcp().to_string(), free_udp().to_string());
    let text = format!(
        "camera = \"tcp:{camera}\"\ncamera_lag_s = 0.01\n[track]\nmm_per_px = 0.073\n[robot]\nlink = \"{link}\"\nlisten = \"{corrections}\"\n"
    );
    let live = seamtrack().args(["live", "--config"]).arg(configured(folder, &text)).spawn().unwrap();
    let mut cell = seamtrack();
    cell.args(["cell", "--link", link, "--camera", &camera, "--corrections", &corrections]).args(arguments);
    let cell = cell.spawn().unwrap();
    while_welding(&live);
    let cell = cell.wait_with_output().unwrap();
    end(&live, "-TERM");
    (done(&live.wait_with_output().unwrap()), cell)
}

#[test]
fn a_short_weld_is_answered_cycle_by_cycle_and_no_step_is_above_the_cap() {
    let folder = tempfile::tempdir().unwrap();
    let (live, cell) = weld(folder.path(), &["--length", "90"], |_| ());
    let cell = text(&cell.stdout);
    assert!(numbers(&cell, "largest step [mm]:")[0] <= CAP_MM + 1e-9, "{cell}");
    assert_eq!(numbers(&live, "late packets")[1..3], [0.0, 0.0], "every message was understood and new: {live}");
}

#[test]
fn a_camera_that_freezes_for_good_stops_the_corrections_and_the_exit_code_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let (_, cell) = weld(folder.path(), &["--length", "300", "--trouble", "frozen@40:60"], |_| ());
    assert_eq!(cell.status.code(), Some(3), "{}", text(&cell.stderr));
    let report = text(&cell.stdout);
    assert!(report.contains("stopped: "), "{report}");
    assert!(numbers(&report, "largest step [mm]:")[0] <= CAP_MM + 1e-9, "{report}");
}

#[test]
fn an_abb_is_answered_too_and_a_stop_is_silence() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--length", "300", "--trouble", "frozen@40:60"];
    let (live, cell) = weld_by("egm", folder.path(), &arguments, |_| ());
    assert_eq!(cell.status.code(), Some(3), "{}", text(&cell.stderr));
    let report = text(&cell.stdout);
    assert!(report.contains("stopped: unknown"), "the robot's time-out: {report}");
    assert!(numbers(&report, "largest step [mm]:")[0] <= CAP_MM + 1e-9, "{report}");
    assert_eq!(numbers(&live, "late packets")[1..3], [0.0, 0.0], "every message was understood and new: {live}");
}

/// Root mean square and maximum of the torch's error \[mm\].
fn torch_mm(cell: &Output) -> (f64, f64) {
    let report = done(cell);
    println!("{report}");
    let numbers = numbers(&report, "torch beside the seam [mm]:");
    (numbers[1], numbers[2])
}

#[test]
#[ignore = "20 s each and a quiet machine: make live-test"]
fn the_torch_keeps_to_the_seam() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["sine", "corner", "tack", "arc"] {
        let (_, cell) = weld(folder.path(), &["--scene", scene], |_| ());
        let (rms_mm, max_mm) = torch_mm(&cell);
        assert!(rms_mm <= 0.08 && max_mm <= 0.3, "{scene}: rms {rms_mm}, max {max_mm}");
    }
    let (_, cell) = weld_by("egm", folder.path(), &["--speed", "10", "--length", "300"], |_| ());
    let (rms_mm, max_mm) = torch_mm(&cell);
    assert!(rms_mm <= 0.08 && max_mm <= 0.3, "EGM at 10 mm/s: rms {rms_mm}, max {max_mm}");
    let (_, cell) = weld(folder.path(), &["--lose", "0.5", "--trouble", "stall@300:0.5"], |_| ());
    let (_, max_mm) = torch_mm(&cell);
    assert!(max_mm <= 0.6, "with a stall: {max_mm}");
}

#[test]
#[ignore = "40 s and a quiet machine: make live-test"]
fn ten_thousand_cycles_of_four_milliseconds_are_answered_in_time() {
    let folder = tempfile::tempdir().unwrap();
    let (_, cell) = weld(folder.path(), &["--length", "1200"], |_| ());
    let report = done(&cell);
    println!("{report}");
    let late = numbers(&report, "late:");
    assert!(late[1] >= 9_900.0 && late[2] <= 0.5 && late[3] <= 4.0, "{report}");
    assert!(numbers(&report, "answer [ms]:")[1] <= 0.2, "{report}");
}

#[test]
#[ignore = "a minute and a quiet machine: make live-test"]
fn after_a_dead_camera_a_cut_network_or_a_stopped_process_the_robot_holds_and_goes_on_when_it_is_told_to() {
    let folder = tempfile::tempdir().unwrap();
    let pause = |live: &Child| {
        std::thread::sleep(std::time::Duration::from_secs(6));
        end(live, "-STOP");
        std::thread::sleep(std::time::Duration::from_secs(1));
        end(live, "-CONT");
    };
    let nothing = |_: &Child| ();
    /// What the live run says, the cell's trouble, and what happens while it welds.
    type Case<'a> = (&'a str, &'a [&'a str], &'a dyn Fn(&Child));
    let cases: [Case; 3] = [
        ("camera-silent", &["--trouble", "dead@150:4"], &nothing),
        ("robot-silent", &["--trouble", "cut@150:1"], &nothing),
        ("robot-silent", &[], &pause),
    ];
    for (why, trouble, while_welding) in cases {
        let arguments = [&["--length", "400", "--resets", "9"], trouble].concat();
        let (live, cell) = weld(folder.path(), &arguments, while_welding);
        let report = text(&cell.stdout);
        println!("{report}{live}");
        assert!(report.contains(&format!("stopped: {why}")), "{report}");
        assert!(numbers(&report, "largest step [mm]:")[0] <= CAP_MM + 1e-9, "{report}");
        assert!(numbers(&report, "torch beside the seam [mm]:")[3] >= 400.0, "it went on to the end: {report}");
    }
}
