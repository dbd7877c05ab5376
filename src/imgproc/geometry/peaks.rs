//! The stripe's brightest rows round a seed, and straight lines through them.

use std::ops::Range;

use super::columns;
use super::line::Line;
use crate::frame::GrayFrame;
use crate::imgproc::Pixels;
use crate::units::PixelPoint;

/// Rows above and below the seed in which the stripe is sought, as a share of the half window: deeper than any joint.
const REACH_SHARE: f64 = 0.9;
/// A column counts when its peak reaches this share of the median column's on its side of the seed, since one plate may
/// be much darker than the other. Prototype: of all columns.
const LEAST_PEAK_SHARE: f64 = 0.4;
/// Columns next to the seed are of either side \[px\]. Chosen.
const INNER_PX: f64 = 14.0;
/// What is within the noise of a line, in medians of the distance from it (3 SD of a normal one), and the least such
/// median \[px\]. Chosen.
const NOISE_MEDIANS: f64 = 4.5;
const LEAST_NOISE_PX: f64 = 0.1;
/// Fewest columns of a line.
const LEAST_COLUMNS: usize = 8;
/// Columns that vote for a line before it is asked whether it can still win.
const VOTERS: usize = 16;
/// Range of stripe SDs \[px\].
const STRIPE_SD_PX: std::ops::RangeInclusive<f64> = 1.2..=6.0;
/// A Gaussian of SD 1.5 px.
const SMOOTHING: [f64; 7] = [0.0366, 0.1113, 0.2167, 0.2708, 0.2167, 0.1113, 0.0366];

/// A column's brightest row.
#[derive(Debug, Clone, Copy)]
pub struct Peak {
    pub du_px: f64,
    pub v_px: f64,
    pub height_grey: f64,
}

/// The brightest row of each column near the seed, after a smoothing across the stripe; faint columns left out.
pub fn peaks(mut pixels: impl Pixels, seed: PixelPoint, half_window_px: f64) -> Vec<Peak> {
    let centre = seed.v_px.round().max(0.0) as usize;
    let reach = (REACH_SHARE * half_window_px) as usize;
    let rows = centre.saturating_sub(reach)..(centre + reach + 1).min(pixels.size_px().1);
    let columns = columns(&pixels, seed.u_px, half_window_px);
    let frame = pixels.region(columns.clone(), rows.start.saturating_sub(4)..rows.end + 4);
    let brightest = brightest_rows(frame, columns.clone(), rows);
    let mut peaks: Vec<Peak> = columns
        .zip(brightest)
        .map(|(u, best)| {
            let smooth = |v: usize| {
                (-3isize..=3)
                    .map(|dv| f64::from(frame.at_clamped(u as isize, v as isize + dv)) * SMOOTHING[(dv + 3) as usize])
                    .sum::<f64>()
            };
            let height = smooth(best);
            let (a, b, c) = (smooth(best.saturating_sub(1)), height, smooth(best + 1));
            let curvature = a - 2.0 * b + c;
            let vertex = if curvature < -1e-9 { (0.5 * (a - c) / curvature).clamp(-0.5, 0.5) } else { 0.0 };
            Peak { du_px: u as f64 - seed.u_px, v_px: best as f64 + vertex, height_grey: height }
        })
        .collect();
    let threshold = [-1.0, 1.0].map(|sign| {
        let beside = peaks.iter().filter(|p| sign * p.du_px > INNER_PX).map(|p| p.height_grey);
        LEAST_PEAK_SHARE * median(&mut beside.collect::<Vec<_>>()).unwrap_or(0.0)
    });
    let least = |du_px: f64| match () {
        () if du_px < -INNER_PX => threshold[0],
        () if du_px > INNER_PX => threshold[1],
        () => threshold[0].min(threshold[1]),
    };
    peaks.retain(|p| p.height_grey > least(p.du_px));
    peaks
}

