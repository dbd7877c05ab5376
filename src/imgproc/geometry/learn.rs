//! The joint's cross-section from a frame in which the stripe is well seen.

use super::groove::{self, Groove};
use super::line::{Knowledge, Line};
use super::peaks::{Peak, consensus_line, median, peaks, stripe_sd};
use super::ridge::{CrossSection, RidgePoint, Search, ridge};
use super::{HALF_WINDOW_PX, JointKind, JointModel, LEAST_GAP_SD_PX, columns};
use crate::frame::GrayFrame;
use crate::imgproc::Pixels;
use crate::units::PixelPoint;

/// Columns left out beside the seed \[px\] when the sides' lines are fitted. Prototype.
const INNER_EDGES_PX: f64 = 14.0;
/// Columns left out next to a fillet's corner \[px\]: its rounded toe.
const TOE_FILLET_PX: f64 = 6.0;
/// A worn or welded toe is wider: then the legs are taken from so far outwards, and followed inwards to where the stripe leaves
/// them; so far at most \[px\]. Chosen: a toe of 49 px, on legs of 80.
const WORN_TOE_PX: f64 = 36.0;
/// How far the middle of a rounded toe lies off the point where its legs meet, as a share of its half width and of the bend: a
/// quarter on a circle; twice that much is believed.
const ROUNDED_SHARE: f64 = 0.5;
/// Larger windows for wider grooves \[px\], half their length.
const WIDER_WINDOWS_PX: [f64; 2] = [160.0, 320.0];
/// What counts as near a corner \[px\], and how far off it the stripe may lie there \[px\]: rounded toes are 2 px deep.
const ROOT_PX: f64 = 5.0;
const ROOT_DEPTH_PX: f64 = 5.0;
/// Distance from its line at which a column leaves a side \[px\], in the smallest window: long flanks bow.
const INLIER_PX: f64 = 1.8;
/// A plain stripe lies on one line in this share of the columns, and without a break of this length in the stretch
/// where the joint should be \[px\]. Chosen: narrower breaks are speckle.
const PLAIN_SHARE: f64 = 0.85;
const PLAIN_BREAK_PX: f64 = 4.0;
/// How far from a place a plain stripe is looked for \[px\].
pub const PLAIN_REACH_PX: f64 = 20.0;
/// Rows on both sides of that line that are looked at \[px\], and the least correlation with the stripe's cross-section:
/// glare has bright rows too.
const PLAIN_BAND_PX: usize = 14;
const PLAIN_QUALITY: f64 = 0.5;

/// A joint as one frame shows it.
#[derive(Debug, Clone)]
pub struct Learned {
    /// Its cross-section.
    pub model: JointModel,
    /// Where it is: a groove's root may lie off the seed.
    pub place: PixelPoint,
}

/// Reads the joint's model round `seed`. None where there is no stripe on both sides.
#[must_use]
pub fn learn(frame: &GrayFrame, seed: PixelPoint, kind: JointKind) -> Option<Learned> {
    let near = learn_within(frame, seed, kind, HALF_WINDOW_PX);
    if kind != JointKind::VGroove || near.as_ref().is_some_and(|near| near.model.plates.is_some()) {
        return near;
    }
    // A groove in a large picture: its shoulders lie farther out.
    let mut wider = WIDER_WINDOWS_PX.into_iter().filter_map(|half_px| learn_within(frame, seed, kind, half_px));
    wider.find(|learned| learned.model.plates.is_some()).or(near)
}

