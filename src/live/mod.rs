//! At the torch: from sightings to corrections, and never a stale value.
//!
//! The core has neither clock nor input nor output, so that it is tested in virtual time:
//!
//! | file | what it does |
//! |---|---|
//! | `guide` | sightings ahead of the torch in, corrections at the torch out |
//! | `settings` | geometry, caps, distances and ages |
//! | `ring` | where the seam was seen, by the path |
//! | `poses` | where the robot was, by time |
//! | `corrections` | what was sent: under way, caps |
//! | `guard` | when a correction may be sent, and when the seam is given up |
//! | `stamps` | a camera's clock and ours |

mod corrections;
mod guard;
mod guide;
mod poses;
mod ring;
mod settings;
mod stamps;

pub use guard::{State, Why};
pub use guide::{Answer, Correction, Guide, Offset, Sighting};
pub use poses::Pose;
pub use settings::{BadGuideSetting, GuideSettings};
pub use stamps::StampMap;

#[cfg(test)]
mod tests;
