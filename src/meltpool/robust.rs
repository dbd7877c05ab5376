//! Fits that a few stray points do not move: least squares with Tukey's weights, redone until they settle.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Rounds of reweighting; chosen, the weights have settled by then.
const ROUNDS: usize = 6;
/// Tukey's constant: 95 % efficiency under normal noise.
const TUKEY: f64 = 4.685;
/// Standard deviation of normal noise over its median absolute value.
const SIGMA_OVER_MEDIAN: f64 = 1.482_6;
/// Least scale of the residuals \[px\]; chosen, so that a perfect fit does not throw all but a few points out.
const LEAST_SCALE_PX: f64 = 0.05;

/// A straight line: the points x with normal · x = distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub(super) normal: Vector2<f64>,
    pub(super) distance: f64,
    pub(super) centre: Vector2<f64>,
    /// Residual variance \[px²\], number of points by weight, and their spread along the line \[px²\].
    pub(super) variance: f64,
    pub(super) weight: f64,
    spread: f64,
}

impl Line {
    /// The line through points, by orthogonal distance; none with fewer than three or without a direction.
    pub(super) fn through(points: &[[f64; 2]], residuals: &mut Vec<f64>) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let mut weights_from: Option<(Self, f64)> = None;
        for _ in 0..ROUNDS {
            let weight = |point: &Vector2<f64>| {
                weights_from.map_or(1.0, |(line, scale): (Self, f64)| tukey(line.residual(point) / scale))
            };
            let (mut sum, mut mean) = (0.0, Vector2::zeros());
            for point in points.iter().map(|&p| Vector2::from(p)) {
                sum += weight(&point);
                mean += weight(&point) * point;
            }
            if sum < 2.0 {
                return None;
            }
            mean /= sum;
            let mut scatter = Matrix2::zeros();
            for point in points.iter().map(|&p| Vector2::from(p)) {
                let d = point - mean;
                scatter += weight(&point) * d * d.transpose();
            }
            // The eigenvectors of a symmetric 2 x 2 matrix, in closed form.
            let angle = 0.5 * (2.0 * scatter[(0, 1)]).atan2(scatter[(0, 0)] - scatter[(1, 1)]);
            let direction = Vector2::new(angle.cos(), angle.sin());
            let normal = Vector2::new(-direction.y, direction.x);
            let spread = (direction.transpose() * scatter * direction)[0];
            if spread <= 0.0 {
                return None;
            }
            let variance = (normal.transpose() * scatter * normal)[0] / (sum - 1.0).max(1.0);
            let line = Self { normal, distance: normal.dot(&mean), centre: mean, variance, weight: sum, spread };
            residuals.clear();
            residuals.extend(points.iter().map(|&p| line.residual(&Vector2::from(p)).abs()));
            weights_from = Some((line, scale(residuals)));
        }
        weights_from.map(|(line, _)| line)
    }

    fn residual(&self, point: &Vector2<f64>) -> f64 {
        self.normal.dot(point) - self.distance
    }

    /// Variance of the line's place beside `point` \[px²\], `point` near the line. `correlation` neighbours count as one.
    pub(super) fn variance_at(&self, point: &Vector2<f64>, correlation: f64) -> f64 {
        let along = (point - self.centre).norm_squared();
        let variance = self.variance.max(LEAST_SCALE_PX * LEAST_SCALE_PX);
        correlation * variance * (1.0 / self.weight + along / self.spread)
    }
}

/// A parabola a + b t + c t² through values at `t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parabola {
    pub(super) coefficients: Vector3<f64>,
    /// Residual variance, number of points by weight, and their spread in t.
    pub(super) variance: f64,
    pub(super) weight: f64,
    spread: f64,
}

