//! ABB EGM path correction: protobuf over UDP. The controller sends an `EgmRobot` each cycle and takes an `EgmSensorPathCorr`.
//!
//! The messages are those of ABB's `egm.proto` (sensor interface V1.1, package `abb.egm`), written down by hand with the fields
//! that are used: what else the controller sends is skipped, as protobuf asks for. A correction is the whole offset from the
//! programmed path since the movement began, not a step, so that a lost answer does no harm and a reset within it no jump. A hold is a message without `pathCorr`: no number. In STOP
//! nothing is sent, so that the controller's own time-out (`\CommTimeout` of `EGMSetupUC`) ends the movement.

use prost::Message;

use super::State;
use super::guide::{Answer, Correction};
use super::wire::{Command, Heard, Wire};

/// `EgmHeader.mtype`: from the controller, and path corrections of a sensor.
pub const FROM_ROBOT: i32 = 2;
pub const PATH_CORRECTION: i32 = 4;
/// `EgmMCIState.state`: EGM moves the robot.
pub const MCI_RUNNING: i32 = 3;
/// Longest gap of the numbering that counts as lost packets. Chosen: beyond it the controller was started anew.
const LONGEST_GAP: u32 = 1000;

/// `EgmHeader`.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct Header {
    /// Number of the message.
    #[prost(uint32, optional, tag = "1")]
    pub seqno: Option<u32>,
    /// When it was sent \[ms\].
    #[prost(uint32, optional, tag = "2")]
    pub tm: Option<u32>,
    /// What it is.
    #[prost(int32, optional, tag = "3")]
    pub mtype: Option<i32>,
}

/// `EgmCartesian` \[mm\].
#[derive(Clone, Copy, PartialEq, Message)]
pub struct Cartesian {
    #[prost(double, required, tag = "1")]
    pub x: f64,
    #[prost(double, required, tag = "2")]
    pub y: f64,
    #[prost(double, required, tag = "3")]
    pub z: f64,
}

/// `EgmPose`, without its orientation.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct Place {
    #[prost(message, optional, tag = "1")]
    pub pos: Option<Cartesian>,
}

/// `EgmFeedBack`: where the robot is.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct FeedBack {
    #[prost(message, optional, tag = "2")]
    pub cartesian: Option<Place>,
}

/// `EgmMCIState`, `EgmMotorState`, `EgmRapidCtrlExecState`.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct Running {
    #[prost(int32, required, tag = "1")]
    pub state: i32,
}

/// `EgmRobot`.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct Robot {
    #[prost(message, optional, tag = "1")]
    pub header: Option<Header>,
    #[prost(message, optional, tag = "2")]
    pub feed_back: Option<FeedBack>,
    #[prost(message, optional, tag = "5")]
    pub mci: Option<Running>,
}

/// `EgmPathCorr`.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct PathCorr {
    /// Offset in the path's coordinates \[mm\].
    #[prost(message, required, tag = "1")]
    pub pos: Cartesian,
    /// How old the measurement is \[ms\].
    #[prost(uint32, required, tag = "2")]
    pub age: u32,
}

/// `EgmSensorPathCorr`.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct SensorPathCorr {
    #[prost(message, optional, tag = "1")]
    pub header: Option<Header>,
    #[prost(message, optional, tag = "2")]
    pub path_corr: Option<PathCorr>,
}

/// The sensor's end of EGM.
#[derive(Debug, Default)]
pub struct Egm {
    /// The robot's last message: its number, its stamp, and whether EGM moved it.
    last: Option<(Option<u32>, u32)>,
    was_running: bool,
    /// The robot's stamp without the wrap at 2³² ms.
    stamp_ms: u64,
    lost: u64,
    /// Number of our next answer.
    number: u32,
    /// Sum of the steps since the movement began \[mm\].
    offset_mm: f64,
}

impl Egm {
    /// Packets that never came, by the numbering.
    fn count_lost(&mut self, seqno: Option<u32>) {
        let before = self.last.and_then(|(before, _)| before);
        if let (Some(before), Some(now)) = (before, seqno) {
            let missing = now.wrapping_sub(before).wrapping_sub(1);
            self.lost += if missing < LONGEST_GAP { u64::from(missing) } else { 0 };
        }
    }
}

