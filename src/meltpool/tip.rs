//! The pool's tip: the corner that protrudes at its front, where the seam is.
//!
//! The outline turns most sharply there. The corner is not the foremost pixel, which noise and a slanting front move,
//! but where the two flanks meet: straight lines fitted to their edges, over as much of them as is straight. A blunt
//! tip has no straight flanks; there it is the top of a parabola.

use nalgebra::{Matrix2, Vector2};

use super::edge::edge;
use super::pool::Pool;
use super::refusal::{Border, Refusal};
use super::robust::{Line, Parabola};
use super::travel::Turned;

/// Arms that the turning is measured over, as a part of the pool's mean diameter, and their bounds \[px\]. Chosen: longer
/// than the raggedness, shorter than the front.
const ARM_PART: f64 = 0.15;
const ARM_PX: (f64, f64) = (4.0, 30.0);
/// Least turning of the outline at a candidate \[rad\]. Chosen: a circle turns by 9° over these arms, and raggedness
/// adds as much.
const CANDIDATE_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Corners that turn at least this part of the sharpest one are candidates; the foremost of them is the tip. Chosen.
const CANDIDATE_PART: f64 = 0.6;
/// Least angle between the fitted flanks, half an arm before and behind the tip \[rad\]. Chosen: a circle bends by 17°
/// there, an ellipse 1.7 times as long as wide by 38° at its end.
const LEAST_BEND_RAD: f64 = 25.0 * std::f64::consts::PI / 180.0;
/// Flanks that bend by more are a corner, and no parabola is tried; chosen.
const SHARP_BEND_RAD: f64 = 50.0 * std::f64::consts::PI / 180.0;
/// A tip points forwards within 60° of the travel; chosen: the seam lies in front of the pool.
const LEAST_FORWARD: f64 = 0.5;
/// Lengths of flank that are tried, in arms; chosen. Of those that are as straight as the straightest, the one that
/// places the tip best is taken.
const FLANKS: [f64; 7] = [0.35, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0];
/// As straight: a residual deviation within this factor of the smallest, or of the least that matters \[px\]; chosen.
const AS_STRAIGHT: f64 = 1.4;
const STRAIGHT_PX: f64 = 0.15;
/// Least part of a flank's points that its fit must hold on to; chosen: a flank with a kink loses more.
const LEAST_WEIGHT: f64 = 0.6;
/// Farthest reach of a ray across a flank \[px\]; chosen: beyond it lies the other flank.
const FLANK_REACH_PX: usize = 3;
/// The flanks begin so far from the apex \[px\]; chosen: the optics round the corner off there.
const GAP_PX: usize = 2;
/// Neighbouring edges that err alike \[px\]; chosen: their rays overlap.
const CORRELATION_PX: f64 = 4.0;
/// How far the flanks may meet from the sharpest pixel, in arms; chosen.
const FARTHEST_MEETING: f64 = 1.0;

/// A tip in the turned picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tip {
    pub(super) corner: [f64; 2],
}

/// A place for the tip.
#[derive(Debug, Clone, Copy)]
struct Fit {
    place: Vector2<f64>,
    /// Variance across the travel \[px²\].
    variance: f64,
    residual_px: f64,
    bend_rad: f64,
    is_corner: bool,
}

/// Buffers of the measurement.
#[derive(Debug, Default)]
pub(super) struct TipMeter {
    fits: Vec<Fit>,
    front: Vec<[f64; 2]>,
    sums: Vec<Vector2<f64>>,
    turnings: Vec<f64>,
    flanks: [Vec<Option<[f64; 2]>>; 2],
    points: [Vec<[f64; 2]>; 2],
    residuals: Vec<f64>,
}

