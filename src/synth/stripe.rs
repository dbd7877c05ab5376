//! The stripe's light: cross-section, speckle, reflectance, ends.

use rand_pcg::Pcg64Mcg;

use super::canvas::Canvas;
use super::noise::{Component, SmoothNoise, generator, normal};
use super::profile::{Branch, edge};
use super::scenario::Stripe;

/// Contrast of whole cross-sections relative to that of the grains inside: real frames show both.
const SECTION_SHARE: f64 = 0.7;
/// Length of the plates' reflectance variation along the stripe \[px\] and along the travel \[frames\] (chosen).
const REFLECTANCE_PX: f64 = 24.0;
const REFLECTANCE_FRAMES: f64 = 6.0;
/// How much dimmer the laser line is at the image's ends (chosen: a cylindrical-lens line).
const FAN_FALLOFF: f64 = 0.2;
/// Blur of the ends of a stripe that ends inside the image \[px\] (read off real frames).
pub(super) const END_BLUR_PX: f64 = 1.2;
/// The wings' half width relative to the stripe's.
const WING_WIDTH: f32 = 3.0;

/// The light on one stripe in one frame.
pub(super) struct Illumination<'a> {
    /// The stripe in this seed's numbers.
    pub(super) stripe: &'a Stripe,
    /// Middle of a stripe that ends inside the image \[px\].
    pub(super) centre_px: f64,
    /// The camera's frame number.
    pub(super) tick: usize,
    /// The scene's seed.
    pub(super) seed: u64,
}

impl Illumination<'_> {
    /// Adds the branches' light.
    pub(super) fn paint(&self, branches: &[Branch], canvas: &mut Canvas) {
        let mut rng = generator(self.seed, self.tick as u64, Component::Speckle);
        let incident = self.incident(canvas.width_px());
        for branch in branches {
            self.paint_branch(branch, &incident, &mut rng, canvas);
        }
    }

    /// The laser's brightness and the plates' reflectance at each column \[grey\].
    fn incident(&self, columns: usize) -> Vec<f32> {
        let texture = SmoothNoise::new(self.seed, Component::Texture, 0);
        let half = 0.5 * columns as f64;
        (0..columns)
            .map(|x| {
                let x = x as f64;
                let fan = 1.0 - FAN_FALLOFF * ((x - half) / half).powi(2);
                let end = self.stripe.length_px.map_or(1.0, |length| {
                    let inside = 0.5 * length - (x - self.centre_px).abs();
                    edge(inside, END_BLUR_PX)
                });
                let reflectance = self.stripe.reflectance
                    * f64::from(texture.at(x / REFLECTANCE_PX, 0.0, self.tick as f64 / REFLECTANCE_FRAMES));
                (self.stripe.amplitude_grey * fan * end * (1.0 + reflectance).max(0.1)) as f32
            })
            .collect()
    }

    fn paint_branch(&self, branch: &Branch, incident: &[f32], rng: &mut Pcg64Mcg, canvas: &mut Canvas) {
        let columns = canvas.width_px();
        let sigma = self.stripe.sigma_px as f32;
        let reach = (3.3 * sigma * branch.width.iter().copied().fold(0.1, f32::max)).ceil() as i64;
        let sections = correlated(columns, rng);
        let grains = grain_rows(columns, 2 * reach as usize + 1, rng);
        let (speckle, grain) = ((SECTION_SHARE * self.stripe.speckle) as f32, self.stripe.speckle as f32);
        // Log-normal of unit mean: never negative, with the bright spots of real speckle.
        let log_normal = |x: f32, contrast: f32| {
            let variance = (1.0 + contrast * contrast).ln();
            (x * variance.sqrt() - 0.5 * variance).exp()
        };
        let wings = self.stripe.wings as f32;
        let wing_reach = if wings > 0.0 { (6.0 * WING_WIDTH * sigma).ceil() as i64 } else { reach };
        for x in 0..columns {
            let gain = branch.gain[x] * incident[x];
            if gain < 0.05 {
                continue;
            }
            let peak = gain * log_normal(sections[x], speckle);
            let width = sigma * branch.width[x];
            let ridge = branch.row_px[x];
            let nearest = ridge.round() as i64;
            for offset in -wing_reach..=wing_reach {
                let row = nearest + offset;
                let distance = (row as f32 - ridge) / width;
                let mut light = gain * wings / (1.0 + (distance / WING_WIDTH).powi(2));
                if offset.abs() <= reach {
                    let grains_here = grains[(offset + reach) as usize][x];
                    light += peak * (-0.5 * distance * distance).exp() * log_normal(grains_here, grain);
                }
                canvas.add(x as i64, row, light);
            }
        }
    }
}

/// Normal numbers of unit variance, correlated over about two samples: the grain of speckle behind a lens.
fn correlated(samples: usize, rng: &mut Pcg64Mcg) -> Vec<f32> {
    let white: Vec<f32> = (0..samples + 2).map(|_| normal(rng)).collect();
    let norm = 1.5_f32.sqrt();
    white.windows(3).map(|w| (0.5 * w[0] + w[1] + 0.5 * w[2]) / norm).collect()
}

/// Rows of correlated numbers, correlated from row to row as well.
fn grain_rows(columns: usize, rows: usize, rng: &mut Pcg64Mcg) -> Vec<Vec<f32>> {
    let single: Vec<Vec<f32>> = (0..rows + 1).map(|_| correlated(columns, rng)).collect();
    let norm = (1.0_f32 + 0.36).sqrt();
    single.windows(2).map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| (a + 0.6 * b) / norm).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_speckle_the_centroid_of_every_column_is_the_ridge() {
        let stripe = Stripe { speckle: 0.0, reflectance: 0.0, wings: 0.0, ..Stripe::default() };
        let light = Illumination { stripe: &stripe, centre_px: 50.0, tick: 0, seed: 1 };
        let branch = Branch {
            row_px: (0..100).map(|x| 40.0 + 0.137 * x as f32).collect(),
            gain: vec![1.0; 100],
            width: vec![1.0; 100],
            on_plates: true,
        };
        let mut canvas = Canvas::filled(100, 100, 0.0);
        light.paint(std::slice::from_ref(&branch), &mut canvas);
        for x in 0..100 {
            let column: Vec<f32> = (0..100).map(|y| canvas.light()[y * 100 + x]).collect();
            let sum: f32 = column.iter().sum();
            let centroid = column.iter().enumerate().map(|(y, g)| y as f32 * g).sum::<f32>() / sum;
            assert!((centroid - branch.row_px[x]).abs() < 0.01, "{centroid} {}", branch.row_px[x]);
        }
    }
}
