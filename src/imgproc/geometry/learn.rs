//! The joint's cross-section from a frame in which the stripe is well seen.

use std::ops::Range;

use super::line::Line;
use super::ridge::{CrossSection, RidgePoint, Search, ridge};
use super::{HALF_WINDOW_PX, JointKind, JointModel, columns};
use crate::frame::GrayFrame;
use crate::units::PixelPoint;

/// Rows above and below the seed in which the stripe is sought, as a share of the half window: deeper than any joint.
const REACH_SHARE: f64 = 0.9;
/// A column counts when its peak reaches this share of the median column's. Prototype.
const LEAST_PEAK_SHARE: f64 = 0.4;
/// Columns left out beside the seed \[px\] when the sides' lines are fitted. Prototype.
const INNER_EDGES_PX: f64 = 14.0;
const INNER_FILLET_PX: f64 = 6.0;
/// Columns left out next to a corner \[px\]: its rounded toe.
const TOE_FILLET_PX: f64 = 6.0;
const TOE_VGROOVE_PX: f64 = 3.0;
/// From this distance to the stripe on, a root counts as open \[px\].
const LEAST_OPEN_PX: f64 = 6.0;
/// The stretch in which a V-groove's flank begins \[px\], in the smallest window.
const FLANK_PX: Range<f64> = 5.0..20.0;
/// Narrowest V-groove, root to shoulder \[px\], and the widest as a share of the window: the plates must be in it.
const LEAST_HALF_WIDTH_PX: f64 = 12.0;
const WIDEST_SHARE: f64 = 0.88;
/// Larger windows for wider grooves \[px\], half their length.
const WIDER_WINDOWS_PX: [f64; 2] = [160.0, 320.0];
/// The stretch of a plate behind its shoulder \[px\], in the smallest window, and by how much its slope differs from the flank's at least.
const PLATE_PX: Range<f64> = 4.0..60.0;
const LEAST_SHOULDER_BEND: f64 = 0.15;
/// How often a flank's line is fitted anew over its new length.
const GROWTH_ROUNDS: usize = 12;
/// What counts as near a corner \[px\], and how far off it the stripe may lie there \[px\]: rounded toes are 2 px deep.
const ROOT_PX: f64 = 5.0;
const ROOT_DEPTH_PX: f64 = 5.0;
/// Distance from its line at which a column leaves a side \[px\], in the smallest window: long flanks bow.
const INLIER_PX: f64 = 1.8;
/// A plain stripe lies on one line in this share of the columns, and without a break of this length in the stretch
/// where the joint should be \[px\]. Chosen: narrower breaks are speckle.
const PLAIN_SHARE: f64 = 0.85;
const PLAIN_BREAK_PX: f64 = 4.0;
const PLAIN_REACH_PX: f64 = 20.0;
/// Rows on both sides of that line that are looked at \[px\], and the least correlation with the stripe's cross-section:
/// glare has bright rows too.
const PLAIN_BAND_PX: usize = 14;
const PLAIN_QUALITY: f64 = 0.5;
/// Fewest columns of a side.
const LEAST_COLUMNS: usize = 8;
/// Range of stripe SDs \[px\].
const STRIPE_SD_PX: std::ops::RangeInclusive<f64> = 1.2..=6.0;

/// A column's brightest row.
#[derive(Debug, Clone, Copy)]
struct Peak {
    du_px: f64,
    v_px: f64,
    height_grey: f64,
}

/// Reads the joint's model round `seed`. None where there is no stripe on both sides.
#[must_use]
pub fn learn(frame: &GrayFrame, seed: PixelPoint, kind: JointKind) -> Option<JointModel> {
    let near = learn_within(frame, seed, kind, HALF_WINDOW_PX);
    if kind != JointKind::VGroove || near.as_ref().is_some_and(|model| model.plates.is_some()) {
        return near;
    }
    // A groove in a large picture: its shoulders lie farther out.
    let wider = WIDER_WINDOWS_PX.into_iter().filter_map(|half_px| learn_within(frame, seed, kind, half_px));
    wider.into_iter().find(|model| model.plates.is_some()).or(near)
}

