//! A run read back from its results directory.

use std::path::{Path, PathBuf};

use super::atomic::ResultsError;
use super::results::{Estimator, PathRow, Status, read_path_csv};
use super::summary::{Summary, read_summary};
use super::thumbnails::{Thumbnail, read_thumbnails};
use super::truth::{self, read_truth_along_px};
use crate::calib::Ruler;
use crate::units::{LengthUnit, PixelPoint};

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
        let axis = summary.calibration.stripe;
        let truth_px =
            read_truth_along_px(&dir.join(truth::FILE_NAME), axis, (summary.input.first_frame(), rows.len()))?;
        let name =
            dir.file_name().map_or_else(|| dir.display().to_string(), |name| name.to_string_lossy().into_owned());
        Ok(Self { dir: dir.to_owned(), name, rows, summary, truth_px, thumbnails: Vec::new() })
    }

    /// What measures along the stripe: from where `x_mm` is 0, or, when the summary does not say, from the first value.
    #[must_use]
    pub fn ruler(&self) -> Ruler {
        let calibration = &self.summary.calibration;
        let (sensor, axis) = (calibration.sensor(), calibration.stripe);
        let given = calibration.origin_px.map(|along_px| {
            axis.image_from_stripe(PixelPoint::new(along_px, calibration.origin_across_px.unwrap_or(0.0)))
        });
        let first = || self.rows.iter().find_map(|row| row.point(Estimator::Filtered));
        Ruler { sensor, axis, origin: given.or_else(first).unwrap_or(PixelPoint::new(0.0, 0.0)) }
    }

    /// The unit of lengths.
    #[must_use]
    pub fn unit(&self) -> LengthUnit {
        self.summary.calibration.sensor().unit()
    }

    /// Position of one estimate along the stripe by `ruler`, frame by frame.
    #[must_use]
    pub fn position(&self, estimator: Estimator, ruler: &Ruler) -> Vec<Option<f64>> {
        self.rows.iter().map(|row| ruler.position(row.point(estimator)?)).collect()
    }

    /// The true position by `ruler`, at the height of the seam as it was estimated.
    #[must_use]
    pub fn true_position(&self, ruler: &Ruler) -> Option<Vec<Option<f64>>> {
        let truth_px = self.truth_px.as_ref()?;
        let position = |(row, along_px): (&PathRow, &Option<f64>)| {
            let seen = row.point(Estimator::Smoothed).or(row.point(Estimator::Filtered)).unwrap_or(ruler.origin);
            let place = PixelPoint::new((*along_px)?, ruler.axis.across_px(seen));
            ruler.position(ruler.axis.image_from_stripe(place))
        };
        Some(self.rows.iter().zip(truth_px).map(position).collect())
    }

    /// Estimate − truth, where both are known.
    #[must_use]
    pub fn error(&self, estimator: Estimator) -> Option<Vec<Option<f64>>> {
        Some(self.error_against(estimator, self.truth_px.as_ref()?))
    }

    /// Estimate − truth for a truth along the stripe \[px\], where both are known: in pixels first, so that no origin enters.
    #[must_use]
    pub fn error_against(&self, estimator: Estimator, truth_px: &[Option<f64>]) -> Vec<Option<f64>> {
        let ruler = self.ruler();
        let error = |(row, truth_px): (&PathRow, &Option<f64>)| {
            let point = row.point(estimator)?;
            ruler.error(point, ruler.axis.along_px(point) - (*truth_px)?)
        };
        self.rows.iter().zip(truth_px).map(error).collect()
    }

    /// One σ of an estimate along the stripe, frame by frame.
    #[must_use]
    pub fn sigma(&self, estimator: Estimator) -> Vec<Option<f64>> {
        let unit = self.unit();
        self.rows.iter().map(|row| row.sigma(estimator, unit)).collect()
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
