//! The robot of a simulated cell: drives along the taught line, asks for a correction each cycle, executes it late.

use std::collections::VecDeque;
use std::net::UdpSocket;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::report::stop_in_words;
use super::wire::{Move, Read, Wire};
use super::{Cell, CellReport, CellSettings, TroubleKind};
use crate::live::{State, Why};

/// The torch is judged from so far behind the first correction \[mm\]. Chosen.
const SETTLED_MM: f64 = 10.0;
/// How long a stop is answered before it is reset or the weld ends \[s\]. Chosen.
const STOPPED_S: f64 = 0.5;
/// A robot that knows no states stops after such a silence \[s\]: the default of EGM's `\\CommTimeout`.
const SILENT_S: f64 = 1.0;
/// Most places that are remembered with their time: all troubles are looked up in them.
const PASSED: usize = 8;

/// Where the torch is, and when it passed the places of the troubles.
#[derive(Debug, Clone, Copy, Default)]
pub struct Motion {
    pub at_s: f64,
    pub path_mm: f64,
    pub lateral_mm: f64,
    pub speed_mm_s: f64,
    passed: [Option<(f64, f64)>; PASSED],
}

impl Motion {
    /// The torch at a time a moment later.
    pub fn at(&self, now_s: f64) -> (f64, f64) {
        (self.path_mm + self.speed_mm_s * (now_s - self.at_s).max(0.0), self.lateral_mm)
    }

    /// For how long a place of a trouble has been passed \[s\].
    pub fn passed_s(&self, place_mm: f64, now_s: f64) -> Option<f64> {
        let found = self.passed.iter().flatten().find(|(at_mm, _)| *at_mm == place_mm);
        found.map(|(_, at_s)| now_s - at_s)
    }

    fn pass(&mut self, settings: &CellSettings) {
        for trouble in &settings.troubles {
            let is_new = self.passed.iter().flatten().all(|(at_mm, _)| *at_mm != trouble.at_mm);
            if self.path_mm >= trouble.at_mm
                && is_new
                && let Some(free) = self.passed.iter_mut().find(|place| place.is_none())
            {
                *free = Some((trouble.at_mm, self.at_s));
            }
        }
    }
}

/// The robot's end of the wire.
pub struct Arm {
    socket: UdpSocket,
    wire: Wire,
    ordered: VecDeque<(f64, Move)>,
    /// The offset that was ordered last \[mm\].
    ordered_mm: f64,
    /// When the last answer came.
    heard_s: f64,
    report: CellReport,
    late_run: u64,
    judged_from_mm: Option<f64>,
    stopped_s: Option<f64>,
    resets: u32,
    /// Whether the sensor is asked to begin anew.
    begins: bool,
}

impl Arm {
    pub fn open(settings: &CellSettings) -> std::io::Result<Self> {
        let any = if settings.corrections.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
        let socket = UdpSocket::bind(any)?;
        socket.connect(settings.corrections)?;
        Ok(Self {
            socket,
            wire: Wire::new(settings),
            ordered: VecDeque::new(),
            ordered_mm: 0.0,
            heard_s: 0.0,
            report: CellReport::default(),
            late_run: 0,
            judged_from_mm: None,
            stopped_s: None,
            resets: settings.resets,
            begins: true,
        })
    }

