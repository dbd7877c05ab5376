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
//! | `stamps` | the clock of a camera or a robot, and ours |
//!
//! Around it, with the feature `cli`, what runs it:
//!
//! | file | what it does |
//! |---|---|
//! | `run`, `tracking`, `config` | threads of a live run, and `live.toml` |
//! | `slot` | the newest picture between camera and tracker |
//! | `camera`, `stream` | a recording or a scene at its own speed; pictures of a simulated cell |
//! | `genicam` | GigE Vision and USB3 Vision cameras, with the feature `camera` |
//! | `double` | a GigE Vision camera that is not there |
//! | `robot`, `wire` | cycles and answers, the same for every robot |
//! | `rsi`, `egm` | KUKA's and ABB's messages |
//! | `modbus` | registers for a PLC |
//! | `page/` | a page to look at it, with the feature `page` |
//! | `recorder` | the log that `track` reads |
//! | `spread` | latencies in memory that does not grow |
//! | `cell` | a simulated robot cell with a known seam |

#[cfg(feature = "cli")]
mod camera;
#[cfg(feature = "cli")]
mod cell;
#[cfg(feature = "cli")]
mod config;
mod corrections;
#[cfg(feature = "cli")]
mod double;
#[cfg(feature = "cli")]
mod egm;
#[cfg(feature = "camera")]
mod genicam;
mod guard;
mod guide;
#[cfg(feature = "cli")]
mod modbus;
#[cfg(feature = "page")]
mod page;
mod poses;
#[cfg(feature = "cli")]
mod recorder;
mod ring;
#[cfg(feature = "cli")]
mod robot;
#[cfg(feature = "cli")]
mod rsi;
#[cfg(feature = "cli")]
mod run;
mod settings;
#[cfg(feature = "cli")]
mod slot;
#[cfg(feature = "cli")]
mod spread;
mod stamps;
#[cfg(feature = "cli")]
mod stream;
#[cfg(feature = "cli")]
mod tracking;
#[cfg(feature = "cli")]
mod wire;

#[cfg(feature = "cli")]
pub use cell::{
    CellError, CellLink, CellReport, CellScene, CellSettings, READOUT_S, TorchError, Trouble, TroubleKind,
    run as run_cell,
};
#[cfg(feature = "cli")]
pub use config::{GenicamConfig, Link, LiveConfig, ModbusConfig, RobotConfig};
#[cfg(feature = "cli")]
pub use double::{DoubleError, DoubleReport, DoubleSettings, Fault, run as run_double};

pub use guard::{State, Why};
pub use guide::{Answer, Correction, Guide, Offset, Sighting};
pub use poses::Pose;
#[cfg(feature = "cli")]
pub use robot::RobotCounts;
#[cfg(feature = "cli")]
pub use run::{LiveError, LiveReport, run};
pub use settings::{BadGuideSetting, GuideSettings};
#[cfg(feature = "cli")]
pub use spread::Spread;
pub use stamps::StampMap;

/// Cycles by state, in words.
#[cfg(feature = "cli")]
fn state_names(by_state: &[u64; State::ALL.len()]) -> String {
    State::ALL
        .iter()
        .zip(by_state)
        .map(|(state, count)| format!("{} {count}", state.name()))
        .collect::<Vec<_>>()
        .join(", ")
}

#[cfg(test)]
mod tests;
