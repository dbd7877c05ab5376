//! A recording through the tracker: frames in, rows of `path.csv` out.

mod summarise;

pub use summarise::summarise;

use std::sync::mpsc::sync_channel;
use std::time::Instant;

use crate::calib::{Origin, ScaleCalibration};
use crate::config::{Config, ConfigError};
use crate::frame::GrayFrame;
use crate::report::results::{PathRow, Status as RowStatus};
use crate::report::summary::{FrameCounts, Percentiles, Timing};
use crate::source::{FrameError, FrameSource, SixteenBitScale, SizeCheck};
use crate::tracker::{Estimate, Status, Tracker, TrackerError};
use crate::units::{PixelPoint, StripeAxis};

/// Frames that are decoded ahead of the tracker.
const DECODED_AHEAD: usize = 8;

/// What the tracker saw in one frame, for those who watch a run.
pub struct Seen<'a> {
    /// Number of the frame, from 0.
    pub number: usize,
    /// Name of its file.
    pub file: &'a str,
    /// The picture, or why it could not be read.
    pub picture: Result<&'a GrayFrame, &'a FrameError>,
    /// The tracker's estimate, if there was a picture.
    pub estimate: Option<&'a Estimate>,
}

/// A run's results.
#[derive(Debug)]
pub struct RunOutcome {
    /// One row a frame.
    pub rows: Vec<PathRow>,
    /// Columns and rows of the frames.
    pub size_px: (usize, usize),
    /// Which way the stripe runs, if one was seen.
    pub axis: Option<StripeAxis>,
    /// Millimetres; none when nothing was tracked and the origin is the first tracked frame.
    pub calibration: Option<ScaleCalibration>,
    /// Frames by status.
    pub counts: FrameCounts,
    /// How long it took.
    pub timing: Timing,
    /// How 16-bit grey was brought to 8 bits.
    pub sixteen_bit_scale: Option<SixteenBitScale>,
    /// First frame with a seam.
    pub confirmed_at: Option<usize>,
}

impl RunOutcome {
    /// Frames without a value: lost, unreadable, or seeking after the seam was first confirmed; all of them when it
    /// never was.
    #[must_use]
    pub fn unavailable_frames(&self) -> usize {
        let valueless = |row: &&PathRow| !matches!(row.status, RowStatus::Tracked | RowStatus::Coasting);
        self.rows[self.confirmed_at.unwrap_or(0)..].iter().filter(valueless).count()
    }
}

/// A run that cannot begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The configuration is wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The tracker failed.
    #[error(transparent)]
    Tracker(#[from] TrackerError),
    /// No frame could be read.
    #[error("none of the {frames} frames could be read; the first: {first}")]
    NothingReadable {
        /// Frames in the recording.
        frames: usize,
        /// What was wrong with the first.
        first: String,
    },
}