/// The row of each of `columns` that is brightest after the smoothing, the first of them if there are several.
fn brightest_rows(frame: &GrayFrame, columns: Range<usize>, rows: Range<usize>) -> Vec<usize> {
    let smoothing = SMOOTHING.map(|weight| weight as f32);
    let (mut best, mut height) = (vec![rows.start as u32; columns.len()], vec![f32::NEG_INFINITY; columns.len()]);
    let mut smooth = vec![0.0f32; columns.len()];
    for v in rows {
        smooth.fill(0.0);
        for (i, weight) in smoothing.iter().enumerate() {
            let row = frame.row((v + i).saturating_sub(SMOOTHING.len() / 2).min(frame.height_px() - 1));
            for (sum, &grey) in smooth.iter_mut().zip(&row[columns.clone()]) {
                *sum += weight * f32::from(grey);
            }
        }
        for ((best, height), &value) in best.iter_mut().zip(&mut height).zip(&smooth) {
            *best = if value > *height { v as u32 } else { *best };
            *height = if value > *height { value } else { *height };
        }
    }
    best.into_iter().map(|v| v as usize).collect()
}

/// The line that most columns agree on, refined by least squares over those.
pub fn consensus_line(peaks: &[Peak], inlier_px: f64) -> Option<Line> {
    if peaks.len() < LEAST_COLUMNS {
        return None;
    }
    let through = |a: Peak, b: Peak| {
        let slope = (b.v_px - a.v_px) / (b.du_px - a.du_px);
        Line::straight(a.v_px - slope * a.du_px, slope)
    };
    let inlier = |line: &Line, p: &Peak| (p.v_px - line.at(p.du_px)).abs() < inlier_px;
    // Rows and columns apart, so that they are counted side by side.
    let places: Vec<f64> = peaks.iter().map(|p| p.du_px).collect();
    let rows: Vec<f64> = peaks.iter().map(|p| p.v_px).collect();
    // The votes for a line; given up where they cannot be more than `most`.
    let votes_for = |line: &Line, most: usize| {
        let mut misses = 0;
        for (places, rows) in places.chunks(VOTERS).zip(rows.chunks(VOTERS)) {
            let far = places.iter().zip(rows).map(|(du, v)| usize::from((v - line.at(*du)).abs() >= inlier_px));
            misses += far.sum::<usize>();
            if misses + most >= peaks.len() {
                return None;
            }
        }
        Some(peaks.len() - misses)
    };
    let stride = (peaks.len() / 24).max(1);
    let mut best: Option<(usize, Line)> = None;
    for i in (0..peaks.len()).step_by(stride) {
        for j in (i + 1..peaks.len()).step_by(stride) {
            if (peaks[j].du_px - peaks[i].du_px).abs() < 6.0 {
                continue;
            }
            let line = through(peaks[i], peaks[j]);
            if let Some(votes) = votes_for(&line, best.map_or(0, |(most, _)| most)) {
                best = Some((votes, line));
            }
        }
    }
    let (votes, line) = best?;
    if votes < LEAST_COLUMNS.max(peaks.len() / 3) {
        return None;
    }
    // Twice over those that are on it: the second time within the noise of the first.
    let once = least_squares(peaks.iter().filter(|p| inlier(&line, p)))?;
    let mut off: Vec<f64> =
        peaks.iter().map(|p| (p.v_px - once.at(p.du_px)).abs()).filter(|off| *off < inlier_px).collect();
    let near_px = NOISE_MEDIANS * median(&mut off)?.max(LEAST_NOISE_PX);
    least_squares(peaks.iter().filter(|p| (p.v_px - once.at(p.du_px)).abs() < near_px)).or(Some(once))
}

fn least_squares<'a>(peaks: impl Iterator<Item = &'a Peak> + Clone) -> Option<Line> {
    let n = peaks.clone().count() as f64;
    let mu = peaks.clone().map(|p| p.du_px).sum::<f64>() / n;
    let mv = peaks.clone().map(|p| p.v_px).sum::<f64>() / n;
    let spread: f64 = peaks.clone().map(|p| (p.du_px - mu).powi(2)).sum();
    let covariance: f64 = peaks.map(|p| (p.du_px - mu) * (p.v_px - mv)).sum();
    let slope = covariance / spread;
    slope.is_finite().then(|| Line::straight(mv - slope * mu, slope))
}

/// The stripe's SD from the second moment of clean columns, the median of them.
pub fn stripe_sd(frame: &GrayFrame, seed: PixelPoint, peaks: &[Peak]) -> Option<f64> {
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
    let median = median(&mut sds)?;
    // The threshold cuts off the tails, which makes the moment 5 % small.
    Some((1.05 * median).clamp(*STRIPE_SD_PX.start(), *STRIPE_SD_PX.end()))
}

/// The median; none of nothing.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
