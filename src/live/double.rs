//! A GigE Vision camera that is not there: a recording or a made-up scene, sent as a real one sends it, with packets lost on
//! purpose, stalls and deaths. For tests, demonstrations, and to try a network before the camera is bought.
//!
//! | file | what it does |
//! |---|---|
//! | `registers` | the memory and its description in GenICam's XML |
//! | `control` | GVCP: registers, who has the camera, packets again |
//! | `stream` | GVSP: pictures in packets |
//! | `reel` | what is shown, again and again |
//! | here | threads, troubles, report |
//!
//! The standard library is enough. It answers what clients ask for in fact (tried with aravis), not all of the specification.

mod control;
mod reel;
mod registers;
mod stream;

use std::fmt;
use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::frame::GrayFrame;
use crate::source::SourceError;
use crate::synth::ScenarioError;
use control::{Control, Task};
use reel::Reel;
use registers::{PACKET_SIZE, PERIOD_US, Registers};
use stream::{Sent, packets};

/// GVCP's port.
const PORT: u16 = 3956;
/// How often somebody looks whether the run is to end. Chosen.
const WAIT: Duration = Duration::from_millis(50);
/// How often an idle camera looks whether it is to run. Chosen.
const IDLE: Duration = Duration::from_millis(2);
/// How long a byte takes on the wire \[ns\], 1 Gb/s, and bytes that are sent at once: all at once would overflow a receiver.
const BYTE_NS: u64 = 8;
const AT_ONCE: u64 = 1 << 15;
/// Shortest period that is believed \[µs\]. Chosen: 1000 pictures a second.
const LEAST_PERIOD_US: u32 = 1000;

/// What a double is.
#[derive(Debug, Clone)]
pub struct DoubleSettings {
    /// What it shows, again and again: `file:PATH` or `scene:NAME`.
    pub shows: String,
    /// The address it has: one of this machine's.
    pub address: Ipv4Addr,
    /// Pictures a second, until a client sets them otherwise.
    pub frames_per_s: f64,
    /// Share of the packets that are lost, 0 to 1; also of those that are sent again.
    pub lost_share: f64,
    /// Seed of what is lost.
    pub seed: u64,
    /// What goes wrong.
    pub faults: Vec<Fault>,
}

/// Something that goes wrong, counted from the first picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// Whether all is gone, or only the pictures.
    pub is_death: bool,
    /// When \[s\].
    pub at_s: f64,
    /// For how long \[s\].
    pub for_s: f64,
}

impl FromStr for Fault {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
        let parts = text.split_once('@').and_then(|(kind, rest)| Some((kind, rest.split_once(':')?)));
        let parsed = parts.and_then(|(kind, (at_s, for_s))| {
            let is_death = match kind {
                "dead" => true,
                "stall" => false,
                _ => return None,
            };
            Some(Self { is_death, at_s: number(at_s)?, for_s: number(for_s)? })
        });
        parsed.ok_or_else(|| "expected stall or dead, when [s] and how long [s], such as dead@5:2".into())
    }
}

/// A double that cannot be.
#[derive(Debug, thiserror::Error)]
pub enum DoubleError {
    /// What it shows is none that is known.
    #[error("what to show is file:PATH or scene:NAME, not {0:?}")]
    Shows(String),
    /// There is nothing to show.
    #[error("{0} has no picture that can be read")]
    Empty(String),
    /// The recording cannot be opened.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// There is no such scene.
    #[error(transparent)]
    Scene(#[from] ScenarioError),
    /// A port cannot be used.
    #[error(
        "the port {address} cannot be used: is it an address of this machine, and is no other camera double on it?"
    )]
    Port {
        /// The address.
        address: SocketAddr,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A part of the program failed, which is a fault of it.
    #[error("the control thread ended by itself: this is a fault of seamtrack, please report it")]
    Thread,
}