fn learn_within(frame: &GrayFrame, seed: PixelPoint, kind: JointKind, half_window_px: f64) -> Option<JointModel> {
    let peaks = peaks(frame, seed, half_window_px);
    let inlier_px = INLIER_PX * (half_window_px / HALF_WINDOW_PX).sqrt();
    let side = |from_px: f64, to_px: f64| {
        let part: Vec<Peak> = peaks.iter().copied().filter(|p| p.du_px > from_px && p.du_px < to_px).collect();
        consensus_line(&part, inlier_px)
    };
    let open_px = if kind.has_edges() { 0.0 } else { open_root(&peaks) };
    let (mut half_width_px, mut plates) = (None, None);
    let (left, right) = match kind {
        JointKind::VGroove => {
            let scale = half_window_px / HALF_WINDOW_PX;
            let flank = open_px + FLANK_PX.start..open_px + FLANK_PX.end * scale;
            let (left, left_end) = grown_flank(&peaks, -1.0, &flank, inlier_px)?;
            let (right, right_end) = grown_flank(&peaks, 1.0, &flank, inlier_px)?;
            let half = left_end.min(right_end);
            let widths = LEAST_HALF_WIDTH_PX..=WIDEST_SHARE * half_window_px;
            // Flanks without an end in sight have no shoulder: then there is no half width.
            half_width_px = widths.contains(&half).then_some(half);
            let half = half.clamp(*widths.start(), *widths.end());
            let refit = |from, to, otherwise| side(from, to).unwrap_or(otherwise);
            let (from, to) = (open_px + 4.0, half - 4.0);
            let flanks = (refit(-to, -from, left), refit(from, to, right));
            let beside = |sign: f64, end_px: f64| {
                let (near, far) = (end_px + PLATE_PX.start * scale, end_px + PLATE_PX.end * scale);
                side((sign * near).min(sign * far), (sign * near).max(sign * far))
            };
            let pair = beside(-1.0, left_end).zip(beside(1.0, right_end));
            let bent = |flank: Line, plate: Line| (flank.slope - plate.slope).abs() >= LEAST_SHOULDER_BEND;
            plates = half_width_px.and(pair).filter(|(l, r)| bent(flanks.0, *l) && bent(flanks.1, *r));
            flanks
        }
        JointKind::Fillet => (side(-half_window_px, -INNER_FILLET_PX)?, side(INNER_FILLET_PX, half_window_px)?),
        JointKind::Butt | JointKind::Lap => {
            (side(-half_window_px, -INNER_EDGES_PX)?, side(INNER_EDGES_PX, half_window_px)?)
        }
    };
    if !kind.has_edges() && !reaches_root(&peaks, left, right) {
        return None;
    }
    let toe_px = open_px + if half_width_px.is_some() { TOE_VGROOVE_PX } else { TOE_FILLET_PX };
    let stripe_sd_px = stripe_sd(frame, seed, &peaks)?;
    let plates = plates.map(|(left, right)| [left, right]);
    Some(JointModel {
        kind,
        stripe_sd_px,
        left,
        right,
        gap_px: None,
        half_width_px,
        plates,
        half_window_px,
        toe_px,
        fits: 0,
    })
}

/// Whether a stripe of `stripe_sd_px` goes straight through at `place`, seen in nearly every column: there is no joint.
#[must_use]
pub fn is_plain(frame: &GrayFrame, place: PixelPoint, half_window_px: f64, stripe_sd_px: f64) -> bool {
    let Some(line) = consensus_line(&peaks(frame, place, half_window_px), INLIER_PX) else { return false };
    let search = Search { half_band_px: PLAIN_BAND_PX, prior_sd_px: 8.0 };
    let columns = columns(frame, place.u_px, half_window_px);
    let count = columns.len() as f64;
    let points = ridge(frame, columns, |u| line.at(u - place.u_px), &CrossSection::new(stripe_sd_px), search);
    let is_stripe =
        |p: &&RidgePoint| p.quality > PLAIN_QUALITY && (p.v_px - line.at(p.u_px - place.u_px)).abs() < INLIER_PX;
    let on_line: Vec<f64> = points.iter().filter(is_stripe).map(|p| p.u_px - place.u_px).collect();
    let near: Vec<f64> = on_line.iter().copied().filter(|du| du.abs() <= PLAIN_REACH_PX).collect();
    let unbroken = near.windows(2).all(|pair| pair[1] - pair[0] < PLAIN_BREAK_PX)
        && near.first().zip(near.last()).is_some_and(|(a, b)| b - a > 2.0 * PLAIN_REACH_PX - PLAIN_BREAK_PX);
    on_line.len() as f64 >= PLAIN_SHARE * count && unbroken
}

