//! When a correction may be sent, by distance and by age, and when the seam must be given up.

use super::GuideSettings;
use super::ring::Reach;

/// What the guide does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The torch has not reached the seam's start. No corrections.
    Wait,
    /// The seam at the torch was seen. Corrections.
    Ok,
    /// Not seen here but bridged between two places: corrections. Or a value has been missing for a short way, or the camera
    /// for a short time.
    Coast,
    /// Neither. No corrections; the robot keeps its line.
    Lost,
    /// Given up until [`reset`](super::Guide::reset).
    Stop,
    /// The seam's stated length is done. No corrections.
    Done,
}

impl State {
    /// Its name in logs and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wait => "WAIT",
            Self::Ok => "OK",
            Self::Coast => "COAST",
            Self::Lost => "LOST",
            Self::Stop => "STOP",
            Self::Done => "DONE",
        }
    }

    /// Its number on the wire: part of the contract with robots, never changed.
    #[must_use]
    pub const fn code(self) -> u16 {
        match self {
            Self::Wait => 0,
            Self::Ok => 1,
            Self::Coast => 2,
            Self::Lost => 3,
            Self::Stop => 4,
            Self::Done => 5,
        }
    }

    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 6] = [Self::Wait, Self::Ok, Self::Coast, Self::Lost, Self::Stop, Self::Done];

    const fn badness(self) -> u8 {
        match self {
            Self::Wait | Self::Ok | Self::Done => 0,
            Self::Coast => 1,
            Self::Lost => 2,
            Self::Stop => 3,
        }
    }

    /// The worse of two.
    const fn or_worse(self, other: (Self, Why), why: Why) -> (Self, Why) {
        if other.0.badness() > self.badness() { other } else { (self, why) }
    }
}

/// Why it does so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// Nothing is amiss.
    Fine,
    /// The seam's start is not reached.
    BeforeStart,
    /// Between two places where the seam was seen, as over a tack weld.
    Bridging,
    /// The seam was not seen here, or too long ago.
    SeamUnseen,
    /// No new picture, or none of this place.
    CameraSilent,
    /// No seam within the way from the start.
    NotFound,
    /// The robot did not ask for too long: it went on without us, or we were stopped.
    RobotSilent,
    /// The robot's pose is no number, or its time went back.
    BadPose,
    /// The seam lies further away than corrections may reach.
    OutOfReach,
    /// Somebody asked for it.
    Asked,
    /// The seam's length is done.
    EndOfSeam,
    /// The PLC's heartbeat stands.
    PlcSilent,
}

impl Why {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 12] = [
        Self::Fine,
        Self::BeforeStart,
        Self::Bridging,
        Self::SeamUnseen,
        Self::CameraSilent,
        Self::NotFound,
        Self::RobotSilent,
        Self::BadPose,
        Self::OutOfReach,
        Self::Asked,
        Self::EndOfSeam,
        Self::PlcSilent,
    ];

    /// The one of a number on the wire.
    #[must_use]
    pub fn of_code(code: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|why| why.code() == code)
    }

    /// Its name in logs and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::BeforeStart => "before-start",
            Self::Bridging => "bridging",
            Self::SeamUnseen => "seam-unseen",
            Self::CameraSilent => "camera-silent",
            Self::NotFound => "not-found",
            Self::RobotSilent => "robot-silent",
            Self::BadPose => "bad-pose",
            Self::OutOfReach => "out-of-reach",
            Self::Asked => "asked",
            Self::EndOfSeam => "end-of-seam",
            Self::PlcSilent => "plc-silent",
        }
    }

    /// Its number on the wire: part of the contract with robots, never changed.
    #[must_use]
    pub const fn code(self) -> u16 {
        match self {
            Self::Fine => 0,
            Self::BeforeStart => 1,
            Self::Bridging => 2,
            Self::SeamUnseen => 3,
            Self::CameraSilent => 4,
            Self::NotFound => 5,
            Self::RobotSilent => 6,
            Self::BadPose => 7,
            Self::OutOfReach => 8,
            Self::Asked => 9,
            Self::EndOfSeam => 10,
            Self::PlcSilent => 11,
        }
    }
}

/// Decides from cycle to cycle. [`State::Stop`] is latched.
#[derive(Debug, Clone, Default)]
pub struct Guard {
    stopped: Option<Why>,
    /// Where the seam began \[mm\], once the torch got there.
    began_mm: Option<f64>,
    /// Where the last value was, or the torch started \[mm\].
    value_at_mm: Option<f64>,
    done: bool,
}

impl Guard {
    /// Gives up, unless it was given up before.
    pub fn stop(&mut self, why: Why) {
        self.stopped.get_or_insert(why);
    }

    /// Whether and why it was given up.
    #[must_use]
    pub const fn stopped(&self) -> Option<Why> {
        self.stopped
    }

    /// What may be done at `path_mm`, where the ring knows `reach`, `age_s` after the newest picture.
    pub fn judge(&mut self, path_mm: f64, reach: Reach, age_s: f64, settings: &GuideSettings) -> (State, Why) {
        if self.stopped.is_none() {
            let (state, why) = self.judged(path_mm, reach, age_s, settings);
            if state != State::Stop {
                return (state, why);
            }
            self.stop(why);
        }
        (State::Stop, self.stopped.unwrap_or(Why::Asked))
    }

    fn judged(&mut self, path_mm: f64, reach: Reach, age_s: f64, settings: &GuideSettings) -> (State, Why) {
        if self.done {
            return (State::Done, Why::EndOfSeam);
        }
        let has_value = matches!(reach, Reach::Seen(_) | Reach::Bridged(_));
        if has_value {
            self.began_mm.get_or_insert(path_mm);
        }
        let unseen_mm = match self.value_at_mm {
            Some(at_mm) if !has_value => (path_mm - at_mm).abs(),
            _ => {
                self.value_at_mm = Some(path_mm);
                0.0
            }
        };
        let silent = |state| (state, Why::CameraSilent);
        let by_age = match age_s {
            age_s if age_s <= settings.fresh_s => (State::Ok, Why::Fine),
            age_s if age_s <= settings.coast_s => silent(State::Coast),
            age_s if age_s <= settings.stop_s => silent(State::Lost),
            _ => silent(State::Stop),
        };
        let Some(began_mm) = self.began_mm else {
            return match reach {
                _ if by_age.0 == State::Stop => by_age,
                Reach::Unknown | Reach::Unlooked if unseen_mm > settings.ahead_mm + settings.start_mm => {
                    (State::Stop, Why::NotFound)
                }
                _ => (State::Wait, Why::BeforeStart),
            };
        };
        if settings.seam_mm.is_some_and(|seam_mm| path_mm - began_mm >= seam_mm) {
            self.done = true;
            return (State::Done, Why::EndOfSeam);
        }
        // What no picture shows is the camera's silence, however far the torch went: the seam may well be there.
        let why = if reach == Reach::Unlooked { Why::CameraSilent } else { Why::SeamUnseen };
        let unseen = |state| (state, why);
        let (state, why) = match reach {
            Reach::Seen(_) => (State::Ok, Why::Fine),
            Reach::Bridged(_) => (State::Coast, Why::Bridging),
            _ if unseen_mm <= settings.coast_mm => unseen(State::Coast),
            _ if unseen_mm <= settings.stop_mm => unseen(State::Lost),
            _ => unseen(State::Stop),
        };
        state.or_worse(by_age, why)
    }
}
