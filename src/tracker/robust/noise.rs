//! How noisy the measurements are, from the measurements themselves.
//!
//! The third difference of four successive positions hardly sees any path (a sine of 40 px and 130 frames leaves
//! 0.005 px), so its spread is the noise's, whatever the filter believes.

use std::collections::VecDeque;

use super::GEOMETRY_VARIANCE_PX2;
use super::filter::{COLOUR_COEFFICIENT, COLOUR_VARIANCE_PX2};

/// Third differences that are remembered. Chosen: a few seconds of welding.
const WINDOW: usize = 48;
/// Third differences of the nominal noise that are believed beforehand. Tuned.
const PRIOR_COUNT: usize = 8;
/// Range of the scale. Tuned: to believe edges sharper than they were for a while costs accuracy, to believe torn edges
/// sharp costs the seam; so it goes far up and little down.
const RANGE: std::ops::RangeInclusive<f64> = 0.7..=8.0;
/// Median of |x| of a normal variable of SD 1.
const MEDIAN_OF_NORMAL: f64 = 0.6745;

/// A running, robust estimate of the noise's scale: 1 is the nominal noise.
#[derive(Debug, Clone, Default)]
pub struct NoiseScale {
    last: VecDeque<f64>,
    differences_px: VecDeque<f64>,
}

/// Variance of a third difference under the nominal noise \[px²\]: Σᵢⱼ cᵢcⱼ times the noise's covariance, with
/// c = (1, −3, 3, −1).
fn nominal_variance_px2() -> f64 {
    let psi = COLOUR_COEFFICIENT;
    20.0 * GEOMETRY_VARIANCE_PX2 + COLOUR_VARIANCE_PX2 * (20.0 - 30.0 * psi + 12.0 * psi.powi(2) - 2.0 * psi.powi(3))
}

impl NoiseScale {
    /// Takes in the position of the next frame; none breaks the succession.
    pub fn push(&mut self, position_px: Option<f64>) {
        let Some(position_px) = position_px else {
            self.last.clear();
            return;
        };
        self.last.push_back(position_px);
        if let [a, b, c, d] = *self.last.make_contiguous() {
            self.differences_px.push_back((d - 3.0 * c + 3.0 * b - a).abs());
            self.last.pop_front();
            if self.differences_px.len() > WINDOW {
                self.differences_px.pop_front();
            }
        }
    }

    /// The scale of the noise's variance.
    pub fn scale(&self) -> f64 {
        let count = self.differences_px.len();
        if count < 4 {
            return 1.0;
        }
        let mut sorted: Vec<f64> = self.differences_px.iter().copied().collect();
        let (_, &mut median, _) = sorted.select_nth_unstable_by(count / 2, f64::total_cmp);
        let measured = (median / MEDIAN_OF_NORMAL).powi(2) / nominal_variance_px2();
        let trust = count as f64 / (count + PRIOR_COUNT) as f64;
        (trust * measured + (1.0 - trust)).clamp(*RANGE.start(), *RANGE.end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    fn scale_of(noise: f64, path: impl Fn(f64) -> f64) -> f64 {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let unit = Normal::new(0.0, 1.0).unwrap();
        let (mut scale, mut colour) = (NoiseScale::default(), 0.0);
        let mut sum = 0.0;
        for t in 0..2000 {
            let drive = (noise * COLOUR_VARIANCE_PX2 * (1.0 - COLOUR_COEFFICIENT.powi(2))).sqrt();
            colour = COLOUR_COEFFICIENT * colour + drive * unit.sample(&mut rng);
            let white = (noise * GEOMETRY_VARIANCE_PX2).sqrt() * unit.sample(&mut rng);
            scale.push(Some(path(f64::from(t)) + colour + white));
            sum += if t >= 1000 { scale.scale() / 1000.0 } else { 0.0 };
        }
        sum
    }

    #[test]
    fn the_scale_is_that_of_the_noise_on_straight_and_on_winding_paths() {
        for noise in [0.8, 1.0, 2.0, 5.0] {
            for path in [|t: f64| 0.5 * t, |t: f64| 41.0 * (t / 20.8).sin()] {
                let found = scale_of(noise, path);
                // A seventh of the weight stays with the nominal noise.
                let expected = (6.0 * noise + 1.0) / 7.0;
                assert!((found / expected - 1.0).abs() < 0.15, "{noise}: {found}");
            }
        }
    }

    #[test]
    fn a_gap_in_the_measurements_is_no_jump() {
        let mut scale = NoiseScale::default();
        for t in 0..40 {
            scale.push((t % 5 != 4).then_some(f64::from(t) * 10.0));
        }
        assert!(scale.scale() <= 0.7);
    }
}
