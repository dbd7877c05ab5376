//! Constant velocity under white noise: Zhang 2009.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{SMatrix, SVector, matrix, vector};

use super::gaussian::{Gaussian, InnovationNotPositive};
use super::state_space::{InvalidParameter, StateSpace, not_negative, positive};

/// Parameters of the model with state \[position mm, velocity mm/s\] and the position measured.
///
/// The paper's unit is the millimetre; any other goes if the variances are in its square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantVelocity {
    acceleration_variance_mm2_s4: f64,
    white_variance_mm2: f64,
    acceleration: Acceleration,
}

/// How the random acceleration runs between two frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Acceleration {
    /// Constant over each step, as in the paper; two short steps then gather less noise than one long one.
    HeldOverStep,
    /// White in continuous time, for time stamps that are irregular; gathers in velocity what the held one does over
    /// this period \[s\].
    Continuous {
        /// The period the acceleration's variance belongs to \[s\].
        period_s: f64,
    },
}

/// Which covariance the two-point start has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TwoPointCovariance {
    /// That of the errors: \[\[R, R/T\], \[R/T, 2R/T² + σ₂²/4\]\] with σ₂ = Tσₐ.
    Exact,
    /// As printed in the paper, slightly too large (up to 1.3 % at T = 0.4 s).
    Printed,
}

impl ConstantVelocity {
    /// A model from the variance of the acceleration σₐ² \[mm²/s⁴\] and that of the measurement R \[mm²\].
    ///
    /// # Errors
    /// When R is not positive, σₐ² negative, or one not finite.
    pub fn new(acceleration_variance_mm2_s4: f64, white_variance_mm2: f64) -> Result<Self, InvalidParameter> {
        not_negative("the acceleration's variance [mm²/s⁴]", acceleration_variance_mm2_s4)?;
        if white_variance_mm2 == 0.0 {
            return Err(InvalidParameter::NoMeasurementNoise);
        }
        positive("the white noise's variance R [mm²]", white_variance_mm2)?;
        let acceleration = Acceleration::HeldOverStep;
        Ok(Self { acceleration_variance_mm2_s4, white_variance_mm2, acceleration })
    }

    /// The numbers printed in Zhang 2009: σₐ = 0.1 mm/s², σᵥ = 0.1 mm.
    #[must_use]
    pub const fn printed() -> Self {
        Self { acceleration_variance_mm2_s4: 0.01, white_variance_mm2: 0.01, acceleration: Acceleration::HeldOverStep }
    }

    /// The same model with another kind of acceleration.
    ///
    /// # Errors
    /// When a period is not positive.
    pub fn with_acceleration(self, acceleration: Acceleration) -> Result<Self, InvalidParameter> {
        if let Acceleration::Continuous { period_s } = acceleration {
            positive("the acceleration's period [s]", period_s)?;
        }
        Ok(Self { acceleration, ..self })
    }

    /// The variance R of the measurement \[mm²\].
    #[must_use]
    pub const fn white_variance_mm2(&self) -> f64 {
        self.white_variance_mm2
    }

    /// The variance of the acceleration \[mm²/s⁴\].
    #[must_use]
    pub const fn acceleration_variance_mm2_s4(&self) -> f64 {
        self.acceleration_variance_mm2_s4
    }

    /// How the acceleration runs between two frames.
    #[must_use]
    pub const fn acceleration(&self) -> Acceleration {
        self.acceleration
    }

    /// The model over a step of `dt_s` seconds.
    ///
    /// # Errors
    /// When the step is not positive and finite.
    pub fn state_space(&self, dt_s: f64) -> Result<StateSpace<2, 1>, InvalidParameter> {
        let T = positive("the time step [s]", dt_s)?;
        let shape = match self.acceleration {
            Acceleration::HeldOverStep => {
                let G = vector![0.5 * T * T, T];
                G * G.transpose()
            }
            Acceleration::Continuous { period_s } => matrix![T * T * T / 3.0, T * T / 2.0; T * T / 2.0, T] * period_s,
        };
        Ok(StateSpace {
            F: matrix![1.0, T; 0.0, 1.0],
            Qd: shape * self.acceleration_variance_mm2_s4,
            H: matrix![1.0, 0.0],
            R: matrix![self.white_variance_mm2],
        })
    }

    /// The state at the second of two measurements `dt_s` seconds apart, and nothing known before them.
    ///
    /// # Errors
    /// When the step is not positive or a measurement not finite.
    pub fn start_from_two(
        &self,
        y1_mm: f64,
        y2_mm: f64,
        dt_s: f64,
        covariance: TwoPointCovariance,
    ) -> Result<Gaussian<2>, InvalidParameter> {
        let T = positive("the time step [s]", dt_s)?;
        let R = self.white_variance_mm2;
        let sigma_a = self.acceleration_variance_mm2_s4.sqrt();
        let (s1, s2) = (0.5 * T * T * sigma_a, T * sigma_a);
        let P = match covariance {
            TwoPointCovariance::Exact => matrix![R, R / T; R / T, 2.0 * R / (T * T) + 0.25 * s2 * s2],
            TwoPointCovariance::Printed => {
                let cross = R / T + s1 * s2;
                matrix![R + s1 * s1, cross; cross, 2.0 * R / (T * T) + s2 * s2]
            }
        };
        Gaussian::new(vector![y2_mm, (y2_mm - y1_mm) / T], P)
    }
}

/// The gains of the first `steps` frames, which depend on no measurement and can be computed beforehand (Zhang 2009,
/// section 2).
///
/// # Errors
/// When an S is not positive definite.
pub fn gain_table<const N: usize>(
    space: &StateSpace<N, 1>,
    P0: SMatrix<f64, N, N>,
    steps: usize,
) -> Result<Vec<SVector<f64, N>>, InnovationNotPositive> {
    let mut state = Gaussian { x: SVector::zeros(), P: P0 };
    let mut gains = Vec::with_capacity(steps);
    for _ in 0..steps {
        let update = state.predict(space).update(space, &[Some(0.0)], None)?;
        gains.push(update.K);
        state = update.posterior;
    }
    Ok(gains)
}
