//! The straight line of the laser stripe in a frame: a ridge per column, then a robust fit that follows the last one.

use rand::Rng;
use rand_pcg::Pcg32;

use crate::frame::GrayFrame;

/// The stripe's line `v = intercept + slope · u` in a frame with a horizontal stripe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripeLine {
    /// Rows per column.
    pub slope: f64,
    /// Row at column 0 \[px\].
    pub intercept_px: f64,
}

impl StripeLine {
    /// The row of the line in column `u_px`.
    #[must_use]
    pub fn v_px(self, u_px: f64) -> f64 {
        self.intercept_px + self.slope * u_px
    }
}

/// A core brighter than this is saturated on real recordings; capping keeps glints from drawing the ridge.
const GREY_CAP: u8 = 200;
/// Half width of the mean along the stripe \[px\]: speckle is averaged, a tilt of 0.5 is not (chosen).
const ALONG_HALF_PX: usize = 6;
/// Half height of the background's mean across the stripe \[px\]: three times a stripe (chosen).
const BACKGROUND_HALF_PX: usize = 13;
/// Half height of the triangle across the stripe \[px\], about a Gaussian of 2 px as wide as the stripe.
const TRIANGLE_HALF_PX: usize = 4;
/// The ridge of a known line is looked for within this distance \[px\].
const PRIOR_REACH_PX: f64 = 14.0;
/// A ridge lower than this over its background is no stripe \[grey\] (docs/method.md §6.1).
const MIN_RIDGE_GREY: f32 = 8.0;
/// A brighter ridge weighs no more than this \[grey\].
const MAX_WEIGHT_GREY: f32 = 60.0;
/// Fewer columns than this make no line.
const MIN_COLUMNS: usize = 40;
/// Steepest stripe \[px/px\].
const MAX_SLOPE: f64 = 0.5;
/// Pairs of columns tried for the first line, and how far apart they must be \[px\].
const RANSAC_PAIRS: usize = 300;
const RANSAC_BASE_PX: usize = 60;
/// Distance of an inlier from the first line \[px\], and from the refined one in each round.
const RANSAC_INLIER_PX: f64 = 2.5;
const REFIT_INLIER_PX: [f64; 4] = [5.0, 3.0, 2.5, 2.5];
/// A line within this of the last one \[px\] moves by half the difference: the stripe's height changes slowly.
const SMOOTH_WITHIN_PX: f64 = 6.0;

/// Finds the stripe's line in frame after frame.
#[derive(Debug, Clone, Default)]
pub struct StripeLineFinder {
    line: Option<StripeLine>,
    smooth: Vec<f32>,
    ridge_map: Vec<f32>,
    ridge: Vec<RidgePoint>,
}

/// The ridge in one column: its row and its height over the background.
#[derive(Debug, Clone, Copy, Default)]
struct RidgePoint {
    v_px: f64,
    grey: f32,
}

impl RidgePoint {
    fn weight(self) -> f64 {
        if self.grey < MIN_RIDGE_GREY { 0.0 } else { f64::from(self.grey.min(MAX_WEIGHT_GREY)) }
    }
}

impl StripeLineFinder {
    /// The stripe's line in `frame`, or `None` when no column shows a stripe and none was known before.
    pub fn find(&mut self, frame: &GrayFrame) -> Option<StripeLine> {
        let fresh = self.line.and_then(|prior| {
            self.find_ridge(frame, Some(prior));
            refit(prior, &self.ridge)
        });
        let fresh = fresh.or_else(|| {
            self.find_ridge(frame, None);
            first_line(&self.ridge).and_then(|line| refit(line, &self.ridge))
        });
        let Some(fresh) = fresh else { return self.line };
        let middle = 0.5 * frame.width_px() as f64;
        self.line = Some(match self.line {
            Some(last) if (fresh.v_px(middle) - last.v_px(middle)).abs() < SMOOTH_WITHIN_PX => StripeLine {
                slope: 0.5 * (fresh.slope + last.slope),
                intercept_px: 0.5 * (fresh.intercept_px + last.intercept_px),
            },
            _ => fresh,
        });
        self.line
    }

