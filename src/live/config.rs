//! `live.toml`: everything of a live run.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::GuideSettings;
use crate::config::{Config, ConfigError};

/// The configuration of a live run. Unknown keys are refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiveConfig {
    /// Where pictures come from: `gige:ADDRESS` and `usb3:NAME`, cameras (feature `camera`); `file:PATH`, a recording at its own
    /// speed; `scene:NAME`, a made-up one; `tcp:HOST:PORT`, a simulated cell.
    pub camera: String,
    /// How much faster than its own speed a recording or a scene is played. Default 1.
    #[serde(default = "one")]
    pub rate: f64,
    /// Least time from the middle of the exposure to the picture's arrival \[s\]: half the exposure, readout, transfer. A stamp
    /// cannot tell it, since two clocks are compared by the quickest picture. Default 0. For `gige:`, `usb3:` and `tcp:`.
    #[serde(default)]
    pub camera_lag_s: f64,
    /// How a camera is spoken to.
    #[serde(default)]
    pub genicam: GenicamConfig,
    /// The calibration of the sensor; without it `track.mm_per_px` must be given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<PathBuf>,
    /// Where the torch's line appears in the picture \[px\]; its middle when it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torch_px: Option<[f64; 2]>,
    /// Whether the robot's lateral coordinate falls where the picture's grows.
    #[serde(default)]
    pub mirrored: bool,
    /// Where the run is recorded (MCAP); it is not when this is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<PathBuf>,
    /// Size at which recording ends \[MB\]. Default 20 000.
    #[serde(default = "twenty_gigabytes")]
    pub record_most_mb: u64,
    /// How the seam is tracked: as for recordings.
    #[serde(default)]
    pub track: Config,
    /// Look-ahead, caps and ages.
    #[serde(default)]
    pub guide: GuideSettings,
    /// The robot.
    #[serde(default)]
    pub robot: RobotConfig,
    /// Where the page can be looked at, such as 127.0.0.1:8080; nowhere when it is not given. Whoever reaches another address than
    /// a loopback one can look. Needs the feature `page`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub page: Option<SocketAddr>,
    /// With it the page can reset and stop; without it nobody can.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub page_token: Option<String>,
    /// Registers for a PLC; there are none when this is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modbus: Option<ModbusConfig>,
}

/// How a GigE Vision or USB3 Vision camera is spoken to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GenicamConfig {
    /// Size of a packet with all headers \[bytes\]; tried out when it is not given. Larger ones need jumbo frames on the whole way.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub packet_bytes: Option<u16>,
    /// Buffer of the socket \[bytes\]. Default 4 MiB: a dozen pictures. The system's `net.core.rmem_max` must allow it.
    pub socket_bytes: u32,
    /// Pictures a second; the camera's own setting when it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_per_s: Option<f64>,
    /// Exposure \[µs\]; the camera's own setting when it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure_us: Option<f64>,
    /// A camera silent for longer is opened anew \[s\]. Default 1.
    pub silent_s: f64,
}

impl Default for GenicamConfig {
    fn default() -> Self {
        Self { packet_bytes: None, socket_bytes: 4 << 20, frames_per_s: None, exposure_us: None, silent_s: 1.0 }
    }
}

/// Registers for a PLC.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModbusConfig {
    /// Where we listen. Modbus knows no password: keep it in the machine's own network.
    pub listen: SocketAddr,
    /// A PLC whose heartbeat stands for longer than this stops the corrections \[s\]; none is expected when it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plc_silent_s: Option<f64>,
}

/// How the robot is spoken to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RobotConfig {
    /// Its protocol.
    pub link: Link,
    /// Where we listen. Default 127.0.0.1:49152: RSI's usual port, and nobody but this machine. EGM's is 6510.
    pub listen: SocketAddr,
    /// Unit vector of the travel, in the frame of poses and corrections.
    pub travel: [f64; 3],
    /// Unit vector of the corrections, at right angles to it.
    pub lateral: [f64; 3],
    /// Without a link: the speed of the torch \[mm/s\].
    pub speed_mm_s: f64,
    /// Without a link: the length of a cycle \[s\].
    pub cycle_s: f64,
}

