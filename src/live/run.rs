//! A live run: camera, tracker, robot and recorder, each on a thread of its own.

use std::fmt;
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use super::camera::{Camera, LiveClock, Picture, Player, SceneSource, Taken};
use super::config::{Link, LiveConfig, ModbusConfig, RobotConfig};
use super::egm::Egm;
use super::guide::Guide;
use super::modbus;
use super::recorder::{self, Entry, RecordError};
use super::robot::{Leader, RobotCounts, Shared};
use super::rsi::Rsi;
use super::settings::BadGuideSetting;
use super::slot::Slot;
use super::spread::Spread;
use super::state_names;
use super::stream::StreamCamera;
use super::tracking::Tracking;
use super::wire::Wire;
use crate::calib::file::CalibrationFileError;
use crate::config::ConfigError;
use crate::run::RunError;
use crate::source::{Period, SourceError};
use crate::synth::{ScenarioError, Scene, builtin};
use crate::tracker::TrackerError;

/// Sightings, and frames to be recorded, that may wait. Chosen: a second of a quick camera.
const SIGHTINGS: usize = 64;
const RECORDED_AHEAD: usize = 64;
const NEWS: usize = 64;
/// How often somebody looks whether the run is to end. Chosen.
const WAIT: Duration = Duration::from_millis(50);

