//! Randomness that depends on (seed, frame, component) only, so that a frame can be rendered alone, in any order.

use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// The independent sources of randomness in a scene.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
pub(super) enum Component {
    /// The numbers drawn afresh for a seed.
    Variation = 1,
    /// Motion, raggedness, flicker: simulated once for the whole recording.
    Timeline,
    /// Speckle of the stripe in one frame.
    Speckle,
    /// Hot particles in one frame.
    Spatter,
    /// Shot and read noise of one frame.
    Sensor,
    /// The sensor's fixed pattern.
    FixedPattern,
    /// Texture of the plates.
    Texture,
    /// Smoke and its haze.
    Smoke,
    /// What covers the seam.
    Cover,
    /// The slowly changing look of a hairline joint.
    Hairline,
    /// The ragged outline of a melt pool.
    Outline,
    /// The plume over a melt pool.
    Plume,
    /// Where marks lie on the plates, and their outlines.
    Marks,
    /// Mill scale and grinding marks.
    Finish,
    /// How beads of earlier passes wander.
    Beads,
    /// Reflections and a second seam.
    Rivals,
    /// Dirt, dead pixels, gaps of the laser's line, shadows.
    View,
}

/// A generator for one component of one frame.
pub(super) fn generator(seed: u64, frame: u64, component: Component) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(mixed(mixed(seed, frame), component as u64))
}

/// Two words mixed into one; the finaliser of SplitMix64 (Steele, Lea and Flood 2014).
const fn mixed(a: u64, b: u64) -> u64 {
    let mut z = a.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(b).wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// One standard normal number.
pub(super) fn normal(rng: &mut impl Rng) -> f32 {
    StandardNormal.sample(rng)
}

/// A first-order autoregressive process with stationary standard deviation `sd` and correlation `rho` from step to
/// step, started in its stationary state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ar1 {
    rho: f64,
    sd: f64,
    value: Option<f64>,
}

impl Ar1 {
    /// A process that has not begun.
    pub(super) const fn new(sd: f64, rho: f64) -> Self {
        Self { rho, sd, value: None }
    }

    /// The next value.
    pub(super) fn step(&mut self, rng: &mut impl Rng) -> f64 {
        let innovation: f64 = StandardNormal.sample(rng);
        let value = match self.value {
            None => self.sd * innovation,
            Some(last) => self.rho * last + self.sd * (1.0 - self.rho * self.rho).sqrt() * innovation,
        };
        self.value = Some(value);
        value
    }
}

/// Smooth noise over three coordinates: normal numbers on an integer lattice, interpolated (value noise, Perlin 1985).
/// A pure function: no state, no size.
#[derive(Debug, Clone, Copy)]
pub(super) struct SmoothNoise {
    key: u64,
}

impl SmoothNoise {
    /// A field of its own for this seed, component and number.
    pub(super) const fn new(seed: u64, component: Component, number: u64) -> Self {
        Self { key: mixed(mixed(seed, component as u64), number) }
    }

    /// The value at a point; about zero mean and unit variance on the lattice, somewhat less between.
    pub(super) fn at(&self, x: f64, y: f64, t: f64) -> f32 {
        let (xi, xf) = split(x);
        let (yi, yf) = split(y);
        let (ti, tf) = split(t);
        let mut sum = 0.0;
        for (dt, wt) in [(0, 1.0 - tf), (1, tf)] {
            for (dy, wy) in [(0, 1.0 - yf), (1, yf)] {
                let row = wt * wy;
                if row > 0.0 {
                    sum += row * (1.0 - xf) * self.lattice(xi, yi + dy, ti + dt);
                    sum += row * xf * self.lattice(xi + 1, yi + dy, ti + dt);
                }
            }
        }
        sum
    }

    /// Three octaves over a turned plane, so that no lattice is seen; about zero mean and unit variance.
    pub(super) fn cloud(&self, x: f64, y: f64, t: f64) -> f32 {
        let (mut x, mut y, mut weight, mut sum) = (x, y, 1.15_f32, 0.0);
        for octave in 0..3 {
            // A turn by atan(3/4) and a scale of 2.1 from octave to octave.
            (x, y) = (0.8 * x - 0.6 * y + 0.37, 0.6 * x + 0.8 * y + 0.71);
            sum += weight * self.at(x, y, t + 17.0 * f64::from(octave));
            (x, y, weight) = (2.1 * x, 2.1 * y, 0.55 * weight);
        }
        sum
    }

    /// The nearly normal number of a lattice point: the sum of four uniform ones.
    fn lattice(&self, x: i64, y: i64, t: i64) -> f32 {
        let bits = mixed(mixed(mixed(self.key, x as u64), y as u64), t as u64);
        let sum: u64 = (0..4).map(|i| (bits >> (16 * i)) & 0xFFFF).sum();
        (sum as f32 / 65535.0 - 2.0) * 3.0_f32.sqrt()
    }
}

/// Integer and smoothed fractional part.
fn split(x: f64) -> (i64, f32) {
    let floor = x.floor();
    let f = (x - floor) as f32;
    (floor as i64, f * f * (3.0 - 2.0 * f))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_autoregressive_process_has_the_stated_deviation_and_correlation() {
        let mut rng = generator(3, 0, Component::Timeline);
        let mut process = Ar1::new(0.6, 0.5);
        let x: Vec<f64> = (0..40_000).map(|_| process.step(&mut rng)).collect();
        let variance = x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64;
        let lagged = x.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (x.len() - 1) as f64;
        assert!((variance.sqrt() - 0.6).abs() < 0.015, "{variance}");
        assert!((lagged / variance - 0.5).abs() < 0.03, "{lagged}");
    }

    #[test]
    fn smooth_noise_is_continuous_and_has_unit_variance_on_its_lattice() {
        let noise = SmoothNoise::new(1, Component::Texture, 0);
        assert!((noise.at(4.999_999, 2.5, 1.0) - noise.at(5.0, 2.5, 1.0)).abs() < 1e-4);
        let n = 20_000;
        let variance = (0..n).map(|i| noise.at(f64::from(i), 7.0, 0.0).powi(2)).sum::<f32>() / n as f32;
        assert!((variance - 1.0).abs() < 0.04, "{variance}");
    }

    #[test]
    fn components_and_frames_draw_from_different_streams() {
        let first = |frame, component| generator(1, frame, component).random::<u64>();
        assert_ne!(first(0, Component::Speckle), first(1, Component::Speckle));
        assert_ne!(first(0, Component::Speckle), first(0, Component::Sensor));
    }
}
