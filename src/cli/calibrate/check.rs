//! `seamtrack calibrate check`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, anyhow};
use clap::Args;
use seamtrack::calib::board::pair;
use seamtrack::calib::check::{Checked, StripePoints, check_boards, check_plate, check_step, stripe_points};
use seamtrack::calib::check_travel::TravelCheck;
use seamtrack::calib::file::CalibrationFile;
use seamtrack::calib::laser_camera::LaserCamera;
use seamtrack::calib::stripes::find_stripes;
use seamtrack::source;
use serde_json::json;

use super::camera::{Board, parse_board};
use super::laser::{board_of, read_pairs};
use super::pictures::{Folder, read_poses, still_light};
use super::{parse_finite, parse_positive};
use crate::cli::recordings::size_of;

/// Test a calibration by a flat plate, a known step, a known travel, or its own boards
///
/// Without --plate, --step and --poses, INPUT is a folder of boards with the stripe on them, as for `calibrate laser`.
/// Exits with 3 when a figure is beyond its gate.
#[derive(Debug, Args)]
pub struct Check {
    /// The calibration
    #[arg(value_name = "CALIBRATION.toml")]
    calibration: PathBuf,
    /// The recording, or the folder of boards
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    /// The recording shows a flat plate
    #[arg(long)]
    plate: bool,
    /// The recording shows a step of this height [mm]
    #[arg(long, value_name = "MM", value_parser = parse_positive)]
    step: Option<f64>,
    /// The robot's x, y, z [mm] for each frame, while it moved along the plate or up and down
    #[arg(long, value_name = "CSV")]
    poses: Option<PathBuf>,
    /// Largest good error [mm]
    #[arg(long, value_name = "MM", default_value_t = 0.2, value_parser = parse_positive)]
    gate: f64,
    /// The plate's tilt along the stripe, where it does not lie squarely [°]
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = parse_finite, allow_negative_numbers = true)]
    tilt: f64,
    /// The recording's pictures were cut out of the calibrated ones at this column and row
    #[arg(long, value_name = "UxV", value_parser = pair)]
    crop_at: Option<[usize; 2]>,
    /// Boards: lines dark,lit with names of pictures
    #[arg(long, value_name = "LIST.csv")]
    pairs: Option<PathBuf>,
    /// Boards: side of a square [mm] [default: the file's]
    #[arg(long, value_name = "MM", value_parser = parse_positive)]
    square: Option<f64>,
    /// Boards: inner corners [default: the file's, else auto]
    #[arg(long, value_name = "auto|6x7", value_parser = parse_board)]
    board: Option<Board>,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