impl Wire for Egm {
    fn read(&mut self, bytes: &[u8]) -> Option<Heard> {
        let robot = Robot::decode(bytes).ok()?;
        let header = robot.header?;
        let (tm, tool) = (header.tm?, robot.feed_back?.cartesian?.pos?);
        let is_running = robot.mci?.state == MCI_RUNNING;
        if header.mtype.is_some_and(|mtype| mtype != FROM_ROBOT) {
            return None;
        }
        self.count_lost(header.seqno);
        // The stamp wraps after 49 days; one that steps back is as old as it says, or the controller was started anew.
        let since_ms = self.last.map_or(0, |(_, before)| i64::from(tm.wrapping_sub(before).cast_signed()));
        self.stamp_ms = self.stamp_ms.saturating_add_signed(since_ms);
        self.last = Some((header.seqno, tm));
        // A movement under EGM that begins is the next seam.
        let was_running = std::mem::replace(&mut self.was_running, is_running);
        let begins = is_running && !was_running;
        if begins {
            self.offset_mm = 0.0;
        }
        let command = Some(if begins { Command::Reset } else { Command::Nothing });
        Some(Heard { stamp_ms: self.stamp_ms, tool_mm: [tool.x, tool.y, tool.z], late: self.lost, command })
    }

    fn write(&mut self, to: &mut Vec<u8>, answer: &Answer) -> bool {
        if answer.state == State::Stop {
            return false;
        }
        let mut path_corr = None;
        if let (Correction::Step(step_mm), Some(age_s)) = (answer.correction, answer.age_s) {
            self.offset_mm += step_mm;
            let pos = Cartesian { x: 0.0, y: self.offset_mm, z: 0.0 };
            // Rounded up: never younger than it is.
            path_corr = Some(PathCorr { pos, age: (age_s * 1e3).ceil().max(0.0) as u32 });
        }
        let tm = self.last.map(|(_, tm)| tm);
        let header = Header { seqno: Some(self.number), tm, mtype: Some(PATH_CORRECTION) };
        self.number = self.number.wrapping_add(1);
        to.clear();
        // Room is made as it is needed: this cannot fail.
        let _ = SensorPathCorr { header: Some(header), path_corr }.encode(to);
        true
    }

