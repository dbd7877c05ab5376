//! A recording of a melt pool: frames in, rows of its `path.csv` out.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;

use super::ahead::decode_ahead;
use crate::eval::{self, Estimate};
use crate::frame::{GrayFrame, IntensityFrame};
use crate::kalman::SeriesError;
use crate::meltpool::{
    Followed, Measure, Measured, Meter, Noise, NoiseLevels, Reading, Refusal, SegmentationError, Status, Threshold,
    follow,
};
use crate::report::pool::{PoolErrors, PoolMarks, PoolRow};
use crate::report::results::Status as RowStatus;
use crate::report::summary::{FrameCounts, Percentiles, Timing};
use crate::source::{FrameError, IntensityScale, IntensitySource, NextFrame, SizeCheck, SourceFrame};
use crate::units::{MmPerPx, PixelPoint, Travel};

/// Most points of an outline that are kept for looking at.
const OUTLINE_POINTS: usize = 96;

/// What is measured, and how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PoolSettings {
    /// Tip or width.
    pub measure: Measure,
    /// The direction of travel.
    pub travel: Travel,
    /// A fixed level between pool and surroundings, in the recording's own values; none for Otsu's.
    pub threshold: Option<f64>,
    /// Scale across the travel.
    pub mm_per_px: MmPerPx,
    /// Where a tip's offset is 0 \[px\]; 0 for a width.
    pub zero_px: f64,
    /// Time between frames \[s\].
    pub period_s: f64,
    /// Where the filter's noise levels come from.
    pub noise: Noise,
}

impl PoolSettings {
    /// The value of a pixel coordinate or length \[mm\].
    #[must_use]
    pub fn mm(&self, px: f64) -> f64 {
        self.mm_per_px.get() * (px - self.zero_px)
    }
}

/// One frame of a run, for those who watch it; rows are known when all frames are measured.
pub struct PoolSeen<'a> {
    /// Number of the frame.
    pub frame: usize,
    /// The picture in 8 bits for looking at, or why it could not be read.
    pub picture: Result<&'a dyn Fn() -> GrayFrame, &'a FrameError>,
    /// Whether it was measured.
    pub is_measured: bool,
    /// What was seen.
    pub marks: &'a PoolMarks,
}

/// A run's results.
#[derive(Debug)]
pub struct PoolOutcome {
    /// One row a frame.
    pub rows: Vec<PoolRow>,
    /// What was seen, one a frame.
    pub marks: Vec<PoolMarks>,
    /// Why a frame's value was not taken, one a frame.
    pub refusals: Vec<Option<Refusal>>,
    /// Columns and rows of the frames.
    pub size_px: (usize, usize),
    /// The recording's scale.
    pub scale: IntensityScale,
    /// The filter's noise levels.
    pub noise: NoiseLevels,
    /// Whether they come from the recording.
    pub noise_is_fitted: bool,
    /// Frames by status.
    pub counts: FrameCounts,
    /// How long it took.
    pub timing: Timing,
}

