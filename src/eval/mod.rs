//! A path against its truth: errors in millimetres along the stripe.
//!
//! Errors are taken in pixels first, so that no origin enters. How frames are counted: a frame is *unavailable* when it
//! has a truth but no value although the seam had been found before; a value is *wrong* when it is off by more than
//! [`WRONG_MM`].

mod errors;
mod truth;

pub use errors::{Errors, Estimate, WRONG_MM, errors};
pub use truth::{TruthFileError, TruthRow, read_truth};
