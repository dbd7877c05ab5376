//! A path against its truth: errors along the stripe, in millimetres, or in pixels where no scale is known.
//!
//! Errors are taken in pixels first, so that no origin enters. How frames are counted: a frame is *unavailable* when it
//! has a truth but no value although the seam had been found before; a value is *wrong* when it is off by more than
//! [`WRONG_MM`] or [`WRONG_PX`].

mod errors;
mod plane;
mod truth;

pub use errors::{Errors, Estimate, WRONG_MM, WRONG_PX, errors, errors_by, wrong_limit};
pub use plane::{AxisErrors, PlaneErrors, PlaneValue, axis_errors};
pub use truth::{TruthFileError, TruthRow, parse_truth, read_truth};