fn learn_within(frame: &GrayFrame, seed: PixelPoint, kind: JointKind, half_window_px: f64) -> Option<Learned> {
    let peaks = peaks(frame, seed, half_window_px);
    let inlier_px = INLIER_PX * (half_window_px / HALF_WINDOW_PX).sqrt();
    let groove = match kind {
        JointKind::VGroove => groove::from_plates(&peaks, half_window_px, inlier_px).or_else(|| {
            let groove = groove::from_root(&peaks, half_window_px, inlier_px)?;
            reaches_root(&peaks, groove.flanks, ROOT_DEPTH_PX).then_some(groove)
        })?,
        JointKind::Fillet => corner(&peaks, half_window_px, inlier_px)?,
        JointKind::Butt | JointKind::Lap => beside(&peaks, INNER_EDGES_PX, half_window_px, inlier_px)?,
    };
    let [left, right] = groove.flanks;
    let known = groove.flanks_px.clone().map(|seen| match kind {
        JointKind::VGroove => Knowledge::of_flank(seen.end - seen.start),
        _ => Knowledge::of_plate(),
    });
    let model = JointModel {
        kind,
        stripe_sd_px: stripe_sd(frame, seed, &peaks)?,
        left,
        right,
        gap_px: None,
        gap_sd_px: LEAST_GAP_SD_PX,
        half_width_px: groove.half_width_px,
        plates: groove.plates,
        half_window_px,
        flanks_px: groove.flanks_px,
        known,
        fits: 0,
    };
    let v_px = if kind == JointKind::VGroove { model.seam_v_px() } else { seed.v_px };
    Some(Learned { model, place: PixelPoint::new(seed.u_px + groove.root_du, v_px) })
}

/// The two sides of a fillet.
fn corner(peaks: &[Peak], half_window_px: f64, inlier_px: f64) -> Option<Groove> {
    let legs = beside(peaks, TOE_FILLET_PX, half_window_px, inlier_px)?;
    let first_px = groove::open_root(peaks) + TOE_FILLET_PX;
    if reaches_root(peaks, legs.flanks, ROOT_DEPTH_PX) {
        return Some(Groove { flanks_px: [0, 1].map(|_| first_px..half_window_px), ..legs });
    }
    let legs = beside(peaks, WORN_TOE_PX, half_window_px, inlier_px)?;
    let toes_px =
        [-1.0, 1.0].map(|sign| groove::leg_begins(peaks, legs.flanks[usize::from(sign > 0.0)], sign, inlier_px));
    let [Some(left_px), Some(right_px)] = toes_px else { return None };
    let toe_px = left_px.max(right_px).max(TOE_FILLET_PX);
    let depth_px = ROUNDED_SHARE * toe_px * (legs.flanks[0].slope - legs.flanks[1].slope).abs();
    let is_worn = toe_px <= WORN_TOE_PX && reaches_root(peaks, legs.flanks, depth_px);
    is_worn.then_some(Groove { flanks_px: [0, 1].map(|_| toe_px..half_window_px), ..legs })
}

/// The stripe on both sides of the seed, without `inner_px` next to it.
fn beside(peaks: &[Peak], inner_px: f64, half_window_px: f64, inlier_px: f64) -> Option<Groove> {
    let side = |sign: f64| {
        let within = |p: &&Peak| sign * p.du_px > inner_px && sign * p.du_px < half_window_px;
        consensus_line(&peaks.iter().filter(within).copied().collect::<Vec<_>>(), inlier_px)
    };
    let flanks = [side(-1.0)?, side(1.0)?];
    let flanks_px = [0, 1].map(|_| inner_px..half_window_px);
    Some(Groove { root_du: 0.0, flanks, flanks_px, half_width_px: None, plates: None })
}

/// Whether the stripe near the root goes through it, within `depth_px`: a gap's bottom lies off the point where its edges' lines meet.
fn reaches_root(peaks: &[Peak], [left, right]: [Line; 2], depth_px: f64) -> bool {
    let Some((du, v_px)) = left.meets(right) else { return false };
    let mut near: Vec<f64> = peaks.iter().filter(|p| (p.du_px - du).abs() < ROOT_PX).map(|p| p.v_px).collect();
    median(&mut near).is_none_or(|middle| (middle - v_px).abs() < depth_px)
}