/// A live run that cannot begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// The camera's name is none.
    #[error(
        "the camera {0:?} is none that is known: give gige:ADDRESS, usb3:NAME, file:PATH, scene:NAME or tcp:HOST:PORT"
    )]
    Camera(String),
    /// The program speaks to no cameras.
    #[error("this program was built without cameras: build it with `--features camera`, or give file:, scene: or tcp:")]
    NoCameras,
    /// The recording cannot be opened.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// There is no such scene.
    #[error(transparent)]
    Scene(#[from] ScenarioError),
    /// The tracker's configuration is wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A limit is out of its range.
    #[error(transparent)]
    Guide(#[from] BadGuideSetting),
    /// The calibration cannot be used.
    #[error(transparent)]
    Calibration(#[from] CalibrationFileError),
    /// What is known of the sensor contradicts the configuration or the pictures.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The program has no page.
    #[error(
        "this program was built without the page: take `page` out of the configuration, or build it with `--features page`"
    )]
    NoPage,
    /// The robot needs millimetres.
    #[error("corrections are in millimetres: give calibration, or mm_per_px under [track]")]
    NoMillimetres,
    /// The tracker failed.
    #[error(transparent)]
    Tracker(#[from] TrackerError),
    /// A port cannot be opened or fails.
    #[error("the port {address} cannot be used: is another program on it?")]
    Port {
        /// The address.
        address: std::net::SocketAddr,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A part of the program failed, which is a fault of it.
    #[error("the thread of the {0} ended by itself: this is a fault of seamtrack, please report it")]
    Thread(&'static str),
}

/// What a live run was.
#[derive(Debug, Clone, Default)]
pub struct LiveReport {
    /// Pictures the camera gave.
    pub pictures: u64,
    /// Of them, passed over since a newer one was there.
    pub passed_over: u64,
    /// Pictures that could not be read, or how often the camera was opened anew.
    pub camera_troubles: u64,
    /// Frames by the tracker's status: seeking, tracked, coasting, lost.
    pub by_status: [u64; 4],
    /// Sightings that the robot's thread did not fetch in time.
    pub sightings_lost: u64,
    /// One step of the tracker \[ms\].
    pub step_ms: Spread,
    /// From the middle of the exposure to the estimate \[ms\].
    pub exposure_to_estimate_ms: Spread,
    /// Frames in the log.
    pub recorded: u64,
    /// Frames that the log lacks since its disk was too slow or it was full: `track` of it may differ behind the first.
    pub record_holes: u64,
    /// The robot's side.
    pub robot: RobotCounts,
    /// How long it took \[s\].
    pub elapsed_s: f64,
}

impl fmt::Display for LiveReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [seeking, tracked, coasting, lost] = self.by_status;
        let (robot, took) = (&self.robot, self.elapsed_s);
        writeln!(
            f,
            "pictures: {} in {took:.1} s, passed over {}, camera's troubles {}",
            self.pictures, self.passed_over, self.camera_troubles
        )?;
        writeln!(f, "frames: seeking {seeking}, tracked {tracked}, coasting {coasting}, lost {lost}")?;
        writeln!(f, "step of the tracker [ms]: {}", self.step_ms)?;
        writeln!(f, "exposure to estimate [ms]: {}", self.exposure_to_estimate_ms)?;
        writeln!(f, "robot's cycles: {}", state_names(&robot.by_state))?;
        writeln!(f, "arrival to answer [ms]: {}", robot.work_ms)?;
        write!(f, "late packets {}, not understood {}, not new {}, ", robot.late, robot.not_understood, robot.not_new)?;
        writeln!(f, "sightings without pose {}, lost {}", robot.unpaired, self.sightings_lost)?;
        if let Some(why) = robot.stopped {
            writeln!(f, "given up first: {}", why.name())?;
        }
        writeln!(f, "recorded: {} frames, holes {}", self.recorded, self.record_holes)
    }
}

/// Runs until the recording is over or `ends` is set. `news` is told when something changes.
///
/// # Errors
/// When something cannot be opened, or the tracker fails. A camera or a robot that is silent is no error: the guide's state
/// says so.
pub fn run(config: &LiveConfig, ends: &AtomicBool, mut news: impl FnMut(&str)) -> Result<LiveReport, LiveError> {
    let mut camera = open_camera(config)?;
    let tracking = Tracking::new(config)?;
    let guide = Guide::new(config.guide)?;
    let port = |address| move |source| LiveError::Port { address, source };
    let robot_port = port(config.robot.listen);
    let socket = match config.robot.link {
        Link::None => None,
        Link::Rsi | Link::Egm => Some(UdpSocket::bind(config.robot.listen).map_err(robot_port)?),
    };
    let listen = |modbus: &ModbusConfig| TcpListener::bind(modbus.listen).map_err(port(modbus.listen));
    let registers = config.modbus.as_ref().map(listen).transpose()?;
    let log = config.record.as_deref().map(|path| Ok::<_, RecordError>((path, recorder::create(path)?))).transpose()?;
    #[cfg(feature = "page")]
    let page = super::page::Page::open(config)?;
    #[cfg(feature = "page")]
    let tracking = tracking.shown_on(page.view());
    if !cfg!(feature = "page") && config.page.is_some() {
        return Err(LiveError::NoPage);
    }
    let (shared, slot, clock) = (Arc::new(Shared::default()), Slot::default(), LiveClock::start());
    let (saw, sightings) = sync_channel(SIGHTINGS);
    let (tell, told) = sync_channel::<String>(NEWS);
    let camera_tells = tell.clone();
    let (to_log, entries) = sync_channel(RECORDED_AHEAD);
    let began = Instant::now();

    let mut report = std::thread::scope(|scope| {
        let recording = log.map(|log| scope.spawn(move || record(log, &entries, config.record_most_mb)));
        let to_log = recording.is_some().then_some(to_log);
        let shared = &shared;
        let slot = &slot;
        let robot = {
            let plc_silent_s = config.modbus.as_ref().and_then(|modbus| modbus.plc_silent_s);
            let mut leader = Leader::new(guide, sightings, (shared, clock), tell, plc_silent_s);
            let socket = &socket;
            scope.spawn(move || {
                let _ending = Ending(shared);
                match socket {
                    None => leader.lead_by_speed(&config.robot),
                    Some(socket) => leader.answer(socket, wire(&config.robot).as_mut(), &config.robot)?,
                }
                Ok(leader.counts)
            })
        };
        let registers = registers.as_ref().map(|listener| {
            scope.spawn(move || {
                let _ending = Ending(shared);
                let address = listener.local_addr().unwrap_or(config.robot.listen);
                modbus::serve(listener, shared, clock).map_err(port(address))
            })
        });
        #[cfg(feature = "page")]
        let page = scope.spawn(move || {
            let address = config.page.unwrap_or(config.robot.listen);
            page.serve(shared, clock).map_err(port(address))
        });
        let tracker = scope.spawn(move || {
            let _ending = Ending(shared);
            tracking.run(slot, clock, shared, &saw, to_log.as_ref())
        });
        let pictures = scope.spawn(move || {
            let pictures = watch(camera.as_mut(), slot, &clock, shared, &camera_tells);
            slot.close();
            (pictures, camera.troubles())
        });
        while !shared.is_ending() {
            if ends.load(Ordering::Relaxed) {
                shared.ends.store(true, Ordering::Relaxed);
            }
            if let Ok(line) = told.recv_timeout(WAIT) {
                news(&line);
            }
        }
        let (pictures, camera_troubles) = pictures.join().map_err(|_| LiveError::Thread("camera"))?;
        let tracked = tracker.join().map_err(|_| LiveError::Thread("tracker"))??;
        let counted: std::io::Result<RobotCounts> = robot.join().map_err(|_| LiveError::Thread("robot"))?;
        let recorded = recording.map(|recording| recording.join().map_err(|_| LiveError::Thread("recorder")));
        let recorded = recorded.transpose()?.transpose()?.unwrap_or(0);
        told.try_iter().for_each(|line| news(&line));
        let served = registers.map(|served| served.join().map_err(|_| LiveError::Thread("registers")));
        served.transpose()?.transpose()?;
        #[cfg(feature = "page")]
        page.join().map_err(|_| LiveError::Thread("page"))??;
        let robot = counted.map_err(robot_port)?;
        Ok::<_, LiveError>(LiveReport { pictures, camera_troubles, recorded, robot, ..tracked })
    })?;
    report.passed_over = slot.passed_over();
    report.elapsed_s = began.elapsed().as_secs_f64();
    Ok(report)
}

/// The robot's protocol.
fn wire(robot: &RobotConfig) -> Box<dyn Wire> {
    match robot.link {
        Link::Egm => Box::new(Egm::default()),
        Link::None | Link::Rsi => Box::new(Rsi::new(robot.lateral)),
    }
}

/// Ends the whole run when a thread ends, however it does.
struct Ending<'a>(&'a Shared);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.ends.store(true, Ordering::Relaxed);
    }
}

