//! `seamtrack calibrate`: from boards, plates and gauges to millimetres that can be trusted.

mod camera;
mod check;
mod convert;
mod laser;
mod pictures;
mod scale;
mod target;

pub use laser::read_hand_eye;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::anyhow;
use clap::{Args, Subcommand};
use seamtrack::calib::board::pair;
use seamtrack::calib::board_svg::board_svg;

use self::target::Target;

/// Calibrate a camera and its laser plane, or a scale, and test a calibration
///
/// The way: print a board, take 14 or more pictures of it in different tilts and distances, `camera`; then the same
/// with the laser on it, `laser`; then `check`. Where one scale is enough: `scale`.
#[derive(Debug, Args)]
pub struct Calibrate {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Board(Board),
    Camera(camera::Camera),
    Laser(laser::Laser),
    Scale(scale::Scale),
    Check(check::Check),
    Import(convert::Import),
    Export(convert::Export),
}

/// Draw a chessboard to print, with a ruler to check the print by
#[derive(Debug, Args)]
struct Board {
    /// Squares along a row and rows of them; one number odd, one even tells how the board lies
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = pair, default_value = "7x8")]
    squares: [usize; 2],
    /// Side of a square [mm]
    #[arg(long, value_name = "MM")]
    square: f64,
    /// The drawing
    #[arg(short, long, value_name = "FILE.svg")]
    output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
}

impl Calibrate {
    /// Does what the subcommand says.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        match &self.command {
            Command::Board(board) => board.run(),
            Command::Camera(camera) => camera.run(),
            Command::Laser(laser) => laser.run(),
            Command::Scale(scale) => scale.run(),
            Command::Check(check) => check.run(),
            Command::Import(import) => import.run(),
            Command::Export(export) => export.run(),
        }
    }
}

impl Board {
    fn run(&self) -> anyhow::Result<ExitCode> {
        let target = Target::new(&self.output, self.force, [])?;
        let svg = board_svg(self.squares, self.square).map_err(|problem| anyhow!(problem))?;
        target.write_text(&svg, String::new)?;
        let [columns, rows] = self.squares;
        outln!("{target}: {columns} x {rows} squares, {} x {} inner corners", columns - 1, rows - 1);
        outln!("print it at 100 %, check the ruler, glue it to something flat");
        if (columns + rows) % 2 == 0 {
            errln!(
                "a board with one odd and one even number of squares shows which way round it lies; this one does not"
            );
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Prints what was left out to stderr, and what is weak to stdout.
fn print_advice(left_out: &[String], advice: &[String]) {
    for reason in left_out {
        errln!("left out: {reason}");
    }
    for sentence in advice {
        outln!("  to improve: {sentence}");
    }
}

pub fn parse_positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "expected a number above 0".into())
}

pub(super) fn parse_finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "expected a number".into())
}
