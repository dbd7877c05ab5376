//! Whether the joint asked for is the joint seen.

use super::RobustSettings;
use super::levels::Levels;
use super::seek::Found;
use crate::frame::GrayFrame;
use crate::imgproc::geometry::JointKind;

/// Frames that are looked at for a joint of any kind. Chosen: a joint with edges or a corner is found within ten.
const FRAMES: usize = 20;

/// Seeks a joint of any kind beside the tracker that was told one.
pub struct Doubter {
    levels: Levels,
    looked_at: usize,
    seen: Option<JointKind>,
}

impl Doubter {
    /// A seeker by the settings, but for the joint.
    pub fn new(settings: &RobustSettings) -> Self {
        let open = RobustSettings { joint: None, ..settings.clone() };
        // A break of the stripe is a part of every joint: a hairline would tell nothing.
        Self { levels: Levels::without_hairlines(&open, true), looked_at: 0, seen: None }
    }

    /// Looks at the next frame.
    pub fn look(&mut self, frame: &GrayFrame) {
        self.looked_at += 1;
        let (_, found) = self.levels.look(frame);
        match found {
            Found::Joint { seed, .. } => self.seen = Some(seed.model.kind),
            // A break of the stripe is a part of every joint.
            Found::Hairline { .. } | Found::Nothing { .. } => {}
        }
    }

    /// The kind that was seen.
    pub const fn seen(&self) -> Option<JointKind> {
        self.seen
    }

    /// Whether there is nothing more to be learned.
    pub const fn is_done(&self) -> bool {
        self.seen.is_some() || self.looked_at >= FRAMES
    }
}
