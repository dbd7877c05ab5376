//! The truth a run is judged by: read once, kept beside the results.

use std::path::{Path, PathBuf};

use anyhow::bail;
use seamtrack::eval::{TruthFileError, TruthRow, parse_truth};
use seamtrack::report::atomic::write_atomically;
use seamtrack::report::pool::{PoolErrors, parse_true_values};
use seamtrack::report::results::PathRow;
use seamtrack::report::summary::ErrorTable;
use seamtrack::run::meltpool::{PoolOutcome, PoolSettings};
use seamtrack::units::MmPerPx;

use super::say::tell;

/// A truth file.
pub struct Truth {
    /// Its rows.
    pub rows: Vec<TruthRow>,
    /// The file as it was when the run began.
    copy: TruthCopy,
}

/// The truth of a melt pool.
pub struct PoolTruth {
    file: PathBuf,
    /// The value of each frame that has a line \[px\].
    values_px: Vec<(usize, Option<f64>)>,
    copy: TruthCopy,
}

/// The bytes of a truth file, whatever its columns.
struct TruthCopy(Vec<u8>);

impl Truth {
    /// Reads the file.
    pub fn read(file: &Path) -> anyhow::Result<Self> {
        let copy = TruthCopy::read(file)?;
        Ok(Self { rows: parse_truth(&copy.0[..], file)?, copy })
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

    /// Says when the recording shows no seam, and what is to be thought of values then.
    pub fn tell_if_seamless(&self, file: &Path, errors: &Option<ErrorTable>, rows: &[PathRow]) {
        if errors.is_none() {
            let (file, values) = (file.display(), rows.iter().filter(|row| row.has_value()).count());
            tell(&format!(
                "{file} has no seam in any frame: there are no errors, and {values} values of what is no seam"
            ));
        }
    }
}

impl PoolTruth {
    /// Reads the file: the tip's coordinate across the travel, or the width.
    pub fn read(file: &Path, settings: &PoolSettings) -> anyhow::Result<Self> {
        let copy = TruthCopy::read(file)?;
        let values_px = parse_true_values(&copy.0, file, settings.measure, settings.travel)?;
        Ok(Self { file: file.to_owned(), values_px, copy })
    }

    /// The errors of a run against it.
    pub fn errors(&self, outcome: &PoolOutcome, mm_per_px: MmPerPx) -> anyhow::Result<PoolErrors> {
        let mut truth_px = vec![None; outcome.rows.len()];
        for (frame, value_px) in &self.values_px {
            if let Some(place) = truth_px.get_mut(*frame) {
                *place = *value_px;
            }
        }
        if truth_px.iter().all(Option::is_none) {
            bail!("{} has no frame of this recording", self.file.display());
        }
        Ok(outcome.errors(&truth_px, mm_per_px))
    }

    /// Writes the copy into the folder of the results.
    pub fn keep_copy(&self, folder: &Path) -> anyhow::Result<()> {
        self.copy.keep(folder)
    }
}

impl TruthCopy {
    fn read(file: &Path) -> anyhow::Result<Self> {
        let unreadable = |error| TruthFileError::Read { file: file.display().to_string(), source: error };
        Ok(Self(std::fs::read(file).map_err(csv::Error::from).map_err(unreadable)?))
    }

    fn keep(&self, folder: &Path) -> anyhow::Result<()> {
        let target = folder.join(seamtrack::report::truth::FILE_NAME);
        Ok(write_atomically(&target, |file| std::io::Write::write_all(file, &self.0))?)
    }
}
