//! What a live run records, and what becomes of it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{configured, done, end, numbers, seamtrack, text, wait_until};

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/demo-butt/frames")
}

/// Status, column and row of the causal path, one a frame.
type Path3 = Vec<(String, Option<f64>, Option<f64>)>;

/// As the live run wrote it into its log.
fn path_of_log(log: &Path) -> Path3 {
    let bytes = fs::read(log).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let rows = messages.filter(|message| message.channel.topic == "/seam/path");
    let row = |message: mcap::Message<'_>| {
        let row: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        (row["status"].as_str().unwrap().to_owned(), row["u_px"].as_f64(), row["v_px"].as_f64())
    };
    rows.map(row).collect()
}

/// As `track` makes it of the log.
fn path_of_track(log: &Path, results: &Path) -> Path3 {
    let mut track = seamtrack();
    track.arg("track").arg(log).arg("-o").arg(results).args(["--mm-per-px", "0.073", "--quiet"]);
    let output = track.output().unwrap();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", text(&output.stderr));
    assert!(!text(&output.stderr).contains("ends early"), "{}", text(&output.stderr));
    let mut csv = csv::Reader::from_path(results.join("path.csv")).unwrap();
    let headers = csv.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let [status, u, v] = ["status", "u_px", "v_px"].map(column);
    let row = |row: csv::StringRecord| (row[status].to_owned(), row[u].parse().ok(), row[v].parse().ok());
    csv.records().map(|record| row(record.unwrap())).collect()
}

/// Gives the number of frames.
fn assert_same_path(log: &Path, results: &Path) -> usize {
    let (live, tracked) = (path_of_log(log), path_of_track(log, results));
    assert_eq!(live.len(), tracked.len());
    // path.csv has three decimals.
    let same = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= 0.000_501,
        (a, b) => a == b,
    };
    for (frame, (a, b)) in live.iter().zip(&tracked).enumerate() {
        assert!(a.0 == b.0 && same(a.1, b.1) && same(a.2, b.2), "frame {frame}: live {a:?}, tracked {b:?}");
    }
    live.len()
}

#[test]
fn track_of_the_record_gives_the_path_of_the_live_run_also_where_frames_were_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    // 400 times as fast are more frames than can be tracked, so that some are passed over.
    for rate in [3, 400] {
        let log = folder.path().join(format!("run-{rate}.mcap"));
        let camera = demo();
        let config = configured(
            folder.path(),
            &format!(
                "camera = {:?}\nrate = {rate}\n[track]\nmm_per_px = 0.073\n",
                format!("file:{}", camera.display())
            ),
        );
        let mut live = seamtrack();
        let report =
            done(&live.args(["live", "--quiet", "--config"]).arg(&config).arg("--record").arg(&log).output().unwrap());
        assert_eq!(numbers(&report, "recorded:")[1], 0.0, "{report}");
        assert!(assert_same_path(&log, &folder.path().join(format!("results-{rate}"))) > 0);
    }
}

#[test]
fn a_live_run_that_is_told_to_end_leaves_a_whole_record() {
    for signal in ["-INT", "-TERM"] {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("run.mcap");
        let config =
            configured(folder.path(), "camera = \"scene:butt-clean\"\nrate = 10\n[track]\nmm_per_px = 0.073\n");
        let mut live = seamtrack();
        let live = live.args(["live", "--quiet", "--config"]).arg(&config).arg("--record").arg(&log).spawn().unwrap();
        wait_until("a record", || fs::metadata(&log).is_ok_and(|metadata| metadata.len() > 1 << 20));
        end(&live, signal);
        done(&live.wait_with_output().unwrap());
        assert_same_path(&log, &folder.path().join("results"));
    }
}

#[test]
fn an_old_record_is_never_written_over_and_messages_name_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("old.mcap");
    fs::write(&log, "old").unwrap();
    let told = |text_of_config: &str| {
        let config = configured(folder.path(), text_of_config);
        let output = seamtrack().args(["live", "--config"]).arg(&config).arg("--record").arg(&log).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        text(&output.stderr)
    };
    let good = "camera = \"scene:butt-clean\"\n[track]\nmm_per_px = 0.073\n";
    assert!(told(good).contains("choose a new file"));
    assert_eq!(fs::read_to_string(&log).unwrap(), "old");
    assert!(told("camera = \"scene:butt-clean\"\n").contains("mm_per_px"));
    assert!(told("camera = \"nowhere\"\n[track]\nmm_per_px = 0.073\n").contains("file:PATH"));
    assert!(told(&format!("{good}[guide]\ngain = 1.0\n")).contains("gain must be from 0.01 to 0.3"));
    assert!(told(&format!("{good}[guide]\nspeed = 1.0\n")).contains("unknown field `speed`"));
    assert!(told(&format!("{good}[robot]\ntravel = [1, 1, 0]\n")).contains("unit vectors"));
}
