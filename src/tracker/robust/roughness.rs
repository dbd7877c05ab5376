//! How much a series jumps from frame to frame, whatever path it is on.
//!
//! The third difference of four successive values hardly sees any path (a sine of 40 px and 130 frames leaves 0.005 px),
//! so its spread is that of what comes and goes within a few frames: noise, raggedness, vibration.

use std::collections::VecDeque;

use arrayvec::ArrayVec;

/// Third differences that are remembered. Chosen: a few seconds of welding.
const WINDOW: usize = 48;
/// Fewest third differences that have a spread.
const LEAST_COUNT: usize = 4;
/// Median of |x| of a normal variable of SD 1.
const MEDIAN_OF_NORMAL: f64 = 0.6745;

/// The spread of a series' third differences, running and robust.
#[derive(Debug, Clone, Default)]
pub struct Roughness {
    last: VecDeque<f64>,
    differences: VecDeque<f64>,
}

/// Σᵢⱼ cᵢcⱼ ψ^|i−j| with c = (1, −3, 3, −1): what noise of variance 1 and correlation ψ from value to value makes of the
/// variance of a third difference. 20 where it is white.
pub fn third_difference_gain(psi: f64) -> f64 {
    20.0 - 30.0 * psi + 12.0 * psi.powi(2) - 2.0 * psi.powi(3)
}

impl Roughness {
    /// Takes in the next value; none breaks the succession.
    pub fn push(&mut self, value: Option<f64>) {
        let Some(value) = value else {
            self.last.clear();
            return;
        };
        self.last.push_back(value);
        if let [a, b, c, d] = *self.last.make_contiguous() {
            self.differences.push_back((d - 3.0 * c + 3.0 * b - a).abs());
            self.last.pop_front();
            if self.differences.len() > WINDOW {
                self.differences.pop_front();
            }
        }
    }

    /// The mean square of the newest `count` third differences; none of fewer.
    pub fn newest_px2(&self, count: usize) -> Option<f64> {
        let newest = self.differences.iter().rev().take(count);
        (self.differences.len() >= count).then(|| newest.map(|x| x * x).sum::<f64>() / count as f64)
    }

    /// The variance of a third difference and the number of those it comes from; none from too few.
    pub fn variance(&self) -> Option<(f64, usize)> {
        let count = self.differences.len();
        if count < LEAST_COUNT {
            return None;
        }
        let mut sorted: ArrayVec<f64, WINDOW> = self.differences.iter().copied().take(WINDOW).collect();
        let (_, &mut median, _) = sorted.select_nth_unstable_by(count / 2, f64::total_cmp);
        Some(((median / MEDIAN_OF_NORMAL).powi(2), count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    fn noise(psi: f64, count: usize) -> Vec<f64> {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let unit = Normal::new(0.0, 1.0).unwrap();
        let next = |x: &mut f64, drive: f64| {
            *x = psi * *x + (1.0 - psi * psi).sqrt() * drive;
            Some(*x)
        };
        (0..count).map(|_| unit.sample(&mut rng)).scan(0.0, next).collect()
    }

    #[test]
    fn third_differences_of_white_and_of_coloured_noise_have_the_variance_that_the_covariance_says() {
        for psi in [0.0_f64, 0.3, 0.5, 0.8] {
            let noise = noise(psi, 100_000);
            let third = noise.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2));
            let variance = third.sum::<f64>() / (noise.len() - 3) as f64;
            assert!((variance / third_difference_gain(psi) - 1.0).abs() < 0.03, "{psi}: {variance}");
        }
    }

    #[test]
    fn the_running_spread_is_that_of_white_noise_on_a_straight_path() {
        let (mut roughness, mut sum) = (Roughness::default(), 0.0);
        let noise = noise(0.0, 4000);
        for (t, noise) in noise.iter().enumerate() {
            roughness.push(Some(noise + 0.3 * t as f64));
            sum += roughness.variance().map_or(0.0, |(variance, _)| variance) / 4000.0;
        }
        assert!((sum / third_difference_gain(0.0) - 1.0).abs() < 0.12, "{sum}");
    }

    #[test]
    fn a_gap_in_the_values_is_no_jump() {
        let mut roughness = Roughness::default();
        for t in 0..40 {
            roughness.push((t % 5 != 4).then_some(f64::from(t) * 10.0));
        }
        assert!(roughness.variance().unwrap().0 < 1e-9);
    }
}
