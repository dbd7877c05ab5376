//! What is fuzzed: each target takes any bytes and must come back, with a value or a refusal.
//!
//! The same functions run under cargo-fuzz (`fuzz_targets/`), in `make fuzz` (`examples/fuzz`, on a stable compiler), and over
//! the corpora in the tests (`tests/fuzz_corpus.rs`).

#[path = "../src/cli/manifest.rs"]
mod manifest;
#[path = "../src/cli/filter/measurements.rs"]
mod measurements;
#[path = "session.rs"]
mod session;

use std::path::PathBuf;

use seamtrack::calib::file::CalibrationFile;
use seamtrack::calib::interchange::import_camera;
use seamtrack::config::Config;
use seamtrack::eval::read_truth;
use seamtrack::report::pool::read_pool_csv;
use seamtrack::report::results::{read_path_csv, write_path_csv};
use seamtrack::report::summary::read_summary;
use seamtrack::source::{FrameSource, Period, open, open_intensity};
use seamtrack::synth::pool::{PoolScenario, PoolScene};
use seamtrack::synth::{Scenario, Scene};
use seamtrack::units::PixelPoint;

/// A target.
pub struct Target {
    /// Its name, that of its corpus.
    pub name: &'static str,
    /// Takes an input. It panics when a promise is broken.
    pub run: fn(&[u8]),
    /// How many of a thousand inputs are for it: those that are slow get fewer.
    pub share: u64,
}

/// All targets.
pub const TARGETS: [Target; 15] = [
    Target { name: "config", run: config, share: 130 },
    Target { name: "scenario", run: scenario, share: 40 },
    Target { name: "pool-scenario", run: pool_scenario, share: 40 },
    Target { name: "calibration", run: calibration, share: 130 },
    Target { name: "camera", run: camera, share: 130 },
    Target { name: "truth", run: truth, share: 70 },
    Target { name: "path", run: path, share: 70 },
    Target { name: "pool-path", run: pool_path, share: 60 },
    Target { name: "summary", run: summary, share: 80 },
    Target { name: "manifest", run: manifest, share: 80 },
    Target { name: "measurements", run: measurements, share: 80 },
    Target { name: "timestamps", run: timestamps, share: 20 },
    Target { name: "picture", run: picture, share: 30 },
    Target { name: "mcap", run: mcap, share: 30 },
    Target { name: "session", run: session::run, share: 10 },
];

/// Feeds an input to the target of this name: what cargo-fuzz calls.
#[allow(dead_code, reason = "the other two go through the list")]
pub fn run(name: &str, input: &[u8]) {
    let target = TARGETS.iter().find(|target| target.name == name).expect("there is such a target");
    (target.run)(input);
}

/// Longest made-up recording whose path is worked out, and largest frame that is rendered.
const MOST_FRAMES: usize = 300;
const MOST_PIXELS: usize = 320 * 240;

/// What a configuration says is refused, or becomes a method; and it survives being written.
fn config(bytes: &[u8]) {
    let (_folder, file) = file("config.toml", bytes);
    let Ok(config) = Config::read(&file) else { return };
    let _ = config.method();
    if let Ok(text) = toml::to_string(&config) {
        let again: Config = toml::from_str(&text).expect("a configuration that was written can be read");
        assert_eq!(toml::to_string(&again).ok(), Some(text));
    }
}

/// A scenario is refused, or can be rendered.
fn scenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(scenario) = Scenario::from_toml(text, "fuzz") else { return };
    if let Ok(text) = scenario.to_toml() {
        Scenario::from_toml(&text, "written").expect("a scenario that was written can be read");
    }
    let pixels = scenario.image.width_px * scenario.image.height_px;
    if scenario.frames <= MOST_FRAMES
        && pixels <= MOST_PIXELS
        && let Ok(scene) = Scene::new(&scenario, scenario.seed)
    {
        let last = scene.frame_count() - 1;
        std::hint::black_box((scene.render(last), scene.truth(last)));
    }
}

/// The same for a melt pool.
fn pool_scenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(scenario) = PoolScenario::from_toml(text, "fuzz") else { return };
    if scenario.frames <= MOST_FRAMES
        && scenario.image.width_px * scenario.image.height_px <= MOST_PIXELS
        && let Ok(scene) = PoolScene::new(&scenario, scenario.seed)
    {
        std::hint::black_box(scene.render(scene.frame_count() - 1));
    }
}

