//! A robust line through a side's ridge: straight, or bent as a curved plate is.

use nalgebra::{Matrix3, Vector3};

use super::ridge::RidgePoint;

/// A line v = `v_px` + `slope`·du + ½ `curvature_per_px`·du², du being the distance from a reference column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Row at the reference column \[px\].
    pub v_px: f64,
    /// Rows per column, at the reference column.
    pub slope: f64,
    /// Slope per column \[1/px\]: 0 on a flat plate.
    pub curvature_per_px: f64,
}

impl Line {
    /// A straight line.
    #[must_use]
    pub const fn straight(v_px: f64, slope: f64) -> Self {
        Self { v_px, slope, curvature_per_px: 0.0 }
    }

    /// The row at `du_px` from the reference column \[px\].
    #[must_use]
    pub fn at(&self, du_px: f64) -> f64 {
        self.v_px + (self.slope + 0.5 * self.curvature_per_px * du_px) * du_px
    }

    /// Where two lines with the same reference column meet next to it: distance from it and row \[px\]; none when they
    /// do not.
    #[must_use]
    pub fn meets(&self, other: Self) -> Option<(f64, f64)> {
        let (bend, apart) = (self.slope - other.slope, other.v_px - self.v_px);
        let curvature = self.curvature_per_px - other.curvature_per_px;
        // ½ curvature·du² + bend·du = apart, in the form that has no difference of like numbers.
        let root = (bend * bend + 2.0 * curvature * apart).sqrt();
        let du = 2.0 * apart / (bend + bend.signum() * root);
        du.is_finite().then(|| (du, self.at(du)))
    }

    /// The same line with the reference column moved by `du_px`.
    #[must_use]
    pub fn moved(&self, du_px: f64) -> Self {
        Self { v_px: self.at(du_px), slope: self.slope + self.curvature_per_px * du_px, ..*self }
    }
}

/// How surely slope and curvature of a side are known beforehand, as the weight of the columns that told them: the sum of
/// du² about their mean \[px²\], and of what a straight line leaves of ½ du² \[px⁴\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knowledge {
    /// Of the slope \[px²\].
    pub slope_px2: f64,
    /// Of the curvature \[px⁴\].
    pub curvature_px4: f64,
}

impl Knowledge {
    /// Of a side of which nothing but one look is known: slope to within .03, curvature to within 1/1000 px. Chosen: most
    /// plates are flat.
    pub const LITTLE: Self = Self { slope_px2: 100.0, curvature_px4: 1e5 };
    /// The same of a groove's flank, which is machined straight.
    pub const OF_FLANK: Self = Self { slope_px2: 100.0, curvature_px4: 1e7 };

    /// With what a fit of columns out to `reach_px` from the corner or edge showed. What is known of a slope is forgotten
    /// as fast as it comes in where the side is long, since a curved plate turns as it passes, and slower where it is short.
    pub fn with(self, shown: Self, reach_px: f64) -> Self {
        let most_slope_px2 = MOST_SLOPE_PX2.min(SLOPE_MEMORY * reach_px.powi(3) / 12.0);
        let most_curvature_px4 = LEAST_CURVATURE_PX4.max(CURVATURE_MEMORY * reach_px.powi(5) / 720.0);
        Self {
            slope_px2: (self.slope_px2 + shown.slope_px2).min(most_slope_px2),
            curvature_px4: (self.curvature_px4 + shown.curvature_px4).min(most_curvature_px4),
        }
    }
}

/// Most that is known of a slope beforehand \[px²\]: as much as a clean side of 71 columns tells (n³/12). Prototype.
const MOST_SLOPE_PX2: f64 = 30_000.0;
/// The same for a short side, in multiples of what it could tell if all of it were seen. Chosen.
const SLOPE_MEMORY: f64 = 3.0;
/// The same for a curvature (n⁵/720), and its least \[px⁴\]: a short flank tells nothing of its own. Chosen.
const CURVATURE_MEMORY: f64 = 10.0;
const LEAST_CURVATURE_PX4: f64 = 1e7;

/// A side's line and how well it is founded.
#[derive(Debug, Clone, Copy)]
pub struct SideFit {
    pub line: Line,
    /// What the columns by themselves tell of slope and curvature.
    pub shown: Knowledge,
/// Sum of the columns' weights over their number, 0 to 1.
    pub support: f64,
    /// Weighted RMS distance from the line \[px\].
    pub residual_px: f64,
    /// Variance of the line's row at the reference column \[px²\], slope and curvature as unsure as they are.
    pub variance_px2: f64,
    /// Median amplitude of the good columns near the seam \[grey\].
    pub amplitude: f64,
}

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
/// what is `known` of slope and curvature. None when too few columns agree.
pub fn fit(points: &[RidgePoint], u0_px: f64, prior: Line, known: Knowledge, reach_px: f64) -> Option<SideFit> {
    let weights: Vec<f64> = points.iter().map(prior_weight).collect();
    if weights.iter().sum::<f64>() < LEAST_WEIGHT + 1.0 {
        return None;
    }
    let mut line = Line { v_px: prior.v_px + vote(points, &weights, u0_px, prior), ..prior };
    let mut tukey_px = FIRST_TUKEY_PX;
    let mut round = Round::default();
    for _ in 0..4 {
        round = Round::of(points, &weights, u0_px, line, tukey_px);
        if round.total < LEAST_WEIGHT {
            return None;
        }
        line = round.line(prior, known)?;
        tukey_px = (0.75 * tukey_px).max(LAST_TUKEY_PX);
    }
    let (total, squares) = (round.total, round.squares);
    let residual_px = (squares / total).sqrt();
    let unit_px2 = residual_px.max(LEAST_RESIDUAL_PX).powi(2) * CORRELATED_COLUMNS;
    Some(SideFit {
        line,
        shown: round.shown(),
        support: total / points.len() as f64,
        residual_px,
        variance_px2: unit_px2 * round.normal(known).try_inverse()?[(0, 0)],
        amplitude: typical_amplitude(points, u0_px, line, reach_px),
    })
}

