//! Constant rate of change with the change measured besides: Jiang 2016, equations (3)–(14), for the clad's width.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{SMatrix, matrix, vector};

use super::gaussian::Gaussian;
use super::state_space::{InvalidParameter, StateSpace, not_negative, positive};

/// Parameters of the model with state \[w mm, ẇ mm/s, w of the frame before mm\]; measured are the width and its
/// change since the frame before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Width {
    acceleration_variance_mm2_s4: f64,
    white_variance_mm2: f64,
}

impl Width {
    /// Variance of the random acceleration: 10⁻³ mm²/s⁴, chosen; 7·10⁻⁴ gives exactly the paper's 0.028 → 0.0093 mm
    /// for a constant width under white noise.
    pub const ACCELERATION_VARIANCE_MM2_S4: f64 = 1e-3;

    /// A model from the variance q of the acceleration \[mm²/s⁴\] and that of the width's measurement r \[mm²\]; the
    /// change of two such widths has 2 r.
    ///
    /// # Errors
    /// When q is negative, r not positive, or one not finite.
    pub fn new(acceleration_variance_mm2_s4: f64, white_variance_mm2: f64) -> Result<Self, InvalidParameter> {
        not_negative("the acceleration's variance [mm²/s⁴]", acceleration_variance_mm2_s4)?;
        if white_variance_mm2 == 0.0 {
            return Err(InvalidParameter::NoMeasurementNoise);
        }
        positive("the width's variance [mm²]", white_variance_mm2)?;
        Ok(Self { acceleration_variance_mm2_s4, white_variance_mm2 })
    }

    /// The variance q of the acceleration \[mm²/s⁴\].
    #[must_use]
    pub const fn acceleration_variance_mm2_s4(&self) -> f64 {
        self.acceleration_variance_mm2_s4
    }

    /// The variance r of the width's measurement \[mm²\].
    #[must_use]
    pub const fn white_variance_mm2(&self) -> f64 {
        self.white_variance_mm2
    }

    /// The model over a step of `dt_s` seconds.
    ///
    /// # Errors
    /// When the step is not positive and finite.
    pub fn state_space(&self, dt_s: f64) -> Result<StateSpace<3, 2>, InvalidParameter> {
        let T = positive("the time step [s]", dt_s)?;
        let G = vector![0.5 * T * T, T, 0.0];
        let r = self.white_variance_mm2;
        Ok(StateSpace {
            F: matrix![1.0, T, 0.0; 0.0, 1.0, 0.0; 1.0, 0.0, 0.0],
            Qd: G * G.transpose() * self.acceleration_variance_mm2_s4,
            H: matrix![1.0, 0.0, 0.0; 1.0, 0.0, -1.0],
            R: matrix![r, 0.0; 0.0, 2.0 * r],
        })
    }

    /// The state at the second of two widths `dt_s` seconds apart, and nothing known before them.
    ///
    /// # Errors
    /// When the step is not positive or a width not finite.
    pub fn start_from_two(&self, w0_mm: f64, w1_mm: f64, dt_s: f64) -> Result<Gaussian<3>, InvalidParameter> {
        let T = positive("the time step [s]", dt_s)?;
        let shape: SMatrix<f64, 3, 3> =
            matrix![1.0, 1.0 / T, 0.0; 1.0 / T, 2.0 / (T * T), -1.0 / T; 0.0, -1.0 / T, 1.0];
        Gaussian::new(vector![w1_mm, (w1_mm - w0_mm) / T, w0_mm], shape * self.white_variance_mm2)
    }
}