/// A calibration is refused, or can be used, and survives being written.
fn calibration(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(file) = CalibrationFile::parse(text) else { return };
    let (_, _) = (file.known_camera(), file.hand_eye());
    if let (Ok(sensor), Some((width, height))) = (file.laser_camera(), file.size_px()) {
        let _ = sensor.stripe_axis();
        for share in [0.0, 0.5, 1.0] {
            let pixel = PixelPoint::new(share * width as f64, share * height as f64);
            let (point, _, _) = (sensor.point(pixel), sensor.jacobian(pixel), sensor.calibration_covariance_mm2(pixel));
            if let Some(point) = point {
                assert!(point.lateral_mm.is_finite() && point.height_mm.is_finite(), "{point:?}");
                let _ = sensor.pixel(point);
            }
        }
    }
    if let Ok(text) = file.to_toml() {
        CalibrationFile::parse(&text).expect("a calibration that was written can be read");
    }
}

/// Another program's camera.
fn camera(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = import_camera(text);
    }
}

/// A truth.
fn truth(bytes: &[u8]) {
    let (_folder, file) = file("truth.csv", bytes);
    let _ = read_truth(&file);
}

/// The rows of a run: refused, or written as they were read.
fn path(bytes: &[u8]) {
    let (folder, file) = file("path.csv", bytes);
    let Ok(rows) = read_path_csv(&file) else { return };
    let again = folder.path().join("again.csv");
    write_path_csv(&again, &rows).expect("rows can be written");
    assert_eq!(read_path_csv(&again).map(|rows| rows.len()).ok(), Some(rows.len()));
}

/// The rows of a melt pool.
fn pool_path(bytes: &[u8]) {
    let (_folder, file) = file("path.csv", bytes);
    let _ = read_pool_csv(&file);
}

/// The summary of a run.
fn summary(bytes: &[u8]) {
    let (_folder, file) = file("summary.json", bytes);
    let _ = read_summary(&file);
}

/// A list of recordings.
fn manifest(bytes: &[u8]) {
    let (_folder, file) = file("list.csv", bytes);
    let _ = manifest::read(&file);
}

/// A measured series: refused, or with steps that rise.
fn measurements(bytes: &[u8]) {
    let (_folder, file) = file("series.csv", bytes);
    if let Ok(series) = measurements::Measurements::read(&file) {
        assert!(series.steps_s().iter().all(|step_s| *step_s > 0.0) && series.median_step_s() > 0.0);
    }
}

/// Time stamps in the folder of a recording.
fn timestamps(bytes: &[u8]) {
    let (folder, _) = file("timestamps.csv", bytes);
    for name in ["0.png", "1.png"] {
        std::fs::write(folder.path().join(name), b"none").expect("the temporary folder can be written");
    }
    if let Ok(mut source) = open(folder.path(), Period::Given(0.2)) {
        while let Some(frame) = source.next_frame() {
            assert!(frame.time_s.is_finite());
        }
    }
}

/// A picture, a stack of pages or a NumPy stack; the first byte says which.
fn picture(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let name = ["a.png", "a.jpg", "a.bmp", "a.tif", "a.npy"][usize::from(kind % 5)];
    let (_folder, file) = file(name, bytes);
    if let Ok(mut source) = open_intensity(&file, Period::Given(0.2)) {
        for _ in 0..4 {
            let Some(frame) = source.next_frame() else { break };
            if let Ok(picture) = frame.picture {
                assert_eq!(picture.pixels().len(), picture.width_px() * picture.height_px());
            }
        }
    }
    // What is none of these goes to a decoder in another process, which is not what is fuzzed.
    if kind % 5 != 4
        && let Ok(mut source) = open(&file, Period::Given(0.2))
    {
        frames(&mut *source);
    }
}

/// A log of a robot: refused, or a recording that can be read to its end and once more from any frame.
fn mcap(bytes: &[u8]) {
    let (_folder, file) = file("log.mcap", bytes);
    for skipped in 0..2 {
        let Ok(mut source) = open(&file, Period::OwnOr(0.2)) else { return };
        assert!(source.period_s() > 0.0 && source.period_s().is_finite());
        source.skip(skipped);
        while let Some(frame) = source.next_frame() {
            assert!(frame.time_s.is_finite() && frame.time_s >= 0.0);
            if let Ok(picture) = frame.picture {
                assert_eq!(picture.pixels().len(), picture.width_px() * picture.height_px());
            }
        }
    }
}

fn frames(source: &mut dyn FrameSource) {
    for _ in 0..4 {
        let Some(frame) = source.next_frame() else { return };
        if let Ok(picture) = frame.picture {
            assert_eq!(picture.pixels().len(), picture.width_px() * picture.height_px());
        }
    }
}

/// The bytes as a file in a folder of its own.
fn file(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("there is a temporary folder");
    let file = folder.path().join(name);
    std::fs::write(&file, bytes).expect("the temporary folder can be written");
    (folder, file)
}
