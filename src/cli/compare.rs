//! `seamtrack compare A B …`: several runs on one recording, or several batches, in one page and one table.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::ensure;
use seamtrack::output::Reads;
use seamtrack::report::compare::{
    availability_lines, check_same_recording, comparison_rows, lend_truth, mixed_scales, tell_apart,
};
use seamtrack::report::page::{DEFAULT_MAX_BYTES, write_comparison};
use seamtrack::report::run::Run;
use seamtrack::report::terminal::text_table;
use seamtrack::report::{batch, matrix};

use super::say;

/// Compare several runs on one recording, or several batches on the same recordings, in one page and one table
#[derive(Debug, clap::Args)]
pub struct Compare {
    /// Results directories of the runs, of which the first one gives scale and stored frames and the first with a truth the
    /// truth; or folders of batches, one a method
    #[arg(required = true, num_args = 2.., value_name = "DIR")]
    dirs: Vec<PathBuf>,
    /// The page to write
    #[arg(short, long, value_name = "FILE", default_value = "comparison.html")]
    output: PathBuf,
    /// Overwrite the page
    #[arg(long)]
    force: bool,
}

impl Compare {
    /// Run the subcommand.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let mut reads = Reads::default();
        self.dirs.iter().for_each(|dir| reads.add(dir));
        reads.refuse(&self.output, "-o")?;
        let page = say::shown(&self.output);
        ensure!(!self.output.is_dir(), "{page} is a folder: name a file for the page with -o");
        let exists = self.output.symlink_metadata().is_ok();
        ensure!(self.force || !exists, "{page} exists; --force overwrites it, -o names another file");
        let batches = self.dirs.iter().filter(|dir| matrix::is_batch(dir)).count();
        if batches > 0 {
            ensure!(
                batches == self.dirs.len(),
                "batches and single runs do not compare: name folders with a {}",
                batch::TABLE
            );
            let matrix = matrix::read_matrix(&self.dirs)?;
            matrix.write_page(&self.output)?;
            return self.tell(&matrix.text());
        }
        let mut runs = self.dirs.iter().map(|dir| Run::read(dir)).collect::<Result<Vec<_>, _>>()?;
        check_same_recording(&runs)?;
        tell_apart(&mut runs);
        lend_truth(&mut runs);
        mixed_scales(&runs).iter().for_each(|doubt| say::tell(doubt));
        let rows = comparison_rows(&runs);
        write_comparison(&self.output, &runs, &rows, DEFAULT_MAX_BYTES)?;
        let text = match rows.as_slice() {
            [] => availability_lines(&runs).join("\n") + "\n",
            rows => text_table(rows, runs[0].unit()),
        };
        self.tell(&text)
    }

    fn tell(&self, text: &str) -> anyhow::Result<ExitCode> {
        say::tell(&format!("wrote {}", self.output.display()));
        say::print(&text.lines().map(|line| say::plain(line) + "\n").collect::<String>())?;
        Ok(ExitCode::SUCCESS)
    }
}