fn record(log: (&Path, std::fs::File), entries: &Receiver<Entry>, most_mb: u64) -> Result<u64, RecordError> {
    recorder::record(log, entries, most_mb.saturating_mul(1_000_000))
}

/// The camera that the configuration names.
fn open_camera(config: &LiveConfig) -> Result<Box<dyn Camera>, LiveError> {
    let unknown = || LiveError::Camera(config.camera.clone());
    let (kind, place) = config.camera.split_once(':').ok_or_else(unknown)?;
    Ok(match kind {
        "file" => {
            let source = crate::source::open(Path::new(place), Period::OwnOr(config.track.period_s))?;
            Box::new(Player::new(source, config.rate))
        }
        "scene" => {
            let scenario = builtin::scenario(place)?;
            let scene = Scene::new(&scenario, scenario.seed)?;
            Box::new(Player::new(Box::new(SceneSource::new(scene)), config.rate))
        }
        "tcp" => Box::new(StreamCamera::new(place.parse().map_err(|_| unknown())?, config.camera_lag_s)),
        "gige" | "usb3" if place.is_empty() => return Err(unknown()),
        #[cfg(feature = "camera")]
        "gige" | "usb3" => Box::new(super::genicam::GenicamCamera::new(place, config.genicam, config.camera_lag_s)),
        #[cfg(not(feature = "camera"))]
        "gige" | "usb3" => return Err(LiveError::NoCameras),
        _ => return Err(unknown()),
    })
}

/// Fetches pictures until the run or the recording ends.
fn watch(
    camera: &mut dyn Camera,
    slot: &Slot<Picture>,
    clock: &LiveClock,
    shared: &Shared,
    news: &SyncSender<String>,
) -> u64 {
    let mut pictures = 0;
    while !shared.is_ending() {
        match camera.next(clock) {
            Taken::Picture(picture) => {
                pictures += 1;
                slot.put(picture);
            }
            Taken::Nothing => {}
            Taken::End => break,
        }
        if let Some(line) = camera.news() {
            // What does not fit is not told.
            let _told = news.try_send(line);
        }
    }
    pictures
}