    /// Drives to the end of the weld, or to a stop that nobody resets.
    pub fn weld(mut self, cell: &Cell<'_>) -> std::io::Result<CellReport> {
        let settings = cell.settings;
        let mut motion = Motion { at_s: cell.now_s(), ..Motion::default() };
        let mut next_s = motion.at_s;
        self.heard_s = motion.at_s;
        while motion.path_mm < settings.length_mm && !cell.ends.load(Ordering::Relaxed) {
            next_s = (next_s + settings.cycle_s).max(cell.now_s() - settings.cycle_s);
            cell.sleep_until(next_s);
            let now_s = cell.now_s();
            let since_s = now_s - motion.at_s;
            while self.ordered.front().is_some_and(|(at_s, _)| *at_s <= now_s) {
                match self.ordered.pop_front().map(|(_, what)| what) {
                    Some(Move::Step(step_mm)) => motion.lateral_mm += step_mm,
                    Some(Move::Offset(offset_mm)) => motion.lateral_mm = offset_mm,
                    Some(Move::Hold) | None => {}
                }
            }
            motion.path_mm += motion.speed_mm_s * since_s;
            motion.at_s = now_s;
            motion.speed_mm_s = if self.stopped_s.is_some() { 0.0 } else { settings.speed_mm_s };
            motion.pass(settings);
            *cell.motion.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = motion;
            self.judge(cell, &motion);
            self.report.cycles += 1;
            self.wire.tick(now_s);
            if cell.is_on(TroubleKind::Cut, now_s, &motion) {
                continue;
            }
            let message = self.wire.message(&motion, self.report.late, self.begins);
            let asked = Instant::now();
            let answer = self.ask(&message, Duration::from_secs_f64(settings.cycle_s));
            match answer {
                None => {
                    self.late_run += 1;
                    self.report.late += 1;
                    self.report.longest_late = self.report.longest_late.max(self.late_run);
                    if self.wire.stops_by_silence() && now_s - self.heard_s > SILENT_S && self.stop(None, &motion) {
                        break;
                    }
                }
                Some(read) => {
                    (self.late_run, self.begins, self.heard_s) = (0, false, now_s);
                    self.report.answer_ms.push(asked.elapsed().as_secs_f64() * 1e3);
                    self.take_move(read.moves, now_s + settings.delay_s);
                    if self.take_state(&read, &motion) {
                        break;
                    }
                }
            }
        }
        self.report.reached_mm = motion.path_mm;
        Ok(self.report)
    }

    fn take_move(&mut self, moves: Move, at_s: f64) {
        let step_mm = match moves {
            Move::Step(step_mm) => step_mm,
            Move::Offset(offset_mm) => offset_mm - std::mem::replace(&mut self.ordered_mm, offset_mm),
            Move::Hold => {
                self.report.holds += 1;
                return;
            }
        };
        self.report.corrections += 1;
        self.report.largest_step_mm = self.report.largest_step_mm.max(step_mm.abs());
        self.ordered.push_back((at_s, moves));
    }

    /// Counts the state; whether the weld is over.
    fn take_state(&mut self, read: &Read, motion: &Motion) -> bool {
        let state = State::ALL.into_iter().find(|state| Some(state.code()) == read.state);
        if let Some(count) = state.and_then(|state| self.report.by_state.get_mut(usize::from(state.code()))) {
            *count += 1;
        }
        // Without states a correction says that the seam is seen.
        if state == Some(State::Ok) || (state.is_none() && read.moves != Move::Hold) {
            self.judged_from_mm.get_or_insert(motion.path_mm + SETTLED_MM);
        }
        if state != Some(State::Stop) {
            self.stopped_s = None;
            return false;
        }
        self.stop(read.why.and_then(Why::of_code), motion)
    }

    /// The sensor gave up; whether the weld is over.
    fn stop(&mut self, why: Option<Why>, motion: &Motion) -> bool {
        if self.stopped_s.is_none() {
            self.report.stops.push(stop_in_words(why, motion.path_mm));
        }
        let since_s = *self.stopped_s.get_or_insert(motion.at_s);
        if motion.at_s - since_s < STOPPED_S {
            return false;
        }
        if self.resets == 0 {
            return true;
        }
        self.resets -= 1;
        // Offsets are counted from where the torch stands when the sensor begins anew.
        self.wire.begin_at(motion.lateral_mm);
        (self.ordered_mm, self.heard_s) = (motion.lateral_mm, motion.at_s);
        (self.begins, self.stopped_s, self.judged_from_mm) = (true, None, None);
        false
    }

    fn judge(&mut self, cell: &Cell<'_>, motion: &Motion) {
        if self.judged_from_mm.is_some_and(|from_mm| motion.path_mm >= from_mm) && self.stopped_s.is_none() {
            let seam_mm = cell.seam.lateral_mm(motion.path_mm);
            self.report.torch.push(motion.lateral_mm - seam_mm);
            self.report.uncorrected.push(seam_mm);
        }
    }

    /// Asks and waits for the answer of this cycle; those of earlier ones are thrown away.
    fn ask(&self, message: &[u8], cycle: Duration) -> Option<Read> {
        let began = Instant::now();
        // Nobody there yet: that is a late packet.
        self.socket.send(message).ok()?;
        let mut buffer = [0; 2048];
        loop {
            let left = cycle.checked_sub(began.elapsed()).filter(|left| !left.is_zero())?;
            self.socket.set_read_timeout(Some(left)).ok()?;
            let length = self.socket.recv(&mut buffer).ok()?;
            if let Some(read) = self.wire.answer(&buffer[..length]) {
                return Some(read);
            }
        }
    }
}
