//! What the robot of a simulated cell sends and reads: a KUKA's RSI or an ABB's EGM.

use std::str::FromStr;

use prost::Message;

use super::CellSettings;
use super::arm::Motion;
use crate::live::egm::{
    Cartesian, FROM_ROBOT, FeedBack, Header, MCI_RUNNING, PATH_CORRECTION, Place, Robot, Running, SensorPathCorr,
};

/// `EgmMCIState.state`: EGM does not move the robot.
const MCI_STOPPED: i32 = 2;
/// What the robot's clock shows when ours begins \[ms\].
const POWER_ON_MS: u64 = 4_208_163_985;
/// Longest offset that is believed \[mm\]. Chosen: a robot's program limits it too.
const LARGEST_OFFSET_MM: f64 = 1000.0;

/// What a simulated robot speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellLink {
    /// KUKA RSI: steps.
    Rsi,
    /// ABB EGM path correction: offsets from the path where the movement began.
    Egm,
}

impl FromStr for CellLink {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "rsi" => Ok(Self::Rsi),
            "egm" => Ok(Self::Egm),
            _ => Err("expected rsi or egm".into()),
        }
    }
}

/// What the robot is told to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Move {
    /// So much further \[mm\].
    Step(f64),
    /// To there \[mm\].
    Offset(f64),
    /// Nothing.
    Hold,
}

/// An answer as the robot reads it.
pub struct Read {
    pub moves: Move,
    /// State and reason, where the protocol has them.
    pub state: Option<u16>,
    pub why: Option<u16>,
}

/// The robot's protocol.
pub struct Wire {
    link: CellLink,
    /// The robot's clock \[ms\].
    stamp_ms: u64,
    seqno: u32,
    /// Where the torch stood beside the line when the movement began: offsets count from there \[mm\].
    from_mm: f64,
}

impl Wire {
    pub fn new(settings: &CellSettings) -> Self {
        Self { link: settings.link, stamp_ms: POWER_ON_MS, seqno: 0, from_mm: 0.0 }
    }

    /// The next cycle, at `now_s`: a pose is stamped with the moment it is of, also where this machine woke us late.
    pub fn tick(&mut self, now_s: f64) {
        let now_ms = POWER_ON_MS + (now_s * 1e3).round() as u64;
        self.stamp_ms = now_ms.max(self.stamp_ms + 1);
        self.seqno += 1;
    }

    pub const fn begin_at(&mut self, lateral_mm: f64) {
        self.from_mm = lateral_mm;
    }

    /// Whether the sensor stops the robot by saying nothing.
    pub const fn stops_by_silence(&self) -> bool {
        matches!(self.link, CellLink::Egm)
    }

    /// This cycle's message; `begins` asks the sensor to begin anew.
    pub fn message(&self, motion: &Motion, late: u64, begins: bool) -> Vec<u8> {
        let (x, y, stamp_ms) = (motion.path_mm, motion.lateral_mm, self.stamp_ms);
        match self.link {
            CellLink::Rsi => format!(
                "<Rob Type=\"KUKA\"><RIst X=\"{x:.4}\" Y=\"{y:.4}\" Z=\"0.0000\" A=\"0.0\" B=\"0.0\" C=\"0.0\"/>\
                 <Delay D=\"{late}\"/><Seam C=\"{}\"/><IPOC>{stamp_ms}</IPOC></Rob>",
                u8::from(begins)
            )
            .into_bytes(),
            CellLink::Egm => {
                // One cycle at rest before each movement, from which the sensor knows that it begins.
                let state = if begins && self.seqno % 2 == 1 { MCI_STOPPED } else { MCI_RUNNING };
                let tool = Place { pos: Some(Cartesian { x, y, z: 0.0 }) };
                Robot {
                    header: Some(Header {
                        seqno: Some(self.seqno),
                        tm: Some(stamp_ms as u32),
                        mtype: Some(FROM_ROBOT),
                    }),
                    feed_back: Some(FeedBack { cartesian: Some(tool) }),
                    mci: Some(Running { state }),
                }
                .encode_to_vec()
            }
        }
    }

    /// The answer to this cycle's message; none if it is another one's.
    pub fn answer(&self, bytes: &[u8]) -> Option<Read> {
        match self.link {
            CellLink::Rsi => {
                let answer = std::str::from_utf8(bytes).ok()?;
                if !answer.contains(&format!("<IPOC>{}</IPOC>", self.stamp_ms)) {
                    return None;
                }
                let after = |mark: &str| Some(answer.split_once(mark)?.1.split_once('"')?.0);
                let step_mm = after(" Y=\"")?.parse().ok()?;
                let is_step = after(" V=\"")? == "1";
                Some(Read {
                    moves: if is_step { Move::Step(step_mm) } else { Move::Hold },
                    state: Some(after("<Seam S=\"")?.parse().ok()?),
                    why: Some(after(" W=\"")?.parse().ok()?),
                })
            }
            CellLink::Egm => {
                let answer = SensorPathCorr::decode(bytes).ok()?;
                let header = answer.header?;
                if header.tm != Some(self.stamp_ms as u32) || header.mtype != Some(PATH_CORRECTION) {
                    return None;
                }
                let offset_mm = answer.path_corr.map(|corr| self.from_mm + corr.pos.y);
                let offset_mm = offset_mm.filter(|offset_mm| offset_mm.abs() < LARGEST_OFFSET_MM);
                Some(Read { moves: offset_mm.map_or(Move::Hold, Move::Offset), state: None, why: None })
            }
        }
    }
}
