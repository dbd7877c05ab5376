//! A recording through the tracker: frames in, rows of `path.csv` out.

mod ahead;
#[cfg(feature = "cli")]
pub mod meltpool;
mod rows;
mod score;
mod second_pass;
mod settings;
mod summarise;

use std::time::Instant;

pub use rows::{marks, row};
pub use score::{NoCommonFrame, error_table, plane_errors};
pub use settings::{expect_calibrated_size, session_settings};
pub use summarise::summarise;

use self::ahead::decode_ahead;
use self::rows::fill_smoothed;
use crate::calib::laser_camera::OtherImageSize;
use crate::calib::{KnownSensor, Origin, Ruler};
use crate::config::{Config, ConfigError};
use crate::frame::GrayFrame;
use crate::report::marks::FrameMarks;
use crate::report::results::{PathRow, Status as RowStatus};
use crate::report::summary::{FrameCounts, Percentiles, Timing};
use crate::report::trace::TraceRow;
use crate::source::{FrameError, FrameSource, SixteenBitScale, SizeCheck, SourceError, SourceFrame};
use crate::tracker::{
    Estimate, Evidence, JointDecision, Observation, SeamEstimate, SeamPath, Session, SessionSettings, TrackerError,
};
use crate::units::{PixelPoint, PixelRect, StripeAxis};

/// One frame of a run, for those who watch it.
pub struct Seen<'a> {
    /// Its row; the smoothed columns come at the end of the run.
    pub row: &'a PathRow,
    /// The picture, or why it could not be read.
    pub picture: Result<&'a GrayFrame, &'a FrameError>,
    /// The tracker's estimate, if there was a picture.
    pub estimate: Option<&'a Estimate>,
    /// What overlays show.
    pub marks: &'a FrameMarks,
}

impl Seen<'_> {
    /// What was measured in it, and what speaks for it.
    #[must_use]
    pub fn trace(&self) -> TraceRow {
        let evidence = self.estimate.map_or(Evidence::NONE, |estimate| estimate.evidence);
        TraceRow {
            frame: self.row.frame,
            observation: self.estimate.map_or("unreadable", |estimate| estimate.observation.name()),
            nis: self.row.nis,
            measured_px: evidence.along_px,
            support: evidence.support,
            residual_px: evidence.residual_px,
            cost: evidence.cost,
            margin: evidence.margin,
            presence: evidence.presence,
            psr_ratio: self.estimate.and_then(|estimate| estimate.kcf).map(|kcf| kcf.psr_ratio),
        }
    }
}

/// A run's results.
#[derive(Debug)]
pub struct RunOutcome {
    /// One row a frame.
    pub rows: Vec<PathRow>,
    /// What overlays show, one a frame.
    pub marks: Vec<FrameMarks>,
    /// Columns and rows of the frames.
    pub size_px: (usize, usize),
    /// Which way the stripe runs, if one was seen.
    pub axis: Option<StripeAxis>,
    /// What measures along the stripe; none when nothing was tracked and the origin is the first tracked frame.
    pub ruler: Option<Ruler>,
    /// Frames by status.
    pub counts: FrameCounts,
    /// How long it took.
    pub timing: Timing,
    /// How 16-bit grey was brought to 8 bits.
    pub sixteen_bit_scale: Option<SixteenBitScale>,
    /// First frame with a seam.
    pub confirmed_at: Option<usize>,
    /// The joints that were found, in their order.
    pub joints: Vec<JointDecision>,
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
    /// The recording cannot be opened a second time.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The user's seed is not in the frames.
    #[error("the seed {}, {} lies outside the frames of {} x {} pixels: give a point of the image", seed.u_px, seed.v_px, size_px.0, size_px.1)]
    SeedOutside {
        /// The seed.
        seed: PixelPoint,
        /// Columns and rows of the frames.
        size_px: (usize, usize),
    },
    /// The user's seed is not in the part that is looked at.
    #[error("the seed {}, {} lies outside the part to look at, {} x {} pixels from ({}, {}): give a point of it",
        seed.u_px, seed.v_px, roi.width_px, roi.height_px, roi.u_px, roi.v_px)]
    SeedOutsideRoi {
        /// The seed.
        seed: PixelPoint,
        /// The part of the picture.
        roi: PixelRect,
    },
    /// The calibration is of pictures of another size.
    #[error(
        "{source_name} is of pictures of {} x {} pixels, the recording's have {} x {}: calibrate at the recording's size, or say by --crop-at UxV where its pictures were cut out",
        sizes.calibrated_px.0, sizes.calibrated_px.1, sizes.got_px.0, sizes.got_px.1
    )]
    OtherImageSize {
        /// The calibration.
        source_name: String,
        /// The two sizes.
        sizes: OtherImageSize,
    },
    /// The calibration is of a stripe that runs the other way.
    #[error("{source_name} is of a {calibrated} stripe, but --stripe says {given}: leave --stripe out")]
    OtherStripe {
        /// The calibration.
        source_name: String,
        /// How its stripe runs.
        calibrated: StripeAxis,
        /// How it is said to run.
        given: StripeAxis,
    },
    /// No frame could be read.
    #[error("none of the {frames} frames could be read; the first: {first}")]
    NothingReadable {
        /// Frames in the recording.
        frames: usize,
        /// What was wrong with the first.
        first: String,
    },
}