    /// Fills `self.ridge`: per column the highest difference between a triangle and the background across the stripe.
    fn find_ridge(&mut self, frame: &GrayFrame, prior: Option<StripeLine>) {
        let (width, height) = (frame.width_px(), frame.height_px());
        let (first, end) = match prior {
            None => (0, height),
            Some(line) => {
                let (a, b) = (line.v_px(0.0), line.v_px(width as f64 - 1.0));
                let first = (a.min(b) - PRIOR_REACH_PX).floor().clamp(0.0, height as f64 - 1.0) as usize;
                (first, ((a.max(b) + PRIOR_REACH_PX).ceil().max(0.0) as usize + 1).clamp(first + 1, height))
            }
        };
        self.fill_ridge_map(frame, first, end);
        self.ridge.clear();
        let at = |map: &[f32], v: usize, u: usize| map[(v - first) * width + u];
        for u in 0..width {
            let (low, high) = match prior {
                None => (first, end),
                Some(line) => {
                    let low = (line.v_px(u as f64) - PRIOR_REACH_PX).clamp(first as f64, end as f64 - 1.0) as usize;
                    (low, (low + 2 * PRIOR_REACH_PX as usize + 1).min(end))
                }
            };
            let mut best = low;
            for v in low..high {
                if at(&self.ridge_map, v, u) > at(&self.ridge_map, best, u) {
                    best = v;
                }
            }
            let grey = at(&self.ridge_map, best, u);
            let mut v_px = best as f64;
            if best > first && best + 1 < end {
                let (above, below) = (at(&self.ridge_map, best - 1, u), at(&self.ridge_map, best + 1, u));
                let bend = (above - 2.0 * grey + below).min(-1e-3);
                v_px += f64::from((0.5 * (above - below) / bend).clamp(-1.0, 1.0));
            }
            self.ridge.push(RidgePoint { v_px, grey });
        }
    }

    /// Rows `first..end` of the filtered frame. The border rows continue outside the frame.
    fn fill_ridge_map(&mut self, frame: &GrayFrame, first: usize, end: usize) {
        let (width, height) = (frame.width_px(), frame.height_px());
        let margin = BACKGROUND_HALF_PX;
        let count = end - first + 2 * margin;
        self.smooth.resize(count * width, 0.0);
        for (i, out) in self.smooth.chunks_exact_mut(width).enumerate() {
            mean_along(frame.row((first + i).saturating_sub(margin).min(height - 1)), out);
        }
        self.ridge_map.resize((end - first) * width, 0.0);
        let row = |i: usize| &self.smooth[i * width..(i + 1) * width];
        let mut background = vec![0.0; width];
        for i in 0..2 * margin {
            add(&mut background, row(i), 1.0);
        }
        let triangle_sum = ((TRIANGLE_HALF_PX + 1) * (TRIANGLE_HALF_PX + 1)) as f32;
        for (v, out) in self.ridge_map.chunks_exact_mut(width).enumerate() {
            add(&mut background, row(v + 2 * margin), 1.0);
            for (o, b) in out.iter_mut().zip(&background) {
                *o = -b / (2 * margin + 1) as f32;
            }
            for d in 0..=2 * TRIANGLE_HALF_PX {
                let weight = TRIANGLE_HALF_PX + 1 - TRIANGLE_HALF_PX.abs_diff(d);
                add(out, row(v + margin + d - TRIANGLE_HALF_PX), weight as f32 / triangle_sum);
            }
            add(&mut background, row(v), -1.0);
        }
    }
}

/// `sum += factor · row`.
fn add(sum: &mut [f32], row: &[f32], factor: f32) {
    for (s, r) in sum.iter_mut().zip(row) {
        *s += factor * r;
    }
}

/// Running mean of the capped grey along one row.
fn mean_along(row: &[u8], out: &mut [f32]) {
    let capped = |u: usize| u32::from(row[u].min(GREY_CAP));
    let width = row.len();
    let (mut sum, mut count) = (0, 0);
    for u in 0..ALONG_HALF_PX.min(width) {
        sum += capped(u);
        count += 1;
    }
    for (u, out) in out.iter_mut().enumerate() {
        if u + ALONG_HALF_PX < width {
            sum += capped(u + ALONG_HALF_PX);
            count += 1;
        }
        *out = sum as f32 / count as f32;
        if u >= ALONG_HALF_PX {
            sum -= capped(u - ALONG_HALF_PX);
            count -= 1;
        }
    }
}

