//! What every robot's protocol gives and takes, so that one loop answers all of them.

use super::guide::Answer;

/// What a robot's program may ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// 0: nothing.
    Nothing,
    /// 1: forget all, a stop too: the next seam begins.
    Reset,
    /// 2: give up.
    Stop,
}

impl Command {
    /// By its number on the wire; others are nothing.
    #[must_use]
    pub const fn of(code: u16) -> Self {
        match code {
            1 => Self::Reset,
            2 => Self::Stop,
            _ => Self::Nothing,
        }
    }

    /// Its number on the wire.
    #[cfg(feature = "page")]
    #[must_use]
    pub const fn code(self) -> u16 {
        match self {
            Self::Nothing => 0,
            Self::Reset => 1,
            Self::Stop => 2,
        }
    }
}

/// One message of a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heard {
    /// The robot's stamp \[ms\]; it goes on from message to message.
    pub stamp_ms: u64,
    /// The tool, X, Y and Z \[mm\].
    pub tool_mm: [f64; 3],
    /// Packets that came late or never, as the robot or its numbering counts them, since the beginning.
    pub late: u64,
    /// What the robot's program asks for; acts when it changes. None: nothing is said of it.
    pub command: Option<Command>,
}

/// A robot's protocol: bytes to messages, answers to bytes.
pub trait Wire {
    /// Reads a message; none when it is not understood.
    fn read(&mut self, bytes: &[u8]) -> Option<Heard>;
    /// Writes the answer to the message read last. Whether it is to be sent: a protocol may hold by silence.
    fn write(&mut self, to: &mut Vec<u8>, answer: &Answer) -> bool;
    /// Whether only the newest of several waiting messages is answered, since the robot takes one answer a cycle and the rest
    /// would wait behind it for good.
    fn answers_newest_only(&self) -> bool;
}
