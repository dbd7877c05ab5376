//! `seamtrack report DIR`: rebuild the page and the exports from a results directory.

use std::path::PathBuf;
use std::process::ExitCode;

use seamtrack::report::export::{Exports, write_exports};
use seamtrack::report::pool::{is_pool_summary, write_pool_report};
use seamtrack::report::run::Run;
use seamtrack::report::terminal::{Colour, terminal_summary};

/// Rebuild report.html from path.csv, summary.json and the stored frames, and print the summary
#[derive(Debug, clap::Args)]
pub struct Report {
    /// Results directory of a run
    dir: PathBuf,
    /// Largest size of the page in megabytes; frames are thinned out to fit
    #[arg(long, value_name = "MB", default_value_t = 10)]
    max_page_mb: u32,
    /// Also write the paths as TUM trajectories in metres (filtered.tum, smoothed.tum, kcf.tum, truth.tum)
    #[arg(long)]
    tum: bool,
}

impl Report {
    /// Run the subcommand.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        if is_pool_summary(&self.dir) {
            write_pool_report(&self.dir)?;
            eprintln!("wrote {}", self.dir.join("report.html").display());
            return Ok(ExitCode::SUCCESS);
        }
        let run = Run::read(&self.dir)?;
        write_exports(&run, Exports { max_page_bytes: self.max_page_mb as usize * 1_000_000, tum: self.tum })?;
        print!("{}", terminal_summary(&run, Colour::for_stdout()));
        eprintln!("wrote {}", self.dir.join("report.html").display());
        Ok(ExitCode::SUCCESS)
    }
}