/// A run that cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum PoolRunError {
    /// OpenCV failed.
    #[error(transparent)]
    Segmentation(#[from] SegmentationError),
    /// The filter failed.
    #[error("the series cannot be filtered")]
    Series(#[from] SeriesError),
    /// No frame could be read.
    #[error("none of the {frames} frames could be read; the first: {first}")]
    NothingReadable {
        /// Frames in the recording.
        frames: usize,
        /// What was wrong with the first.
        first: String,
    },
}

/// Measures a recording and filters the series. `watch` is called after each frame, in order.
///
/// Frames are decoded on a second thread; the result does not depend on it.
///
/// # Errors
/// When no frame can be read, OpenCV fails, or time stamps do not rise.
pub fn measure_pool(
    source: &mut dyn IntensitySource,
    settings: &PoolSettings,
    mut watch: impl FnMut(&PoolSeen<'_>),
) -> Result<PoolOutcome, PoolRunError> {
    let scale = source.scale();
    let threshold =
        settings.threshold.map_or(Threshold::Otsu, |value| Threshold::Fixed(f64::from(scale.intensity(value))));
    let mut run = Run {
        meter: Meter::new(settings.measure, settings.travel, threshold),
        sizes: SizeCheck::default(),
        files: vec![],
        readings: vec![],
        marks: vec![],
        decode_ms: vec![],
        measure_ms: vec![],
        first_error: None,
    };
    let started = Instant::now();
    decode_ahead(
        || source.next_frame().map(NextFrame::Decoded),
        |picture: &IntensityFrame| size_of_val(picture.pixels()),
        |frame, decoding| {
            run.decode_ms.push(decoding.as_secs_f64() * 1e3);
            run.step(frame, &mut watch)
        },
    )?;
    run.finish(settings, scale, started)
}

struct Run {
    meter: Meter,
    sizes: SizeCheck,
    files: Vec<String>,
    readings: Vec<Reading>,
    marks: Vec<PoolMarks>,
    decode_ms: Vec<f64>,
    measure_ms: Vec<f64>,
    first_error: Option<String>,
}

impl Run {
    fn step(
        &mut self,
        frame: SourceFrame<IntensityFrame>,
        watch: &mut impl FnMut(&PoolSeen<'_>),
    ) -> Result<(), PoolRunError> {
        let SourceFrame { file, time_s, picture } = self.sizes.admit_intensity(frame);
        let measured = match &picture {
            Err(error) => {
                self.first_error.get_or_insert_with(|| error.to_string());
                Err(Refusal::Unreadable)
            }
            Ok(picture) => {
                let began = Instant::now();
                let measured = self.meter.measure(picture)?;
                self.measure_ms.push(began.elapsed().as_secs_f64() * 1e3);
                measured
            }
        };
        let marks = match &picture {
            Err(_) => PoolMarks::default(),
            Ok(_) => self.marks_of(measured.ok()),
        };
        let to_gray = picture.as_ref().map(|picture| || picture.to_gray());
        watch(&PoolSeen {
            frame: self.readings.len(),
            picture: to_gray.as_ref().map(|to_gray| to_gray as &dyn Fn() -> GrayFrame).map_err(|error| *error),
            is_measured: measured.is_ok(),
            marks: &marks,
        });
        self.files.push(file);
        self.readings.push(Reading { time_s, value_px: measured.map(|measured| measured.value_px) });
        self.marks.push(marks);
        Ok(())
    }

    fn marks_of(&self, measured: Option<Measured>) -> PoolMarks {
        let step = self.meter.outline().count().div_ceil(OUTLINE_POINTS).max(1);
        PoolMarks {
            outline: self.meter.outline().step_by(step).collect(),
            measured: measured.map(|measured| measured.ends),
            filtered: None,
        }
    }

    fn finish(
        mut self,
        settings: &PoolSettings,
        scale: IntensityScale,
        started: Instant,
    ) -> Result<PoolOutcome, PoolRunError> {
        let Some(size_px) = self.sizes.size_px() else {
            let first = self.first_error.unwrap_or_else(|| "the recording is empty".into());
            return Err(PoolRunError::NothingReadable { frames: self.readings.len(), first });
        };
        let values: Vec<Option<f64>> = self.readings.iter().map(|reading| reading.value_px.ok()).collect();
        let fitted = match settings.noise {
            Noise::Fit => NoiseLevels::of_series(settings.measure, &values, settings.period_s),
            Noise::Paper => None,
        };
        let noise = fitted.unwrap_or_else(|| NoiseLevels::of_papers(settings.measure, settings.mm_per_px.get()));
        let path = follow(settings.measure, &self.readings, noise, settings.period_s)?;
        let mut counts = FrameCounts::default();
        let mut rows = Vec::with_capacity(self.files.len());
        for (i, (file, followed)) in self.files.into_iter().zip(&path.frames).enumerate() {
            let row = row(i, file, &self.readings[i], followed, settings);
            count(&mut counts, row.status, followed.refused);
            self.marks[i].filtered = filtered_marks(self.marks[i].measured, &row, settings);
            rows.push(row);
        }
        Ok(PoolOutcome {
            size_px,
            scale,
            noise: path.noise,
            noise_is_fitted: fitted.is_some(),
            refusals: path.frames.iter().map(|followed| followed.refused).collect(),
            timing: Timing {
                decode_ms: Percentiles::of(&self.decode_ms),
                track_ms: Percentiles::of(&self.measure_ms),
                frames_per_second: rows.len() as f64 / started.elapsed().as_secs_f64().max(1e-9),
            },
            counts,
            rows,
            marks: self.marks,
        })
    }
}

fn row(frame: usize, file: String, reading: &Reading, followed: &Followed, settings: &PoolSettings) -> PoolRow {
    let scale = settings.mm_per_px.get();
    let (filtered, smooth) = (followed.filtered, followed.smooth);
    PoolRow {
        frame,
        file,
        time_s: reading.time_s,
        status: match followed.status {
            Status::Seeking => RowStatus::Seeking,
            Status::Tracked => RowStatus::Tracked,
            Status::Coasting => RowStatus::Coasting,
            Status::Lost => RowStatus::Lost,
            Status::Unreadable => RowStatus::Unreadable,
        },
        measured_px: reading.value_px.ok(),
        filtered_px: filtered.map(|(px, _)| px),
        filtered_mm: filtered.map(|(px, _)| settings.mm(px)),
        filtered_std_mm: filtered.map(|(_, std_px)| scale * std_px),
        nis: followed.nis,
        smooth_px: smooth.map(|(px, _)| px),
        smooth_mm: smooth.map(|(px, _)| settings.mm(px)),
        smooth_std_mm: smooth.map(|(_, std_px)| scale * std_px),
    }
}

fn count(counts: &mut FrameCounts, status: RowStatus, refused: Option<Refusal>) {
    counts.total += 1;
    match status {
        RowStatus::Seeking => counts.seeking += 1,
        RowStatus::Tracked => counts.tracked += 1,
        RowStatus::Coasting => counts.coasting += 1,
        RowStatus::Lost => counts.lost += 1,
        RowStatus::Unreadable => counts.unreadable += 1,
    }
    counts.saturated += usize::from(refused == Some(Refusal::Saturated));
}

/// The measured marks moved to the filter's value: the tip across the travel, the ends of the width about its middle.
fn filtered_marks(
    measured: Option<[PixelPoint; 2]>,
    row: &PoolRow,
    settings: &PoolSettings,
) -> Option<[PixelPoint; 2]> {
    let ([a, b], px) = (measured?, row.filtered_px?);
    let across = |point: PixelPoint| settings.travel.across_px(point);
    let moved = |point: PixelPoint, to: f64| {
        if settings.travel.is_along_columns() {
            PixelPoint::new(to, point.v_px)
        } else {
            PixelPoint::new(point.u_px, to)
        }
    };
    Some(match settings.measure {
        Measure::Tip => [moved(a, px); 2],
        Measure::Width => {
            let middle = 0.5 * (across(a) + across(b));
            [moved(a, middle - 0.5 * px), moved(b, middle + 0.5 * px)]
        }
    })
}

impl PoolOutcome {
    /// Frames whose value was not taken, by reason.
    #[must_use]
    pub fn refused(&self) -> BTreeMap<String, usize> {
        let mut counts = BTreeMap::new();
        for refusal in self.refusals.iter().flatten() {
            *counts.entry(refusal.name().to_owned()).or_insert(0) += 1;
        }
        counts
    }

    /// The errors of the three estimates against a truth \[px\], one a frame.
    #[must_use]
    pub fn errors(&self, truth_px: &[Option<f64>], scale: MmPerPx) -> PoolErrors {
        type Column<'a> = &'a dyn Fn(&PoolRow) -> Option<(f64, Option<f64>)>;
        let of = |value: Column<'_>| {
            let estimates: Vec<Option<Estimate>> = self
                .rows
                .iter()
                .map(|row| value(row).map(|(position_px, std_px)| Estimate { position_px, std_px }))
                .collect();
            eval::errors(&estimates, truth_px, scale)
        };
        let px = |std_mm: Option<f64>| std_mm.map(|std_mm| std_mm / scale.get());
        PoolErrors {
            measured: of(&|row| Some((row.measured_px?, None))),
            filtered: of(&|row| Some((row.filtered_px?, px(row.filtered_std_mm)))),
            smoothed: of(&|row| Some((row.smooth_px?, px(row.smooth_std_mm)))),
        }
    }
}
