//! A robust line through a side's ridge: straight, or bent as a curved plate is.

use arrayvec::ArrayVec;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::peaks::median;
use super::ridge::{MOST_COLUMNS, RidgePoint};

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

/// How surely slope and curvature of a side are known beforehand: the inverse of their covariance, for columns whose error
/// has the variance 1 px².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knowledge {
    information: Matrix2<f64>,
    /// Variances of what slope and curvature change by from fit to fit.
    drift: Vector2<f64>,
}

/// What is known after one look: of the slope \[px²\], of a curvature (to within 1/2000 px; chosen: most plates are flat), and that of
/// a groove's flank, which is machined straight \[px⁴\].
const FIRST_SLOPE_PX2: f64 = 100.0;
const FIRST_CURVATURE_PX4: f64 = 1e6;
const STRAIGHT_PX4: f64 = 1e7;
/// Variance of a slope's change from fit to fit, as [`Knowledge`] has it. Chosen: of a clean side of 71 columns half is then
/// remembered; a pipe of R = 320 px turns by .003 when the seam goes on by a pixel.
const SLOPE_DRIFT: f64 = 1.6e-5;
/// A flank of which less is seen, beside a bead, tells little of its slope in one frame (n³/12), and is remembered the longer
/// \[px\]. Chosen.
const LONG_FLANK_PX: f64 = 30.0;
/// On a curved plate the slope beside the seam changes as the seam goes on, the faster the more it is curved: so many times the drift
/// at so strong a curvature \[1/px\], growing with its square. Chosen: R = 320 px then remembers a twentieth; measured, a fillet over
/// a plate of that radius lagged by .4 px.
const TURNING_PER_PX: f64 = 1.0 / 1500.0;
/// Variance of a curvature's change \[1/px²\]. Chosen: the same side's is remembered over forty fits.
const CURVATURE_DRIFT: f64 = 4e-10;

impl Knowledge {
    /// Of a plate after one look.
    pub fn of_plate() -> Self {
        let information = Matrix2::from_diagonal(&Vector2::new(FIRST_SLOPE_PX2, FIRST_CURVATURE_PX4));
        Self { information, drift: Vector2::new(SLOPE_DRIFT, CURVATURE_DRIFT) }
    }

    /// Of a groove's flank, seen over `length_px`, after one look.
    pub fn of_flank(length_px: f64) -> Self {
        let information = Matrix2::from_diagonal(&Vector2::new(FIRST_SLOPE_PX2, STRAIGHT_PX4));
        let share = (length_px / LONG_FLANK_PX).powi(3).min(1.0);
        Self { information, drift: Vector2::new(share * SLOPE_DRIFT, 0.0) }
    }

    /// For the next fit, after one of a side of that curvature whose columns by themselves had the information `shown`.
    pub fn with(self, shown: Matrix2<f64>, curvature_per_px: f64) -> Self {
        let covariance = (self.information + shown).try_inverse();
        let turning = 1.0 + (curvature_per_px / TURNING_PER_PX).powi(2);
        let drift = self.drift.component_mul(&Vector2::new(turning, 1.0));
        let drifted = covariance.and_then(|c| (c + Matrix2::from_diagonal(&drift)).try_inverse());
        Self { information: drifted.unwrap_or(self.information), ..self }
    }
}

/// A side's line and how well it is founded.
#[derive(Debug, Clone, Copy)]
pub struct SideFit {
    pub line: Line,
    /// What the columns by themselves tell of slope and curvature.
    pub shown: Matrix2<f64>,
    /// Sum of the columns' weights over their number, 0 to 1.
    pub support: f64,
    /// Weighted RMS distance from the line \[px\].
    pub residual_px: f64,
    /// Covariance of row \[px\] and slope at the reference column, slope and curvature as unsure as they are.
    pub covariance: Matrix2<f64>,
    /// The same side by this frame alone.
    pub in_frame: FrameLine,
    /// Median amplitude of the good columns near the seam \[grey\].
    pub amplitude: f64,
}

/// A line as one frame shows it. Its slope is not remembered from earlier frames, so it does not lag behind a plate that comes
/// nearer, and its error is its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameLine {
    /// The line.
    pub line: Line,
    /// Covariance of its row \[px\] and slope at the reference column.
    pub covariance: Matrix2<f64>,
}

