//! seamtrack finds the weld seam in laser-stripe frames and estimates its centre in millimetres.
//!
//! The way of the data is one direction:
//! `GrayFrame → Centreline → SeamRoi → Response → Observation → Estimate → Track → Report`.
//! `ARCHITECTURE.md` says which module may use which.

pub mod calib;
pub mod config;
pub mod eval;
pub mod frame;
pub mod imgproc;
pub mod kalman;
pub mod kcf;
pub mod meltpool;
pub mod output;
pub mod regress;
pub mod report;
pub mod reproduce;
pub mod run;
pub mod source;
pub mod synth;
pub mod tracker;
pub mod units;