/// A robot's protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Link {
    /// None: the path is speed × time.
    None,
    /// KUKA RSI.
    Rsi,
    /// ABB EGM, path correction. Corrections go along Y of the path's coordinates; `lateral` must be that direction.
    Egm,
}

impl Default for RobotConfig {
    fn default() -> Self {
        Self {
            link: Link::None,
            listen: SocketAddr::from(([127, 0, 0, 1], 49152)),
            travel: [1.0, 0.0, 0.0],
            lateral: [0.0, 1.0, 0.0],
            speed_mm_s: 10.0,
            cycle_s: 0.01,
        }
    }
}

const fn one() -> f64 {
    1.0
}

const fn twenty_gigabytes() -> u64 {
    20_000
}

/// A unit vector's length, and the cosine of a right angle, may be off by this. Chosen: three decimals in a file.
const UNIT_TOLERANCE: f64 = 2e-3;

/// Shortest token. Chosen: longer than what is guessed over a network.
const SHORTEST_TOKEN: usize = 12;

impl LiveConfig {
    /// Reads `live.toml`.
    ///
    /// # Errors
    /// When it cannot be read, is not TOML, has an unknown key, or a number is out of its range.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
        let wrong = |problem: String| ConfigError::Parse { path: path.to_owned(), problem };
        let config: Self = toml::from_str(&text).map_err(|error| wrong(error.to_string().trim().to_owned()))?;
        config.check().map_err(wrong)?;
        Ok(config)
    }

    fn check(&self) -> Result<(), String> {
        self.guide.checked().map_err(|error| error.to_string())?;
        self.track.method().map_err(|error| error.to_string())?;
        let RobotConfig { travel, lateral, speed_mm_s, cycle_s, .. } = &self.robot;
        let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let is_unit = |vector: &[f64; 3]| (dot(vector, vector).sqrt() - 1.0).abs() < UNIT_TOLERANCE;
        let within = |name: &str, value: f64, from: f64, to: f64| match (from..=to).contains(&value) {
            true => Ok(()),
            false => Err(format!("{name} must be from {from} to {to}, not {value}")),
        };
        if !is_unit(travel) || !is_unit(lateral) || dot(travel, lateral).abs() > UNIT_TOLERANCE {
            return Err("robot.travel and robot.lateral must be unit vectors at right angles".into());
        }
        within("robot.speed_mm_s", *speed_mm_s, 0.0, 1000.0)?;
        within("robot.cycle_s", *cycle_s, 0.001, 0.1)?;
        within("camera_lag_s", self.camera_lag_s, 0.0, 1.0)?;
        within(
            "modbus.plc_silent_s",
            self.modbus.as_ref().and_then(|modbus| modbus.plc_silent_s).unwrap_or(1.0),
            0.05,
            600.0,
        )?;
        within("rate", self.rate, 0.01, 1000.0)?;
        let genicam = &self.genicam;
        within("genicam.packet_bytes", genicam.packet_bytes.map_or(1400.0, f64::from), 576.0, 16_000.0)?;
        within("genicam.socket_bytes", f64::from(genicam.socket_bytes), 65_536.0, 1e9)?;
        within("genicam.frames_per_s", genicam.frames_per_s.unwrap_or(1.0), 0.1, 10_000.0)?;
        within("genicam.exposure_us", genicam.exposure_us.unwrap_or(1.0), 0.1, 1e6)?;
        within("genicam.silent_s", genicam.silent_s, 0.1, 60.0)?;
        if self.page_token.as_ref().is_some_and(|token| token.len() < SHORTEST_TOKEN) {
            return Err(format!("page_token must have {SHORTEST_TOKEN} characters or more: it can stop the weld"));
        }
        match self.torch_px {
            Some(point) if !point.iter().all(|px| px.is_finite()) => Err("torch_px must be two numbers".into()),
            _ => Ok(()),
        }
    }
}
