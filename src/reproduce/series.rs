//! Noise for simulated series.

use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// Mean absolute value of a Gaussian over its σ, √(2/π).
pub(super) const MEAN_ABSOLUTE_GAUSSIAN: f64 = 0.797_884_560_802_865_4;

/// A reproducible source of noise.
pub(super) fn generator(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// Gaussian noise of deviation `sigma` and lag-1 correlation `rho`, stationary from its first value.
pub(super) fn correlated(count: usize, sigma: f64, rho: f64, rng: &mut Pcg64) -> Vec<f64> {
    let mut value = 0.0;
    let drive = (1.0 - rho * rho).sqrt();
    (0..count)
        .map(|k| {
            let white: f64 = StandardNormal.sample(rng);
            value = if k == 0 { white } else { rho * value + drive * white };
            sigma * value
        })
        .collect()
}

/// Where `share` of the values are, errors of either sign between the bounds of `size`; none elsewhere.
pub(super) fn outliers(count: usize, share: f64, size: (f64, f64), rng: &mut Pcg64) -> Vec<Option<f64>> {
    (0..count)
        .map(|_| {
            let hit = rng.random::<f64>() < share;
            let magnitude = rng.random_range(size.0..size.1);
            let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
            hit.then_some(sign * magnitude)
        })
        .collect()
}