impl FrameLine {
    /// The same with the reference column moved by `du_px`.
    pub(super) fn moved(&self, du_px: f64) -> Self {
        let by = Matrix2::new(1.0, du_px, 0.0, 1.0);
        Self { line: self.line.moved(du_px), covariance: by * self.covariance * by.transpose() }
    }
}

/// Half-width of the offset vote \[px\], and its bins.
const VOTE_REACH_PX: f64 = 8.25;
const VOTE_BINS: usize = 33;
/// Tukey constants of the four rounds: from the tolerance of a good ridge down to its noise \[px\].
const FIRST_TUKEY_PX: f64 = 3.0;
const LAST_TUKEY_PX: f64 = 1.2;
/// Columns that have one error between them: speckle is correlated along the stripe. Measured on rendered stripes.
const CORRELATED_COLUMNS: f64 = 2.5;
/// Least of Σψ' as a share of Σw: of normal noise whose σ is half of Tukey's constant. Chosen: beyond it the columns are no line.
const LEAST_YIELD: f64 = 0.25;
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
    let weights: ArrayVec<f64, MOST_COLUMNS> = points.iter().take(MOST_COLUMNS).map(prior_weight).collect();
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
    let covariance = unit_px2 * round.normal(known).try_inverse()?;
    Some(SideFit {
        line,
        shown: round.shown(),
        support: total / points.len() as f64,
        residual_px,
        covariance: covariance.fixed_view::<2, 2>(0, 0).into_owned(),
        in_frame: round.in_frame(prior, known)?,
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
    /// Sums over the columns of ψ² and of ψ', ψ being what a column pulls with.
    pulls: f64,
    yields: f64,
}

impl Round {
    fn of(points: &[RidgePoint], weights: &[f64], u0_px: f64, line: Line, tukey_px: f64) -> Self {
        let mut round = Self { before: Some(line), ..Self::default() };
        for (point, weight) in points.iter().zip(weights) {
            let du = point.u_px - u0_px;
            let off_px = point.v_px - line.at(du);
            round.yields += weight * tukey_yield(off_px, tukey_px);
            let weight = weight * tukey(off_px, tukey_px);
            round.pulls += (weight * off_px).powi(2);
            let basis = Vector3::new(1.0, du, 0.5 * du * du);
            round.sums += weight * basis * basis.transpose();
            round.moments += weight * off_px * basis;
            round.total += weight;
            round.squares += weight * off_px * off_px;
        }
        round
    }

    fn normal(&self, known: Knowledge) -> Matrix3<f64> {
        let mut normal = self.sums;
        let mut block = normal.fixed_view_mut::<2, 2>(1, 1);
        block += known.information;
        normal
    }

    /// The line of least squares with what was known before.
    fn line(&self, prior: Line, known: Knowledge) -> Option<Line> {
        let before = self.before?;
        let (slope_off, curvature_off) = (prior.slope - before.slope, prior.curvature_per_px - before.curvature_per_px);
        let pull = known.information * Vector2::new(slope_off, curvature_off);
        let pull = Vector3::new(0.0, pull[0], pull[1]);
        let change = self.normal(known).cholesky()?.solve(&(self.moments + pull));
        Some(Line {
            v_px: before.v_px + change[0],
            slope: before.slope + change[1],
            curvature_per_px: before.curvature_per_px + change[2],
        })
    }

    /// The line by these columns alone, only its curvature remembered. Its covariance is that of an M-estimate, unit σ² =
    /// Σψ² Σw / (Σψ')² (Huber 1981, section 7.6), since weights that fall with the distance make the scatter look smaller than it is;
    /// row and slope take two of the columns that are independent.
    fn in_frame(&self, prior: Line, known: Knowledge) -> Option<FrameLine> {
        let curvature = Vector2::new(0.0, known.information[(1, 1)]);
        let alone = Knowledge { information: Matrix2::from_diagonal(&curvature), ..known };
        let yields = self.yields.max(LEAST_YIELD * self.total);
        let unit_px2 = (self.pulls * self.total / (yields * yields)).max(LEAST_RESIDUAL_PX.powi(2));
        let freedom = (self.total / CORRELATED_COLUMNS - 2.0).max(1.0) * CORRELATED_COLUMNS;
        let unit_px2 = unit_px2 * CORRELATED_COLUMNS * (self.total / freedom).max(1.0);
        let covariance = unit_px2 * self.normal(alone).try_inverse()?;
        let line = self.line(prior, alone)?;
        Some(FrameLine { line, covariance: covariance.fixed_view::<2, 2>(0, 0).into_owned() })
    }

    /// What these columns by themselves tell of slope and curvature, whatever the row.
    fn shown(&self) -> Matrix2<f64> {
        let s = &self.sums;
        let row = Vector2::new(s[(0, 1)], s[(0, 2)]);
        s.fixed_view::<2, 2>(1, 1) - row * row.transpose() / s[(0, 0)]
    }
}

fn tukey(residual_px: f64, constant_px: f64) -> f64 {
    let t = (1.0 - (residual_px / constant_px).powi(2)).max(0.0);
    t * t
}

/// Derivative of the residual times its [`tukey`] weight.
fn tukey_yield(residual_px: f64, constant_px: f64) -> f64 {
    let square = (residual_px / constant_px).powi(2);
    if square < 1.0 { (1.0 - square) * (1.0 - 5.0 * square) } else { 0.0 }
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
    let mut near: ArrayVec<f64, MOST_COLUMNS> =
        points.iter().filter(on_line).filter(good).map(|p| p.amplitude).take(MOST_COLUMNS).collect();
    if near.len() <= 6 {
        near = points.iter().filter(on_line).map(|p| p.amplitude).take(MOST_COLUMNS).collect();
    }
    median(&mut near).unwrap_or(0.0)
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
                RidgePoint { u_px: u, v_px: 100.0 + 0.1 * u + wild, quality: 0.9, amplitude: 100.0, has_glare: false }
            })
            .collect();
        let prior = Line::straight(101.5, 0.1);
        let found = fit(&points, 0.0, prior, Knowledge::of_plate(), 55.0).unwrap();
        assert!((found.line.v_px - 100.0).abs() < 0.1, "{found:?}");
        assert!((found.line.slope - 0.1).abs() < 0.005);
        assert!((0.55..0.75).contains(&found.support));
    }

    #[test]
    fn columns_without_stripe_make_no_line() {
        let points: Vec<RidgePoint> = (0..60)
            .map(|i| RidgePoint { u_px: f64::from(i), v_px: 100.0, quality: 0.2, amplitude: 3.0, has_glare: false })
            .collect();
        let prior = Line::straight(100.0, 0.0);
        assert!(fit(&points, 0.0, prior, Knowledge::of_plate(), 55.0).is_none());
    }

    fn pipe(u: f64) -> RidgePoint {
        let v_px = 100.0 + 0.02 * u + 0.5 * 0.002 * u * u;
        RidgePoint { u_px: u, v_px, quality: 0.9, amplitude: 100.0, has_glare: false }
    }

    #[test]
    fn the_side_of_a_pipe_is_not_extrapolated_straight() {
        let points: Vec<RidgePoint> = (10..80).map(|i| pipe(f64::from(i))).collect();
        let (mut line, mut known) = (Line::straight(101.0, 0.08), Knowledge::of_plate());
        for _ in 0..20 {
            let found = fit(&points, 0.0, line, known, 55.0).unwrap();
            (line, known) = (found.line, known.with(found.shown, found.line.curvature_per_px));
        }
        assert!((line.v_px - 100.0).abs() < 0.06, "{line:?}");
        assert!((line.curvature_per_px - 0.002).abs() < 1e-4, "{line:?}");
    }

    #[test]
    fn what_is_known_holds_the_slope_of_a_side_that_is_hardly_seen() {
        let points: Vec<RidgePoint> =
            (10..20).map(|i| RidgePoint { v_px: 101.0 + 0.1 * f64::from(i), ..pipe(f64::from(i)) }).collect();
        let known = Knowledge { information: Matrix2::new(30_000.0, 0.0, 0.0, 1e7), ..Knowledge::of_plate() };
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
