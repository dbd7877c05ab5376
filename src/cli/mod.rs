//! The command line, one file a subcommand. Results go to stdout, diagnostics to stderr.

/// Prints a line of a result; where that fails, says so.
macro_rules! outln {
    ($($text:tt)*) => {
        if let Err(error) = $crate::cli::say::print(&(format!($($text)*) + "\n")) {
            $crate::cli::say::tell(&$crate::cli::say::one_line(error.as_ref()));
        }
    };
}

/// Prints a line of diagnostics.
macro_rules! errln {
    ($($text:tt)*) => {
        $crate::cli::say::tell(&format!($($text)*))
    };
}

mod base_frame;
mod batch;
mod calibrate;
mod camera_double;
mod cell;
mod compare;
mod config;
mod decode_video;
mod drawing;
mod eval;
mod filter;
mod live;
mod manifest;
mod meltpool;
mod places;
mod recordings;
mod report;
mod reproduce;
pub mod say;
pub mod signals;
mod synth;
mod track;
mod troubles;
mod truth;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Find the weld seam in laser-stripe frames and estimate its centre in millimetres.
///
/// Exit codes: 0 done · 1 error · 2 usage · 3 done, but the verdict is BAD.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Track(Box<track::Track>),
    Synth(synth::Synth),
    Eval(eval::Eval),
    Report(report::Report),
    Compare(compare::Compare),
    Calibrate(Box<calibrate::Calibrate>),
    Config(config::PrintConfig),
    Filter(Box<filter::Filter>),
    Meltpool(Box<meltpool::Meltpool>),
    Reproduce(reproduce::Reproduce),
    Live(live::Live),
    Cell(cell::Cell),
    CameraDouble(camera_double::CameraDouble),
    #[command(hide = true)]
    DecodeVideo(decode_video::DecodeVideo),
}

impl Cli {
    /// Whether it ends by itself when it is told to: what it does has an end that is worth reaching.
    pub const fn ends_itself(&self) -> bool {
        matches!(self.command, Command::Live(_) | Command::Cell(_) | Command::CameraDouble(_))
    }

    /// Does what the command line asks for.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        if !matches!(self.command, Command::DecodeVideo(_)) {
            decode_video::in_another_process();
        }
        match &self.command {
            Command::Track(track) => track.run(),
            Command::Synth(synth) => synth.run(),
            Command::Eval(eval) => eval.run(),
            Command::Report(report) => report.run(),
            Command::Compare(compare) => compare.run(),
            Command::Calibrate(calibrate) => calibrate.run(),
            Command::Config(config) => config.run(),
            Command::Filter(filter) => filter.run(),
            Command::Meltpool(meltpool) => meltpool.run(),
            Command::Reproduce(reproduce) => reproduce.run(),
            Command::Live(live) => live.run(),
            Command::Cell(cell) => cell.run(),
            Command::CameraDouble(double) => double.run(),
            Command::DecodeVideo(decode) => decode.run(),
        }
    }
}
