//! A robust straight line through a side's ridge.

use super::ridge::RidgePoint;

/// A line v = `v_px` + `slope`·(u − reference column).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Row at the reference column \[px\].
    pub v_px: f64,
    /// Rows per column.
    pub slope: f64,
}

impl Line {
    /// The row at `du_px` from the reference column \[px\].
    #[must_use]
    pub fn at(&self, du_px: f64) -> f64 {
        self.v_px + self.slope * du_px
    }

    /// Where two lines with the same reference column meet: distance from it and row \[px\]; none when they are
    /// parallel.
    #[must_use]
    pub fn meets(&self, other: Self) -> Option<(f64, f64)> {
        let du = (other.v_px - self.v_px) / (self.slope - other.slope);
        du.is_finite().then(|| (du, self.at(du)))
    }

    /// The same line with the reference column moved by `du_px`.
    #[must_use]
    pub fn moved(&self, du_px: f64) -> Self {
        Self { v_px: self.at(du_px), slope: self.slope }
    }
}

/// A side's line and how well it is founded.
#[derive(Debug, Clone, Copy)]
pub struct SideFit {
    pub line: Line,
    /// The slope with hardly any prior.
    pub free_slope: f64,
    /// Sum of the columns' weights over their number, 0 to 1.
    pub support: f64,
    /// Weighted RMS distance from the line \[px\].
    pub residual_px: f64,
    /// Variance of the line's row at the reference column \[px²\].
    pub variance_px2: f64,
    /// Median amplitude of the good columns near the seam \[grey\].
    pub amplitude: f64,
}

/// Weight of the slope prior [px²]: as much as a clean side of 71 columns has (n³/12). Prototype.
const SLOPE_PRIOR_PX2: f64 = 30_000.0;
/// Weight of the prior on the slope that is learned from.
const FREE_SLOPE_PRIOR_PX2: f64 = 300.0;
/// Half-width of the offset vote \[px\], and its bins.
const VOTE_REACH_PX: f64 = 8.25;
const VOTE_BINS: usize = 33;
/// Tukey constants of the four rounds: from the tolerance of a good ridge down to its noise \[px\].
const FIRST_TUKEY_PX: f64 = 3.0;
const LAST_TUKEY_PX: f64 = 1.2;
/// Columns that have one error between them: speckle is correlated along the stripe. Measured on rendered stripes.
const CORRELATED_COLUMNS: f64 = 2.5;
/// Least SD of a ridge about its line \[px\]: what the sensor's pixels leave of an even stripe. Chosen.
const LEAST_RESIDUAL_PX: f64 = 0.1;
/// Least sum of weights before and within the rounds.
const LEAST_WEIGHT: f64 = 5.0;

/// How much a column counts before its residual is known: by its correlation and its amplitude.
fn prior_weight(point: &RidgePoint) -> f64 {
    ((point.quality - 0.45) / 0.3).clamp(0.0, 1.0) * (point.amplitude / 30.0).clamp(0.0, 1.0)
}

/// Fits a line through `points` near `prior` (both relative to column `u0_px`): an offset vote, then Tukey rounds with
/// a prior on the slope. None when too few columns agree.
pub fn fit(points: &[RidgePoint], u0_px: f64, prior: Line, reach_px: f64) -> Option<SideFit> {
    let weights: Vec<f64> = points.iter().map(prior_weight).collect();
    if weights.iter().sum::<f64>() < LEAST_WEIGHT + 1.0 {
        return None;
    }
    let mut line = Line { v_px: prior.v_px + vote(points, &weights, u0_px, prior), slope: prior.slope };
    let mut tukey_px = FIRST_TUKEY_PX;
    let mut free_slope = prior.slope;
    let mut total = 0.0;
    let mut squares = 0.0;
    let mut leverage = 1.0;
    for _ in 0..4 {
        let mut sums = [0.0; 5];
        for (point, w0) in points.iter().zip(&weights) {
            let du = point.u_px - u0_px;
            let w = w0 * tukey(point.v_px - line.at(du), tukey_px);
            sums = [
                sums[0] + w,
                sums[1] + w * du,
                sums[2] + w * point.v_px,
                sums[3] + w * du * du,
                sums[4] + w * du * point.v_px,
            ];
        }
        let [w, wu, wv, wuu, wuv] = sums;
        if w < LEAST_WEIGHT {
            return None;
        }
        let (mu, mv) = (wu / w, wv / w);
        let (spread, covariance) = (wuu - w * mu * mu, wuv - w * mu * mv);
        let slope = |prior_px2: f64| (covariance + prior_px2 * prior.slope) / (spread + prior_px2);
        line.slope = slope(SLOPE_PRIOR_PX2);
        line.v_px = mv - line.slope * mu;
        free_slope = slope(FREE_SLOPE_PRIOR_PX2);
        leverage = 1.0 + w * mu * mu / (spread + SLOPE_PRIOR_PX2);
        total = w;
        squares = 0.0;
        for (point, w0) in points.iter().zip(&weights) {
            let r = point.v_px - line.at(point.u_px - u0_px);
            squares += w0 * tukey(r, tukey_px) * r * r;
        }
        tukey_px = (0.75 * tukey_px).max(LAST_TUKEY_PX);
    }
    let residual_px = (squares / total).sqrt();
    Some(SideFit {
        line,
        free_slope,
        support: total / points.len() as f64,
        residual_px,
        variance_px2: residual_px.max(LEAST_RESIDUAL_PX).powi(2) * CORRELATED_COLUMNS * leverage / total,
        amplitude: typical_amplitude(points, u0_px, line, reach_px),
    })
}

