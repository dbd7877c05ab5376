//! `seamtrack cell`: a robot cell that is not there.

use std::net::SocketAddr;
use std::process::ExitCode;

use clap::Args;
use seamtrack::live::{CellLink, CellScene, CellSettings, Trouble, run_cell};

use super::calibrate::parse_positive;
use super::{say, signals, track};

/// Simulate a robot cell: a camera and a robot along a known seam, to try `seamtrack live` on
///
/// Waits for somebody who fetches pictures, welds once, and prints where the torch was. Exit code 3: corrections stopped.
#[derive(Debug, Args)]
pub struct Cell {
    /// sine, corner, tack or arc
    #[arg(long, default_value = "sine")]
    scene: CellScene,
    /// What the robot speaks: rsi (KUKA) or egm (ABB)
    #[arg(long, default_value = "rsi")]
    link: CellLink,
    /// Speed of the torch [mm/s]
    #[arg(long, value_name = "MM_PER_S", default_value_t = 30.0, value_parser = parse_positive)]
    speed: f64,
    /// Length of the weld [mm]
    #[arg(long, value_name = "MM", default_value_t = 600.0, value_parser = parse_positive)]
    length: f64,
    /// The robot's cycle [ms]: RSI has 4 or 12, EGM's path correction multiples of 24 [default: 4, or 24 with EGM]
    #[arg(long, value_name = "MS", value_parser = parse_positive)]
    cycle: Option<f64>,
    /// How much later than its answer a correction is executed [ms]
    #[arg(long, value_name = "MS", default_value_t = 12.0, value_parser = parse_positive)]
    delay: f64,
    /// Pictures a second
    #[arg(long, value_name = "FPS", default_value_t = 60.0, value_parser = parse_positive)]
    fps: f64,
    /// Share of the pictures that are lost [%]
    #[arg(long, value_name = "PCT", default_value_t = 0.0, value_parser = track::parse_percentage)]
    lose: f64,
    /// What goes wrong, where [mm] and how long [s]: stall@200:0.5, dead@…, frozen@… (camera), cut@… (the robot's network)
    #[arg(long, value_name = "WHAT@MM:S")]
    trouble: Vec<Trouble>,
    /// How often a stop is reset and the weld gone on with
    #[arg(long, value_name = "N", default_value_t = 0)]
    resets: u32,
    /// Seed of the scene and of what is lost
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where pictures can be fetched
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:49151")]
    camera: SocketAddr,
    /// Where corrections are asked for
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:49152")]
    corrections: SocketAddr,
}

impl Cell {
    /// Welds once and prints the report.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let cycle_ms = self.cycle.unwrap_or(match self.link {
            CellLink::Rsi => 4.0,
            CellLink::Egm => 24.0,
        });
        let settings = CellSettings {
            scene: self.scene,
            link: self.link,
            speed_mm_s: self.speed,
            length_mm: self.length,
            cycle_s: cycle_ms * 1e-3,
            delay_s: self.delay * 1e-3,
            frames_per_s: self.fps,
            lost_share: self.lose * 1e-2,
            seed: self.seed,
            troubles: self.trouble.clone(),
            resets: self.resets,
            camera: self.camera,
            corrections: self.corrections,
            ..CellSettings::default()
        };
        let ends = signals::asked_to_end()?;
        let report = run_cell(&settings, &ends)?;
        say::print(&report.to_string())?;
        Ok(track::exit_code(!report.stops.is_empty()))
    }
}
