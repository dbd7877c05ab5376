//! R of the measurements: all its parts, in one place.
//!
//! R = scale · (white + edge cost) · inflation, beside it the coloured part scale · [`COLOUR_VARIANCE_PX2`]. Filter and
//! smoother use the same.

use super::filter::{COLOUR_COEFFICIENT, COLOUR_VARIANCE_PX2};
use super::roughness::{Roughness, third_difference_gain};
use crate::imgproc::geometry::{EVEN_VARIANCE_PX2, JointFit};

/// White part of R of a fit \[px²\]: what a fit on an even stripe says of itself.
pub const WHITE_VARIANCE_PX2: f64 = EVEN_VARIANCE_PX2;
/// Edge cost of an undisturbed fit, and how R grows with the square of what is above it \[px²\]. Tuned: at a cost of
/// 0.02 the squared error is some 1 px², at 0.05 some 5 px².
const USUAL_COST: f64 = 0.005;
const VARIANCE_PER_COST2_PX2: f64 = 3000.0;
/// NIS above which a sighting is used with an inflated R: at it, R is as it is; above, it grows with the NIS. Prototype.
pub const INFLATE_NIS: f64 = 4.0;

/// Third differences of the expected noise that are believed beforehand. Tuned.
const PRIOR_COUNT: usize = 8;
/// Range of the scale. Tuned: to believe edges sharper than they were for a while costs accuracy, to believe torn edges
/// sharp costs the seam; so it goes far up and little down.
const SCALE_RANGE: std::ops::RangeInclusive<f64> = 0.7..=64.0;
/// Plates are as ragged in one shop as in another: 0.6 px at 0.073 mm/px is the nominal noise, so a
/// pixel of this many millimetres has it; finer ones see the same raggedness larger.
const NOMINAL_MM_PER_PX: f64 = 0.073;
/// Largest scale that is expected for this reason. Chosen: below 0.02 mm/px other things than raggedness blur an edge.
const MOST_EXPECTED: f64 = 16.0;

/// R of a fit under the nominal noise \[px²\]: edges that explain the stripe badly are worth less.
pub fn of_fit(fit: &JointFit) -> f64 {
    let excess_cost = fit.edges.map_or(0.0, |edges| (edges.cost - USUAL_COST).max(0.0));
    fit.along_variance_px2 + VARIANCE_PER_COST2_PX2 * excess_cost.powi(2)
}

/// The factor on R of a sighting whose NIS is `nis`.
pub fn inflation(nis: f64) -> f64 {
    (nis / INFLATE_NIS).max(1.0)
}

/// The scale of the noise where a pixel is `mm_per_px` millimetres, before anything is measured; 1 where that is not known.
pub fn expected_scale(mm_per_px: Option<f64>) -> f64 {
    mm_per_px.map_or(1.0, |mm_per_px| (NOMINAL_MM_PER_PX / mm_per_px).powi(2).clamp(1.0, MOST_EXPECTED))
}

/// How noisy the measurements are, from the measurements themselves: 1 is the nominal noise.
#[derive(Debug, Clone)]
pub struct NoiseScale {
    expected: f64,
    roughness: Roughness,
}

impl NoiseScale {
    /// Nothing is measured yet; `expected` is what the sensor lets expect.
    pub fn new(expected: f64) -> Self {
        Self { expected, roughness: Roughness::default() }
    }

    /// Takes in the position of the next frame; none breaks the succession.
    pub fn push(&mut self, position_px: Option<f64>) {
        self.roughness.push(position_px);
    }

    /// The scale of the noise's variance.
    pub fn scale(&self) -> f64 {
        let Some((variance_px2, count)) = self.roughness.variance() else { return self.expected };
        let nominal_px2 = third_difference_gain(0.0) * WHITE_VARIANCE_PX2
            + third_difference_gain(COLOUR_COEFFICIENT) * COLOUR_VARIANCE_PX2;
        let trust = count as f64 / (count + PRIOR_COUNT) as f64;
        (trust * variance_px2 / nominal_px2 + (1.0 - trust) * self.expected)
            .clamp(*SCALE_RANGE.start(), *SCALE_RANGE.end())
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
        let (mut scale, mut colour) = (NoiseScale::new(1.0), 0.0);
        let mut sum = 0.0;
        for t in 0..2000 {
            let drive = (noise * COLOUR_VARIANCE_PX2 * (1.0 - COLOUR_COEFFICIENT.powi(2))).sqrt();
            colour = COLOUR_COEFFICIENT * colour + drive * unit.sample(&mut rng);
            let white = (noise * WHITE_VARIANCE_PX2).sqrt() * unit.sample(&mut rng);
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
    fn r_grows_with_the_edge_cost_and_with_a_large_innovation_alone() {
        assert_eq!(inflation(1.0), 1.0);
        assert_eq!(inflation(8.0), 2.0);
    }
}
