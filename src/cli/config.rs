//! `seamtrack config`: the configuration with its defaults.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use seamtrack::config::{Config, Preset};
use seamtrack::units::MmPerPx;

/// Print the effective configuration as TOML, to start a file from
#[derive(Debug, Args)]
pub struct PrintConfig {
    /// Print it (there is nothing else to do with it yet)
    #[arg(long, required = true)]
    print: bool,
    /// Read this file first
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Set the preset
    #[arg(long)]
    preset: Option<Preset>,
}

impl PrintConfig {
    /// Prints the configuration.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let mut config = self.config.as_deref().map_or_else(|| Ok(Config::default()), Config::read)?;
        config.preset = self.preset.unwrap_or(config.preset);
        config.method()?;
        if config.preset == Preset::Paper {
            // What belongs to the preset is stated.
            config.mm_per_px = config.mm_per_px.or(Some(MmPerPx::DU_2022));
        }
        super::say::print(&toml::to_string(&config)?)?;
        Ok(ExitCode::SUCCESS)
    }
}
