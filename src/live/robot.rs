//! The robot's thread: cycles in, answers out. It waits for nobody but the robot.

use std::io::ErrorKind;
use std::net::UdpSocket;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU16, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::{Duration, Instant};

use super::camera::LiveClock;
use super::config::RobotConfig;
use super::guide::{Answer, Guide, Sighting};
use super::poses::Pose;
use super::spread::Spread;
use super::stamps::StampMap;
use super::wire::{Command, Heard, Wire};
use super::{State, Why};

/// Longest that the robot is waited for before somebody looks whether the run is to end. Chosen.
const WAIT: Duration = Duration::from_millis(50);
/// Longest message that is read \[bytes\]. Chosen: RSI's and EGM's are some hundred.
const LONGEST_MESSAGE: usize = 4096;

/// What all threads of a run share.
#[derive(Debug, Default)]
pub struct Shared {
    /// The run is to end.
    pub ends: AtomicBool,
    /// What the robot was told last. Whoever reads it holds it for the time of a copy; the robot's thread never waits for it.
    told: Mutex<Option<Told>>,
    /// What a PLC asks for.
    pub orders: Orders,
}

/// The last answer to the robot.
#[derive(Debug, Clone, Copy)]
pub struct Told {
    /// The answer.
    pub answer: Answer,
    /// Number of the cycle: a heartbeat.
    pub cycle: u64,
    /// Packets that came late, so far.
    #[cfg(feature = "page")]
    pub late: u64,
}

/// What a PLC asks for: registers that it writes.
#[derive(Debug, Default)]
pub struct Orders {
    /// A [`Command`]; acts when it changes.
    command: AtomicU16,
    /// Its heartbeat, and when it changed last, by the run's clock \[ms\].
    heartbeat: AtomicU16,
    heard_ms: AtomicU64,
    /// The torch's speed \[0.01 mm/s\]; 0: the configured one.
    speed: AtomicU16,
    /// A [`Command`] from the page; acts once.
    asked: AtomicU16,
}

impl Orders {
    /// What was written, by register.
    pub fn written(&self) -> [u16; 3] {
        [&self.command, &self.heartbeat, &self.speed].map(|register| register.load(Ordering::Relaxed))
    }

    /// Takes what a PLC writes into register 0, 1 or 2.
    pub fn write(&self, register: u16, value: u16, now_s: f64) {
        match register {
            0 => self.command.store(value, Ordering::Relaxed),
            1 if self.heartbeat.swap(value, Ordering::Relaxed) != value => {
                self.heard_ms.store((now_s * 1e3) as u64, Ordering::Relaxed);
            }
            2 => self.speed.store(value, Ordering::Relaxed),
            _ => {}
        }
    }

    /// Asks for a reset or a stop, once.
    #[cfg(feature = "page")]
    pub fn ask(&self, command: Command) {
        self.asked.store(command.code(), Ordering::Relaxed);
    }

    fn silent_s(&self, now_s: f64) -> f64 {
        now_s - self.heard_ms.load(Ordering::Relaxed) as f64 * 1e-3
    }
}

impl Shared {
    /// Whether the run is to end.
    pub fn is_ending(&self) -> bool {
        self.ends.load(Ordering::Relaxed)
    }