impl TipMeter {
    /// The tip of a pool.
    pub(super) fn measure(&mut self, picture: &Turned<'_>, pool: &Pool) -> Result<Tip, Refusal> {
        let diameter = 2.0 * (pool.area_px2 / std::f64::consts::PI).sqrt();
        let arm = ((ARM_PART * diameter).clamp(ARM_PX.0, ARM_PX.1)).round() as usize;
        if pool.touches(picture, Border::Front) {
            return Err(Refusal::Border(Border::Front));
        }
        if pool.outline.len() < 6 * arm {
            return Err(Refusal::NoCorner);
        }
        let apex = self.apex(picture, pool, arm)?;
        self.find_flanks(picture, pool, apex, arm);
        let corner = self.meeting(Vector2::from(pool.outline[apex]), arm).ok_or(Refusal::NoCorner)?;
        Ok(Tip { corner: corner.into() })
    }

    /// The outline's point at the foremost sharp corner.
    fn apex(&mut self, picture: &Turned<'_>, pool: &Pool, arm: usize) -> Result<usize, Refusal> {
        let outline = &pool.outline;
        let count = outline.len();
        self.sums.clear();
        self.sums.push(Vector2::zeros());
        let mut sum = Vector2::zeros();
        for point in outline.iter().chain(&outline[..2 * arm]) {
            sum += Vector2::from(*point);
            self.sums.push(sum);
        }
        let (right, bottom) = ((picture.width - 1) as f64, (picture.height - 1) as f64);
        let on_border = |&[x, y]: &[f64; 2]| x == 0.0 || y == 0.0 || x == right || y == bottom;
        self.turnings.clear();
        self.turnings.resize(count, 0.0);
        // The point `arm` after the start of a stretch of 2 arm + 1, so that sums need not wrap backwards.
        for start in 0..count {
            let index = (start + arm) % count;
            let point = Vector2::from(outline[index]);
            let mean = |from: usize| (self.sums[from + arm] - self.sums[from]) / arm as f64 - point;
            let before = mean(start);
            let after = mean(start + arm + 1);
            let (before, after) = (before.normalize(), after.normalize());
            let outwards = -(before + after);
            let turning = std::f64::consts::PI - before.dot(&after).clamp(-1.0, 1.0).acos();
            // Against the clock in a picture whose rows count downwards, a convex corner turns this way.
            let convex = before.x * after.y - before.y * after.x > 0.0;
            let forward = -outwards.y >= LEAST_FORWARD * outwards.norm();
            if convex && forward && !on_border(&outline[index]) {
                self.turnings[index] = turning;
            }
        }
        let sharpest = self.turnings.iter().copied().fold(0.0, f64::max);
        if sharpest < CANDIDATE_RAD {
            return Err(Refusal::NoCorner);
        }
        let half = arm / 2;
        let is_peak = |index: usize| {
            let turning = self.turnings[index];
            let near = (1..=half).flat_map(|d| [(index + d) % count, (index + count - d) % count]);
            turning >= CANDIDATE_RAD.max(CANDIDATE_PART * sharpest)
                && near.into_iter().all(|other| self.turnings[other] <= turning)
        };
        let candidates = (0..count).filter(|&index| is_peak(index));
        candidates.min_by(|&a, &b| outline[a][1].total_cmp(&outline[b][1])).ok_or(Refusal::NoCorner)
    }

    /// The edges along both flanks of the apex, from near to far.
    fn find_flanks(&mut self, picture: &Turned<'_>, pool: &Pool, apex: usize, arm: usize) {
        let count = pool.outline.len();
        let longest = ((FLANKS[FLANKS.len() - 1] * arm as f64) as usize).min(count / 3);
        let reach_px = pool.reach_px.min(FLANK_REACH_PX);
        for (side, flank) in self.flanks.iter_mut().enumerate() {
            flank.clear();
            for step in GAP_PX..GAP_PX + longest {
                let index = if side == 0 { (apex + step) % count } else { (apex + count - step) % count };
                // The normal from this flank alone: nearer the apex than its arm it would lean over the corner.
                let normal = pool.normal(index, reach_px.min(step));
                let point = pool.outline[index];
                let found = edge(picture, point, normal, reach_px);
                let found = found.filter(|edge| edge.contrast >= pool.least_edge);
                flank.push(found.map(|edge| [0, 1].map(|axis| point[axis] + edge.offset_px * normal[axis])));
            }
        }
    }

