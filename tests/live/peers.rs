//! Programs of others: a Modbus client, a KUKA's emulation, and the messages of an ABB, all in Python. `SEAMTRACK_PEERS` names a
//! Python that has pymodbus, RSIPI and ABBRobotEGM; without it these tests say so and pass.

use std::path::Path;
use std::process::Command;

use crate::program::{configured, done, end, free_tcp, free_udp, numbers, seamtrack, text};

fn peer() -> Option<String> {
    let python = std::env::var("SEAMTRACK_PEERS").ok();
    if python.is_none() {
        eprintln!("skipped: SEAMTRACK_PEERS names no Python with pymodbus, RSIPI and ABBRobotEGM");
    }
    python
}

fn script(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/live").join(name)
}

#[test]
#[ignore = "needs programs of others: make live-test"]
fn pymodbus_reads_ten_thousand_times_and_no_value_is_torn() {
    let Some(python) = peer() else { return };
    let folder = tempfile::tempdir().unwrap();
    let modbus = free_tcp();
    let text_of_config = format!(
        "camera = \"scene:butt-clean\"\n[track]\nmm_per_px = 0.073\n[modbus]\nlisten = \"{modbus}\"\nplc_silent_s = 600\n"
    );
    let live = seamtrack().args(["live", "--config"]).arg(configured(folder.path(), &text_of_config)).spawn().unwrap();
    let output = Command::new(python).arg(script("peer_modbus.py")).arg(modbus.port().to_string()).output().unwrap();
    end(&live, "-TERM");
    done(&live.wait_with_output().unwrap());
    println!("{}", done(&output));
}

#[test]
#[ignore = "needs programs of others: make live-test"]
fn an_emulated_kuka_finds_no_fault_in_our_answers() {
    let Some(python) = peer() else { return };
    for cycle_ms in ["4", "12"] {
        let folder = tempfile::tempdir().unwrap();
        let text_of_config = "camera = \"scene:butt-clean\"\n[track]\nmm_per_px = 0.073\n[robot]\nlink = \"rsi\"\nlisten = \"127.0.0.1:49152\"\n";
        let live =
            seamtrack().args(["live", "--config"]).arg(configured(folder.path(), text_of_config)).spawn().unwrap();
        let setup = script("../../docs/live/rsi-ethernet.xml");
        let mut python = Command::new(&python);
        let output =
            python.current_dir(folder.path()).arg(script("peer_rsi.py")).arg(setup).arg(cycle_ms).output().unwrap();
        end(&live, "-TERM");
        let report = done(&live.wait_with_output().unwrap());
        let peer = done(&output);
        println!("{peer}{report}");
        assert_eq!(numbers(&report, "late packets")[1], 0.0, "{report}");
        assert!(numbers(&peer, "cycles")[0] > 300.0, "{peer} {}", text(&output.stderr));
    }
}

#[test]
#[ignore = "needs programs of others: make live-test"]
fn the_messages_of_an_abb_are_understood_and_ours_by_it() {
    let Some(python) = peer() else { return };
    for cycle_ms in ["4", "24"] {
        let folder = tempfile::tempdir().unwrap();
        let egm = free_udp();
        let text_of_config = format!(
            "camera = \"scene:butt-clean\"\n[track]\nmm_per_px = 0.073\n[guide]\nahead_mm = 5\ntack_mm = 5\n\
             [robot]\nlink = \"egm\"\nlisten = \"{egm}\"\n"
        );
        let live =
            seamtrack().args(["live", "--config"]).arg(configured(folder.path(), &text_of_config)).spawn().unwrap();
        let mut python = Command::new(&python);
        let output = python.arg(script("peer_egm.py")).arg(egm.port().to_string()).arg(cycle_ms).output().unwrap();
        end(&live, "-TERM");
        let report = done(&live.wait_with_output().unwrap());
        println!("{}{report}", done(&output));
        assert_eq!(numbers(&report, "late packets")[1..3], [0.0, 0.0], "{report}");
    }
}