/// The weighted sums of one round: over the columns, each basis function 1, du, ½ du² times each, and times the row's
/// distance from the line before.
#[derive(Default)]
struct Round {
    before: Option<Line>,
    sums: Matrix3<f64>,
    moments: Vector3<f64>,
    total: f64,
    squares: f64,
}

impl Round {
    fn of(points: &[RidgePoint], weights: &[f64], u0_px: f64, line: Line, tukey_px: f64) -> Self {
        let mut round = Self { before: Some(line), ..Self::default() };
        for (point, weight) in points.iter().zip(weights) {
            let du = point.u_px - u0_px;
            let off_px = point.v_px - line.at(du);
            let weight = weight * tukey(off_px, tukey_px);
            let basis = Vector3::new(1.0, du, 0.5 * du * du);
            round.sums += weight * basis * basis.transpose();
            round.moments += weight * off_px * basis;
            round.total += weight;
            round.squares += weight * off_px * off_px;
        }
        round
    }

    fn normal(&self, known: Knowledge) -> Matrix3<f64> {
        self.sums + Matrix3::from_diagonal(&Vector3::new(0.0, known.slope_px2, known.curvature_px4))
    }

    /// The line of least squares with what was known before.
    fn line(&self, prior: Line, known: Knowledge) -> Option<Line> {
        let before = self.before?;
        let (slope_off, curvature_off) = (prior.slope - before.slope, prior.curvature_per_px - before.curvature_per_px);
        let pull = Vector3::new(0.0, known.slope_px2 * slope_off, known.curvature_px4 * curvature_off);
        let change = self.normal(known).cholesky()?.solve(&(self.moments + pull));
        Some(Line {
            v_px: before.v_px + change[0],
            slope: before.slope + change[1],
            curvature_per_px: before.curvature_per_px + change[2],
        })
    }

    /// What these columns tell of slope and curvature when nothing else is known: the Schur complements.
    fn shown(&self) -> Knowledge {
        let s = &self.sums;
        let spread = s[(1, 1)] - s[(0, 1)].powi(2) / s[(0, 0)];
        let across = s[(1, 2)] - s[(0, 1)] * s[(0, 2)] / s[(0, 0)];
        let bent = s[(2, 2)] - s[(0, 2)].powi(2) / s[(0, 0)];
        let curvature_px4 = if spread > 0.0 { bent - across * across / spread } else { 0.0 };
        Knowledge { slope_px2: spread.max(0.0), curvature_px4: curvature_px4.max(0.0) }
    }
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
        let prior = Line::straight(101.5, 0.1);
        let found = fit(&points, 0.0, prior, Knowledge::LITTLE, 55.0).unwrap();
        assert!((found.line.v_px - 100.0).abs() < 0.1, "{found:?}");
        assert!((found.line.slope - 0.1).abs() < 0.005);
        assert!((0.55..0.75).contains(&found.support));
    }

    #[test]
    fn columns_without_stripe_make_no_line() {
        let points: Vec<RidgePoint> = (0..60)
            .map(|i| RidgePoint { u_px: f64::from(i), v_px: 100.0, quality: 0.2, amplitude: 3.0, background: 9.0 })
            .collect();
        let prior = Line::straight(100.0, 0.0);
        assert!(fit(&points, 0.0, prior, Knowledge::LITTLE, 55.0).is_none());
    }

    fn pipe(u: f64) -> RidgePoint {
        let v_px = 100.0 + 0.02 * u + 0.5 * 0.002 * u * u;
        RidgePoint { u_px: u, v_px, quality: 0.9, amplitude: 100.0, background: 9.0 }
    }

    #[test]
    fn the_side_of_a_pipe_is_not_extrapolated_straight() {
        let points: Vec<RidgePoint> = (10..80).map(|i| pipe(f64::from(i))).collect();
        let prior = Line::straight(101.0, 0.08);
        let found = fit(&points, 0.0, prior, Knowledge::LITTLE, 55.0).unwrap();
        assert!((found.line.v_px - 100.0).abs() < 0.05, "{found:?}");
        assert!((found.line.curvature_per_px - 0.002).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn what_is_known_holds_the_slope_of_a_side_that_is_hardly_seen() {
        let points: Vec<RidgePoint> = (10..20).map(|i| RidgePoint { v_px: 101.0 + 0.1 * f64::from(i), ..pipe(f64::from(i)) }).collect();
        let known = Knowledge { slope_px2: 30_000.0, curvature_px4: 1e7 };
        let found = fit(&points, 0.0, Line::straight(102.0, 0.0), known, 55.0).unwrap();
        assert!(found.line.slope.abs() < 0.002, "{found:?}");
    }

    #[test]
    fn curved_lines_meet_where_they_do() {
        let (a, b) = (Line { v_px: 100.0, slope: 0.5, curvature_per_px: 0.002 }, Line::straight(103.0, -0.4));
        let (du, v) = a.meets(b).unwrap();
        assert!((a.at(du) - b.at(du)).abs() < 1e-9 && (v - a.at(du)).abs() < 1e-9 && du.abs() < 5.0);
        let moved = a.moved(7.0);
        assert!((moved.at(3.0) - a.at(10.0)).abs() < 1e-9);
        assert_eq!(Line::straight(1.0, 0.1).meets(Line::straight(2.0, 0.1)), None);
    }
}
