//! The papers' other two sensors: the tip of the molten pool in infrared, and the width of a clad.
//!
//! | file | what it does |
//! |---|---|
//! | `travel` | the picture turned so that the torch travels up |
//! | `grey`, `cv`, `pool` | grey stretch, threshold and contours (OpenCV's), the pool and whether it is one |
//! | `edge`, `robust` | edges to a fraction of a pixel, fits that stray points do not move |
//! | `tip`, `width`, `meter` | the measures of one frame |
//! | `noise`, `follow` | a measured series: its noise, its filter with statuses, its smoother |

mod cv;
mod edge;
mod follow;
mod grey;
mod meter;
mod noise;
mod pool;
mod refusal;
mod robust;
mod tip;
mod travel;
mod width;

pub use cv::SegmentationError;
pub use follow::{Followed, Path, Reading, Status, follow};
pub use meter::{Measured, Meter};
pub use noise::{Noise, NoiseLevels};
pub use pool::Threshold;
pub use refusal::{Border, Refusal};

use serde::{Deserialize, Serialize};

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The corner at the front of the molten pool: where the seam is, across the travel.
    Tip,
    /// The longest cut of the pool across the travel: the width of the clad.
    Width,
}
