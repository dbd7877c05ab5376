//! `seamtrack live`: camera in, corrections out.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use seamtrack::live::{LiveConfig, run};

use super::{say, signals};

/// Follow a seam live: camera in, corrections for a robot out
///
/// Ends when the recording is over, or on Ctrl-C; what it recorded stays whole.
#[derive(Debug, Args)]
pub struct Live {
    /// What camera, sensor, robot and limits are: docs/live.md
    #[arg(long, value_name = "live.toml")]
    config: PathBuf,
    /// The camera instead of the configuration's: gige:ADDRESS, usb3:NAME, file:PATH, scene:NAME or tcp:HOST:PORT
    #[arg(long, value_name = "CAMERA")]
    camera: Option<String>,
    /// Where the run is recorded instead: a new MCAP file
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
    /// Say nothing on the way
    #[arg(long)]
    quiet: bool,
}

impl Live {
    /// Runs until the end or a signal, and prints what the run was.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let mut config = LiveConfig::read(&self.config)?;
        config.camera = self.camera.clone().unwrap_or(config.camera);
        config.record = self.record.clone().or(config.record);
        let ends = signals::asked_to_end()?;
        let report = run(&config, &ends, |line| {
            if !self.quiet {
                say::tell(line);
            }
        })?;
        say::print(&report.to_string())?;
        Ok(ExitCode::SUCCESS)
    }
}
