//! Pixels to millimetres.

pub mod adjust;
pub mod board;
pub mod board_svg;
pub mod camera;
pub mod check;
pub mod check_travel;
#[cfg(feature = "opencv")]
pub mod corners;
#[cfg(feature = "opencv")]
mod cv;
#[cfg(feature = "opencv")]
pub mod detect;
pub mod error;
pub mod file;
mod file_sections;
pub mod guidance;
pub mod hand_eye;
pub mod interchange;
pub mod intrinsics;
mod known;
pub mod laser;
pub mod laser_camera;
pub mod pairs;
pub mod plane;
pub mod pose;
pub mod resample;
mod ruler;
pub mod scale;
mod sensor;
pub mod sightings;
pub mod stripe;
#[cfg(feature = "opencv")]
pub mod stripes;
mod student;
pub mod travel;
pub mod uncertainty;
mod yaml;

pub use known::KnownSensor;
pub use laser_camera::PlanePoint;
pub use ruler::{Origin, Ruler};
pub use sensor::Sensor;