    /// Where the flanks meet, by the fit that places it best across the travel.
    fn meeting(&mut self, apex: Vector2<f64>, arm: usize) -> Option<Vector2<f64>> {
        self.fits.clear();
        for part in FLANKS {
            let length = ((part * arm as f64).round() as usize).max(4);
            for (points, flank) in self.points.iter_mut().zip(&self.flanks) {
                points.clear();
                points.extend(flank.iter().take(length).flatten());
            }
            if self.points.iter().any(|points| 2 * points.len() < length) {
                continue;
            }
            let fits = [self.corner(length), self.top(apex, length, arm)];
            let near = |fit: &Fit| (fit.place - apex).norm() <= FARTHEST_MEETING * arm as f64;
            self.fits.extend(fits.into_iter().flatten().filter(near));
        }
        let straightest = self.fits.iter().map(|fit| fit.residual_px).fold(f64::INFINITY, f64::min);
        let straight = |fit: &&Fit| fit.residual_px <= AS_STRAIGHT * straightest.max(STRAIGHT_PX);
        // A parabola through a sharp corner can look good by chance.
        let sharp = |fit: &Fit| fit.is_corner && fit.bend_rad >= SHARP_BEND_RAD;
        let is_sharp = self.fits.iter().filter(straight).any(sharp);
        let fitting = self.fits.iter().filter(straight).filter(|fit| fit.is_corner || !is_sharp);
        let best = fitting.min_by(|a, b| a.variance.total_cmp(&b.variance))?;
        (best.bend_rad >= LEAST_BEND_RAD).then_some(best.place)
    }

    /// The flanks as two lines.
    fn corner(&mut self, length: usize) -> Option<Fit> {
        let a = Line::through(&self.points[0], &mut self.residuals)?;
        let b = Line::through(&self.points[1], &mut self.residuals)?;
        if a.weight.min(b.weight) < LEAST_WEIGHT * length as f64 {
            return None;
        }
        let normals = Matrix2::from_rows(&[a.normal.transpose(), b.normal.transpose()]);
        let inverse = normals.try_inverse()?;
        let place = inverse * Vector2::new(a.distance, b.distance);
        let variances = Vector2::new(a.variance_at(&place, CORRELATION_PX), b.variance_at(&place, CORRELATION_PX));
        let variance = (inverse * Matrix2::from_diagonal(&variances) * inverse.transpose())[(0, 0)];
        let residual_px = (0.5 * (a.variance + b.variance)).sqrt();
        Some(Fit { place, variance, residual_px, bend_rad: bend(place, &a, &b), is_corner: true })
    }

    /// The flanks as one parabola across the travel.
    fn top(&mut self, apex: Vector2<f64>, length: usize, arm: usize) -> Option<Fit> {
        let both = self.points.iter().flatten();
        self.front.clear();
        self.front.extend(both.map(|&[x, y]| [x - apex.x, y - apex.y]));
        let parabola = Parabola::through(&self.front, STRAIGHT_PX, &mut self.residuals)?;
        let curvature = 2.0 * parabola.coefficients[2];
        if parabola.weight < 2.0 * LEAST_WEIGHT * length as f64 || curvature <= 0.0 {
            return None;
        }
        let x = parabola.vertex()?;
        Some(Fit {
            place: apex + Vector2::new(x, parabola.at(x)),
            variance: parabola.vertex_variance(CORRELATION_PX),
            residual_px: parabola.variance.sqrt(),
            bend_rad: 2.0 * (0.5 * curvature * arm as f64).atan(),
            is_corner: false,
        })
    }
}

/// How far two flanks that meet at `place` turn from a straight line.
fn bend(place: Vector2<f64>, a: &Line, b: &Line) -> f64 {
    let (along_a, along_b) = (a.centre - place, b.centre - place);
    std::f64::consts::PI - along_a.angle(&along_b)
}
