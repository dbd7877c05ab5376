//! Made-up recordings: scenario → scene → rendered frames and their truth.
//!
//! One [`Scenario`] (a TOML file) decides everything; with a seed it becomes a [`Scene`], whose frames can be rendered
//! one by one, in any order, on any thread, with the same bytes.

mod arc;
pub mod board;
pub mod builtin;
mod canvas;
mod draw;
mod noise;
pub mod pool;
mod profile;
pub mod recording;
pub mod scenario;
mod scene;
mod sensor;
mod spatter;
mod stripe;
mod timeline;

pub use scenario::{Scenario, ScenarioError};
pub use scene::{Scene, Truth};
