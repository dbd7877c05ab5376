//! The kernelized correlation filter of Henriques et al. (IEEE TPAMI 37(3), 2015) as Du 2022 uses it: grey features,
//! cosine window, Gaussian kernel, and the peak-to-sidelobe ratio of the response.
//!
//! Images and spectra are `f32`. Every buffer is made once, a step allocates nothing.

mod fft2;
mod filter;
mod patch;
mod response;

pub use fft2::{Fft2, Spectrum};
pub use filter::{Kcf, KcfError, KcfSettings};
pub use response::{Response, psr_ceiling};