    /// What the robot was told last.
    pub fn last(&self) -> Option<Told> {
        *self.told.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// What the robot's thread counted.
#[derive(Debug, Clone, Default)]
pub struct RobotCounts {
    /// Cycles by state, by its number.
    pub by_state: [u64; State::ALL.len()],
    /// From a message's arrival to its answer \[ms\].
    pub work_ms: Spread,
    /// Messages that were not understood.
    pub not_understood: u64,
    /// Messages with the stamp of the one before, or an older one: answered with a hold.
    pub not_new: u64,
    /// Packets that came late: as the robot counts them (RSI); that never came, or were overtaken before we read them (EGM).
    pub late: u64,
    /// Sightings without a pose.
    pub unpaired: u64,
    /// Why it was given up first, if it was.
    pub stopped: Option<Why>,
}

/// The guide at work.
pub struct Leader<'a> {
    /// What decides.
    pub guide: Guide,
    /// What the tracker sees.
    pub sightings: Receiver<Sighting>,
    /// What others look at.
    pub shared: &'a Shared,
    /// The run's clock.
    pub clock: LiveClock,
    /// Told when the state changes; what does not fit is not told.
    pub news: SyncSender<String>,
    /// What was counted.
    pub counts: RobotCounts,
    plc_silent_s: Option<f64>,
    ordered: Command,
    cycle: u64,
    last: Option<(State, Why)>,
}

impl<'a> Leader<'a> {
    /// Before the first cycle.
    pub fn new(
        guide: Guide,
        sightings: Receiver<Sighting>,
        (shared, clock): (&'a Shared, LiveClock),
        news: SyncSender<String>,
        plc_silent_s: Option<f64>,
    ) -> Self {
        let (counts, ordered) = (RobotCounts::default(), Command::Nothing);
        Self { guide, sightings, shared, clock, news, counts, plc_silent_s, ordered, cycle: 0, last: None }
    }

    /// Does what a PLC or the page asks for; whether all was forgotten.
    fn obey(&mut self, now_s: f64) -> bool {
        if self.plc_silent_s.is_some_and(|limit_s| self.shared.orders.silent_s(now_s) > limit_s) {
            self.guide.stop(Why::PlcSilent);
        }
        let by_page = self.carry_out(Command::of(self.shared.orders.asked.swap(0, Ordering::Relaxed)));
        let asked = Command::of(self.shared.orders.written()[0]);
        let by_plc = std::mem::replace(&mut self.ordered, asked) != asked && self.carry_out(asked);
        by_page || by_plc
    }

    /// Whether all was forgotten.
    fn carry_out(&mut self, command: Command) -> bool {
        match command {
            Command::Reset => self.guide.reset(),
            Command::Stop => self.guide.stop(Why::Asked),
            Command::Nothing => {}
        }
        command == Command::Reset
    }

    fn see(&mut self) {
        while let Ok(sighting) = self.sightings.try_recv() {
            self.guide.see(&sighting);
        }
    }

    fn tell(&mut self, answer: &Answer) {
        self.counts.by_state[usize::from(answer.state.code())] += 1;
        self.counts.unpaired = self.guide.unpaired();
        if answer.state == State::Stop {
            self.counts.stopped.get_or_insert(answer.why);
        }
        self.cycle += 1;
        if let Ok(mut told) = self.shared.told.try_lock() {
            *told = Some(Told {
                answer: *answer,
                cycle: self.cycle,
                #[cfg(feature = "page")]
                late: self.counts.late,
            });
        }
        let now = (answer.state, answer.why);
        if self.last.replace(now) != Some(now) {
            let place_mm = answer.pose.path_mm;
            let _told = self.news.try_send(format!("{} ({}) at {place_mm:.1} mm", now.0.name(), now.1.name()));
        }
    }

    /// Without a robot: cycles by the clock, at the configured speed.
    pub fn lead_by_speed(&mut self, config: &RobotConfig) {
        let cycle = Duration::from_secs_f64(config.cycle_s);
        let mut next = Instant::now();
        while !self.shared.is_ending() {
            next = (next + cycle).max(Instant::now());
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
            self.see();
            let began = Instant::now();
            let now_s = self.clock.now_s();
            self.obey(now_s);
            let ordered_mm_s = f64::from(self.shared.orders.written()[2]) * 0.01;
            let speed_mm_s = if ordered_mm_s > 0.0 { ordered_mm_s } else { config.speed_mm_s };
            let answer = self.guide.cycle_at_speed(now_s, speed_mm_s);
            self.counts.work_ms.push(began.elapsed().as_secs_f64() * 1e3);
            self.tell(&answer);
        }
    }

    /// Answers a robot until the run ends.
    ///
    /// # Errors
    /// When the socket fails for another reason than time.
    pub fn answer(&mut self, socket: &UdpSocket, wire: &mut dyn Wire, config: &RobotConfig) -> std::io::Result<()> {
        socket.set_read_timeout(Some(WAIT))?;
        let (mut buffer, mut bytes) = ([0; LONGEST_MESSAGE], Vec::with_capacity(512));
        let mut seam = Seam::default();
        let mut overtaken = 0;
        while !self.shared.is_ending() {
            let (length, from) = match socket.recv_from(&mut buffer) {
                Ok(received) => received,
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                        self.see();
                        continue;
                    }
                    // A robot that closed its port; it may come back.
                    ErrorKind::Interrupted | ErrorKind::ConnectionRefused | ErrorKind::ConnectionReset => continue,
                    _ => return Err(error),
                },
            };
            let (began, now_s) = (Instant::now(), self.clock.now_s());
            let Some(heard) = wire.read(&buffer[..length]) else {
                self.counts.not_understood += 1;
                continue;
            };
            self.counts.late = self.counts.late.max(heard.late + overtaken);
            if self.obey_robot(&heard, &mut seam, now_s) {
                seam = Seam { command: seam.command, ..Seam::default() };
            }
            if wire.answers_newest_only() && is_another_waiting(socket)? {
                overtaken += 1;
                continue;
            }
            self.see();
            let answer = self.answer_to(&heard, &mut seam, now_s, config);
            if wire.write(&mut bytes, &answer) {
                // What cannot be sent is a late packet for the robot, which counts it.
                let _sent = socket.send_to(&bytes, from);
            }
            self.counts.work_ms.push(began.elapsed().as_secs_f64() * 1e3);
            self.tell(&answer);
        }
        Ok(())
    }