/// Whether a stripe of `stripe_sd_px` goes straight through at `place`, seen in nearly every column: there is no joint.
#[must_use]
pub fn is_plain(mut pixels: impl Pixels, place: PixelPoint, half_window_px: f64, stripe_sd_px: f64) -> bool {
    let Some(line) = consensus_line(&peaks(&mut pixels, place, half_window_px), INLIER_PX) else { return false };
    let search = Search { half_band_px: PLAIN_BAND_PX, prior_sd_px: 8.0 };
    let columns = columns(&pixels, place.u_px, half_window_px);
    let count = columns.len() as f64;
    let points = ridge(pixels, columns, |u| line.at(u - place.u_px), &CrossSection::new(stripe_sd_px), search);
    let is_stripe =
        |p: &&RidgePoint| p.quality > PLAIN_QUALITY && (p.v_px - line.at(p.u_px - place.u_px)).abs() < INLIER_PX;
    let on_line: Vec<f64> = points.iter().filter(is_stripe).map(|p| p.u_px - place.u_px).collect();
    let near: Vec<f64> = on_line.iter().copied().filter(|du| du.abs() <= PLAIN_REACH_PX).collect();
    let unbroken = near.windows(2).all(|pair| pair[1] - pair[0] < PLAIN_BREAK_PX)
        && near.first().zip(near.last()).is_some_and(|(a, b)| b - a > 2.0 * PLAIN_REACH_PX - PLAIN_BREAK_PX);
    on_line.len() as f64 >= PLAIN_SHARE * count && unbroken
}

#[cfg(test)]
mod tests {
    use super::super::drawn::drawn;
    use super::*;

    const SEED: PixelPoint = PixelPoint { u_px: 100.0, v_px: 80.0 };

    #[test]
    fn a_groove_is_learned_with_its_flanks_shoulders_and_the_stripes_thickness() {
        let frame = drawn(|u| Some(80.0 + (30.0 - 0.8 * (u - 103.0).abs()).max(0.0)));
        let Learned { model, place } = learn(&frame, SEED, JointKind::VGroove).unwrap();
        assert!((place.u_px - 103.0).abs() < 1.5 && (place.v_px - 110.0).abs() < 1.5, "{place:?}");
        assert!((model.left.slope - 0.8).abs() < 0.05 && (model.right.slope + 0.8).abs() < 0.05, "{model:?}");
        assert!((model.half_width_px.unwrap() - 37.5).abs() < 2.5, "{model:?}");
        assert!(model.plates.unwrap().iter().all(|plate| (plate.v_px - 80.0).abs() < 1.0), "{model:?}");
    }

    #[test]
    fn the_stripes_sd_is_measured() {
        let frame = drawn(|_| Some(80.0));
        let model = learn(&frame, SEED, JointKind::Butt).unwrap().model;
        assert!((model.stripe_sd_px - super::super::drawn::STRIPE_SD_PX).abs() < 0.3, "{model:?}");
    }

    #[test]
    fn nothing_is_learned_where_one_side_has_no_stripe_or_where_a_gap_has_a_bottom() {
        let one_side = drawn(|u| (u < 95.0).then_some(80.0));
        assert!(learn(&one_side, SEED, JointKind::Butt).is_none());
        let bottom = drawn(|u| Some(if (u - 100.0).abs() < 10.0 { 100.0 } else { 80.0 + 0.2 * (u - 100.0).abs() }));
        assert!(learn(&bottom, SEED, JointKind::Fillet).is_none());
    }

    #[test]
    fn beside_the_frame_nothing_is_seen() {
        let frame = drawn(|_| Some(80.0));
        for (u_px, v_px) in [(1e4, 80.0), (-1e4, 80.0), (1e4, 1e4), (-1e4, -1e4)] {
            let place = PixelPoint::new(u_px, v_px);
            assert!(!is_plain(&frame, place, HALF_WINDOW_PX, 2.0), "{place:?}");
            for kind in [JointKind::Butt, JointKind::VGroove, JointKind::Fillet] {
                assert!(learn(&frame, place, kind).is_none(), "{place:?}");
            }
        }
    }

    #[test]
    fn a_stripe_is_plain_until_it_breaks_steps_or_bends() {
        let is_plain = |row: &dyn Fn(f64) -> Option<f64>| {
            is_plain(&drawn(row), SEED, HALF_WINDOW_PX, super::super::drawn::STRIPE_SD_PX)
        };
        assert!(is_plain(&|u| Some(80.0 + 0.05 * (u - 100.0))));
        assert!(!is_plain(&|u| ((u - 100.0).abs() > 4.0).then_some(80.0)), "a gap");
        assert!(!is_plain(&|u| Some(if u < 100.0 { 80.0 } else { 92.0 })), "a step");
        assert!(!is_plain(&|u| Some(80.0 + 0.3 * (u - 100.0).abs())), "a corner");
    }
}
