//! `seamtrack calibrate import` and `export`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};
use seamtrack::calib::board::pair;
use seamtrack::calib::file::CalibrationFile;
use seamtrack::calib::interchange::{import_camera, to_opencv, to_ros};

use super::Target;

/// Take over a camera from OpenCV's YAML, ROS' camera_info or Kalibr's camchain
#[derive(Debug, Args)]
pub struct Import {
    /// The other program's file
    #[arg(value_name = "FILE.yaml")]
    input: PathBuf,
    /// Columns and rows of the camera's pictures, where the file does not say
    #[arg(long, value_name = "WxH", value_parser = pair)]
    size: Option<[usize; 2]>,
    /// The calibration
    #[arg(short, long, value_name = "FILE.toml", default_value = "camera.toml")]
    output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
}

/// Write a camera for other programs
#[derive(Debug, Args)]
pub struct Export {
    /// The calibration
    #[arg(value_name = "CALIBRATION.toml")]
    input: PathBuf,
    /// For which program
    #[arg(long)]
    to: Dialect,
    /// The file
    #[arg(short, long, value_name = "FILE.yaml")]
    output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Dialect {
    /// OpenCV's FileStorage, with the laser's plane where there is one
    Opencv,
    /// ROS' camera_info
    Ros,
}

impl Import {
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let target = Target::new(&self.output, self.force, [&self.input])?;
        let text =
            std::fs::read_to_string(&self.input).with_context(|| format!("cannot read {}", self.input.display()))?;
        let imported = import_camera(&text).map_err(|problem| anyhow!("{}: {problem}", self.input.display()))?;
        let given = self.size.map(|[width, height]| (width, height));
        let size_px = given.or(imported.size_px).with_context(|| {
            format!("{} does not say how large its pictures are: give --size WxH", self.input.display())
        })?;
        let mut file = CalibrationFile::default();
        file.set_camera(size_px, &imported.intrinsics);
        target.write(&mut file, |_| String::new())?;
        outln!(
            "{target}: a camera of {}, {} x {} pixels; nothing is known of its uncertainty",
            imported.dialect,
            size_px.0,
            size_px.1
        );
        Ok(ExitCode::SUCCESS)
    }
}

impl Export {
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let target = Target::new(&self.output, self.force, [&self.input])?;
        let file = CalibrationFile::read(&self.input)?;
        let camera = file.known_camera().map_err(|problem| anyhow!("{} {problem}", self.input.display()))?;
        let sensor = file.laser_camera().ok();
        let name = self.input.file_stem().map_or("camera".into(), |stem| stem.to_string_lossy());
        let text = match self.to {
            Dialect::Opencv => to_opencv(&camera.intrinsics, camera.size_px, sensor.as_ref()),
            Dialect::Ros => to_ros(&camera.intrinsics, camera.size_px, &name),
        };
        target.write_text(&text, String::new)?;
        outln!("{target}");
        Ok(ExitCode::SUCCESS)
    }
}
