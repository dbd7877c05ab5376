//! A run read back from its results directory.

use std::path::{Path, PathBuf};

use super::atomic::ResultsError;
use super::measures::{Measure, read_measures};
use super::results::{Estimator, PathRow, Status, read_path_csv};
use super::summary::{Summary, read_summary};
use super::thumbnails::{Thumbnail, read_thumbnails};
use super::truth::{self, read_truth_along_px};

/// Everything the report shows.
#[derive(Debug, Clone)]
pub struct Run {
    /// The results directory.
    pub dir: PathBuf,
    /// What the run is called beside others: the last part of the directory's name.
    pub name: String,
    /// `path.csv`.
    pub rows: Vec<PathRow>,
    /// `summary.json`.
    pub summary: Summary,
    /// True coordinate along the stripe of each frame \[px\], if the truth was given.
    pub truth_px: Option<Vec<Option<f64>>>,
    /// What was measured of the joint besides its place.
    pub measures: Vec<Measure>,
    /// Stored frames in order.
    pub thumbnails: Vec<Thumbnail>,
}

impl Run {
    /// Read `dir/path.csv`, `dir/summary.json` and, where they exist, `dir/truth.csv` and `dir/thumbnails`.
    ///
    /// # Errors
    /// When a file cannot be read or breaks the contract.
    pub fn read(dir: &Path) -> Result<Self, ResultsError> {
        Ok(Self { thumbnails: read_thumbnails(dir)?, ..Self::read_figures(dir)? })
    }

    /// As [`read`](Self::read), without the stored frames.
    ///
    /// # Errors
    /// When a file cannot be read or breaks the contract.
    pub fn read_figures(dir: &Path) -> Result<Self, ResultsError> {
        let summary = read_summary(&dir.join("summary.json"))?;
        let rows = read_path_csv(&dir.join("path.csv"))?;
        let measures = read_measures(&dir.join("path.csv"))?;
        let axis = summary.calibration.stripe;
        let truth_px =
            read_truth_along_px(&dir.join(truth::FILE_NAME), axis, (summary.input.first_frame(), rows.len()))?;
        let name =
            dir.file_name().map_or_else(|| dir.display().to_string(), |name| name.to_string_lossy().into_owned());
        Ok(Self { dir: dir.to_owned(), name, rows, summary, truth_px, measures, thumbnails: Vec::new() })
    }

    /// Position of one estimate along the stripe from `origin_px`, frame by frame \[mm\].
    #[must_use]
    pub fn position_mm(&self, estimator: Estimator, origin_px: f64) -> Vec<Option<f64>> {
        let (scale, axis) = (self.summary.calibration.mm_per_px.get(), self.summary.calibration.stripe);
        self.rows.iter().map(|row| row.along_px(estimator, axis).map(|px| scale * (px - origin_px))).collect()
    }

    /// The true position from `origin_px` \[mm\].
    #[must_use]
    pub fn true_position_mm(&self, origin_px: f64) -> Option<Vec<Option<f64>>> {
        let scale = self.summary.calibration.mm_per_px.get();
        let truth = self.truth_px.as_ref()?;
        Some(truth.iter().map(|px| px.map(|px| scale * (px - origin_px))).collect())
    }

    /// Estimate − truth \[mm\], where both are known.
    #[must_use]
    pub fn error_mm(&self, estimator: Estimator) -> Option<Vec<Option<f64>>> {
        Some(self.error_against_mm(estimator, self.truth_px.as_ref()?))
    }

    /// Estimate − truth \[mm\] for a truth along the stripe \[px\], where both are known.
    #[must_use]
    pub fn error_against_mm(&self, estimator: Estimator, truth_px: &[Option<f64>]) -> Vec<Option<f64>> {
        let scale = self.summary.calibration.mm_per_px.get();
        let truth_mm: Vec<_> = truth_px.iter().map(|px| px.map(|px| scale * px)).collect();
        difference(&self.position_mm(estimator, 0.0), &truth_mm)
    }

    /// Where `x_mm` is 0 \[px\]; the first value along the stripe when the summary does not say.
    #[must_use]
    pub fn origin_px(&self) -> f64 {
        let axis = self.summary.calibration.stripe;
        let first = || self.rows.iter().find_map(|row| row.along_px(Estimator::Filtered, axis));
        self.summary.calibration.origin_px.or_else(first).unwrap_or(0.0)
    }

    /// Frames without a value ([`PathRow::has_value`]) where there is a seam: of all frames, or of those that the truth has a seam in.
    #[must_use]
    pub fn unavailable(&self) -> Unavailable {
        let found_at = self.rows.iter().position(|row| row.status == Status::Tracked);
        let has_seam =
            |frame: usize| self.truth_px.as_ref().is_none_or(|truth| truth.get(frame).is_some_and(Option::is_some));
        let without = |from: usize| {
            let rows = self.rows.iter().enumerate().skip(from);
            rows.filter(|(frame, row)| !row.has_value() && has_seam(*frame)).count()
        };
        let of = (0..self.rows.len()).filter(|&frame| has_seam(frame)).count();
        Unavailable { found_at, missing: without(found_at.unwrap_or(0)), without_value: without(0), of }
    }
}

/// Availability of the seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unavailable {
    /// First tracked frame.
    pub found_at: Option<usize>,
    /// Frames without a value from there on.
    pub missing: usize,
    /// Frames without a value, those before the seam was found included.
    pub without_value: usize,
    /// Frames with a seam.
    pub of: usize,
}

impl Unavailable {
    /// Frames without a value \[%\].
    #[must_use]
    pub fn percent(self) -> f64 {
        if self.of == 0 { 100.0 } else { 100.0 * self.without_value as f64 / self.of as f64 }
    }
}

/// a − b where both are known.
#[must_use]
pub fn difference(a: &[Option<f64>], b: &[Option<f64>]) -> Vec<Option<f64>> {
    a.iter().zip(b).map(|(a, b)| Some((*a)? - (*b)?)).collect()
}