/// Tracks the seam through `source`. `watch` is called after each frame, in order.
///
/// Frames are decoded on a second thread; the result does not depend on it.
///
/// # Errors
/// When the configuration is wrong, no frame can be read, or the tracker fails.
pub fn track(
    mut source: Box<dyn FrameSource>,
    config: &Config,
    origin: Origin,
    mut watch: impl FnMut(&Seen<'_>),
) -> Result<RunOutcome, RunError> {
    let mut run = Run::new(Tracker::new(&config.method()?, config.stripe.axis(), config.seed_at())?);
    run.sixteen_bit_scale = source.sixteen_bit_scale();
    let started = Instant::now();
    std::thread::scope(|scope| -> Result<(), RunError> {
        let (send, receive) = sync_channel(DECODED_AHEAD);
        scope.spawn(move || {
            loop {
                let began = Instant::now();
                let Some(frame) = source.next_frame() else { break };
                if send.send((frame, began.elapsed())).is_err() {
                    break;
                }
            }
        });
        for (frame, decoding) in receive {
            run.decode_ms.push(decoding.as_secs_f64() * 1e3);
            let frame = run.sizes.admit(frame);
            let number = run.records.len();
            let estimate = run.step(frame.time_s, frame.picture.as_ref().ok())?;
            watch(&Seen { number, file: &frame.file, picture: frame.picture.as_ref(), estimate: estimate.as_ref() });
            if let (Err(error), None) = (&frame.picture, &run.first_error) {
                run.first_error = Some(error.to_string());
            }
            run.records.push(Record { file: frame.file, time_s: frame.time_s, estimate });
        }
        Ok(())
    })?;
    run.finish(config, origin, started.elapsed().as_secs_f64())
}

/// What is kept of a frame until the run's end; without an estimate where it could not be read.
struct Record {
    file: String,
    time_s: f64,
    estimate: Option<Estimate>,
}

/// A run under way.
struct Run {
    tracker: Tracker,
    sizes: SizeCheck,
    records: Vec<Record>,
    counts: FrameCounts,
    decode_ms: Vec<f64>,
    track_ms: Vec<f64>,
    first_error: Option<String>,
    sixteen_bit_scale: Option<SixteenBitScale>,
}

impl Run {
    fn new(tracker: Tracker) -> Self {
        Self {
            tracker,
            sizes: SizeCheck::default(),
            records: vec![],
            counts: FrameCounts::default(),
            decode_ms: vec![],
            track_ms: vec![],
            first_error: None,
            sixteen_bit_scale: None,
        }
    }

    fn step(&mut self, time_s: f64, picture: Option<&GrayFrame>) -> Result<Option<Estimate>, RunError> {
        self.counts.total += 1;
        let Some(picture) = picture else {
            self.tracker.miss(time_s)?;
            self.counts.unreadable += 1;
            return Ok(None);
        };
        let began = Instant::now();
        let estimate = self.tracker.step(picture, time_s)?;
        self.track_ms.push(began.elapsed().as_secs_f64() * 1e3);
        match estimate.status {
            Status::Seeking => self.counts.seeking += 1,
            Status::Tracked => self.counts.tracked += 1,
            Status::Coasting => self.counts.coasting += 1,
            Status::Lost => self.counts.lost += 1,
        }
        self.counts.repeated += usize::from(estimate.repeated);
        self.counts.saturated += usize::from(is_saturated(picture));
        Ok(Some(estimate))
    }

    fn finish(self, config: &Config, origin: Origin, elapsed_s: f64) -> Result<RunOutcome, RunError> {
        let Some(size_px) = self.sizes.size_px() else {
            let first = self.first_error.unwrap_or_else(|| "the recording is empty".into());
            return Err(RunError::NothingReadable { frames: self.records.len(), first });
        };
        let axis = self.tracker.axis();
        let along = axis.unwrap_or(StripeAxis::Horizontal);
        let seam = |record: &Record| record.estimate.and_then(|estimate| estimate.seam);
        let confirmed_at = self.records.iter().position(|record| seam(record).is_some());
        let length_px = match along {
            StripeAxis::Horizontal => size_px.0,
            StripeAxis::Vertical => size_px.1,
        };
        let origin_px = match origin {
            Origin::First => {
                confirmed_at.and_then(|frame| seam(&self.records[frame])).map(|s| along.along_px(s.centre))
            }
            Origin::Centre => Some((length_px as f64 - 1.0) / 2.0),
            Origin::At(px) => Some(px),
        };
        let calibration = origin_px.map(|origin_px| ScaleCalibration { mm_per_px: config.mm_per_px, origin_px });
        let frames_per_second = self.records.len() as f64 / elapsed_s.max(1e-9);
        let rows = self.records.into_iter().enumerate();
        let mut rows: Vec<PathRow> = rows.map(|(number, record)| row(number, record, along, calibration)).collect();
        if let Some(calibration) = calibration {
            fill_smoothed(&mut rows, &self.tracker.smoothed()?, along, calibration);
        }
        Ok(RunOutcome {
            size_px,
            axis,
            calibration,
            timing: Timing {
                decode_ms: Percentiles::of(&self.decode_ms),
                track_ms: Percentiles::of(&self.track_ms),
                frames_per_second,
            },
            counts: self.counts,
            rows,
            sixteen_bit_scale: self.sixteen_bit_scale,
            confirmed_at,
        })
    }
}

fn row(number: usize, record: Record, along: StripeAxis, calibration: Option<ScaleCalibration>) -> PathRow {
    let Record { file, time_s, estimate: Some(estimate) } = record else {
        return PathRow::empty(number, record.file, record.time_s, RowStatus::Unreadable);
    };
    let status = match estimate.status {
        Status::Seeking => RowStatus::Seeking,
        Status::Tracked => RowStatus::Tracked,
        Status::Coasting => RowStatus::Coasting,
        Status::Lost => RowStatus::Lost,
    };
    let (kcf, seam) = (estimate.kcf, estimate.seam);
    PathRow {
        kcf_u_px: kcf.map(|k| k.peak.u_px),
        kcf_v_px: kcf.map(|k| k.peak.v_px),
        psr: kcf.map(|k| k.psr),
        template_updated: kcf.is_some_and(|k| k.template_updated),
        u_px: seam.map(|s| s.centre.u_px),
        v_px: seam.map(|s| s.centre.v_px),
        x_mm: seam.zip(calibration).map(|(s, c)| c.mm_from_px(along.along_px(s.centre))),
        x_std_mm: seam.zip(calibration).map(|(s, c)| s.std_px * c.mm_per_px.get()),
        nis: estimate.nis,
        ..PathRow::empty(number, file, time_s, status)
    }
}

/// Writes the smoothed path into the rows. Across the stripe nothing is smoothed: the last row seen stands there.
fn fill_smoothed(
    rows: &mut [PathRow],
    smoothed: &[Option<(f64, f64)>],
    along: StripeAxis,
    calibration: ScaleCalibration,
) {
    let mut across_px = None;
    for (row, state) in rows.iter_mut().zip(smoothed) {
        let seen = row.point(crate::report::results::Estimator::Filtered);
        across_px = seen.map(|point| along.image_from_stripe(point).v_px).or(across_px);
        if let (Some((along_px, variance_px2)), Some(across_px)) = (*state, across_px) {
            let point = along.image_from_stripe(PixelPoint::new(along_px, across_px));
            (row.smooth_u_px, row.smooth_v_px) = (Some(point.u_px), Some(point.v_px));
            row.smooth_x_mm = Some(calibration.mm_from_px(along_px));
            row.smooth_x_std_mm = Some(variance_px2.sqrt() * calibration.mm_per_px.get());
        }
    }
}

/// Over a twentieth of the frame at full scale: more than any stripe covers.
fn is_saturated(picture: &GrayFrame) -> bool {
    let full = picture.pixels().iter().filter(|&&grey| grey == 255).count();
    20 * full > picture.pixels().len()
}
