//! Where the jobs of a command read and write, looked through before the first one begins.

use std::path::{Path, PathBuf};

use seamtrack::output::{Claims, Existing, Reads, WholeFolder, listing};
use seamtrack::report::truth::FILE_NAME;

use super::drawing;

/// The places of one job.
pub struct Places<'a> {
    /// The recording.
    pub input: &'a Path,
    /// Its truth.
    pub truth: Option<&'a Path>,
    /// The folder of its results.
    pub output: &'a Path,
    /// Where it is drawn.
    pub overlay: Option<&'a Path>,
    /// Where its log is written.
    pub mcap: Option<&'a Path>,
    /// The results are there already and stay.
    pub is_done: bool,
}

/// Refuses every place where something would be lost: one that is read by any job or, as `settings`, by all of them; one
/// that two jobs would share; one that holds what is not to be replaced.
pub fn check(jobs: &[Places<'_>], settings: &[&PathBuf], existing: Existing) -> anyhow::Result<()> {
    let mut reads = Reads::default();
    settings.iter().for_each(|file| reads.add(file));
    for job in jobs {
        reads.add(job.input);
        job.truth.filter(|truth| !is_copy_in(truth, job.output)).into_iter().for_each(|truth| reads.add(truth));
    }
    let mut claims = Claims::default();
    for job in jobs {
        let name = job.input.display().to_string();
        reads.refuse(job.output, "-o")?;
        claims.claim(job.output, &name)?;
        if !job.is_done {
            WholeFolder::check(job.output, existing)?;
        }
        if let Some(overlay) = job.overlay {
            reads.refuse(overlay, "--overlay")?;
            claims.claim(overlay, &name)?;
            if !job.is_done {
                drawing::check(overlay, job.output, existing)?;
            }
        }
        if let Some(mcap) = job.mcap {
            reads.refuse(mcap, "--mcap")?;
            claims.claim(mcap, &name)?;
            if !job.is_done {
                drawing::check_log(mcap, job.output, existing)?;
            }
        }
    }
    Ok(claims.check_apart()?)
}

/// Whether a truth is the copy that an earlier run left in the folder of the results: the next run may replace it.
fn is_copy_in(truth: &Path, results: &Path) -> bool {
    let (Ok(truth), Ok(results)) = (truth.canonicalize(), results.canonicalize()) else { return false };
    truth == results.join(FILE_NAME) && listing::proves(&results, FILE_NAME)
}