/// The line through two columns with the heaviest inliers. The pairs are drawn from a fixed seed: same frame, same line.
fn first_line(ridge: &[RidgePoint]) -> Option<StripeLine> {
    let bright: Vec<usize> = (0..ridge.len()).filter(|&u| ridge[u].weight() > 0.0).collect();
    if bright.len() < MIN_COLUMNS {
        return None;
    }
    let mut random = Pcg32::new(0, 0);
    let mut best: Option<(f64, StripeLine)> = None;
    for _ in 0..RANSAC_PAIRS {
        let (a, b) = (bright[random.random_range(0..bright.len())], bright[random.random_range(0..bright.len())]);
        if a.abs_diff(b) < RANSAC_BASE_PX.min(bright.len() / 2) {
            continue;
        }
        let slope = (ridge[a].v_px - ridge[b].v_px) / (a as f64 - b as f64);
        if slope.abs() > MAX_SLOPE {
            continue;
        }
        let line = StripeLine { slope, intercept_px: ridge[a].v_px - slope * a as f64 };
        let support = bright
            .iter()
            .filter(|&&u| (ridge[u].v_px - line.v_px(u as f64)).abs() < RANSAC_INLIER_PX)
            .map(|&u| ridge[u].weight())
            .sum();
        if best.is_none_or(|(most, _)| support > most) {
            best = Some((support, line));
        }
    }
    best.map(|(_, line)| line)
}

/// Weighted least squares over the columns near `line`, in narrowing rounds.
fn refit(mut line: StripeLine, ridge: &[RidgePoint]) -> Option<StripeLine> {
    for inlier_px in REFIT_INLIER_PX {
        let (mut n, mut w, mut wu, mut wv, mut wuu, mut wuv) = (0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (u, point) in ridge.iter().enumerate() {
            let (u, weight) = (u as f64, point.weight());
            if weight > 0.0 && (point.v_px - line.v_px(u)).abs() < inlier_px {
                n += 1;
                w += weight;
                wu += weight * u;
                wv += weight * point.v_px;
                wuu += weight * u * u;
                wuv += weight * u * point.v_px;
            }
        }
        let spread = wuu - wu * wu / w;
        if n < MIN_COLUMNS || spread <= 0.0 {
            return None;
        }
        let slope = (wuv - wu * wv / w) / spread;
        line = StripeLine { slope, intercept_px: (wv - slope * wu) / w };
    }
    Some(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stripe(width: usize, height: usize, line: StripeLine, columns: std::ops::Range<usize>) -> GrayFrame {
        let mut frame = GrayFrame::filled(width, height, 20).unwrap();
        for v in 0..height {
            for u in columns.clone() {
                let d = v as f64 - line.v_px(u as f64);
                frame.pixels_mut()[v * width + u] = (20.0 + 235.0 * (-0.5 * (d / 2.4).powi(2)).exp()) as u8;
            }
        }
        frame
    }

    fn assert_near(found: StripeLine, truth: StripeLine, tolerance_px: f64) {
        for u in [100.0, 300.0] {
            let off = found.v_px(u) - truth.v_px(u);
            assert!(off.abs() < tolerance_px, "{off} px off at {u}");
        }
    }

    #[test]
    fn the_line_of_a_short_tilted_stripe_is_found_beside_a_brighter_blob() {
        let truth = StripeLine { slope: -0.03, intercept_px: 120.0 };
        let mut frame = stripe(400, 300, truth, 60..330);
        for v in 200..230 {
            frame.pixels_mut()[v * 400 + 150..v * 400 + 185].fill(255);
        }
        assert_near(StripeLineFinder::default().find(&frame).unwrap(), truth, 0.15);
    }

    #[test]
    fn the_line_follows_a_slow_drift_and_finds_a_stripe_that_jumped() {
        let mut finder = StripeLineFinder::default();
        let mut truth = StripeLine { slope: 0.02, intercept_px: 100.0 };
        for _ in 0..20 {
            truth.intercept_px += 0.5;
            finder.find(&stripe(400, 300, truth, 0..400));
        }
        truth.intercept_px = 230.0;
        for _ in 0..6 {
            finder.find(&stripe(400, 300, truth, 0..400));
        }
        assert_near(finder.find(&stripe(400, 300, truth, 0..400)).unwrap(), truth, 0.2);
    }

    #[test]
    fn a_frame_without_a_stripe_has_no_line() {
        assert!(StripeLineFinder::default().find(&GrayFrame::filled(200, 100, 30).unwrap()).is_none());
        assert!(StripeLineFinder::default().find(&GrayFrame::filled(1, 1, 30).unwrap()).is_none());
    }
}
