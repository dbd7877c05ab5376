//! A robot cell that is not there: a torch along a made-up seam, a camera ahead of it, and a KUKA's or an ABB's cycle on the wire.
//! What the corrections are worth is known, since the seam is.
//!
//! | file | what it does |
//! |---|---|
//! | `scene` | the seam, and the picture from any place |
//! | `arm` | the robot: cycles, corrections executed late |
//! | `wire` | what the robot sends and reads: RSI, EGM |
//! | `report` | what the torch did |
//! | here | camera's thread, troubles |

mod arm;
mod report;
mod scene;
mod wire;

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rand::Rng;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::GuideSettings;
use super::stream::write_picture;
use crate::synth::ScenarioError;
use arm::{Arm, Motion};
pub use report::{CellReport, TorchError};
pub use scene::CellScene;
use scene::Seam;
pub use wire::CellLink;

/// From the middle of the exposure to the picture's sending \[s\], as a camera's readout and transfer take; rendering happens in
/// it. Chosen.
pub const READOUT_S: f64 = 0.01;
/// How long the picture's receiver is waited for. Chosen.
const CLIENT: Duration = Duration::from_secs(30);
/// How long a receiver may take a picture. Chosen.
const SEND: Duration = Duration::from_millis(500);

/// What a simulated cell is.
#[derive(Debug, Clone)]
pub struct CellSettings {
    /// The seam.
    pub scene: CellScene,
    /// What the robot speaks.
    pub link: CellLink,
    /// Speed of the torch \[mm/s\].
    pub speed_mm_s: f64,
    /// Length of the weld \[mm\].
    pub length_mm: f64,
    /// The robot's cycle \[s\].
    pub cycle_s: f64,
    /// How much later than its answer a correction is executed \[s\].
    pub delay_s: f64,
    /// The camera's rate \[1/s\].
    pub frames_per_s: f64,
    /// How far the camera is ahead of the torch \[mm\].
    pub ahead_mm: f64,
    /// Share of the pictures that are lost, 0 to 1.
    pub lost_share: f64,
    /// Seed of the scene and of what is lost.
    pub seed: u64,
    /// What goes wrong.
    pub troubles: Vec<Trouble>,
    /// How often a stop is reset and the weld gone on with.
    pub resets: u32,
    /// Where pictures can be fetched.
    pub camera: SocketAddr,
    /// Where corrections are asked for.
    pub corrections: SocketAddr,
}

impl Default for CellSettings {
    fn default() -> Self {
        let guide = GuideSettings::default();
        Self {
            scene: CellScene::Sine,
            link: CellLink::Rsi,
            speed_mm_s: 30.0,
            length_mm: 600.0,
            cycle_s: 0.004,
            delay_s: guide.delay_s,
            frames_per_s: 60.0,
            ahead_mm: guide.ahead_mm,
            lost_share: 0.0,
            seed: 1,
            troubles: vec![],
            resets: 0,
            camera: SocketAddr::from(([127, 0, 0, 1], 49151)),
            corrections: SocketAddr::from(([127, 0, 0, 1], 49152)),
        }
    }
}

/// Something that goes wrong at a place of the weld.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trouble {
    /// What.
    pub kind: TroubleKind,
    /// Where the torch is then \[mm\].
    pub at_mm: f64,
    /// For how long \[s\].
    pub for_s: f64,
}

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TroubleKind {
    /// The camera gives no pictures.
    Stall,
    /// The camera is gone, its connection too.
    Dead,
    /// The camera gives the same picture again and again.
    Frozen,
    /// The robot's network is cut.
    Cut,
}

impl FromStr for Trouble {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('@').and_then(|(kind, rest)| Some((kind, rest.split_once(':')?)));
        let kind = match parts.map(|(kind, _)| kind) {
            Some("stall") => Some(TroubleKind::Stall),
            Some("dead") => Some(TroubleKind::Dead),
            Some("frozen") => Some(TroubleKind::Frozen),
            Some("cut") => Some(TroubleKind::Cut),
            _ => None,
        };
        let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
        let numbers = parts.and_then(|(_, (at_mm, for_s))| Some((number(at_mm)?, number(for_s)?)));
        match (kind, numbers) {
            (Some(kind), Some((at_mm, for_s))) => Ok(Self { kind, at_mm, for_s }),
            _ => Err("expected stall, dead, frozen or cut, where [mm] and how long [s], such as stall@200:0.5".into()),
        }
    }
}

