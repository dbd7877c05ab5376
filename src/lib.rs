//! seamtrack finds the weld seam in laser-stripe frames and estimates its centre in millimetres.
//!
//! A [`Session`] takes frames with their stamps, one at a time, and says of each where the seam is, with its uncertainty, or
//! why it cannot tell. A [`SeamPath`] collects what it says and smooths the path of a whole recording.
//!
//! ```
//! use seamtrack::synth::{Scene, builtin};
//! use seamtrack::{Config, MmPerPx, SeamPath, Sensor, Session, SessionSettings, Status};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A made-up recording; a camera gives its frames in the same way.
//! let mut scenario = builtin::scenario("A-butt")?;
//! scenario.frames = 30;
//! let recording = Scene::new(&scenario, 1)?;
//!
//! let method = Config::default().method()?;
//! let sensor = Sensor::Scale(MmPerPx::new(0.073)?);
//! let mut session = Session::new(&SessionSettings { sensor, ..SessionSettings::new(method) })?;
//! let mut path = SeamPath::default();
//! for i in 0..recording.frame_count() {
//!     let estimate = session.step(&recording.render(i), recording.timestamp_s(i))?;
//!     if let (Status::Tracked, Some(seam)) = (estimate.status, estimate.seam) {
//!         println!("frame {i}: {:.2} ± {:.2} px", seam.centre.u_px, seam.std_px);
//!     }
//!     path.push(&estimate);
//! }
//! assert_eq!(session.joint().map(|joint| joint.kind), Some("butt"));
//! assert!(path.smoothed()?.iter().all(Option::is_some));
//! # Ok(())
//! # }
//! ```
//!
//! A whole recording, as the program goes through it:
//!
//! ```no_run
//! use std::path::Path;
//!
//! use seamtrack::{Config, Origin, open, track};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let config = Config::default();
//! let mut recording = open(Path::new("rec/frames"), 0.2)?;
//! let outcome = track(&mut *recording, (&config, &config.sensor()), Origin::First, |_| ())?;
//! println!("{} frames, {} with a value", outcome.counts.total, outcome.counts.tracked);
//! # Ok(())
//! # }
//! ```
//!
//! What a user of the library needs stands here at the root; the modules below are where it comes from, and the parts it is made of.
//! These are what a version promises. What the program alone is made of (pages, results, robots, campaigns) is hidden from this
//! documentation and may change with each version. Without the feature `cli` the crate is the core alone, and needs no OpenCV.

pub mod calib;
pub mod config;
pub mod eval;
pub mod frame;
pub mod imgproc;
pub mod kalman;
pub mod kcf;
mod lanes;
#[doc(hidden)]
pub mod live;
#[cfg(feature = "opencv")]
pub mod meltpool;
#[doc(hidden)]
pub mod output;
#[doc(hidden)]
pub mod regress;
#[doc(hidden)]
pub mod report;
#[cfg(feature = "opencv")]
#[doc(hidden)]
pub mod reproduce;
pub mod run;
pub mod source;
pub mod synth;
pub mod tracker;
pub mod units;

pub use calib::{KnownSensor, Origin, PlanePoint, Sensor};
pub use config::Config;
pub use frame::GrayFrame;
pub use imgproc::geometry::JointKind;
pub use run::{RunError, RunOutcome, track};
pub use source::{FrameSource, Period, SourceError, SourceFrame, open};
pub use tracker::{
    CrossSection, Estimate, Evidence, JointDecision, KcfReading, Method, Observation, PaperSettings, RobustSettings,
    SeamEstimate, SeamPath, Session, SessionSettings, Side, Status, TrackerError,
};
pub use units::{MmPerPx, PixelPoint, StripeAxis};