    fn answers_newest_only(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::{Pose, Why};

    /// `EgmRobot` as the controller sends it, byte by byte by the rules of protobuf: key = field × 8 + kind (0 varint, 1 eight
    /// bytes, 2 length and bytes).
    fn robot(seqno: u8, tm: &[u8], x: f64, mci: u8) -> Vec<u8> {
        let header = [&[0x08, seqno, 0x10][..], tm, &[0x18, 0x02]].concat();
        let axis = |key: u8, mm: f64| [&[key][..], &mm.to_le_bytes()].concat();
        let pos = [axis(0x09, x), axis(0x11, -2.25), axis(0x19, 3.0)].concat();
        assert_eq!(pos.len(), 27);
        // Joints (field 1, six doubles unpacked) come before the pose and are skipped; orientation (field 2 of the pose) too.
        let joints: Vec<u8> = (0..6).flat_map(|_| axis(0x09, 90.0)).collect();
        let pose = [&[0x0a, 27][..], &pos, &[0x12, 9], &axis(0x09, 1.0)].concat();
        let feed_back = [&[0x0a, joints.len() as u8][..], &joints, &[0x12, pose.len() as u8], &pose].concat();
        let part = |key: u8, bytes: &[u8]| [&[key, bytes.len() as u8][..], bytes].concat();
        [
            part(0x0a, &header),
            part(0x12, &feed_back),
            part(0x22, &[0x08, 0x01]), // motors on
            part(0x2a, &[0x08, mci]),
            vec![0x30, 0x00],          // not converged
            part(0x42, &[0x08, 0x02]), // RAPID runs
        ]
        .concat()
    }

    fn answer(state: State, correction: Correction) -> Answer {
        let pose = Pose::default();
        Answer { state, why: Why::Fine, correction, pose, total_mm: 9.0, remaining_mm: None, age_s: Some(0.0161) }
    }

    #[test]
    fn a_controllers_message_is_read_and_what_we_do_not_use_is_skipped() {
        let mut egm = Egm::default();
        // 300 is the varint ac 02.
        let heard = egm.read(&robot(7, &[0xac, 0x02], 1.5, 2)).unwrap();
        assert_eq!((heard.tool_mm, heard.late, heard.command), ([1.5, -2.25, 3.0], 0, Some(Command::Nothing)));
        let next = egm.read(&robot(10, &[0xc4, 0x02], 2.0, 3)).unwrap();
        assert_eq!((next.stamp_ms - heard.stamp_ms, next.late, next.command), (24, 2, Some(Command::Reset)));
        let next = egm.read(&robot(11, &[0xdc, 0x02], 2.5, 3)).unwrap();
        assert_eq!((next.late, next.command), (2, Some(Command::Nothing)));
    }

    #[test]
    fn a_stamp_that_wraps_goes_on() {
        let mut egm = Egm::default();
        let before = egm.read(&robot(1, &[0xff, 0xff, 0xff, 0xff, 0x0f], 0.0, 3)).unwrap();
        let after = egm.read(&robot(2, &[0x17], 0.0, 3)).unwrap();
        assert_eq!(after.stamp_ms - before.stamp_ms, 24);
    }

    #[test]
    fn an_offset_goes_out_with_its_age_a_hold_without_a_number_and_a_stop_not_at_all() {
        let mut egm = Egm::default();
        egm.read(&robot(7, &[0xac, 0x02], 1.5, 3)).unwrap();
        let mut bytes = vec![];
        assert!(egm.write(&mut bytes, &answer(State::Ok, Correction::Step(-1.0))));
        assert!(egm.write(&mut bytes, &answer(State::Ok, Correction::Step(-0.25))));
        // −1.25 = 0xbff4000000000000, age 16.1 ms → 17.
        let expected = [
            &[0x0a, 7, 0x08, 1, 0x10, 0xac, 0x02, 0x18, 4][..],
            &[0x12, 31, 0x0a, 27, 0x09, 0, 0, 0, 0, 0, 0, 0, 0],
            &[0x11, 0, 0, 0, 0, 0, 0, 0xf4, 0xbf],
            &[0x19, 0, 0, 0, 0, 0, 0, 0, 0, 0x10, 17],
        ]
        .concat();
        assert_eq!(bytes, expected);
        assert!(egm.write(&mut bytes, &answer(State::Lost, Correction::Hold)));
        assert_eq!(bytes, [0x0a, 7, 0x08, 2, 0x10, 0xac, 0x02, 0x18, 4]);
        assert!(!egm.write(&mut bytes, &answer(State::Stop, Correction::Hold)));
    }

    #[test]
    fn a_reset_within_a_movement_keeps_its_offset_and_the_next_movement_begins_without_one() {
        let mut egm = Egm::default();
        let (mut bytes, mut tm) = (vec![], 0);
        let mut offset_mm = |mci, step_mm| {
            tm += 24;
            egm.read(&robot(1, &[tm], 0.0, mci)).unwrap();
            egm.write(&mut bytes, &Answer { total_mm: step_mm, ..answer(State::Ok, Correction::Step(step_mm)) });
            SensorPathCorr::decode(&bytes[..]).unwrap().path_corr.unwrap().pos.y
        };
        // What the guide has summed up does not matter: after a reset it counts from zero.
        assert_eq!(
            [offset_mm(3, 0.5), offset_mm(3, 0.5), offset_mm(2, 0.0), offset_mm(3, 0.25)],
            [0.5, 1.0, 1.0, 0.25]
        );
    }

    #[test]
    fn what_is_cut_or_made_up_is_refused_and_breaks_nothing() {
        let whole = robot(7, &[0xac, 0x02], 1.5, 3);
        // Behind EGM's state nothing follows that is needed.
        let needed = whole.len() - 4 - 2;
        assert!((0..needed).all(|end| Egm::default().read(&whole[..end]).is_none()));
        let mut wrong = whole.clone();
        (0..whole.len()).for_each(|at| {
            (0..=255).for_each(|byte| {
                wrong[at] = byte;
                let _ = Egm::default().read(&wrong);
            });
            wrong[at] = whole[at];
        });
        // Our own answer is no message of a robot.
        assert!(Egm::default().read(&[0x0a, 7, 0x08, 1, 0x10, 0xac, 0x02, 0x18, 4]).is_none());
    }
}
