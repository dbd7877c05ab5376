//! Made-up pictures of a molten pool: a body with a corner at its front where the seam is, seen in infrared or through
//! a filter, with what disturbs them.

mod light;
mod scenario;
mod scene;
mod shape;

pub use scenario::{Body, Emissivity, Flaws, Light, PoolImage, PoolScenario};
pub use scene::{PoolPicture, PoolScene, PoolTruth};
