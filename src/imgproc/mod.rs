//! From a frame to the stripe: median filter, centreline, seam features and ROI, the joint's geometry, and the evidence of
//! a hairline along the straightened stripe.
//!
//! Everything here sees a horizontal stripe: a vertical one is transposed before it comes here.

mod ambient_line;
mod box_filter;
mod centreline;
mod features;
pub mod geometry;
mod median;
mod notch;
mod notch_template;
mod pixels;
mod raster;
mod rectify;
mod stripe_line;
mod stripe_path;
mod stripes;

pub use ambient_line::AmbientLine;
pub use centreline::{Centreline, CentrelineSettings, extract as extract_centreline, extract_along};
pub use features::{SeamFeatures, SeamRoi, SeedSettings, candidates as seam_candidates, find as find_seam_features};
pub(crate) use median::MedianFilter;
pub use median::{MedianKernel, median};
pub use notch::NotchEvidence;
pub use notch_template::NotchTemplate;
pub use pixels::Pixels;
pub(crate) use pixels::Tiles;
pub use raster::Raster;
pub use rectify::{BAND_HALF_PX, BAND_ROWS, Band, StripeRectifier};
pub use stripe_line::{StripeLine, StripeLineFinder};
pub use stripe_path::stripe_path;
pub use stripes::{Stripe, stripes};