impl Check {
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let file = CalibrationFile::read(&self.calibration)?;
        let sensor = file.laser_camera().map_err(|problem| anyhow!("{} {problem}", self.calibration.display()))?;
        let of_recording = self.plate || self.step.is_some() || self.poses.is_some();
        let checks =
            if of_recording { self.recording(&sensor)? } else { vec![("boards", self.boards(&file, &sensor)?)] };
        let good = checks.iter().all(|(_, checked)| checked.is_good());
        if self.json {
            outln!("{:#}", self.as_json(&checks, good));
        } else {
            checks.iter().for_each(|(name, checked)| print(name, checked));
            let verdict = if good { "GOOD: the calibration passes" } else { "BAD: do not trust this calibration here" };
            outln!("{verdict}");
        }
        Ok(ExitCode::from(if good { 0 } else { 3 }))
    }

    fn boards(&self, file: &CalibrationFile, sensor: &LaserCamera) -> anyhow::Result<Checked> {
        let pictures = Folder::open(&self.input)?;
        let (board, square_mm) = board_of(file, self.board, self.square, &pictures, &self.input)?;
        let pairs = read_pairs(self.pairs.as_deref(), &pictures, &self.input)?;
        let found = find_stripes(&pictures, &pairs, board, sensor.intrinsics(), sensor.size_px());
        let (views, left_out) = found.with_context(|| self.input.display().to_string())?;
        left_out.iter().for_each(|reason| errln!("left out: {reason}"));
        check_boards(sensor, (board, square_mm), &views, self.gate).with_context(|| self.input.display().to_string())
    }

    fn recording(&self, sensor: &LaserCamera) -> anyhow::Result<Vec<(&'static str, Checked)>> {
        let poses = self.poses.as_deref().map(read_poses).transpose()?;
        let sensor = self.for_recording(sensor)?;
        let mut travel = match poses {
            Some(_) => Some(TravelCheck::new(&sensor, still_light(&self.input)?)),
            None => None,
        };
        let mut source = source::open(&self.input, 1.0)?;
        let mut frames = Sample::default();
        let mut count = 0;
        while let Some(frame) = source.next_frame() {
            let number = count;
            count += 1;
            let Ok(picture) = frame.picture else { continue };
            let size_px = (picture.width_px(), picture.height_px());
            sensor.expect_size(size_px).with_context(|| format!("{} in {}", frame.file, self.input.display()))?;
            if self.plate || self.step.is_some() {
                frames.offer(|| stripe_points(&sensor, &picture));
            }
            if let (Some(travel), Some(poses)) = (&mut travel, &poses) {
                let pose = poses.get(number).with_context(|| {
                    format!("more frames than the {} poses: one line a frame is needed", poses.len())
                })?;
                travel.step(&picture, (pose - poses[0]).norm());
            }
        }
        let mut checks = vec![];
        let named = || self.input.display().to_string();
        if self.plate {
            checks.push(("plate", check_plate(&sensor, &frames.kept, self.gate, self.tilt).with_context(named)?));
        }
        if let Some(step_mm) = self.step {
            checks.push(("step", check_step(&sensor, &frames.kept, step_mm, self.gate).with_context(named)?));
        }
        if let Some(travel) = travel {
            checks.push(("travel", travel.finish(self.gate).with_context(named)?));
        }
        Ok(checks)
    }

    /// The sensor for the recording's pictures: the calibrated ones, or a part cut out of them.
    fn for_recording(&self, sensor: &LaserCamera) -> anyhow::Result<LaserCamera> {
        let size_px = size_of(&self.input)?;
        match self.crop_at {
            Some([u, v]) => sensor.cropped((u, v), size_px).with_context(|| self.input.display().to_string()),
            None => {
                let fits = sensor.expect_size(size_px);
                fits.with_context(|| {
                    format!("{} (--crop-at UxV says where its pictures were cut out)", self.input.display())
                })?;
                Ok(sensor.clone())
            }
        }
    }

    fn as_json(&self, checks: &[(&str, Checked)], good: bool) -> serde_json::Value {
        let figures = checks.iter().flat_map(|(check, checked)| {
            checked.figures.iter().map(move |figure| {
                json!({ "check": check, "name": figure.name, "value": figure.value, "limit": figure.limit, "unit": figure.unit,
                    "good": figure.is_good(), "used": checked.used })
            })
        });
        json!({ "calibration": self.calibration, "input": self.input, "verdict": if good { "GOOD" } else { "BAD" },
            "figures": figures.collect::<Vec<_>>() })
    }
}

/// Most frames whose stripes are kept: a plate does not change.
const MOST_FRAMES: usize = 400;

/// Stripes of frames spread evenly over a recording of unknown length.
#[derive(Default)]
struct Sample {
    kept: Vec<StripePoints>,
    offered: usize,
    halvings: u32,
}

impl Sample {
    fn offer(&mut self, stripe: impl FnOnce() -> Option<StripePoints>) {
        if self.offered.is_multiple_of(1 << self.halvings) {
            self.kept.extend(stripe());
        }
        self.offered += 1;
        if self.kept.len() >= MOST_FRAMES {
            let mut number = 0;
            self.kept.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.halvings += 1;
        }
    }
}

fn print(name: &str, checked: &Checked) {
    outln!("{name}: {} frames or views", checked.used);
    for figure in &checked.figures {
        let mark = if figure.is_good() { "ok " } else { "BAD" };
        outln!("  {mark} {}: {:.3} {} (up to {:.3})", figure.name, figure.value, figure.unit, figure.limit);
        if !figure.is_good() {
            outln!("      {}", figure.meaning);
        }
    }
    for note in &checked.notes {
        outln!("  {note}");
    }
}
