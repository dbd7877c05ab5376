//! The seam's estimator along the stripe: interacting models of Du 2022's augmented state, in pixels of the view and beats.
//!
//! A camera is chosen for its seam: how far the seam moves from frame to frame differs less between shops than how far it
//! moves in a second. So the models' unit of time is the beat, the recording's own period.
#![expect(non_snake_case, reason = "covariances carry the literature's letters")]

use nalgebra::{SMatrix, vector};

use super::part::{Part, Parts};
use crate::kalman::{
    Bending, ColouredMeasurement, Gaussian, Imm, InnovationNotPositive, InvalidParameter, Link, StateSpace,
};

/// Number of models, and the places of two of them.
const MODELS: usize = 3;
const BEND: usize = 1;
const CORNER: usize = 2;
/// White acceleration of the models \[px²/beat⁴\]: nearly straight, bending, sharp corner. The first and the last from the
/// prototype.
const KINKS: [f64; MODELS] = [1e-7, 1e-5, 3e-2];
/// SD of their lasting acceleration \[px/beat²\] and how long a bend lasts \[beats\]. Chosen: the bends of sines and
/// S-curves of some 40 px and 100 frames; in the others it plays no part.
const BENDS: [(f64, f64); MODELS] = [(1e-4, 1.0), (0.15, 15.0), (1e-2, 1.0)];
/// A bend turns the path: the faster the seam, the larger its acceleration. SD of the acceleration as a share of the speed
/// \[1/beat\], and for how long a speed counts, since a sine bends most where it stands still: what is left of it after a
/// beat. Chosen: the speed changes by itself within some ten beats.
const BEND_PER_SPEED: f64 = 0.07;
const SPEED_MEMORY: f64 = 0.97;
/// Largest such SD \[px/beat²\]. Chosen.
const MOST_BEND: f64 = 2.0;
/// Process noise that the smoother's fit starts from \[px²/beat⁴\].
pub const PROCESS_NOISE: f64 = 2e-4;
/// Probability that a model stays for a beat. Prototype.
const STAY: f64 = 0.998;
/// ψ and stationary variance of the coloured measurement noise \[px²\]: plate edges are ragged. Prototype.
pub const COLOUR_COEFFICIENT: f64 = 0.5;
/// See [`COLOUR_COEFFICIENT`].
pub const COLOUR_VARIANCE_PX2: f64 = 0.18;
/// Variance of the seam's own vibration along the stripe \[px²\], which no filter can follow: part of the reported σ.
/// Chosen: 0.12 px, as machines vibrate.
pub const VIBRATION_VARIANCE_PX2: f64 = 0.0144;
/// Variance of the start velocity \[px²/beat²\]. Chosen: slopes of 1 px a frame are common, of 10 in large pictures
/// possible; two sightings tell it.
pub const START_VELOCITY_VARIANCE: f64 = 16.0;
/// Variance of the start acceleration \[px²/beat⁴\]. Chosen: a third of a bend's.
const START_ACCELERATION_VARIANCE: f64 = 0.0025;

/// One model with process noise `q`, in pixels and beats; `white_variance_px2` is R, and `colour_scale` scales the
/// coloured noise's variance.
///
/// # Errors
/// When a number is out of range.
pub fn model(q: f64, white_variance_px2: f64, colour_scale: f64) -> Result<ColouredMeasurement, InvalidParameter> {
    let drive = colour_scale * COLOUR_VARIANCE_PX2 * (1.0 - COLOUR_COEFFICIENT * COLOUR_COEFFICIENT);
    ColouredMeasurement::new(q, drive, COLOUR_COEFFICIENT, white_variance_px2, 1.0)?
        .with_velocity_variance(START_VELOCITY_VARIANCE)
}

fn spaces(noise: f64, speed: f64, beats: f64, parts: Parts) -> Result<[StateSpace<4, 1>; MODELS], InvalidParameter> {
    let colour_scale = if parts.has(Part::ColouredNoise) { noise } else { 0.0 };
    let speed = if parts.has(Part::FastBends) { speed } else { 0.0 };
    let space = |i: usize| {
        let i = if i == CORNER && !parts.has(Part::Corners) { BEND } else { i };
        let (kinks, (bend, bend_beats)) = match i {
            BEND if !parts.has(Part::Bends) => (PROCESS_NOISE, BENDS[0]),
            _ => (KINKS[i], BENDS[i]),
        };
        let bend = if i == BEND { (BEND_PER_SPEED * speed).clamp(bend, MOST_BEND) } else { bend };
        let measured = model(kinks, 1.0, colour_scale)?;
        Bending::new(measured, bend.powi(2), bend_beats)?.state_space(beats)
    };
    Ok([space(0)?, space(BEND)?, space(CORNER)?])
}

/// Position, velocity, acceleration and coloured noise under several models.
#[derive(Debug, Clone, Copy)]
pub struct SeamFilter {
    imm: Imm<4, MODELS>,
    noise: f64,
    /// The speed that bends are made of \[px/beat\].
    speed: f64,
    parts: Parts,
    spaces: [StateSpace<4, 1>; MODELS],
    /// The state before the last step, and what was predicted from it; none where the filter started.
    step: Option<(Gaussian<4>, Imm<4, MODELS>)>,
}