/// Tracks the seam through `source`, measured by a sensor. `watch` is called after each frame, in order. Where the smoother may
/// look at the whole recording, frames that are left without a value are gone through once more, backwards.
///
/// Frames are decoded on other threads; the result does not depend on it.
///
/// # Errors
/// When the configuration is wrong, no frame can be read, the calibration is of other pictures, or the tracker fails.
pub fn track(
    source: &mut dyn FrameSource,
    (config, known): (&Config, &KnownSensor),
    origin: Origin,
    mut watch: impl FnMut(&Seen<'_>),
) -> Result<RunOutcome, RunError> {
    let mut run = Run::new(config, known, origin)?;
    let sixteen_bit_scale = source.sixteen_bit_scale();
    let started = Instant::now();
    decode_ahead(
        || source.next_encoded(),
        |picture: &GrayFrame| picture.pixels().len(),
        |frame, decoding| {
            run.decode_ms.push(decoding.as_secs_f64() * 1e3);
            run.step(frame, &mut watch)
        },
    )?;
    let mut outcome = run.finish(started.elapsed().as_secs_f64(), source)?;
    outcome.sixteen_bit_scale = sixteen_bit_scale;
    Ok(outcome)
}

/// A run under way.
struct Run<'a> {
    config: &'a Config,
    known: &'a KnownSensor,
    origin: Origin,
    settings: SessionSettings,
    session: Session,
    path: SeamPath,
    /// The path a few frames behind, where that is asked for.
    lagged: Vec<Option<SeamEstimate>>,
    joints: Vec<JointDecision>,
    sizes: SizeCheck,
    ruler: Option<Ruler>,
    rows: Vec<PathRow>,
    marks: Vec<FrameMarks>,
    counts: FrameCounts,
    decode_ms: Vec<f64>,
    track_ms: Vec<f64>,
    first_error: Option<String>,
}

impl<'a> Run<'a> {
    fn new(config: &'a Config, known: &'a KnownSensor, origin: Origin) -> Result<Self, RunError> {
        let settings = session_settings(config, known)?;
        Ok(Self {
            config,
            known,
            origin,
            session: Session::new(&settings)?,
            settings,
            path: SeamPath::default(),
            lagged: vec![],
            joints: vec![],
            sizes: SizeCheck::default(),
            ruler: None,
            rows: vec![],
            marks: vec![],
            counts: FrameCounts::default(),
            decode_ms: vec![],
            track_ms: vec![],
            first_error: None,
        })
    }

