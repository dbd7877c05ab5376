//! The seam's coordinate across the stripe.
//!
//! The model is the augmented state of Du 2022, turned round: position, velocity and a coloured part, but here the coloured
//! part is real. The plates shake under the sensor, and where they are is what is asked for; so the estimate is the sum of
//! both. How much they shake is measured on the recording ([`Roughness`]).
#![expect(non_snake_case, reason = "covariances carry the literature's letters")]

use nalgebra::Matrix3;

use super::roughness::{Roughness, third_difference_gain};
use crate::kalman::{ColouredMeasurement, Gaussian, InvalidParameter, Link};
use crate::tracker::TrackerError;

/// White acceleration of the plates' own path \[px²/beat⁴\]. Chosen: a dent of some px in some ten beats.
const PROCESS_NOISE: f64 = 1e-3;
/// ψ of the shaking, a beat. Chosen: arms swing within a few frames.
pub const SHAKING_COEFFICIENT: f64 = 0.3;
/// Variance of the shaking before it is measured \[px²\], and the number of third differences that this counts as.
/// Chosen: 0.65 px, as on recordings of robots.
pub const FIRST_SHAKING_PX2: f64 = 0.42;
const PRIOR_COUNT: f64 = 8.0;
/// Range of the measured variance \[px²\]. Chosen.
const SHAKING_RANGE_PX2: std::ops::RangeInclusive<f64> = 0.01..=100.0;
/// Variance of the velocity at the start \[px²/beat²\]. Chosen.
const START_VELOCITY_VARIANCE: f64 = 1.0;
/// Squared innovation over its variance above which the plate has jumped: the filter starts anew. Chosen.
const JUMP_NIS: f64 = 25.0;

/// A coordinate and its variance \[px, px²\].
pub type Reading = (f64, f64);

/// The model with its shaking of variance `shaking_px2`, measured with variance `R_px2`, in pixels and beats.
///
/// # Errors
/// When a variance is negative or not finite.
pub fn model(shaking_px2: f64, R_px2: f64) -> Result<ColouredMeasurement, InvalidParameter> {
    let drive = shaking_px2 * (1.0 - SHAKING_COEFFICIENT * SHAKING_COEFFICIENT);
    ColouredMeasurement::new(PROCESS_NOISE, drive, SHAKING_COEFFICIENT, R_px2.max(1e-4), 1.0)?
        .with_velocity_variance(START_VELOCITY_VARIANCE)
}

/// Where the plate is: the path and the shaking together.
pub fn reading(state: &Gaussian<3>) -> Reading {
    let P = &state.P;
    (state.x[0] + state.x[2], (P[(0, 0)] + 2.0 * P[(0, 2)] + P[(2, 2)]).max(0.0))
}

/// The filter across the stripe.
#[derive(Debug, Clone)]
pub struct Height {
    state: Gaussian<3>,
    roughness: Roughness,
    mean_R_px2: f64,
    /// The state before the last step, F, and what was predicted; none where the filter started.
    step: Option<(Gaussian<3>, Matrix3<f64>, Gaussian<3>)>,
}

impl Height {
    /// Starts at a reading.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn start((v_px, R_px2): Reading) -> Result<Self, TrackerError> {
        let state = start(v_px, R_px2, FIRST_SHAKING_PX2)?;
        Ok(Self { state, roughness: Roughness::default(), mean_R_px2: R_px2, step: None })
    }

    /// Goes `beats` on.
    ///
    /// # Errors
    /// When `beats` is not positive.
    pub fn predict(&mut self, beats: f64) -> Result<(), TrackerError> {
        let space = model(self.shaking_px2(), self.mean_R_px2)?.state_space(beats)?;
        let before = self.state;
        self.state = before.predict(&space);
        self.step = Some((before, space.F, self.state));
        Ok(())
    }

    /// Takes in a reading, or none.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn update(&mut self, measured: Option<Reading>) -> Result<(), TrackerError> {
        self.roughness.push(measured.map(|(v_px, _)| v_px));
        let Some((v_px, R_px2)) = measured else { return Ok(()) };
        self.mean_R_px2 += 0.1 * (R_px2 - self.mean_R_px2);
        let space = model(self.shaking_px2(), R_px2)?.state_space(1.0)?;
        let update = self.state.update(&space, &[Some(v_px)], None)?;
        let jumped = update.nis.is_some_and(|nis| nis > JUMP_NIS);
        if jumped {
            self.step = None;
        }
        self.state = if jumped { start(v_px, R_px2, self.shaking_px2())? } else { update.posterior };
        Ok(())
    }

    /// The last step, as a smoother takes it.
    pub fn link(&self) -> Link<3> {
        let Some((before, F, prior)) = &self.step else { return Link::first(self.state) };
        Link { posterior: self.state, ..Link::predicted(before, F, *prior) }
    }

    /// The coordinate across the stripe.
    pub fn reading(&self) -> Reading {
        reading(&self.state)
    }

    /// Variance of the shaking \[px²\], as measured so far.
    pub fn shaking_px2(&self) -> f64 {
        let Some((variance_px2, count)) = self.roughness.variance() else { return FIRST_SHAKING_PX2 };
        let noise_px2 = third_difference_gain(0.0) * self.mean_R_px2;
        let measured = (variance_px2 - noise_px2) / third_difference_gain(SHAKING_COEFFICIENT);
        let count = count as f64;
        let shaking = (count * measured.max(0.0) + PRIOR_COUNT * FIRST_SHAKING_PX2) / (count + PRIOR_COUNT);
        shaking.clamp(*SHAKING_RANGE_PX2.start(), *SHAKING_RANGE_PX2.end())
    }
}

/// The state after a reading and nothing else: the shaking is not known apart from the path, their sum is.
fn start(v_px: f64, R_px2: f64, shaking_px2: f64) -> Result<Gaussian<3>, InvalidParameter> {
    model(shaking_px2, R_px2)?.start(v_px)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    #[test]
    fn shaking_plates_are_followed_with_an_honest_sigma() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(3);
        let unit = Normal::new(0.0, 1.0).unwrap();
        for shaking_px in [0.1, 0.65, 2.0] {
            let (mut inside, mut shake, mut height) = (0, 0.0, Height::start((100.0, 0.02)).unwrap());
            for t in 0..400 {
                shake = 0.3 * shake + shaking_px * (1.0_f64 - 0.09).sqrt() * unit.sample(&mut rng);
                let truth = 100.0 + 0.1 * f64::from(t) + shake;
                height.predict(1.0).unwrap();
                let seen = t % 20 < 17;
                height.update(seen.then(|| (truth + 0.02_f64.sqrt() * unit.sample(&mut rng), 0.02))).unwrap();
                let (v_px, variance_px2) = height.reading();
                inside += usize::from((v_px - truth).powi(2) < 4.0 * variance_px2);
            }
            assert!((360..=398).contains(&inside), "{shaking_px}: {inside} of 400 within 2σ");
        }
    }

    #[test]
    fn a_plate_that_jumps_is_found_at_its_new_height() {
        let mut height = Height::start((100.0, 0.02)).unwrap();
        for t in 0..60 {
            height.predict(1.0).unwrap();
            height.update(Some((if t < 40 { 100.0 } else { 140.0 }, 0.02))).unwrap();
            assert!((height.reading().0 - if t < 40 { 100.0 } else { 140.0 }).abs() < 0.5);
        }
    }
}
