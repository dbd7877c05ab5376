//! The seam tracker: seed → locate → estimate. The only place where `imgproc`, `kcf` and `kalman` meet.
//!
//! A step is a pure call without I/O: [`Tracker::step`] takes a frame and its time stamp and gives an [`Estimate`].

mod estimate;
mod grid;
mod grid_smooth;
mod hairline;
mod orientation;
mod paper;
mod robust;

pub use estimate::{
    CrossSection, Estimate, Evidence, JointDecision, KcfReading, Observation, SeamEstimate, Side, Status,
};
pub use grid::{GridEstimate, GridFilter, LocalObservation};
pub use grid_smooth::{EvidenceRow, smooth};
pub use hairline::{HairlineEstimate, HairlineTracker, SeamPresence};
pub use orientation::find_axis;
pub use paper::{PaperSettings, PaperTracker};
pub use robust::{Part, Parts, REFUSE_NIS, RobustSettings, RobustTracker};

use crate::frame::GrayFrame;
use crate::imgproc::{MedianError, SeamRoi};
use crate::kalman::{InnovationNotPositive, InvalidParameter, SeriesError};
use crate::kcf::KcfError;
use crate::units::{PixelPoint, StripeAxis};

/// Which method follows the seam.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// The pipeline of Du 2022.
    Paper(PaperSettings),
    /// Stripe geometry, KCF and interacting models.
    Robust(RobustSettings),
}

/// A tracker that cannot be built, or a step that failed.
#[derive(Debug, thiserror::Error)]
pub enum TrackerError {
    /// A KCF setting is out of range.
    #[error(transparent)]
    Kcf(#[from] KcfError),
    /// A noise parameter of the filter is out of range.
    #[error(transparent)]
    Kalman(#[from] InvalidParameter),
    /// The filter's covariance broke down.
    #[error(transparent)]
    Innovation(#[from] InnovationNotPositive),
    /// The smoother cannot run through the recording.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// OpenCV failed.
    #[error(transparent)]
    Median(#[from] MedianError),
}

/// A method at work on frames of which the stripe is horizontal.
trait Follow: Send {
    /// The user knows where the seam is in the next frame.
    fn seed_at(&mut self, centre: PixelPoint);
    /// One frame further; `repeated` when it equals its predecessor.
    fn step(&mut self, frame: &GrayFrame, time_s: f64, repeated: bool) -> Result<Estimate, TrackerError>;
    /// A frame that could not be read: the filter predicts through it.
    fn miss(&mut self, time_s: f64) -> Result<(), TrackerError>;
    /// Position along the stripe and its variance \[px, px²\] in each frame so far, given all of them.
    fn smoothed(&self) -> Result<Vec<Option<(f64, f64)>>, TrackerError>;
    /// The joints found, in their order.
    fn joints(&self) -> &[JointDecision];
}

/// Finds the seam and follows it from frame to frame.
pub struct Tracker {
    follow: Box<dyn Follow>,
    axis: Option<StripeAxis>,
    previous: Option<GrayFrame>,
    seed_at: Option<PixelPoint>,
}

impl Tracker {
    /// A tracker by `method`; `axis` is found from the frames when it is not given, the seam when
    /// `seed_at` (image coordinates in the first frame that shows a stripe) is not.
    ///
    /// # Errors
    /// When a setting is out of range.
    pub fn new(method: &Method, axis: Option<StripeAxis>, seed_at: Option<PixelPoint>) -> Result<Self, TrackerError> {
        let follow: Box<dyn Follow> = match method {
            Method::Paper(settings) => Box::new(PaperTracker::new(settings)?),
            Method::Robust(settings) => Box::new(RobustTracker::new(settings)?),
        };
        Ok(Self { follow, axis, previous: None, seed_at })
    }

    /// Which way the stripe runs; none before a stripe was seen.
    #[must_use]
    pub const fn axis(&self) -> Option<StripeAxis> {
        self.axis
    }

    /// Takes the next frame, recorded at `time_s`, later than the one before. All points of the estimate are image
    /// coordinates.
    ///
    /// # Errors
    /// When OpenCV fails or a covariance breaks down; neither depends on what the frame shows.
    pub fn step(&mut self, frame: &GrayFrame, time_s: f64) -> Result<Estimate, TrackerError> {
        let repeated = self.previous.as_ref() == Some(frame);
        if self.axis.is_none() {
            self.axis = find_axis(frame);
        }
        if let Some(axis) = self.axis
            && let Some(centre) = self.seed_at.take()
        {
            self.follow.seed_at(axis.image_from_stripe(centre));
        }
        let estimate = match self.axis {
            None => {
                // The method must know of the frame: what it says at the end is told frame by frame.
                self.follow.miss(time_s)?;
                Estimate::seeking(Observation::NoStripe)
            }
            Some(StripeAxis::Horizontal) => self.follow.step(frame, time_s, repeated)?,
            Some(StripeAxis::Vertical) => self.follow.step(&frame.transposed(), time_s, repeated)?.transposed(),
        };
        self.previous = Some(frame.clone());
        Ok(Estimate { repeated, ..estimate })
    }

    /// Says that the frame of `time_s` could not be read: the filter predicts through it.
    ///
    /// # Errors
    /// When the model cannot be built for the time step.
    pub fn miss(&mut self, time_s: f64) -> Result<(), TrackerError> {
        self.follow.miss(time_s)
    }

    /// The joints found so far, in their order: a recording may hold several, and one that was lost is found again.
    #[must_use]
    pub fn joints(&self) -> &[JointDecision] {
        self.follow.joints()
    }

    /// Position along the stripe and its variance \[px, px²\] in each frame so far, given all of them; nothing by a
    /// method without a smoother.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn smoothed(&self) -> Result<Vec<Option<(f64, f64)>>, TrackerError> {
        self.follow.smoothed()
    }
}

/// The ROI that overlays show round an estimate.
#[must_use]
pub fn roi(estimate: &Estimate) -> Option<SeamRoi> {
    estimate.seam.map(|seam| SeamRoi::du_2022(seam.centre))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imgproc::geometry::JointKind;
    use crate::synth::{Scene, builtin};

    #[test]
    fn frames_before_the_first_stripe_do_not_shift_the_smoothed_path() {
        const DARK: usize = 5;
        let mut scenario = builtin::scenario("butt-clean").unwrap();
        scenario.frames = 20;
        let scene = Scene::new(&scenario, 1).unwrap();
        let method = Method::Robust(RobustSettings { joint: Some(JointKind::Butt), ..RobustSettings::default() });
        let mut tracker = Tracker::new(&method, None, None).unwrap();
        let first = scene.render(0);
        let dark = GrayFrame::filled(first.width_px(), first.height_px(), 7).unwrap();
        for i in 0..DARK {
            assert_eq!(tracker.step(&dark, 0.2 * i as f64).unwrap().status, Status::Seeking);
        }
        for i in 0..scene.frame_count() {
            tracker.step(&scene.render(i), 0.2 * (DARK + i) as f64).unwrap();
        }
        let smoothed = tracker.smoothed().unwrap();
        assert_eq!(smoothed.len(), DARK + scene.frame_count());
        assert_eq!(tracker.joints()[0].frame, DARK);
        for (i, state) in smoothed[DARK..].iter().enumerate() {
            let truth_px = scene.truth(i).seam.unwrap().u_px;
            let (u_px, _) = state.unwrap();
            assert!((u_px - truth_px).abs() < 0.5, "frame {i}: {u_px} against {truth_px}");
        }
    }
}
