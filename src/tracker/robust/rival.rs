//! Whether a joint that shows while the one that is followed does not is that one: its preparation has changed, or it was lost.

use crate::imgproc::geometry::JointKind;

/// For how long a joint may be unseen before any is sought beside it \[beats\]. Chosen: covers are shorter.
pub const RIVAL_AFTER_BEATS: f64 = 2.0;
/// How far from the prediction such a joint may be found, as long as there is one: σ, and \[px of the picture\].
const RIVAL_SIGMAS: f64 = 3.0;
const RIVAL_PX: f64 = 12.0;
/// How many times as wide a gap may have become while it was unseen: what lies across the stripe, with plate on both sides, shows a
/// gap too. Chosen; and the width from which that counts \[px of the picture\].
const WIDENS: f64 = 3.0;
const LEAST_GAP_PX: f64 = 8.0;

/// The joint that is followed and not seen.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    pub kind: &'static str,
    /// From edge to edge, of joints with edges \[px of the picture\].
    pub gap_px: Option<f64>,
    pub is_lost: bool,
}

/// The joint that shows.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub kind: &'static str,
    /// From edge to edge \[px of the picture\].
    pub gap_px: f64,
    /// Beyond doubt in one frame.
    pub is_certain: bool,
    /// From the prediction, and σ of that \[px of the picture\].
    pub away_px: f64,
    pub std_px: f64,
}

impl Known {
    /// Whether it may be the joint that shows. It does not become one of another kind elsewhere, a groove of which a part is hidden
    /// becomes no gap, and a gap not many times as wide at once.
    pub fn may_be(self, seen: Seen) -> bool {
        let is_near = seen.away_px.abs() <= RIVAL_SIGMAS * seen.std_px + RIVAL_PX;
        let is_as_wide = self.gap_px.is_none_or(|was_px| seen.gap_px <= WIDENS * was_px.max(LEAST_GAP_PX));
        if self.kind == seen.kind {
            return is_as_wide && (is_near || self.is_lost);
        }
        is_near && (seen.is_certain || self.kind != JointKind::VGroove.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUTT: Known = Known { kind: "butt", gap_px: Some(13.0), is_lost: true };
    const GAP: Seen = Seen { kind: "butt", gap_px: 14.0, is_certain: false, away_px: 60.0, std_px: 5.0 };

    #[test]
    fn a_lost_joint_is_found_anywhere_as_what_it_was() {
        assert!(BUTT.may_be(GAP));
        assert!(!BUTT.may_be(Seen { kind: "fillet", ..GAP }));
        assert!(!Known { is_lost: false, ..BUTT }.may_be(GAP));
    }

    #[test]
    fn what_covers_a_gap_is_not_taken_for_a_gap_that_has_become_wide() {
        for away_px in [60.0, 3.0] {
            assert!(!BUTT.may_be(Seen { gap_px: 96.0, away_px, ..GAP }), "{away_px}");
            assert!(BUTT.may_be(Seen { gap_px: 36.0, away_px, ..GAP }), "{away_px}");
        }
    }

    #[test]
    fn where_it_must_be_a_joint_may_have_become_another_but_a_groove_no_gap() {
        let near = Seen { away_px: 4.0, ..GAP };
        assert!(BUTT.may_be(Seen { kind: "vgroove", ..near }));
        let groove = Known { kind: "vgroove", gap_px: None, is_lost: false };
        assert!(!groove.may_be(near) && groove.may_be(Seen { is_certain: true, ..near }));
    }
}