/// What a double did.
#[derive(Debug, Clone, Copy, Default)]
pub struct DoubleReport {
    /// Pictures sent.
    pub pictures: u64,
    /// Packets of them.
    pub packets: u64,
    /// Packets lost on purpose, those sent again included.
    pub lost: u64,
    /// Packets sent again.
    pub again: u64,
    /// Pictures left out, since the one before was not sent in time.
    pub skipped: u64,
    /// How often it died.
    pub deaths: u64,
}

impl fmt::Display for DoubleReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pictures, packets, lost, again, skipped, deaths } = self;
        writeln!(f, "pictures: {pictures} sent, {skipped} skipped")?;
        writeln!(f, "packets: {packets}, lost on purpose {lost}, sent again {again}")?;
        writeln!(f, "deaths: {deaths}")
    }
}

/// What both threads share.
struct Double<'a> {
    settings: &'a DoubleSettings,
    ends: &'a AtomicBool,
    done: AtomicBool,
    control: Mutex<Control>,
    sent: Mutex<Sent>,
    lossy: Mutex<(Pcg64Mcg, DoubleReport)>,
    is_dead: AtomicBool,
    out: UdpSocket,
}

/// Runs until `ends` is set.
///
/// # Errors
/// When there is nothing to show, or a port cannot be used.
pub fn run(settings: &DoubleSettings, ends: &AtomicBool) -> Result<DoubleReport, DoubleError> {
    let mut reel = Reel::open(&settings.shows)?;
    let first = reel.next().ok_or_else(|| DoubleError::Empty(settings.shows.clone()))?;
    let port = |address: SocketAddr| move |source| DoubleError::Port { address, source };
    let (listen, any) = (SocketAddr::from((settings.address, PORT)), SocketAddr::from((settings.address, 0)));
    let socket = UdpSocket::bind(listen).map_err(port(listen))?;
    socket.set_read_timeout(Some(WAIT)).map_err(port(listen))?;
    let out = UdpSocket::bind(any).map_err(port(any))?;
    let double = Double {
        settings,
        ends,
        done: AtomicBool::new(false),
        control: Mutex::new(Control::new(powered_on(settings, &first))),
        sent: Mutex::default(),
        lossy: Mutex::new((Pcg64Mcg::seed_from_u64(settings.seed), DoubleReport::default())),
        is_dead: AtomicBool::new(false),
        out,
    };
    std::thread::scope(|scope| {
        let control = scope.spawn(|| double.listen(&socket));
        double.show(&mut reel, first);
        double.done.store(true, Ordering::Relaxed);
        control.join().map_err(|_| DoubleError::Thread)?.map_err(port(listen))
    })?;
    let report = lock(&double.lossy).1;
    Ok(report)
}

