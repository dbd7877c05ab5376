//! Frames in, estimates out, one at a time.

use super::clock::{Clock, Tick};
use super::estimate::{Estimate, JointDecision, KcfReading, Observation, SeamEstimate, Status};
use super::lag::{Lag, Links};
use super::orientation::Orientation;
use super::path::Memory;
use super::picture::Picture;
use super::previous::Previous;
use super::{Method, PaperTracker, RobustTracker, TrackerError, find_axis};
use crate::calib::Sensor;
use crate::frame::GrayFrame;
use crate::units::{PixelPoint, PixelRect, StripeAxis};

/// For how long the same picture may come again before the camera must have stopped \[beats\]: recorders repeat pictures,
/// since they are faster than their camera; those of real robots do so once, twice, not six times. Chosen.
pub const FROZEN_AFTER_BEATS: f64 = 5.0;

/// What a session needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionSettings {
    /// Which method follows the seam.
    pub method: Method,
    /// How the stripe runs; found from the frames when it is not given.
    pub axis: Option<StripeAxis>,
    /// Where the seam is in the first frame that shows a stripe, in the picture; found when it is not given.
    pub seed_at: Option<PixelPoint>,
    /// What a pixel is.
    pub sensor: Sensor,
    /// The part of the picture that is looked at; all of it when none is given.
    pub roi: Option<PixelRect>,
    /// Frames that [`Session::due`] waits for; none are when it is not given.
    pub lag: Option<usize>,
}

impl SessionSettings {
    /// By `method`, with all else found from the frames.
    #[must_use]
    pub const fn new(method: Method) -> Self {
        Self { method, axis: None, seed_at: None, sensor: Sensor::Pixels, roi: None, lag: None }
    }
}

/// A method at work on frames of which the stripe is horizontal. Its estimates are in the picture.
pub trait Follow: Send {
    /// The user knows where the seam is in the next frame, given with the stripe along the rows.
    fn seed_at(&mut self, centre: PixelPoint);
    /// One frame further.
    fn step(&mut self, picture: Picture<'_>, tick: Tick) -> Result<Estimate, TrackerError>;
    /// Time passes and nothing can be seen, for the reason `why`: the filter predicts.
    fn miss(&mut self, tick: Tick, why: Observation) -> Result<Estimate, TrackerError>;
    /// Whether a picture that came before is to be looked at again.
    fn looks_at_repeats(&self) -> bool;
    /// Whether a picture of `beats` ago still tells where the seam is.
    fn outlasts(&self, beats: f64) -> bool;
    /// A picture that came before passes without being looked at.
    fn pass_over(&mut self);
    /// The stripe runs the other way than was thought: what was seen in frames before means nothing. No joint was found in them.
    fn start_anew(&mut self);
    /// What a smoother needs of this step, if a seam is followed and the method has one.
    fn links(&self) -> Option<Links>;
    /// The joint found last.
    fn joint(&self) -> Option<&JointDecision>;
}

/// Finds the seam and follows it from frame to frame. A step does no input or output, and what a session remembers does
/// not grow with the recording.
pub struct Session {
    follow: Box<dyn Follow>,
    orientation: Orientation,
    /// The direction for which the method was begun.
    seeking_along: Option<StripeAxis>,
    seed_at: Option<PixelPoint>,
    roi: Option<PixelRect>,
    lag: Option<Lag>,
    clock: Clock,
    previous: Previous,
    last: Estimate,
    /// The previous picture is not the last frame's: something was missed since.
    is_stale: bool,
    /// Time since the picture last changed, and that part of it the filter does not know yet \[beats\].
    repeated_beats: f64,
    held_beats: f64,
    /// Longest that a picture with the seam was repeated before another one came \[beats\]: so the recorder is made.
    usual_beats: f64,
}

impl Session {
    /// A session that has seen no frame.
    ///
    /// # Errors
    /// When a setting is out of range.
    pub fn new(settings: &SessionSettings) -> Result<Self, TrackerError> {
        let follow: Box<dyn Follow> = match &settings.method {
            Method::Paper(paper) => Box::new(PaperTracker::new(paper)?),
            Method::Robust(robust) => Box::new(RobustTracker::new(robust, settings.sensor.clone())?),
        };
        Ok(Self {
            follow,
            orientation: Orientation::told(settings.axis),
            seeking_along: None,
            seed_at: settings.seed_at,
            roi: settings.roi,
            lag: settings.lag.map(Lag::new),
            clock: Clock::default(),
            previous: Previous::default(),
            last: Estimate::seeking(Observation::NoStripe),
            is_stale: false,
            repeated_beats: 0.0,
            held_beats: 0.0,
            usual_beats: 0.0,
        })
    }

    /// How the stripe runs; none before a stripe was seen.
    #[must_use]
    pub const fn axis(&self) -> Option<StripeAxis> {
        self.orientation.axis()
    }

    /// The joint found last, if any. One that was lost is found again, and a recording may hold several.
    #[must_use]
    pub fn joint(&self) -> Option<&JointDecision> {
        self.follow.joint()
    }

    /// The seam in the frame that is now as many frames ago as the session waits for, given those that came since; none in it
    /// when the seam was not followed there. None before so many frames came.
    #[must_use]
    pub fn due(&self) -> Option<Option<SeamEstimate>> {
        self.lag.as_ref()?.due()
    }

    /// The seam in the frames that are still waited for, the oldest first: for the end of a recording.
    pub fn rest(&self) -> impl Iterator<Item = Option<SeamEstimate>> {
        self.lag.iter().flat_map(Lag::rest)
    }

    fn wait(&mut self, is_same_moment: bool) {
        let Some(lag) = &mut self.lag else { return };
        let links = if is_same_moment { lag.last().map(Links::repeated) } else { self.follow.links() };
        lag.push(links);
    }