impl Parabola {
    /// The parabola through points (t, value); none with fewer than three or when they do not spread. `least_scale` is
    /// the least scale of the residuals, in the unit of the values.
    pub(super) fn through(points: &[[f64; 2]], least_scale: f64, residuals: &mut Vec<f64>) -> Option<Self> {
        let mut fit: Option<(Self, f64)> = None;
        for _ in 0..ROUNDS {
            let (mut normal, mut right, mut sum) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
            let mut squares = 0.0;
            for &[t, value] in points {
                let weight = fit.map_or(1.0, |(p, scale): (Self, f64)| tukey((value - p.at(t)) / scale));
                let row = Vector3::new(1.0, t, t * t);
                normal += weight * row * row.transpose();
                right += weight * value * row;
                sum += weight;
                squares += weight * value * value;
            }
            if sum < 3.0 {
                return None;
            }
            let coefficients = normal.cholesky()?.solve(&right);
            let variance = (squares - coefficients.dot(&right)).max(0.0) / (sum - 2.0).max(1.0);
            let spread = normal[(1, 1)] - normal[(0, 1)].powi(2) / sum;
            let parabola = Self { coefficients, variance, weight: sum, spread };
            residuals.clear();
            residuals.extend(points.iter().map(|&[t, value]| (value - parabola.at(t)).abs()));
            fit = Some((parabola, scale(residuals).max(least_scale)));
        }
        fit.map(|(parabola, _)| parabola)
    }

    /// Where the parabola turns; none when it is a straight line.
    pub(super) fn vertex(&self) -> Option<f64> {
        let c = &self.coefficients;
        (c[2] != 0.0).then(|| -0.5 * c[1] / c[2])
    }

    /// Variance of the vertex's place near the points' middle. `correlation` neighbours count as one.
    pub(super) fn vertex_variance(&self, correlation: f64) -> f64 {
        let variance = self.variance.max(LEAST_SCALE_PX * LEAST_SCALE_PX);
        correlation * variance / (4.0 * self.coefficients[2].powi(2) * self.spread.max(f64::MIN_POSITIVE))
    }

    /// The value at `t`.
    pub(super) fn at(&self, t: f64) -> f64 {
        let c = &self.coefficients;
        c[0] + t * (c[1] + t * c[2])
    }
}

fn tukey(u: f64) -> f64 {
    let u = u / TUKEY;
    if u.abs() < 1.0 { (1.0 - u * u).powi(2) } else { 0.0 }
}

/// A robust standard deviation of absolute residuals; they are reordered.
fn scale(residuals: &mut [f64]) -> f64 {
    let middle = residuals.len() / 2;
    let (_, median, _) = residuals.select_nth_unstable_by(middle, f64::total_cmp);
    (SIGMA_OVER_MEDIAN * *median).max(LEAST_SCALE_PX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn three_stray_points_in_twenty_do_not_move_a_line() {
        let mut points: Vec<[f64; 2]> = (0..20).map(|i| [f64::from(i), 3.0 + 0.5 * f64::from(i)]).collect();
        for i in [4, 11, 12] {
            points[i][1] += 6.0;
        }
        let line = Line::through(&points, &mut vec![]).unwrap();
        assert_abs_diff_eq!(line.residual(&Vector2::new(40.0, 23.0)), 0.0, epsilon = 1e-6);
    }

    #[test]
    fn an_upright_line_is_as_good_as_any() {
        let points: Vec<[f64; 2]> = (0..9).map(|i| [7.0, f64::from(i)]).collect();
        let line = Line::through(&points, &mut vec![]).unwrap();
        assert_abs_diff_eq!(line.distance.abs(), 7.0, epsilon = 1e-9);
    }

    #[test]
    fn a_parabola_passes_stray_points_by() {
        let value = |t: f64| 5.0 - 2.0 * t * t;
        let mut points: Vec<[f64; 2]> = (-10..=10).map(|i| f64::from(i) / 10.0).map(|t| [t, value(t)]).collect();
        points[3][1] = 9.0;
        points[4][1] = 9.0;
        let parabola = Parabola::through(&points, 1e-6, &mut vec![]).unwrap();
        assert_abs_diff_eq!(parabola.at(0.0), 5.0, epsilon = 1e-3);
    }

    #[test]
    fn two_points_make_no_line_and_no_parabola() {
        let points = [[0.0, 1.0], [1.0, 2.0]];
        assert_eq!(Line::through(&points, &mut vec![]), None);
        assert_eq!(Parabola::through(&points, 1e-6, &mut vec![]), None);
    }
}
