//! Made-up seams before a made-up sensor, from board images to millimetres: `cargo run --example calibrated -- --seeds 301-312`,
//! after `cargo build` in the same profile.
//!
//! Each seed makes a recording, boards and stripes, calibrates camera and plane from them by the program's own commands, and tracks the
//! seam by what came out. An error in millimetres is then told apart into what the error in pixels makes of it through the true sensor
//! (its Jacobian times the pixels), and the rest, which is the calibration's; each is compared with its own σ.
#![expect(clippy::print_stdout, reason = "the table is what it is for")]

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use nalgebra::Vector2;
use seamtrack::PixelPoint;
use seamtrack::calib::file::CalibrationFile;
use seamtrack::eval::read_truth;
use seamtrack::report::results::read_path_csv;

/// Half the width of the normal's 95 %.
const Z_95: f64 = 1.96;

/// Seams tracked by sensors that were calibrated from their boards
#[derive(Parser)]
struct Arguments {
    /// First and last seed
    #[arg(long, default_value = "301-312")]
    seeds: String,
    /// Scenes with a camera and a laser plane
    #[arg(long, value_delimiter = ',', default_value = "sensor-butt,sensor-vgroove")]
    scenes: Vec<String>,
    /// Views of the board
    #[arg(long, default_value_t = 14)]
    boards: usize,
    /// Frames a recording
    #[arg(long, default_value_t = 120)]
    frames: usize,
}

/// One frame's errors of (lateral, height) \[mm\], and both σ.
struct Seen {
    by_pixels_mm: Vector2<f64>,
    by_calibration_mm: Vector2<f64>,
    noise_std_mm: Vector2<f64>,
    calib_std_mm: Vector2<f64>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let (first, last) = arguments.seeds.split_once('-').context("--seeds takes a range such as 301-312")?;
    let seeds = first.parse::<u64>()?..=last.parse()?;
    let program = beside_this()?;
    println!(
        "| scene, seed | frames | mm | error rms | by the pixels | by the calibration | σ of the calibration | pixels in 95 % | calibration in 95 % |\n\
         |---|---|---|---|---|---|---|---|---|"
    );
    for scene in &arguments.scenes {
        let mut all = vec![];
        for seed in seeds.clone() {
            let folder = tempfile::tempdir()?;
            let seen = trial(&program, folder.path(), (scene, seed), &arguments)?;
            print(&format!("{scene}, {seed}"), &seen);
            all.extend(seen);
        }
        print(&format!("**{scene}, all**"), &all);
    }
    Ok(())
}

/// The program that was built beside this example.
fn beside_this() -> Result<PathBuf> {
    let own = std::env::current_exe().context("this program has no path")?;
    let program = own.ancestors().nth(2).context("this program has no folder")?.join("seamtrack");
    ensure!(program.is_file(), "{} is missing: build the program first", program.display());
    Ok(program)
}

fn trial(program: &Path, folder: &Path, (scene, seed): (&str, u64), arguments: &Arguments) -> Result<Vec<Seen>> {
    let path = |name: &str| folder.join(name).display().to_string();
    let run = |words: &[&str]| {
        let said = Command::new(program).args(words).output()?;
        // 3 says that a verdict is bad, which is no failure of the measurement.
        let done = matches!(said.status.code(), Some(0 | 3));
        ensure!(done, "seamtrack {}: {}", words.join(" "), String::from_utf8_lossy(&said.stderr).trim());
        Ok::<_, anyhow::Error>(())
    };
    let [seed, boards, frames] =
        [seed, arguments.boards as u64, arguments.frames as u64].map(|number| number.to_string());
    let (camera, calibration, result) = (path("camera.toml"), path("calibration.toml"), path("result"));
    run(&["synth", scene, "-o", &path("rec"), "--seed", &seed, "--boards", &boards, "--frames", &frames])?;
    run(&["calibrate", "camera", &path("rec/boards"), "--square", "15", "-o", &camera])?;
    run(&["calibrate", "laser", &path("rec/stripes"), "--camera", &camera, "-o", &calibration])?;
    run(&["track", &path("rec/frames"), "--calibration", &calibration, "-o", &result, "--quiet"])?;
    let true_sensor = CalibrationFile::read(&folder.join("rec/sensor.toml"))?;
    let true_sensor = true_sensor.laser_camera().map_err(anyhow::Error::msg)?;
    let truth = read_truth(&folder.join("rec/truth.csv"))?;
    let rows = read_path_csv(&folder.join("result/path.csv"))?;
    let seen = truth.iter().filter_map(|truth| {
        let row = rows.get(truth.frame)?;
        let at = PixelPoint::new(truth.u_px?, truth.v_px?);
        let off_px = Vector2::new(row.u_px? - at.u_px, row.v_px? - at.v_px);
        let error_mm = Vector2::new(row.lateral_mm?, row.height_mm?) - Vector2::from(truth.plane_mm?);
        let by_pixels_mm = true_sensor.jacobian(at)? * off_px;
        Some(Seen {
            by_pixels_mm,
            by_calibration_mm: error_mm - by_pixels_mm,
            noise_std_mm: Vector2::new(row.lateral_std_mm?, row.height_std_mm?),
            calib_std_mm: Vector2::new(row.calib_lateral_std_mm?, row.calib_height_std_mm?),
        })
    });
    Ok(seen.collect())
}

fn print(name: &str, seen: &[Seen]) {
    let mean = |of: &dyn Fn(&Seen) -> f64| seen.iter().map(of).sum::<f64>() / seen.len() as f64;
    for (axis, word) in ["lateral", "height"].into_iter().enumerate() {
        let rms = |of: &dyn Fn(&Seen) -> f64| mean(&|seen| of(seen).powi(2)).sqrt();
        let inside = |error_mm: f64, std_mm: f64| f64::from(error_mm.abs() <= Z_95 * std_mm);
        println!(
            "| {name} | {} | {word} | {:.3} | {:.3} | {:.3} | {:.3} | {:.1} | {:.1} |",
            seen.len(),
            rms(&|s| s.by_pixels_mm[axis] + s.by_calibration_mm[axis]),
            rms(&|s| s.by_pixels_mm[axis]),
            rms(&|s| s.by_calibration_mm[axis]),
            rms(&|s| s.calib_std_mm[axis]),
            100.0 * mean(&|s| inside(s.by_pixels_mm[axis], s.noise_std_mm[axis])),
            100.0 * mean(&|s| inside(s.by_calibration_mm[axis], s.calib_std_mm[axis]))
        );
    }
}
