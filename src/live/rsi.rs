//! KUKA RSI: the robot sends its pose each cycle, and the answer must be back within it.
//!
//! Corrections are relative: an answer's `RKorr` is added to those before it. So what keeps the line is a step of zero, and
//! the attributes of `Seam` say which it is, a step or a hold (`V`). The robot's side must have `HOLDON="0"`, else it repeats
//! the last step while answers are missing.

use std::fmt::Write;

use super::guide::{Answer, Correction};
use super::wire::{Command, Heard, Wire};

/// One message of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle<'a> {
    /// Its time stamp, to be sent back unchanged.
    pub ipoc: &'a str,
    /// The tool, X, Y and Z \[mm\].
    pub tool_mm: [f64; 3],
    /// Packets that came late, as the robot counts them.
    pub late: Option<u64>,
    /// What the robot's program asks for, in `<Seam C="…"/>`; acts when it changes.
    pub command: Option<Command>,
}

/// The sensor's end of RSI.
#[derive(Debug)]
pub struct Rsi {
    /// Unit vector of the corrections.
    lateral: [f64; 3],
    ipoc: String,
    heartbeat: u32,
    late: u64,
    text: String,
}

impl Rsi {
    /// Corrections go along `lateral`, a unit vector of the correction's frame.
    #[must_use]
    pub const fn new(lateral: [f64; 3]) -> Self {
        Self { lateral, ipoc: String::new(), heartbeat: 0, late: 0, text: String::new() }
    }
}

impl Wire for Rsi {
    fn read(&mut self, bytes: &[u8]) -> Option<Heard> {
        let cycle = Cycle::parse(std::str::from_utf8(bytes).ok()?)?;
        self.late = self.late.max(cycle.late.unwrap_or(0));
        self.ipoc.clear();
        self.ipoc.push_str(cycle.ipoc);
        let stamp_ms = cycle.ipoc.parse().unwrap_or(0);
        Some(Heard { stamp_ms, tool_mm: cycle.tool_mm, late: self.late, command: cycle.command })
    }

    fn write(&mut self, to: &mut Vec<u8>, answer: &Answer) -> bool {
        self.heartbeat = self.heartbeat.wrapping_add(1);
        write_answer(&mut self.text, &self.ipoc, answer, self.lateral, self.heartbeat);
        to.clear();
        to.extend_from_slice(self.text.as_bytes());
        true
    }

    /// Each message is answered: the robot counts those that are not.
    fn answers_newest_only(&self) -> bool {
        false
    }
}

/// Longest stamp that is sent back. Chosen: RSI's is a 64-bit number.
const LONGEST_IPOC: usize = 20;

impl<'a> Cycle<'a> {
    /// Reads a message; none when it lacks stamp or pose.
    #[must_use]
    pub fn parse(message: &'a str) -> Option<Self> {
        let ipoc = between(message, "<IPOC>", "</IPOC>")?.trim();
        let is_stamp = !ipoc.is_empty() && ipoc.len() <= LONGEST_IPOC && ipoc.bytes().all(|b| b.is_ascii_digit());
        let axis = |name| attribute(message, "<RIst", name)?.parse::<f64>().ok();
        let tool_mm = [axis("X")?, axis("Y")?, axis("Z")?];
        let whole = |tag, name| attribute(message, tag, name)?.parse::<u64>().ok();
        is_stamp.then_some(Self {
            ipoc,
            tool_mm,
            late: whole("<Delay", "D"),
            command: whole("<Seam", "C").map(|code| Command::of(code.min(99) as u16)),
        })
    }
}

fn between<'a>(text: &'a str, from: &str, to: &str) -> Option<&'a str> {
    let rest = text.split_once(from)?.1;
    Some(rest.split_once(to)?.0)
}

/// The value of an attribute of the first element that begins with `tag`.
fn attribute<'a>(message: &'a str, tag: &str, name: &str) -> Option<&'a str> {
    let element = message.split_once(tag)?.1.split_once('>')?.0;
    let mut rest = element.strip_prefix(|c: char| c.is_ascii_whitespace())?;
    loop {
        let (key, after) = rest.trim_start().split_once('=')?;
        let after = after.trim_start();
        let quote = after.chars().next().filter(|c| matches!(c, '"' | '\''))?;
        let (value, behind) = after[1..].split_once(quote)?;
        if key.trim() == name {
            return Some(value);
        }
        rest = behind;
    }
}