fn powered_on(settings: &DoubleSettings, picture: &GrayFrame) -> Registers {
    let period_us = (1e6 / settings.frames_per_s).round() as u32;
    Registers::new(picture.width_px() as u32, picture.height_px() as u32, period_us, settings.address)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Double<'_> {
    fn is_ending(&self) -> bool {
        self.done.load(Ordering::Relaxed) || self.ends.load(Ordering::Relaxed)
    }

    /// The control channel.
    fn listen(&self, socket: &UdpSocket) -> std::io::Result<()> {
        let mut buffer = [0; 2048];
        while !self.is_ending() {
            let (length, from) = match socket.recv_from(&mut buffer) {
                Ok(received) => received,
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => continue,
                    // A client that closed its port.
                    ErrorKind::ConnectionRefused | ErrorKind::ConnectionReset => continue,
                    _ => return Err(error),
                },
            };
            if self.is_dead.load(Ordering::Relaxed) {
                continue;
            }
            let (answer, task, to) = {
                let mut control = lock(&self.control);
                let (answer, task) = control.answer(&buffer[..length], from);
                (
                    answer,
                    task,
                    if matches!(task, Task::Trial(_)) { Some(control.trial_to()) } else { control.stream_to() },
                )
            };
            if let Some(answer) = answer {
                // Who is gone is not answered.
                let _sent = socket.send_to(&answer, from);
            }
            match (task, to) {
                (Task::Trial(size), Some(to)) => drop(self.out.send_to(&vec![0; size], to)),
                (Task::Resend { block, first, last }, Some(to)) => {
                    let sent = lock(&self.sent);
                    for packet in sent.again(block, first, last) {
                        lock(&self.lossy).1.again += 1;
                        self.send(packet, to);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Sends a packet, if it is not to be lost.
    fn send(&self, packet: &[u8], to: SocketAddr) {
        let is_lost = {
            let (random, report) = &mut *lock(&self.lossy);
            let is_lost = random.random::<f64>() < self.settings.lost_share;
            report.lost += u64::from(is_lost);
            is_lost
        };
        if !is_lost {
            // A network that does not take it loses it too.
            let _sent = self.out.send_to(packet, to);
        }
    }

    /// Sends a picture's packets as quickly as a wire of 1 Gb/s would take them.
    fn send_all(&self, packets: &[Vec<u8>], to: SocketAddr) {
        let (began, mut sent, mut waited) = (Instant::now(), 0, 0);
        for packet in packets {
            self.send(packet, to);
            sent += packet.len() as u64;
            if sent - waited >= AT_ONCE {
                waited = sent;
                let due = began + Duration::from_nanos(sent * BYTE_NS);
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
            }
        }
    }

    /// The pictures.
    fn show(&self, reel: &mut Reel, first: GrayFrame) {
        let (mut picture, mut block, mut began) = (first, 0_u16, None::<Instant>);
        let mut next = Instant::now();
        while !self.is_ending() {
            let since_s = began.map_or(-1.0, |began| began.elapsed().as_secs_f64());
            let is_on = |fault: &&Fault| (fault.at_s..fault.at_s + fault.for_s).contains(&since_s);
            let fault = self.settings.faults.iter().find(is_on);
            self.live_or_die(fault.is_some_and(|fault| fault.is_death), &picture);
            let (to, period_us, size) = {
                let mut control = lock(&self.control);
                control.watch_heartbeat();
                let size = control.registers.get(PACKET_SIZE) & 0xffff;
                (control.stream_to(), control.registers.get(PERIOD_US).max(LEAST_PERIOD_US), size)
            };
            let (Some(to), None) = (to, fault) else {
                std::thread::sleep(IDLE);
                next = Instant::now();
                continue;
            };
            let period = Duration::from_micros(period_us.into());
            next += period;
            let behind = next.elapsed().as_micros() / period.as_micros();
            if behind > 0 {
                lock(&self.lossy).1.skipped += behind as u64;
                next = Instant::now();
            }
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
            began.get_or_insert_with(Instant::now);
            // Blocks are numbered from 1 to 65 535.
            block = block.wrapping_add(1).max(1);
            let all = packets(block, lock(&self.control).clock_ns(), size as usize, &picture);
            self.send_all(&all, to);
            {
                let report = &mut lock(&self.lossy).1;
                report.pictures += 1;
                report.packets += all.len() as u64;
            }
            lock(&self.sent).push(block, all);
            // A recording that cannot be read any more stands still.
            picture = reel.next().unwrap_or(picture);
        }
    }

    /// After a death everything begins anew: registers, clock, who has the camera.
    fn live_or_die(&self, is_dead: bool, picture: &GrayFrame) {
        let was_dead = self.is_dead.swap(is_dead, Ordering::Relaxed);
        if is_dead && !was_dead {
            lock(&self.lossy).1.deaths += 1;
            *lock(&self.control) = Control::new(powered_on(self.settings, picture));
            lock(&self.sent).clear();
        }
        if was_dead && !is_dead {
            *lock(&self.control) = Control::new(powered_on(self.settings, picture));
        }
    }
}
