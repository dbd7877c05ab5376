//! `seamtrack calibrate camera`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use clap::Args;
use seamtrack::calib::board::BoardSize;
use seamtrack::calib::camera::{CameraFit, fit_camera};
use seamtrack::calib::detect::detect;
use seamtrack::calib::file::{CalibrationFile, ImageHash};
use seamtrack::calib::intrinsics::INTRINSIC_NAMES;
use seamtrack::report::calibration::{camera_map, camera_page};

use super::pictures::Folder;
use super::{Target, parse_positive, print_advice};

/// Calibrate a camera from pictures of a chessboard
#[derive(Debug, Args)]
pub struct Camera {
    /// Folder with pictures of the board, in different tilts and distances
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Side of a square [mm], measured on the print
    #[arg(long, value_name = "MM", value_parser = parse_positive)]
    square: f64,
    /// Inner corners of the board, or auto: found in the pictures
    #[arg(long, value_name = "auto|6x7", default_value = "auto", value_parser = parse_board)]
    board: Board,
    /// The calibration; the report is written beside it
    #[arg(short, long, value_name = "FILE.toml", default_value = "camera.toml")]
    output: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
}

/// The size of a board as given.
#[derive(Debug, Clone, Copy)]
pub struct Board(pub Option<BoardSize>);

pub fn parse_board(text: &str) -> Result<Board, String> {
    if text == "auto" { Ok(Board(None)) } else { text.parse().map(|size| Board(Some(size))) }
}

impl Camera {
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let target = Target::with_page(&self.output, self.force, [&self.folder])?;
        let pictures = Folder::open(&self.folder)?;
        let detected = detect(&pictures, self.board.0).with_context(|| self.folder.display().to_string())?;
        let fit = fit_camera(detected, self.square).with_context(|| self.folder.display().to_string())?;
        let mut file = CalibrationFile::default();
        file.set_camera(fit.size_px, &fit.intrinsics);
        if let Some(camera) = &mut file.camera {
            camera.rms_px = Some(fit.rms_px);
            camera.left_out_rms_px = Some(fit.left_out_rms_px);
            camera.views = Some(fit.views.len());
        }
        file.set_covariance(&fit.covariance);
        file.set_views(fit.board, fit.square_mm, fit.views.iter().map(|view| &view.sighting));
        let hash = |view: &seamtrack::calib::camera::CameraView| ImageHash {
            file: view.sighting.name.clone(),
            sha256: view.sighting.sha256.clone(),
        };
        file.images = fit.views.iter().map(hash).collect();
        target.write(&mut file, |file| camera_page(&self.folder.display().to_string(), file, &fit))?;
        print(&fit);
        print_advice(&fit.left_out, &fit.advice);
        outln!("written: {target}");
        Ok(ExitCode::SUCCESS)
    }
}

fn print(fit: &CameraFit) {
    outln!(
        "camera: {:.3} px rms over {} views in {} poses, {:.3} px on views left out; board {} inner corners",
        fit.rms_px,
        fit.views.len(),
        fit.poses,
        fit.left_out_rms_px,
        fit.board
    );
    let values = fit.intrinsics.to_array();
    for (i, name) in INTRINSIC_NAMES.iter().enumerate() {
        let sigma = fit.covariance[(i, i)].max(0.0).sqrt();
        let decimals = if i < 4 { 2 } else { 5 };
        if sigma > 0.0 {
            outln!("  {name} {:.decimals$} ± {sigma:.decimals$}", values[i]);
        }
    }
    if let Some((middle, worst)) = camera_map(fit).map(|map| map.middle_and_worst_px()) {
        outln!("  a projection is known to {middle:.2} px in the picture's middle and {worst:.2} px at its rim (1 σ)");
    }
    outln!("  the boards' tilts spread by {:.0}°", fit.tilt_spread_deg);
    for view in &fit.views {
        let dropped = view.sighting.corners.len() - view.sighting.used_corners();
        let note = if dropped > 0 { format!(", {dropped} corners left out") } else { String::new() };
        outln!(
            "  {}: {:.3} px, {:.3} px when left out, tilt {:.0}° at {:.0} mm{note}",
            view.sighting.name,
            view.rms_px,
            view.left_out_rms_px,
            view.tilt_deg,
            view.pose.translation_mm.z
        );
    }
}