/// Writes the answer to the message stamped `ipoc`. A step goes along `lateral`, a unit vector of the correction's frame.
pub fn write_answer(to: &mut String, ipoc: &str, answer: &Answer, lateral: [f64; 3], heartbeat: u32) {
    let (step_mm, is_step) = match answer.correction {
        Correction::Step(step_mm) => (step_mm, 1),
        Correction::Hold => (0.0, 0),
    };
    let [x, y, z] = lateral.map(|share| step_mm * share);
    let (state, why) = (answer.state.code(), answer.why.code());
    to.clear();
    // Writing into a string cannot fail.
    let _ = write!(
        to,
        "<Sen Type=\"ImFree\"><RKorr X=\"{x:.4}\" Y=\"{y:.4}\" Z=\"{z:.4}\" A=\"0.0000\" B=\"0.0000\" C=\"0.0000\"/>\
         <Seam S=\"{state}\" W=\"{why}\" V=\"{is_step}\" B=\"{}\"/><IPOC>{ipoc}</IPOC></Sen>",
        heartbeat % 1000
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::{Pose, State, Why};

    const MESSAGE: &str = "<Rob Type=\"KUKA\"><RIst X=\"1.5\" Y=\"-2.25\" Z=\"3.0\" A=\"0\" B=\"0\" C=\"0\"/>\
        <RSol X=\"9\" Y=\"9\" Z=\"9\"/><Delay D=\"4\"/><Seam C=\"1\"/><IPOC>4208163985</IPOC></Rob>";

    #[test]
    fn a_robots_message_is_read() {
        let cycle = Cycle::parse(MESSAGE).unwrap();
        assert_eq!((cycle.ipoc, cycle.tool_mm, cycle.late), ("4208163985", [1.5, -2.25, 3.0], Some(4)));
        assert_eq!(cycle.command, Some(Command::Reset));
    }

    #[test]
    fn what_is_cut_or_made_up_is_refused_and_breaks_nothing() {
        let whole = MESSAGE.find("</Rob>").unwrap();
        assert!((0..whole).all(|end| Cycle::parse(&MESSAGE[..end]).is_none()));
        for message in [
            MESSAGE.replace("1.5", "one"),
            MESSAGE.replace("4208163985", ""),
            MESSAGE.replace("4208163985", "1</IPOC><RKorr X=\"9\"/>"),
            MESSAGE.replace("4208163985", &"9".repeat(21)),
            MESSAGE.replace("RIst X", "RIstX"),
            MESSAGE.replace("X=\"1.5", "X=é1.5"),
        ] {
            let cycle = Cycle::parse(&message);
            assert!(cycle.is_none() || cycle.is_some_and(|cycle| cycle.ipoc == "1"), "{message}");
        }
    }

    #[test]
    fn an_answer_holds_with_a_step_of_zero_and_says_so() {
        let answer = |correction| Answer {
            state: State::Lost,
            why: Why::SeamUnseen,
            correction,
            pose: Pose::default(),
            total_mm: 0.0,
            remaining_mm: None,
            age_s: None,
        };
        let mut text = String::new();
        write_answer(&mut text, "77", &answer(Correction::Hold), [0.0, 1.0, 0.0], 1003);
        assert_eq!(
            text,
            "<Sen Type=\"ImFree\"><RKorr X=\"0.0000\" Y=\"0.0000\" Z=\"0.0000\" A=\"0.0000\" B=\"0.0000\" C=\"0.0000\"/>\
             <Seam S=\"3\" W=\"3\" V=\"0\" B=\"3\"/><IPOC>77</IPOC></Sen>"
        );
        write_answer(&mut text, "78", &answer(Correction::Step(-0.0125)), [0.0, 1.0, 0.0], 4);
        assert!(
            text.contains("Y=\"-0.0125\"") && text.contains("V=\"1\"") && text.contains("<IPOC>78</IPOC>"),
            "{text}"
        );
    }
}
