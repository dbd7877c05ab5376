//! The pool's tip: the corner that protrudes at its front, where the seam is.
//!
//! The outline turns most sharply there. The corner is not the foremost pixel, which noise and a slanting front move,
//! but where the two flanks meet: straight lines fitted to their edges, over as much of them as is straight.

use nalgebra::{Matrix2, Vector2};

use super::edge::edge;
use super::pool::Pool;
use super::refusal::{Border, Refusal};
use super::robust::Line;
use super::travel::Turned;

/// Arms that the turning is measured over, as a part of the pool's mean diameter, and their bounds \[px\]. Chosen: longer
/// than the raggedness, shorter than the front.
const ARM_PART: f64 = 0.15;
const ARM_PX: (f64, f64) = (4.0, 30.0);
/// Least turning of a corner \[rad\]. Chosen: a circle turns by 10° over these arms, an ellipse twice as long as wide by
/// 28° at its end.
const LEAST_TURNING_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Corners that turn at least this part of the sharpest one are candidates; the foremost of them is the tip. Chosen.
const CANDIDATE_PART: f64 = 0.6;
/// A tip points forwards within 60° of the travel; chosen: the seam lies in front of the pool.
const LEAST_FORWARD: f64 = 0.5;
/// Lengths of flank that are tried, in arms; chosen. The one that places the corner best is taken.
const FLANKS: [f64; 6] = [0.5, 0.75, 1.0, 1.5, 2.0, 3.0];
/// Neighbouring edges that err alike \[px\]; chosen: their rays overlap.
const CORRELATION_PX: f64 = 4.0;
/// How far the flanks may meet from the sharpest pixel, in arms; chosen.
const FARTHEST_MEETING: f64 = 1.0;

/// A tip in the turned picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tip {
    pub(super) corner: [f64; 2],
}

/// Buffers of the measurement.
#[derive(Debug, Default)]
pub(super) struct TipMeter {
    sums: Vec<Vector2<f64>>,
    turnings: Vec<f64>,
    flanks: [Vec<Option<[f64; 2]>>; 2],
    points: [Vec<[f64; 2]>; 2],
    residuals: Vec<f64>,
}

impl TipMeter {
    /// The tip of a pool.
    pub(super) fn measure(&mut self, picture: &Turned, pool: &Pool) -> Result<Tip, Refusal> {
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
    fn apex(&mut self, picture: &Turned, pool: &Pool, arm: usize) -> Result<usize, Refusal> {
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
        if sharpest < LEAST_TURNING_RAD {
            return Err(Refusal::NoCorner);
        }
        let half = arm / 2;
        let is_peak = |index: usize| {
            let turning = self.turnings[index];
            let near = (1..=half).flat_map(|d| [(index + d) % count, (index + count - d) % count]);
            turning >= LEAST_TURNING_RAD.max(CANDIDATE_PART * sharpest)
                && near.into_iter().all(|other| self.turnings[other] <= turning)
        };
        let candidates = (0..count).filter(|&index| is_peak(index));
        candidates.min_by(|&a, &b| outline[a][1].total_cmp(&outline[b][1])).ok_or(Refusal::NoCorner)
    }

    /// The edges along both flanks of the apex, from near to far.
    fn find_flanks(&mut self, picture: &Turned, pool: &Pool, apex: usize, arm: usize) {
        let count = pool.outline.len();
        let longest = ((FLANKS[FLANKS.len() - 1] * arm as f64) as usize).min(count / 3);
        let gap = 1 + pool.reach_px / 2;
        for (side, flank) in self.flanks.iter_mut().enumerate() {
            flank.clear();
            for step in gap..gap + longest {
                let index = if side == 0 { (apex + step) % count } else { (apex + count - step) % count };
                // The normal from this flank alone: nearer the apex than its arm it would lean over the corner.
                let normal_arm = pool.reach_px.min(step).max(1);
                let normal = pool.normal(index, normal_arm);
                let point = pool.outline[index];
                let found = edge(picture, point, normal, pool.reach_px);
                flank.push(found.map(|edge| {
                    [point[0] + edge.offset_px * normal[0], point[1] + edge.offset_px * normal[1]]
                }));
            }
        }
    }

    /// Where the flanks meet, by the pair of lines that places the meeting best across the travel.
    fn meeting(&mut self, apex: Vector2<f64>, arm: usize) -> Option<Vector2<f64>> {
        let mut best: Option<(f64, Vector2<f64>)> = None;
        for part in FLANKS {
            let length = ((part * arm as f64).round() as usize).max(4);
            for (points, flank) in self.points.iter_mut().zip(&self.flanks) {
                points.clear();
                points.extend(flank.iter().take(length).flatten());
            }
            if self.points.iter().any(|points| 2 * points.len() < length) {
                continue;
            }
            let lines = [0, 1].map(|side| Line::through(&self.points[side], &mut self.residuals));
            let [Some(a), Some(b)] = lines else { continue };
            let normals = Matrix2::from_rows(&[a.normal.transpose(), b.normal.transpose()]);
            // Flanks that hardly turn meet anywhere.
            if normals.determinant().abs() < LEAST_TURNING_RAD.sin() * 0.5 {
                continue;
            }
            let Some(inverse) = normals.try_inverse() else { continue };
            let corner = inverse * Vector2::new(a.distance, b.distance);
            if (corner - apex).norm() > FARTHEST_MEETING * arm as f64 {
                continue;
            }
            let places = Matrix2::from_diagonal(&Vector2::new(
                a.variance_at(&corner, CORRELATION_PX),
                b.variance_at(&corner, CORRELATION_PX),
            ));
            let variance = (inverse * places * inverse.transpose())[(0, 0)];
            if best.is_none_or(|(least, _)| variance < least) {
                best = Some((variance, corner));
            }
        }
        best.map(|(_, corner)| corner)
    }
}