    /// Does what PLC, page and robot ask for; whether all was forgotten.
    fn obey_robot(&mut self, heard: &Heard, seam: &mut Seam, now_s: f64) -> bool {
        let is_reset = self.obey(now_s);
        match heard.command {
            Some(asked) if std::mem::replace(&mut seam.command, asked) != asked => self.carry_out(asked) || is_reset,
            _ => is_reset,
        }
    }

    fn answer_to(&mut self, heard: &Heard, seam: &mut Seam, now_s: f64, config: &RobotConfig) -> Answer {
        match seam.last {
            // A stamp that does not go on is a robot that stands: it gets no step for it.
            Some((before_ms, answer)) if heard.stamp_ms <= before_ms => {
                self.counts.not_new += 1;
                Answer { correction: super::Correction::Hold, ..answer }
            }
            _ => {
                let start_mm = *seam.start_mm.get_or_insert(heard.tool_mm);
                // The robot's stamp counts milliseconds: so poses that come in a heap keep their distance in time.
                let posed_s = seam.stamps.map(heard.stamp_ms as f64 * 1e-3, now_s);
                let answer = self.guide.cycle_posed(now_s, posed_s, pose(heard.tool_mm, start_mm, config));
                seam.last = Some((heard.stamp_ms, answer));
                answer
            }
        }
    }
}

/// What is remembered of the robot from message to message, until the next seam.
struct Seam {
    start_mm: Option<[f64; 3]>,
    last: Option<(u64, Answer)>,
    stamps: StampMap,
    command: Command,
}

impl Default for Seam {
    fn default() -> Self {
        Self { start_mm: None, last: None, stamps: StampMap::default(), command: Command::Nothing }
    }
}

/// Whether a message can be read at once.
fn is_another_waiting(socket: &UdpSocket) -> std::io::Result<bool> {
    socket.set_nonblocking(true)?;
    let is_waiting = socket.peek(&mut [0; 1]).is_ok();
    socket.set_nonblocking(false)?;
    Ok(is_waiting)
}

/// Along and across the travel, from the start.
fn pose(tool_mm: [f64; 3], start_mm: [f64; 3], config: &RobotConfig) -> Pose {
    let along = |axis: [f64; 3]| (0..3).map(|i| axis[i] * (tool_mm[i] - start_mm[i])).sum();
    Pose { path_mm: along(config.travel), lateral_mm: along(config.lateral) }
}