    fn step(&mut self, frame: SourceFrame, watch: &mut impl FnMut(&Seen<'_>)) -> Result<(), RunError> {
        let SourceFrame { file, time_s, picture } = self.sizes.admit(frame);
        self.check_seed()?;
        self.check_size()?;
        let estimate = match &picture {
            Err(error) => {
                self.first_error.get_or_insert_with(|| error.to_string());
                let estimate = self.session.miss(time_s)?;
                self.path.push(&estimate);
                None
            }
            Ok(picture) => {
                let began = Instant::now();
                let estimate = self.session.step(picture, time_s)?;
                self.track_ms.push(began.elapsed().as_secs_f64() * 1e3);
                self.path.push(&estimate);
                let frame = self.rows.len();
                self.take_joint(frame);
                Some(estimate)
            }
        };
        self.lagged.extend(self.session.due());
        self.lay_ruler(estimate.as_ref());
        let started_s = self.rows.first().map_or(time_s, |first| first.time_s);
        let travel_mm = self.config.speed_mm_s.map(|speed| speed * (time_s - started_s));
        let row = row(self.rows.len(), file, time_s, estimate.as_ref(), self.ruler.as_ref());
        let row = PathRow { travel_mm, ..row };
        let marks = rows::marks(estimate.as_ref());
        self.count(row.status, estimate.as_ref(), picture.as_ref().ok());
        watch(&Seen { row: &row, picture: picture.as_ref(), estimate: estimate.as_ref(), marks: &marks });
        self.rows.push(row);
        self.marks.push(marks);
        Ok(())
    }

    /// Writes down a joint that was found in this frame, or what is known of it now.
    fn take_joint(&mut self, frame: usize) {
        match (self.session.joint(), self.joints.last_mut()) {
            (Some(joint), _) if joint.frame == frame => self.joints.push(joint.clone()),
            (Some(joint), Some(last)) if joint.frame == last.frame => last.clone_from(joint),
            _ => {}
        }
    }

    /// Refuses a seed outside the frames, whose size the first readable one tells, or outside the part that is looked at.
    fn check_seed(&self) -> Result<(), RunError> {
        let (Some(seed), Some(size_px)) = (self.config.seed_at(), self.sizes.size_px()) else { return Ok(()) };
        if seed.u_px >= size_px.0 as f64 || seed.v_px >= size_px.1 as f64 {
            return Err(RunError::SeedOutside { seed, size_px });
        }
        match self.config.roi() {
            Some(roi) if !roi.holds(seed) => Err(RunError::SeedOutsideRoi { seed, roi }),
            _ => Ok(()),
        }
    }

    /// Refuses a calibration of pictures of another size.
    fn check_size(&self) -> Result<(), RunError> {
        self.sizes.size_px().map_or(Ok(()), |size_px| expect_calibrated_size(self.known, size_px))
    }

    /// Sets the origin once it is known.
    fn lay_ruler(&mut self, estimate: Option<&Estimate>) {
        let (Some(axis), Some(size_px)) = (self.session.axis(), self.sizes.size_px()) else { return };
        if self.ruler.as_ref().is_some_and(|ruler| ruler.axis == axis) {
            return;
        }
        let middle = PixelPoint::new((size_px.0 as f64 - 1.0) / 2.0, (size_px.1 as f64 - 1.0) / 2.0);
        let origin = match self.origin {
            Origin::First => estimate.and_then(|e| e.seam).map(|seam| seam.centre),
            Origin::Centre => Some(middle),
            Origin::At(px) => Some(axis.image_from_stripe(PixelPoint::new(px, axis.across_px(middle)))),
        };
        self.ruler = origin.map(|origin| Ruler { sensor: self.known.sensor.clone(), axis, origin });
    }

    fn count(&mut self, status: RowStatus, estimate: Option<&Estimate>, picture: Option<&GrayFrame>) {
        let counts = &mut self.counts;
        counts.total += 1;
        match status {
            RowStatus::Seeking => counts.seeking += 1,
            RowStatus::Tracked => counts.tracked += 1,
            RowStatus::Coasting => counts.coasting += 1,
            RowStatus::Lost => counts.lost += 1,
            RowStatus::Unreadable => counts.unreadable += 1,
        }
        let is = |what| estimate.is_some_and(|estimate| estimate.observation == what);
        counts.frozen += usize::from(is(Observation::Frozen));
        counts.bad_stamps += usize::from(is(Observation::BadStamp));
        counts.repeated += usize::from(estimate.is_some_and(|e| e.repeated));
        counts.saturated += usize::from(picture.is_some_and(is_saturated));
    }

    fn finish(mut self, elapsed_s: f64, source: &dyn FrameSource) -> Result<RunOutcome, RunError> {
        let Some(size_px) = self.sizes.size_px() else {
            let first = self.first_error.unwrap_or_else(|| "the recording is empty".into());
            return Err(RunError::NothingReadable { frames: self.rows.len(), first });
        };
        let axis = self.session.axis();
        if let Some(ruler) = &self.ruler {
            let smoothed = if self.config.fixed_lag.is_some() {
                self.lagged.into_iter().chain(self.session.rest()).collect()
            } else {
                let mut smoothed = self.path.smoothed()?;
                let settings = SessionSettings { axis: Some(ruler.axis), seed_at: None, ..self.settings };
                second_pass::fill(&mut smoothed, &settings, size_px, source)?;
                smoothed
            };
            fill_smoothed(&mut self.rows, &smoothed, ruler);
        }
        Ok(RunOutcome {
            size_px,
            axis,
            ruler: self.ruler,
            confirmed_at: self.rows.iter().position(|row| row.u_px.is_some()),
            timing: Timing {
                decode_ms: Percentiles::of(&self.decode_ms),
                track_ms: Percentiles::of(&self.track_ms),
                frames_per_second: self.rows.len() as f64 / elapsed_s.max(1e-9),
            },
            counts: self.counts,
            rows: self.rows,
            marks: self.marks,
            sixteen_bit_scale: None,
            joints: self.joints,
        })
    }
}

/// Over a twentieth of the frame at full scale: more than any stripe covers.
fn is_saturated(picture: &GrayFrame) -> bool {
    // Counted in bytes side by side.
    let full_of = |few: &[u8]| usize::from(few.iter().map(|&grey| u8::from(grey == 255)).sum::<u8>());
    let full: usize = picture.pixels().chunks(255).map(full_of).sum();
    20 * full > picture.pixels().len()
}
