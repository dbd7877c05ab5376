//! Made-up recordings: scenario → scene → rendered frames and their truth.
//!
//! One [`Scenario`] (a TOML file) decides everything; with a seed it becomes a [`Scene`], whose frames can be rendered
//! one by one, in any order, on any thread, with the same bytes.

mod arc;
mod base;
mod bead;
pub mod board;
pub mod builtin;
mod canvas;
mod draw;
pub mod families;
mod noise;
mod obstacles;
pub mod pool;
mod preparation;
mod profile;
mod projection;
pub mod recording;
mod rivals;
pub mod scenario;
mod scene;
mod sensor;
mod spatter;
mod stripe;
mod surface;
mod timeline;

pub use projection::true_sensor;
pub use scenario::{Scenario, ScenarioError};
pub use scene::{Scene, Truth};
