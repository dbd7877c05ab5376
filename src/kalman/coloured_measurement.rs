//! Constant velocity under coloured measurement noise: Du 2022, equations (9)–(21), the filter of the seam tracker.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use std::f64::consts::PI;

use nalgebra::{SMatrix, SVector, matrix, vector};

use super::gaussian::Gaussian;
use super::state_space::{InvalidParameter, StateSpace, not_negative, positive, stationary};

/// Parameters of the model with state \[u px, u̇ px/s, v px\]: position, velocity and coloured measurement noise.
///
/// The white acceleration ω is held over a step; v is a first-order autoregression driven by ξ; z = u + v + η, with η
/// white of variance R.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColouredMeasurement {
    acceleration_variance_px2_s4: f64,
    colour_drive_variance_px2: f64,
    colour_coefficient: f64,
    white_variance_px2: f64,
    period_s: f64,
    velocity_variance_px2_s2: f64,
}

impl ColouredMeasurement {
    /// Variance of the velocity at the start, when nothing but one position is known: 25 px²/s². Chosen, because it
    /// must cover the slope of the seam (2.74 px/s in Du 2022); 0 would cost 8.4 px at the start of that ramp.
    pub const VELOCITY_VARIANCE_PX2_S2: f64 = 25.0;

    /// Variance of a position taken from the clean image before the arc: 0.1 px², chosen.
    pub const CLEAN_VARIANCE_PX2: f64 = 0.1;

    /// A model from the variance of the acceleration σω² \[px²/s⁴\], the variance σξ² \[px²\] that drives the coloured
    /// noise each period, its coefficient ψ a period, the variance R of the white noise \[px²\], and the period \[s\]
    /// that σξ² and ψ belong to.
    ///
    /// # Errors
    /// When a variance is negative, |ψ| ≥ 1, the period is not positive, a number is not finite, or both
    /// measurement noises are 0.
    pub fn new(
        acceleration_variance_px2_s4: f64,
        colour_drive_variance_px2: f64,
        colour_coefficient: f64,
        white_variance_px2: f64,
        period_s: f64,
    ) -> Result<Self, InvalidParameter> {
        let model = Self {
            acceleration_variance_px2_s4: not_negative(
                "the acceleration's variance [px²/s⁴]",
                acceleration_variance_px2_s4,
            )?,
            colour_drive_variance_px2: not_negative("the coloured noise's variance [px²]", colour_drive_variance_px2)?,
            colour_coefficient: stationary("the coloured noise's coefficient ψ", colour_coefficient)?,
            white_variance_px2: not_negative("the white noise's variance R [px²]", white_variance_px2)?,
            period_s: positive("the period [s]", period_s)?,
            velocity_variance_px2_s2: Self::VELOCITY_VARIANCE_PX2_S2,
        };
        if white_variance_px2 == 0.0 && colour_drive_variance_px2 == 0.0 {
            return Err(InvalidParameter::NoMeasurementNoise);
        }
        Ok(model)
    }

    /// The numbers printed in Du 2022: σω² = 0.01 px²/s⁴, σξ² = 0.01 px², ψ = 0.5, R = 5 px², t = 0.2 s.
    #[must_use]
    pub const fn printed() -> Self {
        Self {
            acceleration_variance_px2_s4: 0.01,
            colour_drive_variance_px2: 0.01,
            colour_coefficient: 0.5,
            white_variance_px2: 5.0,
            period_s: 0.2,
            velocity_variance_px2_s2: Self::VELOCITY_VARIANCE_PX2_S2,
        }
    }

    /// The same model with another variance of the acceleration \[px²/s⁴\].
    ///
    /// # Errors
    /// When it is negative or not finite.
    pub fn with_acceleration_variance(self, acceleration_variance_px2_s4: f64) -> Result<Self, InvalidParameter> {
        let name = "the acceleration's variance [px²/s⁴]";
        not_negative(name, acceleration_variance_px2_s4)?;
        Ok(Self { acceleration_variance_px2_s4, ..self })
    }

    /// The same model with another variance R of the white measurement noise \[px²\].
    ///
    /// # Errors
    /// When it is negative or not finite, or leaves the model without measurement noise.
    pub fn with_white_variance(self, white_variance_px2: f64) -> Result<Self, InvalidParameter> {
        let model = Self::new(
            self.acceleration_variance_px2_s4,
            self.colour_drive_variance_px2,
            self.colour_coefficient,
            white_variance_px2,
            self.period_s,
        )?;
        Ok(Self { velocity_variance_px2_s2: self.velocity_variance_px2_s2, ..model })
    }

