//! The joint at one moment, where its preparation changes on the way.

use std::borrow::Cow;

use super::scenario::{Butt, Change, Fillet, Joint, Lap, Ramp, Vgroove};

/// Least half width of a groove \[px\]: a bevel that has just begun.
const LEAST_BEVEL_PX: f64 = 1.0;

/// A joint, and what is left of another one in it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Prepared<'a> {
    /// The joint.
    pub(super) joint: Cow<'a, Joint>,
    /// The floor of a butt joint that is becoming a groove: its depth \[px\] and its brightness.
    pub(super) floor: Option<(f64, f64)>,
}

impl<'a> Prepared<'a> {
    /// A plate without a joint.
    pub(super) const fn flat() -> Self {
        Self { joint: Cow::Owned(Joint::Flat), floor: None }
    }

    /// The joint at a camera frame; `fraction` is how much of the recording has passed.
    pub(super) fn at(first: &'a Joint, change: Option<&'a Change>, tick: usize, fraction: f64) -> Self {
        let plain = |joint: &'a Joint| Self { joint: Cow::Borrowed(joint), floor: None };
        let Some(change) = change else { return plain(first) };
        let share = (tick as f64 - change.from_frame as f64) / change.over_frames as f64;
        if share <= 0.0 {
            plain(first)
        } else if share >= 1.0 {
            plain(&change.joint)
        } else {
            between(first, &change.joint, share, fraction)
        }
    }
}

fn between<'a>(first: &'a Joint, second: &'a Joint, share: f64, fraction: f64) -> Prepared<'a> {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    let ramp = |a: Ramp, b: Ramp| Ramp::Constant(mix(a.at(fraction), b.at(fraction)));
    let joint = match (first, second) {
        (Joint::Butt(a), Joint::Butt(b)) => Joint::Butt(Butt {
            gap_px: ramp(a.gap_px, b.gap_px),
            depth_px: mix(a.depth_px, b.depth_px),
            hi_lo_px: ramp(a.hi_lo_px, b.hi_lo_px),
            bent_edge_px: mix(a.bent_edge_px, b.bent_edge_px),
            bent_length_px: mix(a.bent_length_px, b.bent_length_px),
            floor_reflectance: mix(a.floor_reflectance, b.floor_reflectance),
        }),
        (Joint::Lap(a), Joint::Lap(b)) => Joint::Lap(Lap {
            step_px: ramp(a.step_px, b.step_px),
            shadow_px: mix(a.shadow_px, b.shadow_px),
            upper_on_right: a.upper_on_right,
            glint: mix(a.glint, b.glint),
        }),
        (Joint::Vgroove(a), Joint::Vgroove(b)) => Joint::Vgroove(Vgroove {
            half_width_px: mix(a.half_width_px, b.half_width_px),
            right_half_width_px: Some(mix(a.half_widths_px()[1], b.half_widths_px()[1])),
            depth_px: mix(a.depth_px, b.depth_px),
            root_gap_px: ramp(a.root_gap_px, b.root_gap_px),
            hi_lo_px: ramp(a.hi_lo_px, b.hi_lo_px),
            flank_reflectance: mix(a.flank_reflectance, b.flank_reflectance),
        }),
        (Joint::Fillet(a), Joint::Fillet(b)) => Joint::Fillet(Fillet {
            left_slope: mix(a.left_slope, b.left_slope),
            right_slope: mix(a.right_slope, b.right_slope),
            toe_px: mix(a.toe_px, b.toe_px),
            inner_reflection: mix(a.inner_reflection, b.inner_reflection),
        }),
        (Joint::Butt(butt), Joint::Vgroove(groove)) => return bevelled(butt, groove, share, fraction),
        (Joint::Vgroove(groove), Joint::Butt(butt)) => return bevelled(butt, groove, 1.0 - share, fraction),
        _ => return Prepared { joint: Cow::Borrowed(first), floor: None },
    };
    Prepared { joint: Cow::Owned(joint), floor: None }
}

/// A butt joint whose edges are bevelled to a share of a V-groove; its floor fades.
fn bevelled<'a>(butt: &Butt, groove: &Vgroove, share: f64, fraction: f64) -> Prepared<'a> {
    let mix = |a: Ramp, b: Ramp| Ramp::Constant(a.at(fraction) + (b.at(fraction) - a.at(fraction)) * share);
    let [left, right] = groove.half_widths_px();
    let half_gap = 0.5 * butt.gap_px.at(fraction) * (1.0 - share);
    let bevel = |half_width_px: f64| (share * half_width_px).max(LEAST_BEVEL_PX) + half_gap;
    let joint = Joint::Vgroove(Vgroove {
        half_width_px: bevel(left),
        right_half_width_px: Some(bevel(right)),
        depth_px: share * groove.depth_px,
        root_gap_px: mix(butt.gap_px, groove.root_gap_px),
        hi_lo_px: mix(butt.hi_lo_px, groove.hi_lo_px),
        flank_reflectance: 1.0 + (groove.flank_reflectance - 1.0) * share,
    });
    let floor = Some((butt.depth_px, butt.floor_reflectance * (1.0 - share)));
    Prepared { joint: Cow::Owned(joint), floor }
}