fn tukey(residual_px: f64, constant_px: f64) -> f64 {
    let t = (1.0 - (residual_px / constant_px).powi(2)).max(0.0);
    t * t
}

/// The offset that most columns vote for \[px\].
fn vote(points: &[RidgePoint], weights: &[f64], u0_px: f64, prior: Line) -> f64 {
    let bin_px = 2.0 * VOTE_REACH_PX / VOTE_BINS as f64;
    let mut bins = [0.0; VOTE_BINS];
    for (point, weight) in points.iter().zip(weights) {
        let bin = (point.v_px - prior.at(point.u_px - u0_px) + VOTE_REACH_PX) / bin_px;
        if (0.0..VOTE_BINS as f64).contains(&bin) {
            bins[bin as usize] += weight;
        }
    }
    let smoothed = |i: usize| {
        bins[i] + 0.5 * (if i > 0 { bins[i - 1] } else { 0.0 }) + 0.5 * bins.get(i + 1).copied().unwrap_or(0.0)
    };
    let mut best = VOTE_BINS / 2;
    for i in 0..VOTE_BINS {
        if smoothed(i) > smoothed(best) {
            best = i;
        }
    }
    (best as f64 + 0.5) * bin_px - VOTE_REACH_PX
}

/// Median amplitude of the good columns on the line within `reach_px` of the seam, else of all on the line \[grey\].
fn typical_amplitude(points: &[RidgePoint], u0_px: f64, line: Line, reach_px: f64) -> f64 {
    let on_line = |p: &&RidgePoint| (p.v_px - line.at(p.u_px - u0_px)).abs() < 1.5;
    let good = |p: &&RidgePoint| p.quality > 0.5 && (p.u_px - u0_px).abs() < reach_px;
    let mut near: Vec<f64> = points.iter().filter(on_line).filter(good).map(|p| p.amplitude).collect();
    if near.len() <= 6 {
        near = points.iter().filter(on_line).map(|p| p.amplitude).collect();
    }
    let middle = near.len() / 2;
    if near.is_empty() {
        return 0.0;
    }
    *near.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_through_a_third_of_wild_columns() {
        let points: Vec<RidgePoint> = (0..60)
            .map(|i| {
                let u = f64::from(i);
                let wild = if i % 3 == 0 { 5.0 + f64::from(i % 7) } else { 0.0 };
                RidgePoint { u_px: u, v_px: 100.0 + 0.1 * u + wild, quality: 0.9, amplitude: 100.0, background: 9.0 }
            })
            .collect();
        let prior = Line { v_px: 101.5, slope: 0.1 };
        let found = fit(&points, 0.0, prior, 55.0).unwrap();
        assert!((found.line.v_px - 100.0).abs() < 0.1, "{found:?}");
        assert!((found.free_slope - 0.1).abs() < 0.005);
        assert!((0.55..0.75).contains(&found.support));
    }

    #[test]
    fn columns_without_stripe_make_no_line() {
        let points: Vec<RidgePoint> = (0..60)
            .map(|i| RidgePoint { u_px: f64::from(i), v_px: 100.0, quality: 0.2, amplitude: 3.0, background: 9.0 })
            .collect();
        assert!(fit(&points, 0.0, Line { v_px: 100.0, slope: 0.0 }, 55.0).is_none());
    }
}
