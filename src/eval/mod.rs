//! A path against its truth.

mod errors;

pub use errors::Errors;
