//! `seamtrack calibrate laser`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, anyhow, bail};
use clap::Args;
use seamtrack::calib::board::BoardSize;
use seamtrack::calib::detect::detect;
use seamtrack::calib::file::{CalibrationFile, HandEyeSection, ImageHash, LaserSection, RangeSection, check_hand_eye};
use seamtrack::calib::laser::{LaserFit, fit_laser};
use seamtrack::calib::laser_camera::PlanePoint;
use seamtrack::calib::pairs::{pair_by_list, pair_by_name};
use seamtrack::calib::stripes::find_stripes;
use seamtrack::report::calibration::laser_page;

use super::camera::{Board, parse_board};
use super::pictures::Folder;
use super::{Target, parse_positive, print_advice};

/// Calibrate the laser's plane from pictures of the board with the stripe on it
///
/// Pictures with the laser off and on are paired by the number in their names (off_03.png, on_03.png) or by --pairs; pictures
/// with the laser on alone do as well.
#[derive(Debug, Args)]
pub struct Laser {
    /// Folder with the pictures
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// The camera, from `calibrate camera` or `calibrate import`
    #[arg(long, value_name = "FILE.toml")]
    camera: PathBuf,
    /// Lines dark,lit with names of pictures in the folder, or lit alone
    #[arg(long, value_name = "LIST.csv")]
    pairs: Option<PathBuf>,
    /// Side of a square [mm] [default: the camera file's]
    #[arg(long, value_name = "MM", value_parser = parse_positive)]
    square: Option<f64>,
    /// Inner corners of the board [default: the camera file's, else auto]
    #[arg(long, value_name = "auto|6x7", value_parser = parse_board)]
    board: Option<Board>,
    /// The camera in the robot's flange: 16 numbers, row by row, shift in mm (text, or OpenCV's YAML)
    #[arg(long, value_name = "FILE")]
    hand_eye: Option<PathBuf>,
    /// The calibration; the report is written beside it
    #[arg(short, long, value_name = "FILE.toml", default_value = "calibration.toml")]
    output: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
}

impl Laser {
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let read = [&self.folder, &self.camera].into_iter().chain(&self.pairs).chain(&self.hand_eye);
        let target = Target::with_page(&self.output, self.force, read)?;
        let mut file = CalibrationFile::read(&self.camera)?;
        let camera = file.known_camera().map_err(|problem| anyhow!("{} {problem}", self.camera.display()))?;
        let hand_eye = self.hand_eye.as_deref().map(read_hand_eye).transpose()?;
        let pictures = Folder::open(&self.folder)?;
        let (board, square_mm) = board_of(&file, self.board, self.square, &pictures, &self.folder)?;
        let pairs = read_pairs(self.pairs.as_deref(), &pictures, &self.folder)?;
        let found = find_stripes(&pictures, &pairs, board, &camera.intrinsics, camera.size_px);
        let (views, left_out) = found.with_context(|| self.folder.display().to_string())?;
        let fit = fit_laser(&camera, (board, square_mm), views, left_out, pairs.len())
            .with_context(|| self.folder.display().to_string())?;
        let camera_images: Vec<ImageHash> = file.images.clone();
        write_into(&mut file, &fit);
        file.images = camera_images;
        file.images.extend(
            fit.views
                .iter()
                .map(|view| ImageHash { file: view.seen.board.name.clone(), sha256: view.seen.board.sha256.clone() }),
        );
        if let Some(matrix) = hand_eye {
            file.hand_eye = Some(HandEyeSection { matrix });
        }
        target.write(&mut file, |file| laser_page(&self.folder.display().to_string(), file, &fit))?;
        print(&fit);
        print_advice(&fit.left_out, &fit.advice);
        outln!("written: {target}");
        outln!("test it with what you have: seamtrack calibrate check {} RECORDING --plate", self.output.display());
        Ok(ExitCode::SUCCESS)
    }
}

fn write_into(file: &mut CalibrationFile, fit: &LaserFit) {
    let sensor = &fit.sensor;
    file.set_camera(sensor.size_px(), sensor.intrinsics());
    let n = sensor.plane().normal();
    file.laser = Some(LaserSection {
        normal: [n.x, n.y, n.z],
        distance_mm: sensor.plane().distance_mm(),
        rms_mm: Some(fit.rms_mm),
        views: Some(fit.views.len()),
    });
    file.range = sensor.range().map(|range| RangeSection {
        u_px: range.u_px,
        v_px: range.v_px,
        lateral_mm: range.lateral_mm,
        height_mm: range.height_mm,
    });
    if let Some(covariance) = sensor.covariance() {
        file.set_covariance(covariance);
    }
}

