//! `seamtrack report DIR`: rebuild the page and the exports from a results directory.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use seamtrack::output::listing;
use seamtrack::report::export::{Exports, trajectory_names, write_exports};
use seamtrack::report::pool::{is_pool_summary, write_pool_report};
use seamtrack::report::run::Run;
use seamtrack::report::terminal::{Colour, terminal_summary};

use super::say::{print, shown, tell};

/// Name of the page beside the results.
const PAGE: &str = "report.html";

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
        let page = self.dir.join(PAGE);
        // A page of ours is known by its title, also in results of an earlier version, which have no listing.
        let is_ours = |page: &Path| std::fs::read_to_string(page).is_ok_and(|text| text.contains("seamtrack</title>"));
        if page.symlink_metadata().is_ok() && !is_ours(&page) {
            bail!("{} is no page of this program: move it away", shown(&page));
        }
        let mut written = vec![PAGE.to_owned()];
        let mut text = String::new();
        if is_pool_summary(&self.dir) {
            write_pool_report(&self.dir)?;
        } else {
            if self.tum {
                written.extend(trajectory_names().map(|name| format!("{name}.tum")));
            }
            for name in &written[1..] {
                let file = self.dir.join(name);
                if file.symlink_metadata().is_ok() && !listing::proves(&self.dir, name) {
                    bail!("{} is not of an earlier run, or was changed since: move it away", shown(&file));
                }
            }
            let run = Run::read(&self.dir)?;
            write_exports(&run, Exports { max_page_bytes: self.max_page_mb as usize * 1_000_000, tum: self.tum })?;
            text = terminal_summary(&run, Colour::for_stdout());
        }
        for name in written.iter().filter(|name| self.dir.join(name).is_file()) {
            listing::add(&self.dir, name).with_context(|| format!("cannot write {}", self.dir.display()))?;
        }
        tell(&format!("wrote {}", page.display()));
        print(&text)?;
        Ok(ExitCode::SUCCESS)
    }
}
