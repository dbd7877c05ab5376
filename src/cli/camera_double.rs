//! `seamtrack camera-double`: a GigE Vision camera that is not there.

use std::net::Ipv4Addr;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use seamtrack::live::{DoubleSettings, Fault, run_double};

use super::calibrate::parse_positive;
use super::{say, signals, track};

/// Show a recording or a made-up scene as a GigE Vision camera, to try a client or a network on
///
/// Listens at the protocol's own port, 3956. Ends on Ctrl-C, or after --for, and prints what was sent.
#[derive(Debug, Args)]
pub struct CameraDouble {
    /// What to show, again and again: file:PATH or scene:NAME
    #[arg(long, value_name = "WHAT", default_value = "scene:butt-clean")]
    show: String,
    /// An address of this machine
    #[arg(long, value_name = "IP", default_value = "127.0.0.1")]
    address: Ipv4Addr,
    /// Pictures a second, until a client sets them otherwise
    #[arg(long, value_name = "FPS", default_value_t = 60.0, value_parser = parse_positive)]
    fps: f64,
    /// Share of the packets that are lost [%]
    #[arg(long, value_name = "PCT", default_value_t = 0.0, value_parser = track::parse_percentage)]
    lose: f64,
    /// What goes wrong, when and how long after the first picture [s]: stall@2:0.5, dead@5:2
    #[arg(long, value_name = "WHAT@S:S")]
    trouble: Vec<Fault>,
    /// Seed of what is lost
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// End after so long [s]
    #[arg(long = "for", value_name = "S", value_parser = parse_positive)]
    for_s: Option<f64>,
}

impl CameraDouble {
    /// Shows until it is told to end, and prints the report.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let settings = DoubleSettings {
            shows: self.show.clone(),
            address: self.address,
            frames_per_s: self.fps,
            lost_share: self.lose * 1e-2,
            seed: self.seed,
            faults: self.trouble.clone(),
        };
        let ends = signals::asked_to_end()?;
        if let Some(for_s) = self.for_s {
            let (ends, wait) = (std::sync::Arc::clone(&ends), Duration::try_from_secs_f64(for_s)?);
            std::thread::spawn(move || {
                std::thread::sleep(wait);
                ends.store(true, std::sync::atomic::Ordering::Relaxed);
            });
        }
        let report = run_double(&settings, &ends)?;
        say::print(&report.to_string())?;
        Ok(ExitCode::SUCCESS)
    }
}