/// The board as given, as in the camera's file, or as found in the pictures.
pub fn board_of(
    file: &CalibrationFile,
    declared: Option<Board>,
    square_mm: Option<f64>,
    pictures: &Folder,
    folder: &Path,
) -> anyhow::Result<(BoardSize, f64)> {
    let known = file.board();
    let Some(square_mm) = square_mm.or(known.map(|(_, square_mm)| square_mm)) else {
        bail!("the side of the board's squares is not in the file: give --square MM");
    };
    let size = match (declared, known) {
        (Some(Board(Some(size))), _) => size,
        (None, Some((size, _))) => size,
        _ => detect(pictures, None).with_context(|| folder.display().to_string())?.board,
    };
    Ok((size, square_mm))
}

/// Which pictures belong together.
pub fn read_pairs(
    list: Option<&Path>,
    pictures: &Folder,
    folder: &Path,
) -> anyhow::Result<Vec<seamtrack::calib::pairs::Pair>> {
    let names = pictures.names();
    match list {
        None => pair_by_name(&names).map_err(|problem| anyhow!("{}: {problem}", folder.display())),
        Some(path) => {
            let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
            pair_by_list(&text, &names).map_err(|problem| anyhow!("{}: {problem}", path.display()))
        }
    }
}

/// A 4 × 4 matrix: sixteen numbers, with whatever words around them OpenCV writes.
pub fn read_hand_eye(path: &Path) -> anyhow::Result<[[f64; 4]; 4]> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let data = text.split_once("data:").map_or(text.as_str(), |(_, data)| data);
    let words = data.split(|c: char| c.is_whitespace() || ",;[]".contains(c)).filter(|word| !word.is_empty());
    let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
    let sixteen: Option<[f64; 16]> = numbers.and_then(|numbers| numbers.try_into().ok());
    let Some(flat) = sixteen else { bail!("{} does not hold 16 numbers", path.display()) };
    let matrix: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| flat[4 * i + j]));
    check_hand_eye(&matrix).map_err(|problem| anyhow!("{}: {problem}", path.display()))?;
    Ok(matrix)
}

fn print(fit: &LaserFit) {
    let n = fit.sensor.plane().normal();
    outln!(
        "laser plane: normal ({:.5}, {:.5}, {:.5}), distance {:.3} mm; {:.3} mm rms over the stripes of {} poses",
        n.x,
        n.y,
        n.z,
        fit.sensor.plane().distance_mm(),
        fit.rms_mm,
        fit.poses
    );
    outln!("  fitted {}", if fit.jointly { "together with the camera" } else { "under the camera as it was given" });
    if let Some(range) = fit.sensor.range() {
        outln!(
            "  calibrated: lateral {:.0} to {:.0} mm, height {:.0} to {:.0} mm (towards the camera, from the point nearest to it)",
            range.lateral_mm[0],
            range.lateral_mm[1],
            range.height_mm[0],
            range.height_mm[1]
        );
        let lateral_mm = 0.5 * (range.lateral_mm[0] + range.lateral_mm[1]);
        for height_mm in [range.height_mm[0], 0.5 * (range.height_mm[0] + range.height_mm[1]), range.height_mm[1]] {
            let pixel = fit.sensor.pixel(PlanePoint { lateral_mm, height_mm });
            let at = pixel
                .and_then(|pixel| Some((fit.sensor.calibration_covariance_mm2(pixel)?, fit.sensor.jacobian(pixel)?)));
            if let Some((covariance, jacobian)) = at {
                outln!(
                    "  at {height_mm:.0} mm: lateral ± {:.3}, height ± {:.3} mm (1 σ of the calibration); {:.3} mm of height a pixel",
                    covariance[(0, 0)].sqrt(),
                    covariance[(1, 1)].sqrt(),
                    jacobian.row(1).norm()
                );
            }
        }
    }
    for view in &fit.views {
        outln!(
            "  {}: mean {:+.3} mm, {:+.3} mm when left out, scatter {:.2} px{}",
            view.seen.board.name,
            view.mean_mm,
            view.left_out_mm,
            view.seen.stripe.scatter_px,
            if view.flagged { "  CONTRADICTS THE OTHERS" } else { "" }
        );
    }
}