/// The brightest row of each column near the seed, after a smoothing across the stripe; faint columns left out.
fn peaks(frame: &GrayFrame, seed: PixelPoint, half_window_px: f64) -> Vec<Peak> {
    let centre = seed.v_px.round().max(0.0) as usize;
    let reach = (REACH_SHARE * half_window_px) as usize;
    let rows = centre.saturating_sub(reach)..(centre + reach + 1).min(frame.height_px());
    let mut peaks: Vec<Peak> = columns(frame, seed.u_px, half_window_px)
        .map(|u| {
            let smooth = |v: usize| {
                (-3isize..=3)
                    .map(|dv| f64::from(frame.at_clamped(u as isize, v as isize + dv)) * SMOOTHING[(dv + 3) as usize])
                    .sum::<f64>()
            };
            let (mut best, mut height) = (rows.start, f64::NEG_INFINITY);
            for v in rows.clone() {
                let value = smooth(v);
                if value > height {
                    (best, height) = (v, value);
                }
            }
            let (a, b, c) = (smooth(best.saturating_sub(1)), height, smooth(best + 1));
            let curvature = a - 2.0 * b + c;
            let vertex = if curvature < -1e-9 { (0.5 * (a - c) / curvature).clamp(-0.5, 0.5) } else { 0.0 };
            Peak { du_px: u as f64 - seed.u_px, v_px: best as f64 + vertex, height_grey: height }
        })
        .collect();
    let mut heights: Vec<f64> = peaks.iter().map(|p| p.height_grey).collect();
    if heights.is_empty() {
        return peaks;
    }
    let middle = heights.len() / 2;
    let median = *heights.select_nth_unstable_by(middle, f64::total_cmp).1;
    peaks.retain(|p| p.height_grey > LEAST_PEAK_SHARE * median);
    peaks
}

/// A Gaussian of SD 1.5 px.
const SMOOTHING: [f64; 7] = [0.0366, 0.1113, 0.2167, 0.2708, 0.2167, 0.1113, 0.0366];

/// The line that most columns agree on, refined by least squares over those.
fn consensus_line(peaks: &[Peak], inlier_px: f64) -> Option<Line> {
    if peaks.len() < LEAST_COLUMNS {
        return None;
    }
    let through = |a: Peak, b: Peak| {
        let slope = (b.v_px - a.v_px) / (b.du_px - a.du_px);
        Line { v_px: a.v_px - slope * a.du_px, slope }
    };
    let inlier = |line: &Line, p: &Peak| (p.v_px - line.at(p.du_px)).abs() < inlier_px;
    let stride = (peaks.len() / 24).max(1);
    let mut best: Option<(usize, Line)> = None;
    for i in (0..peaks.len()).step_by(stride) {
        for j in (i + 1..peaks.len()).step_by(stride) {
            if peaks[j].du_px - peaks[i].du_px < 6.0 {
                continue;
            }
            let line = through(peaks[i], peaks[j]);
            let votes = peaks.iter().filter(|p| inlier(&line, p)).count();
            if best.as_ref().is_none_or(|(most, _)| votes > *most) {
                best = Some((votes, line));
            }
        }
    }
    let (votes, line) = best?;
    if votes < LEAST_COLUMNS.max(peaks.len() / 3) {
        return None;
    }
    let members: Vec<&Peak> = peaks.iter().filter(|p| inlier(&line, p)).collect();
    let n = members.len() as f64;
    let mu = members.iter().map(|p| p.du_px).sum::<f64>() / n;
    let mv = members.iter().map(|p| p.v_px).sum::<f64>() / n;
    let spread: f64 = members.iter().map(|p| (p.du_px - mu).powi(2)).sum();
    let covariance: f64 = members.iter().map(|p| (p.du_px - mu) * (p.v_px - mv)).sum();
    let slope = if spread > 0.0 { covariance / spread } else { line.slope };
    Some(Line { v_px: mv - slope * mu, slope })
}

/// How far the root is open: the distance to the stripe on the farther side \[px\], 0 where it is closed.
fn open_root(peaks: &[Peak]) -> f64 {
    let nearest = |sign: f64| {
        let side = peaks.iter().map(|p| sign * p.du_px).filter(|du| *du >= 0.0);
        side.fold(f64::INFINITY, f64::min)
    };
    let open_px = nearest(1.0).max(nearest(-1.0));
    if open_px < LEAST_OPEN_PX || !open_px.is_finite() { 0.0 } else { open_px }
}