/// A cell that cannot run.
#[derive(Debug, thiserror::Error)]
pub enum CellError {
    /// The seam cannot be made up.
    #[error(transparent)]
    Scene(#[from] ScenarioError),
    /// A port cannot be used.
    #[error("the port {address} cannot be used: is another program on it?")]
    Port {
        /// The address.
        address: SocketAddr,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Nobody fetches pictures.
    #[error("nobody fetched pictures from {0} for 30 s: start `seamtrack live` with camera = \"tcp:{0}\"")]
    NobodyLooks(SocketAddr),
    /// A part of the program failed, which is a fault of it.
    #[error("the thread of the {0} ended by itself: this is a fault of seamtrack, please report it")]
    Thread(&'static str),
}

/// What the cell's threads share.
struct Cell<'a> {
    settings: &'a CellSettings,
    seam: Seam,
    motion: Mutex<Motion>,
    ends: &'a AtomicBool,
    done: AtomicBool,
    started: Instant,
    pictures: AtomicU64,
    lost: AtomicU64,
    skipped: AtomicU64,
}

/// Welds once: waits for somebody who fetches pictures, then drives.
///
/// # Errors
/// When a port cannot be used, or nobody comes.
pub fn run(settings: &CellSettings, ends: &AtomicBool) -> Result<CellReport, CellError> {
    let port = |address| move |source| CellError::Port { address, source };
    let listener = TcpListener::bind(settings.camera).map_err(port(settings.camera))?;
    listener.set_nonblocking(true).map_err(port(settings.camera))?;
    let cell = Cell {
        settings,
        seam: Seam::new(settings)?,
        motion: Mutex::new(Motion::default()),
        ends,
        done: AtomicBool::new(false),
        started: Instant::now(),
        pictures: AtomicU64::new(0),
        lost: AtomicU64::new(0),
        skipped: AtomicU64::new(0),
    };
    let arm = Arm::open(settings).map_err(port(settings.corrections))?;
    let first = cell.wait_for_client(&listener).ok_or(CellError::NobodyLooks(settings.camera))?;
    let mut report = std::thread::scope(|scope| {
        let camera = scope.spawn(|| cell.show(&listener, first));
        let report = arm.weld(&cell);
        cell.done.store(true, Ordering::Relaxed);
        camera.join().map_err(|_| CellError::Thread("camera"))?;
        report.map_err(port(settings.corrections))
    })?;
    report.pictures = cell.pictures.load(Ordering::Relaxed);
    report.lost = cell.lost.load(Ordering::Relaxed);
    report.skipped = cell.skipped.load(Ordering::Relaxed);
    Ok(report)
}

impl Cell<'_> {
    fn is_ending(&self) -> bool {
        self.done.load(Ordering::Relaxed) || self.ends.load(Ordering::Relaxed)
    }

    fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    fn motion(&self) -> Motion {
        *self.motion.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait_for_client(&self, listener: &TcpListener) -> Option<TcpStream> {
        let began = Instant::now();
        while began.elapsed() < CLIENT && !self.is_ending() {
            if let Some(stream) = accept(listener) {
                return Some(stream);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        None
    }

    /// Whether such a trouble is on.
    fn is_on(&self, kind: TroubleKind, now_s: f64, motion: &Motion) -> bool {
        let is_now = |since_s: f64, for_s: f64| (0.0..for_s).contains(&since_s);
        self.settings.troubles.iter().any(|trouble| {
            let since_s = motion.passed_s(trouble.at_mm, now_s);
            trouble.kind == kind && since_s.is_some_and(|since_s| is_now(since_s, trouble.for_s))
        })
    }

    /// The camera: a picture at each tick, sent when it was read out.
    fn show(&self, listener: &TcpListener, first: TcpStream) {
        let mut client = Some(first);
        let mut lost = Pcg64Mcg::seed_from_u64(self.settings.seed);
        let (from_s, period_s) = (self.now_s(), 1.0 / self.settings.frames_per_s);
        let mut number = 0_u64;
        let mut frozen = None;
        while !self.is_ending() {
            number += 1;
            let mut due_s = from_s + number as f64 * period_s;
            let behind = ((self.now_s() - due_s) / period_s).floor();
            if behind >= 1.0 {
                number += behind as u64;
                self.skipped.fetch_add(behind as u64, Ordering::Relaxed);
                due_s += behind * period_s;
            }
            self.sleep_until(due_s);
            let exposed_s = self.now_s();
            let motion = self.motion();
            if self.is_on(TroubleKind::Dead, exposed_s, &motion) {
                client = None;
                drop(accept(listener));
                continue;
            }
            client = client.or_else(|| accept(listener));
            if self.is_on(TroubleKind::Stall, exposed_s, &motion) {
                continue;
            }
            if lost.random::<f64>() < self.settings.lost_share {
                self.lost.fetch_add(1, Ordering::Relaxed);
                continue;
            }
            let (path_mm, lateral_mm) = motion.at(exposed_s);
            let picture = match self.is_on(TroubleKind::Frozen, exposed_s, &motion) {
                true => frozen.get_or_insert_with(|| self.seam.picture(path_mm, lateral_mm)).clone(),
                false => {
                    frozen = None;
                    self.seam.picture(path_mm, lateral_mm)
                }
            };
            self.sleep_until(exposed_s + READOUT_S);
            if let Some(stream) = &mut client {
                match write_picture(stream, &picture, (exposed_s * 1e9) as u64) {
                    Ok(()) => drop(self.pictures.fetch_add(1, Ordering::Relaxed)),
                    Err(_) => client = None,
                }
            }
        }
    }

    fn sleep_until(&self, due_s: f64) {
        let left_s = due_s - self.now_s();
        if left_s > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(left_s));
        }
    }
}

fn accept(listener: &TcpListener) -> Option<TcpStream> {
    let (stream, _) = listener.accept().ok()?;
    stream.set_nonblocking(false).ok()?;
    stream.set_nodelay(true).ok()?;
    stream.set_write_timeout(Some(SEND)).ok()?;
    Some(stream)
}