    /// Takes the next frame, stamped `stamp_s` \[s\]. All points of the estimate are image coordinates.
    ///
    /// A stamp that is no number, or not later than the one before, makes the frame a miss: when it was taken is not known
    /// ([`Observation::BadStamp`]).
    ///
    /// # Errors
    /// When the frame's size differs from the first one's, or a covariance breaks down, which does not depend on what the
    /// frame shows.
    pub fn step(&mut self, frame: &GrayFrame, stamp_s: f64) -> Result<Estimate, TrackerError> {
        if let (Some(first), now) = (self.previous.size_px(), size_px(frame))
            && first != now
        {
            return Err(TrackerError::FrameSize { first, now });
        }
        let tick = self.clock.tick(stamp_s);
        let is_repeated = self.previous.is(frame);
        if !is_repeated && self.last.status == Status::Tracked {
            self.usual_beats = self.usual_beats.max(self.repeated_beats.min(FROZEN_AFTER_BEATS));
        }
        self.repeated_beats = if is_repeated { self.repeated_beats + tick.beats } else { 0.0 };
        let is_frozen = is_repeated && (self.is_stale || !self.may_be_repeat());
        let estimate = if is_frozen {
            let beats = tick.beats + std::mem::take(&mut self.held_beats);
            self.follow.miss(Tick { beats, ..tick }, Observation::Frozen)?
        } else if !tick.stamp_is_good {
            self.is_stale = true;
            self.follow.miss(tick, Observation::BadStamp)?
        } else if is_repeated && !self.follow.looks_at_repeats() {
            self.held_beats += tick.beats;
            self.follow.pass_over();
            self.repeat()
        } else {
            self.held_beats = 0.0;
            self.is_stale = false;
            self.look(frame, tick)?
        };
        self.wait(estimate.memory.beats <= 0.0);
        let estimate = Self::within_picture(estimate, size_px(frame));
        if !is_repeated {
            self.previous.keep(frame, estimate.seam.map(|seam| seam.centre));
        }
        self.last = Estimate { repeated: is_repeated, ..estimate };
        Ok(self.last)
    }

    /// Says that the frame stamped `stamp_s` could not be read: the filter predicts through it.
    ///
    /// # Errors
    /// When the model cannot be built for the time step.
    pub fn miss(&mut self, stamp_s: f64) -> Result<Estimate, TrackerError> {
        let tick = self.clock.tick(stamp_s);
        self.is_stale = true;
        let estimate = self.follow.miss(tick, Observation::Unreadable)?;
        self.last = match self.previous.size_px() {
            Some(size_px) => Self::within_picture(estimate, size_px),
            None => estimate,
        };
        self.wait(false);
        Ok(self.last)
    }

    /// A seam that is predicted beside the picture is lost: the camera is being led away, and nothing tells when that ends.
    fn within_picture(estimate: Estimate, (width, height): (usize, usize)) -> Estimate {
        let (Status::Coasting, Some(seam)) = (estimate.status, estimate.seam) else { return estimate };
        let (width, height) = (width as f64, height as f64);
        let is_inside = (0.0..width).contains(&seam.centre.u_px) && (0.0..height).contains(&seam.centre.v_px);
        if is_inside { estimate } else { Estimate { status: Status::Lost, seam: None, ..estimate } }
    }

    fn look(&mut self, frame: &GrayFrame, tick: Tick) -> Result<Estimate, TrackerError> {
        let picture = |axis| {
            let picture = size_px(frame);
            let roi = self.roi.unwrap_or(PixelRect::whole(picture));
            Picture::new(frame, axis, Some(roi)).ok_or(TrackerError::Roi { roi, picture })
        };
        if self.orientation.is_due(self.follow.joint().is_some()) {
            self.orientation.see(find_axis(&picture(StripeAxis::Horizontal)?.whole()));
        }
        let Some(axis) = self.orientation.axis() else { return self.follow.miss(tick, Observation::NoStripe) };
        let picture = picture(axis)?;
        if self.seeking_along != Some(axis) {
            if self.seeking_along.replace(axis).is_some() {
                self.follow.start_anew();
            }
            if let Some(centre) = self.seed_at {
                self.follow.seed_at(picture.field().field_from_picture(centre));
            }
        }
        self.follow.step(picture, tick)
    }

    /// Whether the same picture once more may be the recorder's doing: then it stands for the same moment. Not when it has
    /// come for too long, and sooner than the recorder is known for not when it shows no seam, or the seam has moved on.
    fn may_be_repeat(&self) -> bool {
        if self.repeated_beats > FROZEN_AFTER_BEATS {
            return false;
        }
        match self.last.status {
            _ if self.follow.looks_at_repeats() || self.repeated_beats <= self.usual_beats => true,
            Status::Tracked => self.follow.outlasts(self.repeated_beats),
            Status::Coasting => false,
            Status::Seeking | Status::Lost => true,
        }
    }

    /// The picture is that of the frame before: so is the estimate, and no time has passed for the seam.
    fn repeat(&self) -> Estimate {
        let kcf = self.last.kcf.map(|kcf| KcfReading { template_updated: false, ..kcf });
        Estimate { kcf, memory: Memory { beats: 0.0, ..self.last.memory }, ..self.last }
    }
}

/// Columns and rows.
const fn size_px(frame: &GrayFrame) -> (usize, usize) {
    (frame.width_px(), frame.height_px())
}

/// The status of a seam that was followed when time passed unseen.
pub const fn unseen(is_lost: bool) -> Status {
    if is_lost { Status::Lost } else { Status::Coasting }
}

#[cfg(test)]
mod tests;
