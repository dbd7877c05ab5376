//! The downhill simplex of Nelder and Mead (1965), for the few parameters of a noise model.

/// A step smaller than this in every parameter ends the search.
const TOLERANCE: f64 = 1e-6;

/// Minimises `objective` from `start` with a first simplex of the size `step`; gives the best point and its value.
///
/// The search ends when the simplex has shrunk to 10⁻⁶, or after 200 evaluations a parameter. An objective that is
/// not finite counts as infinitely bad.
pub(super) fn minimise<const P: usize>(
    start: [f64; P],
    step: f64,
    objective: impl Fn(&[f64; P]) -> f64,
) -> ([f64; P], f64) {
    let value = |point: &[f64; P]| Some(objective(point)).filter(|v| v.is_finite()).unwrap_or(f64::INFINITY);
    let vertex = |point: [f64; P]| (point, value(&point));
    let mut simplex = vec![vertex(start)];
    for parameter in 0..P {
        let mut point = start;
        point[parameter] += step;
        simplex.push(vertex(point));
    }
    for _ in 0..200 * P {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (best, worst) = (simplex[0], simplex[P]);
        let size = |(point, _): &([f64; P], f64)| -> f64 {
            point.iter().zip(&best.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        if simplex.iter().map(size).fold(0.0, f64::max) < TOLERANCE {
            break;
        }
        #[expect(clippy::cast_precision_loss, reason = "a handful of parameters")]
        let centroid: [f64; P] =
            std::array::from_fn(|i| simplex[..P].iter().map(|(point, _)| point[i]).sum::<f64>() / P as f64);
        let along = |t: f64| vertex(std::array::from_fn(|i| centroid[i] + t * (worst.0[i] - centroid[i])));
        let reflected = along(-1.0);
        simplex[P] = if reflected.1 < best.1 {
            let expanded = along(-2.0);
            if expanded.1 < reflected.1 { expanded } else { reflected }
        } else if reflected.1 < simplex[P.saturating_sub(1)].1 {
            reflected
        } else {
            let contracted = along(if reflected.1 < worst.1 { -0.5 } else { 0.5 });
            if contracted.1 < worst.1.min(reflected.1) {
                contracted
            } else {
                for other in &mut simplex[1..] {
                    *other = vertex(std::array::from_fn(|i| 0.5 * (best.0[i] + other.0[i])));
                }
                continue;
            }
        };
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bottom_of_rosenbrocks_valley_is_found() {
        let valley = |p: &[f64; 2]| 100.0 * (p[1] - p[0] * p[0]).powi(2) + (1.0 - p[0]).powi(2);
        let (at, value) = minimise([-1.2, 1.0], 0.5, valley);
        assert!((at[0] - 1.0).abs() < 1e-4 && (at[1] - 1.0).abs() < 1e-4, "{at:?}");
        assert!(value < 1e-9);
    }

    #[test]
    fn an_objective_undefined_at_the_start_is_left_for_where_it_is_defined() {
        let half = |p: &[f64; 1]| if p[0] < 0.0 { f64::NAN } else { (p[0] - 2.0).powi(2) };
        let (at, _) = minimise([-0.5], 1.0, half);
        assert!((at[0] - 2.0).abs() < 1e-4, "{at:?}");
    }
}
