//! Several recordings: one after another or side by side, an index of all at the end. What was finished stays: the same
//! command, given again, goes on where it was ended.

use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use rayon::prelude::*;
use seamtrack::output::unfinished::{self, Removal};
use seamtrack::output::{OutputError, WholeFile};
use seamtrack::report::batch::{self, Entry, Figures};
use seamtrack::report::run::Run;
use seamtrack::report::verdict::Trust;

use super::say;
use super::signals::wait_if_ending;
use super::track::{Job, exit_code};

/// Recordings tracked at a time for each processor: more only take memory from one another. Chosen.
const THREADS_PER_PROCESSOR: usize = 4;

/// The file that is held in a batch's folder while the batch runs.
const HELD: &str = "batch";

/// How a batch is run.
pub struct Batch<'a> {
    /// Where the folders of the results lie, and the index.
    pub folder: &'a Path,
    pub jobs_at_a_time: u16,
    pub quiet: bool,
}

/// Tracks what is not done yet, tells each verdict in a line, and writes the index. The exit code is 1 when a recording has no
/// results, else 3 when one of them is bad.
pub fn run(
    settings: &Batch<'_>,
    jobs: &[Job],
    track: impl Fn(&Job) -> anyhow::Result<Run> + Sync,
) -> anyhow::Result<ExitCode> {
    batch::check(settings.folder)?;
    let _held = hold(settings.folder)?;
    // More threads than recordings or processors have nothing to do.
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = usize::from(settings.jobs_at_a_time).min(jobs.len()).min(THREADS_PER_PROCESSOR * processors);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let one = |job: &Job| {
        let done = if job.is_done { Run::read_figures(&job.output).map_err(Into::into) } else { track(job) };
        // Of a hundred runs the figures stay, not the pictures.
        done.map(|run| {
            let figures = Figures::of(&run);
            let kept = if job.is_done { " (as it was)" } else { "" };
            let line = format!("{}: {}{kept}\n", say::shown(&job.name), say::plain(&figures.line()));
            (figures, if settings.quiet { Ok(()) } else { say::print(&line) })
        })
    };
    let results: Vec<_> = pool.install(|| jobs.par_iter().map(one).collect());
    wait_if_ending();
    let (mut failed, mut any_bad, mut printed) = (0, false, Ok(()));
    let mut entries = vec![];
    for (job, result) in jobs.iter().zip(results) {
        let outcome = match result {
            Ok((figures, print)) => {
                any_bad |= figures.trust == Trust::Bad;
                printed = printed.and(print);
                Ok(figures)
            }
            Err(error) => {
                failed += 1;
                let reason = say::one_line(error.as_ref());
                say::tell(&format!("{}: {reason}", job.input.display()));
                Err(reason)
            }
        };
        entries.push(Entry {
            name: job.name.to_string_lossy().into(),
            input: job.input.to_string_lossy().into(),
            outcome,
        });
    }
    batch::write_batch(settings.folder, entries)?;
    if !settings.quiet {
        let page = say::shown(&settings.folder.join(batch::PAGE));
        let tracked = jobs.len() - failed;
        printed = printed.and(say::print(&format!("{tracked} of {} recordings have results: {page}\n", jobs.len())));
    }
    printed.context("the results are written, but")?;
    Ok(if failed > 0 { ExitCode::from(1) } else { exit_code(any_bad) })
}

/// Keeps a second batch out of the folder, whose index would be of its own refusals.
fn hold(folder: &Path) -> anyhow::Result<WholeFile> {
    if !folder.exists() {
        unfinished::note(folder, Removal::IfEmpty);
    }
    let held = std::fs::create_dir_all(folder).and_then(|()| WholeFile::begin(&folder.join(HELD)));
    held.map_err(|error| match error.kind() {
        std::io::ErrorKind::ResourceBusy => OutputError::Busy(folder.to_owned()).into(),
        _ => anyhow::Error::new(error).context(format!("cannot write {}", folder.display())),
    })
}