/// A flank's line and where it ends, going to `sign`: from the stretch `first` next to the root outwards, as long as it
/// grows.
fn grown_flank(peaks: &[Peak], sign: f64, first: &Range<f64>, inlier_px: f64) -> Option<(Line, f64)> {
    let line_up_to = |end_px: f64| {
        let within = |p: &&Peak| (first.start..end_px).contains(&(sign * p.du_px));
        consensus_line(&peaks.iter().filter(within).copied().collect::<Vec<_>>(), inlier_px)
    };
    let mut line = line_up_to(first.end)?;
    let mut end_px = flank_end(peaks, line, sign, first, inlier_px);
    for _ in 0..GROWTH_ROUNDS {
        let Some(longer) = line_up_to(end_px) else { break };
        let longer_end_px = flank_end(peaks, longer, sign, first, inlier_px);
        if (longer_end_px - end_px).abs() < 1.0 {
            break;
        }
        (line, end_px) = (longer, longer_end_px);
    }
    Some((line, end_px))
}

/// How far from the root the columns stay on a flank's line, going to `sign` \[px\]: where the columns on it, less those
/// off it, are most, for a spatter over some columns ends no flank. Next to the root its edge may be worn.
fn flank_end(peaks: &[Peak], line: Line, sign: f64, first: &Range<f64>, inlier_px: f64) -> f64 {
    let middle_px = 0.5 * (first.start + first.end);
    let mut outward: Vec<&Peak> = peaks.iter().filter(|p| sign * p.du_px > middle_px).collect();
    outward.sort_by(|a, b| a.du_px.abs().total_cmp(&b.du_px.abs()));
    let mut balance = 0;
    let mut best = (0, middle_px);
    for peak in outward {
        let off = (peak.v_px - line.at(peak.du_px)).abs() > 2.0 * inlier_px;
        balance += if off { -1 } else { 1 };
        if balance > best.0 {
            best = (balance, peak.du_px.abs());
        }
    }
    best.1
}

/// Whether the stripe near the root goes through it: a gap's bottom lies off the point where its edges' lines meet.
fn reaches_root(peaks: &[Peak], left: Line, right: Line) -> bool {
    let du = (right.v_px - left.v_px) / (left.slope - right.slope);
    let mut near: Vec<f64> = peaks.iter().filter(|p| (p.du_px - du).abs() < ROOT_PX).map(|p| p.v_px).collect();
    if near.is_empty() {
        return true;
    }
    let middle = near.len() / 2;
    let median = *near.select_nth_unstable_by(middle, f64::total_cmp).1;
    (median - left.at(du)).abs() < ROOT_DEPTH_PX
}

/// The stripe's SD from the second moment of clean columns, the median of them.
fn stripe_sd(frame: &GrayFrame, seed: PixelPoint, peaks: &[Peak]) -> Option<f64> {
    const HALF: isize = 12;
    let mut sds: Vec<f64> = peaks
        .iter()
        .step_by(4)
        .filter_map(|peak| {
            let (u, v) = ((peak.du_px + seed.u_px).round() as isize, peak.v_px.round() as isize);
            let mut greys: Vec<f64> = (-HALF..=HALF).map(|dv| f64::from(frame.at_clamped(u, v + dv))).collect();
            let mut sorted = greys.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            let background = sorted[sorted.len() * 3 / 10];
            let top = sorted[sorted.len() - 1] - background;
            for grey in &mut greys {
                *grey -= background;
                if *grey < 0.1 * top {
                    *grey = 0.0;
                }
            }
            let sum: f64 = greys.iter().sum();
            let moment = |power: i32, about: f64| {
                greys.iter().enumerate().map(|(i, g)| g * (i as f64 - about).powi(power)).sum::<f64>() / sum
            };
            (sum > 0.0).then(|| moment(2, moment(1, 0.0)).sqrt())
        })
        .collect();
    if sds.is_empty() {
        return None;
    }
    let middle = sds.len() / 2;
    let median = *sds.select_nth_unstable_by(middle, f64::total_cmp).1;
    // The threshold cuts off the tails, which makes the moment 5 % small.
    Some((1.05 * median).clamp(*STRIPE_SD_PX.start(), *STRIPE_SD_PX.end()))
}