    /// The same model with another variance of the velocity at the start \[px²/s²\].
    ///
    /// # Errors
    /// When it is negative or not finite.
    pub fn with_velocity_variance(self, velocity_variance_px2_s2: f64) -> Result<Self, InvalidParameter> {
        not_negative("the start velocity's variance [px²/s²]", velocity_variance_px2_s2)?;
        Ok(Self { velocity_variance_px2_s2, ..self })
    }

    /// The variance σω² of the acceleration \[px²/s⁴\].
    #[must_use]
    pub const fn acceleration_variance_px2_s4(&self) -> f64 {
        self.acceleration_variance_px2_s4
    }

    /// The variance σξ² that drives the coloured noise each period \[px²\].
    #[must_use]
    pub const fn colour_drive_variance_px2(&self) -> f64 {
        self.colour_drive_variance_px2
    }

    /// The coloured noise's coefficient ψ a period.
    #[must_use]
    pub const fn colour_coefficient(&self) -> f64 {
        self.colour_coefficient
    }

    /// The velocity's variance at the start \[px²/s²\].
    #[must_use]
    pub const fn velocity_variance_px2_s2(&self) -> f64 {
        self.velocity_variance_px2_s2
    }

    /// The variance of the coloured noise itself, σξ²/(1 − ψ²) \[px²\].
    #[must_use]
    pub fn colour_variance_px2(&self) -> f64 {
        self.colour_drive_variance_px2 / (1.0 - self.colour_coefficient * self.colour_coefficient)
    }

    /// The variance R of the white measurement noise \[px²\].
    #[must_use]
    pub const fn white_variance_px2(&self) -> f64 {
        self.white_variance_px2
    }

    /// The period the coloured noise's numbers belong to \[s\].
    #[must_use]
    pub const fn period_s(&self) -> f64 {
        self.period_s
    }

    /// The model over a step of `dt_s` seconds: ψ(dt) = ψ^(dt/t), the coloured noise's own variance kept.
    ///
    /// A negative ψ has no real power between whole periods; there it takes the real part of the complex one.
    ///
    /// # Errors
    /// When the step is not positive and finite.
    pub fn state_space(&self, dt_s: f64) -> Result<StateSpace<3, 1>, InvalidParameter> {
        let T = positive("the time step [s]", dt_s)?;
        let periods = T / self.period_s;
        let sign = if self.colour_coefficient < 0.0 { (PI * periods).cos() } else { 1.0 };
        let psi = sign * self.colour_coefficient.abs().powf(periods);
        let colour_drive = self.colour_variance_px2() * (1.0 - psi * psi);
        let B = matrix![0.5 * T * T, 0.0; T, 0.0; 0.0, 1.0];
        let Q = matrix![self.acceleration_variance_px2_s4, 0.0; 0.0, colour_drive];
        Ok(StateSpace {
            F: matrix![1.0, T, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, psi],
            Qd: B * Q * B.transpose(),
            H: matrix![1.0, 0.0, 1.0],
            R: matrix![self.white_variance_px2],
        })
    }

    /// The state after a first measurement `z0_px` and nothing else: the exact posterior for an unknown position.
    ///
    /// # Errors
    /// When the measurement is not finite.
    pub fn start(&self, z0_px: f64) -> Result<Gaussian<3>, InvalidParameter> {
        let (s, V) = (self.colour_variance_px2(), self.velocity_variance_px2_s2);
        let P = matrix![self.white_variance_px2 + s, 0.0, -s; 0.0, V, 0.0; -s, 0.0, s];
        Gaussian::new(vector![z0_px, 0.0, 0.0], P)
    }

    /// The state after a position `z0_px` of variance `R0_px2` from a clean image, whose error does not belong to the
    /// coloured noise.
    ///
    /// # Errors
    /// When the position is not finite or its variance negative.
    pub fn start_from_clean(&self, z0_px: f64, R0_px2: f64) -> Result<Gaussian<3>, InvalidParameter> {
        not_negative("the start position's variance [px²]", R0_px2)?;
        let diagonal = SVector::from([R0_px2, self.velocity_variance_px2_s2, self.colour_variance_px2()]);
        Gaussian::new(vector![z0_px, 0.0, 0.0], SMatrix::from_diagonal(&diagonal))
    }
}
