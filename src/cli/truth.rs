//! The truth a run is judged by: read once, kept beside the results.

use std::path::Path;

use anyhow::Context;
use seamtrack::eval::{TruthFileError, TruthRow, parse_truth};
use seamtrack::report::atomic::write_atomically;

use super::say::tell;

/// A truth file.
pub struct Truth {
    /// Its rows.
    pub rows: Vec<TruthRow>,
    /// The file as it was when the run began.
    copy: TruthCopy,
}

/// The bytes of a truth file, whatever its columns.
pub struct TruthCopy(Vec<u8>);

impl Truth {
    /// Reads the file.
    pub fn read(file: &Path) -> anyhow::Result<Self> {
        let unreadable = |error| TruthFileError::Read { file: file.display().to_string(), source: error };
        let content = std::fs::read(file).map_err(csv::Error::from).map_err(unreadable)?;
        Ok(Self { rows: parse_truth(&content[..], file)?, copy: TruthCopy(content) })
    }

    /// Writes the copy into the folder of the results.
    pub fn keep_copy(&self, folder: &Path) -> anyhow::Result<()> {
        self.copy.keep(folder)
    }

    /// Says when frames of the recording do not stand in the truth: errors are of the others only.
    pub fn tell_if_short(&self, file: &Path, first: usize, frames: usize) {
        let known = self.rows.iter().filter(|row| (first..first + frames).contains(&row.frame)).count();
        if (1..frames).contains(&known) {
            let file = file.display();
            tell(&format!("{file} has lines for {known} of the {frames} frames: the errors are those of these frames"));
        }
    }
}

impl TruthCopy {
    /// Reads the file.
    pub fn read(file: &Path) -> anyhow::Result<Self> {
        Ok(Self(std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?))
    }

    /// Writes the copy into the folder of the results.
    pub fn keep(&self, folder: &Path) -> anyhow::Result<()> {
        let target = folder.join(seamtrack::report::truth::FILE_NAME);
        Ok(write_atomically(&target, |file| std::io::Write::write_all(file, &self.0))?)
    }
}
