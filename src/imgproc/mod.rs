//! From a frame to the stripe: median filter, centreline, seam features and ROI.
//!
//! Everything here sees a horizontal stripe: a vertical one is transposed before it comes here.

mod centreline;
mod cv;
mod features;

pub use centreline::{Centreline, CentrelineSettings, extract as extract_centreline};
pub use cv::{MedianError, MedianKernel, median};
pub use features::{SeamFeatures, SeamRoi, SeedSettings, find as find_seam_features};
pub mod ambient_line;
pub(crate) mod box_filter;
pub mod notch;
pub mod notch_template;
pub mod rectify;
pub mod stripe_line;
