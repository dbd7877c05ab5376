//! The seam tracker: seed → locate → estimate. The only place where `imgproc`, `kcf` and `kalman` meet.
//!
//! A [`Session`] takes frames with their stamps and gives an [`Estimate`] of each; a [`SeamPath`] collects them and smooths
//! the path of a whole recording.
//!
//! | file | what it does |
//! |---|---|
//! | `estimate` | what is said of a frame |
//! | `session`, `clock`, `previous` | frames in, estimates out; time, repeated and frozen pictures |
//! | `view`, `orientation` | the picture as a method sees it: stripe along the rows, raster that fits the joint |
//! | `picture` | makes of the picture what is looked at, and no more |
//! | `paper` | the method of Du 2022 |
//! | `robust` | our own |
//! | `hairline`, `grid`, `grid_smooth` | joints that have neither edges nor a corner |
//! | `profile`, `measures` | the joint's lines in millimetres, and what can be measured of it |
//! | `path` | the smoother over a whole recording |
//! | `lag` | the smoother a few frames behind a session |

mod clock;
mod estimate;
mod grid;
mod grid_smooth;
mod hairline;
mod lag;
mod measures;
mod orientation;
mod paper;
mod path;
mod picture;
mod previous;
mod profile;
mod robust;
mod session;
mod view;

pub use estimate::{
    CrossSection, Estimate, Evidence, JointDecision, KcfReading, Observation, SeamEstimate, Side, Status,
};
pub use grid::{GridEstimate, GridFilter, LocalObservation};
pub use grid_smooth::{EvidenceRow, smooth};
pub use hairline::{HairlineEstimate, HairlineTracker, SeamPresence};
pub use measures::{Measure, Measures};
pub use orientation::find_axis;
pub use paper::PaperSettings;
use paper::PaperTracker;
pub use path::SeamPath;
pub use profile::{Profile, SeenLine};
#[cfg(feature = "ablation")]
pub use robust::Part;
use robust::RobustTracker;
pub use robust::{REFUSE_NIS, RobustSettings};
pub use session::{FROZEN_AFTER_BEATS, Session, SessionSettings};

use crate::imgproc::SeamRoi;
use crate::kalman::{InnovationNotPositive, InvalidParameter, SeriesError};
use crate::kcf::KcfError;
use crate::units::{PixelPoint, PixelRect};

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
    /// A frame is not as large as those before it.
    #[error("a frame of {} x {} pixels follows frames of {} x {}: start a new session for it", now.0, now.1, first.0, first.1)]
    FrameSize {
        /// Columns and rows of the frames before.
        first: (usize, usize),
        /// Columns and rows of this one.
        now: (usize, usize),
    },
    /// The user said where the seam is, and there is none.
    #[error("no joint near the seed {:.0}, {:.0} in {frames} frames with a stripe{}: correct the seed or leave it out",
        seed.u_px, seed.v_px,
        elsewhere.map_or_else(String::new, |(kind, at)| format!("; a {kind} joint shows at {:.0}, {:.0}", at.u_px, at.v_px)))]
    NothingAtSeed {
        /// The place, in the picture.
        seed: PixelPoint,
        /// Frames with a stripe that were looked at.
        frames: usize,
        /// A joint that showed at another place, and where.
        elsewhere: Option<(&'static str, PixelPoint)>,
    },
    /// Nothing of the picture lies in the part that is to be looked at.
    #[error("the part to look at, {} x {} pixels from ({}, {}), lies outside the picture of {} x {} pixels",
        roi.width_px, roi.height_px, roi.u_px, roi.v_px, picture.0, picture.1)]
    Roi {
        /// The part.
        roi: PixelRect,
        /// Columns and rows of the picture.
        picture: (usize, usize),
    },
}

/// The ROI that overlays show round an estimate.
#[must_use]
pub fn roi(estimate: &Estimate) -> Option<SeamRoi> {
    estimate.seam.map(|seam| SeamRoi::du_2022(seam.centre))
}