impl SeamFilter {
    /// Starts at a measurement `u_px` of R `white_px2`, under the noise scale `noise`, with velocity `velocity_px` a beat
    /// of variance `velocity_variance`: the exact posterior of an unknown position ([`ColouredMeasurement::start`]).
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn start(
        (u_px, white_px2): (f64, f64),
        (velocity_px, velocity_variance): (f64, f64),
        noise: f64,
        parts: Parts,
    ) -> Result<Self, InvalidParameter> {
        let colour_px2 = noise * COLOUR_VARIANCE_PX2;
        let variances = vector![white_px2 + colour_px2, velocity_variance, START_ACCELERATION_VARIANCE, colour_px2];
        let mut P = SMatrix::from_diagonal(&variances);
        (P[(0, 3)], P[(3, 0)]) = (-colour_px2, -colour_px2);
        let start = Gaussian::new(vector![u_px, velocity_px, 0.0, 0.0], P)?;
        let speed = velocity_px.abs();
        let (imm, spaces) = (Imm::new(start, STAY)?, spaces(noise, speed, 1.0, parts)?);
        Ok(Self { imm, noise, speed, parts, spaces, step: None })
    }

    /// The scale of the measurements' noise.
    pub const fn noise(&self) -> f64 {
        self.noise
    }

    /// Sets the scale of the measurements' noise: 1 for plate edges with a raggedness of 0.6 px.
    pub fn set_noise(&mut self, noise: f64) {
        self.noise = noise;
    }

    /// The state `beats` later.
    ///
    /// # Errors
    /// When `beats` is not positive.
    pub fn predict(&mut self, beats: f64) -> Result<(), InvalidParameter> {
        let before = self.imm.output();
        self.speed = before.x[1].abs().max(SPEED_MEMORY.powf(beats) * self.speed);
        self.spaces = spaces(self.noise, self.speed, beats, self.parts)?;
        self.imm = self.imm.predict_over(&self.spaces, beats);
        self.step = Some((before, self.imm));
        Ok(())
    }

    /// The last step, as a smoother takes it.
    #[must_use]
    pub fn link(&self) -> Link<4> {
        let posterior = self.imm.output();
        let Some((before, predicted)) = &self.step else { return Link::first(posterior) };
        let link = Link::predicted(before, &predicted.transition_matrix(&self.spaces), predicted.output());
        Link { posterior, ..link }
    }

    /// Mean and variance of the position \[px, px²\].
    #[must_use]
    pub fn position(&self) -> (f64, f64) {
        let state = self.imm.output();
        (state.x[0], state.P[(0, 0)].max(0.0))
    }

    /// How fast the position moves \[px/beat\].
    #[must_use]
    pub fn velocity_px(&self) -> f64 {
        self.imm.output().x[1]
    }

    /// NIS of a measurement `u_px` of variance `variance_px2`.
    ///
    /// # Errors
    /// When the innovation's variance is not positive.
    pub fn nis(&self, u_px: f64, variance_px2: f64) -> Result<f64, InnovationNotPositive> {
        let space = self.spaces[0].with_R(self.white(variance_px2));
        Ok(self.imm.nis(&space, &[Some(u_px)])?.unwrap_or(0.0))
    }

    /// R of a measurement: what is not coloured is white.
    fn white(&self, variance_px2: f64) -> SMatrix<f64, 1, 1> {
        let colour = if self.parts.has(Part::ColouredNoise) { 0.0 } else { self.noise * COLOUR_VARIANCE_PX2 };
        SMatrix::from_element(variance_px2 + colour)
    }

    /// Takes in a measurement.
    ///
    /// # Errors
    /// When the innovation's variance is not positive.
    pub fn update(&mut self, u_px: f64, variance_px2: f64) -> Result<(), InnovationNotPositive> {
        let spaces = self.spaces.map(|space| space.with_R(self.white(variance_px2)));
        self.imm = self.imm.update(&spaces, &[Some(u_px)], None)?.posterior;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors \[px\] in the frames from a corner on, whose measurements have no noise.
    fn errors_after_a_corner(slope_before: f64, slope_behind: f64) -> Vec<f64> {
        let path = |t: f64| if t < 60.0 { slope_before * t } else { slope_before * 60.0 + slope_behind * (t - 60.0) };
        let mut filter = SeamFilter::start((0.0, 0.1), (0.0, 1.0), 1.0, Parts::default()).unwrap();
        (1..100)
            .map(|t| {
                let t = f64::from(t);
                filter.predict(1.0).unwrap();
                filter.update(path(t), 0.1).unwrap();
                (filter.position().0 - path(t)).abs()
            })
            .skip(59)
            .collect()
    }

    #[test]
    fn a_corner_of_half_a_pixel_a_frame_costs_little_and_is_soon_forgotten() {
        for (before, behind) in [(0.0, 0.55), (0.55, 0.0), (0.3, -0.25), (-0.55, 0.0)] {
            let errors = errors_after_a_corner(before, behind);
            assert!(errors.iter().all(|error| *error < 1.5), "{before} to {behind}: {errors:?}");
            assert!(errors[6..].iter().all(|error| *error < 0.5), "{before} to {behind}: {errors:?}");
        }
    }
}
