//! Constant velocity under coloured process noise, with the displacement measured besides: the infrared paper,
//! equations (1)–(11).
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{SMatrix, SVector, matrix, vector};

use super::gaussian::Gaussian;
use super::state_space::{InvalidParameter, StateSpace, not_negative, positive, stationary};

/// Parameters of the model with state \[x px, ẋ px/frame, x of the frame before px, w px/frame²\].
///
/// Time counts in frames, as the paper's worked step demands. The acceleration w is a first-order autoregression;
/// measured are the position and its displacement since the frame before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColouredProcess {
    drive_variance_px2_frame4: f64,
    colour_coefficient: f64,
    position_variance_px2: f64,
    displacement_variance_px2: f64,
    period_s: f64,
}

impl ColouredProcess {
    /// A model from the variance q that drives the acceleration \[px²/frame⁴\], its coefficient Π a frame, the
    /// variances of position and displacement \[px²\], and the time from frame to frame \[s\].
    ///
    /// # Errors
    /// When q is negative, |Π| ≥ 1, another variance or the period is not positive, or a number is not finite.
    pub fn new(
        drive_variance_px2_frame4: f64,
        colour_coefficient: f64,
        position_variance_px2: f64,
        displacement_variance_px2: f64,
        period_s: f64,
    ) -> Result<Self, InvalidParameter> {
        if position_variance_px2 == 0.0 {
            return Err(InvalidParameter::NoMeasurementNoise);
        }
        Ok(Self {
            drive_variance_px2_frame4: not_negative("the drive's variance q [px²/frame⁴]", drive_variance_px2_frame4)?,
            colour_coefficient: stationary("the acceleration's coefficient Π", colour_coefficient)?,
            position_variance_px2: positive("the position's variance [px²]", position_variance_px2)?,
            displacement_variance_px2: positive("the displacement's variance [px²]", displacement_variance_px2)?,
            period_s: positive("the period [s]", period_s)?,
        })
    }

    /// Π = 0.5 as printed, R = 5 I px² and q = 0.0081 px²/frame⁴, which reproduce the worked step and, under white
    /// noise, the printed ratio of variances; one frame is 1/1000 s.
    #[must_use]
    pub const fn printed() -> Self {
        Self {
            drive_variance_px2_frame4: 0.0081,
            colour_coefficient: 0.5,
            position_variance_px2: 5.0,
            displacement_variance_px2: 5.0,
            period_s: 1e-3,
        }
    }

    /// The time from frame to frame \[s\].
    #[must_use]
    pub const fn period_s(&self) -> f64 {
        self.period_s
    }

    /// q, Π and the variances of position and displacement.
    #[must_use]
    pub const fn noise(&self) -> [f64; 4] {
        [
            self.drive_variance_px2_frame4,
            self.colour_coefficient,
            self.position_variance_px2,
            self.displacement_variance_px2,
        ]
    }

    /// The model over a step of `dt_s` seconds.
    ///
    /// The first component's noise of the drive enters one frame later, through w, as in the paper.
    ///
    /// # Errors
    /// When the step is not positive and finite.
    pub fn state_space(&self, dt_s: f64) -> Result<StateSpace<4, 2>, InvalidParameter> {
        let T = positive("the time step [s]", dt_s)? / self.period_s;
        let sign = if self.colour_coefficient < 0.0 { (std::f64::consts::PI * T).cos() } else { 1.0 };
        let colour = sign * self.colour_coefficient.abs().powf(T);
        let stationary = self.drive_variance_px2_frame4 / (1.0 - self.colour_coefficient * self.colour_coefficient);
        Ok(StateSpace {
            F: matrix![
                1.0, T, 0.0, 0.5 * T * T;
                0.0, 1.0, 0.0, T;
                1.0, 0.0, 0.0, 0.0;
                0.0, 0.0, 0.0, colour
            ],
            Qd: SMatrix::from_diagonal(&vector![0.0, 0.0, 0.0, stationary * (1.0 - colour * colour)]),
            H: matrix![1.0, 0.0, 0.0, 0.0; 1.0, 0.0, -1.0, 0.0],
            R: matrix![self.position_variance_px2, 0.0; 0.0, self.displacement_variance_px2],
        })
    }

    /// The state after two first positions \[px\], a frame apart, and nothing known before them.
    ///
    /// # Errors
    /// When a position is not finite.
    pub fn start_from_two(&self, z0_px: f64, z1_px: f64) -> Result<Gaussian<4>, InvalidParameter> {
        let r = self.position_variance_px2;
        let w = self.drive_variance_px2_frame4 / (1.0 - self.colour_coefficient * self.colour_coefficient);
        let P = matrix![
            r, r, 0.0, 0.0;
            r, 2.0 * r + 0.25 * w, -r, 0.0;
            0.0, -r, r, 0.0;
            0.0, 0.0, 0.0, w
        ];
        Gaussian::new(vector![z1_px, z1_px - z0_px, z0_px, 0.0], P)
    }

    /// The paper's start from two first positions \[px\] and a first acceleration `w0` \[px/frame²\], with the
    /// covariance diag(4, 0.4, 1, 0.2) R₁: the only proportions that give the printed step with R = r I (the third is
    /// free).
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn start_as_printed(&self, z0_px: f64, z1_px: f64, w0: f64) -> Result<Gaussian<4>, InvalidParameter> {
        let r = self.position_variance_px2;
        let P = SMatrix::from_diagonal(&(SVector::from([4.0, 0.4, 1.0, 0.2]) * r));
        Gaussian::new(vector![z1_px, z1_px - z0_px, z0_px, w0], P)
    }
}

/// Position and displacement of each frame: the displacement is measured only where the frame before was too, so it
/// is dropped after a gap.
#[must_use]
pub fn with_displacement(positions: &[Option<f64>]) -> Vec<[Option<f64>; 2]> {
    let before = std::iter::once(None).chain(positions.iter().copied());
    let displacement = |(now, before): (Option<f64>, Option<f64>)| [now, now.zip(before).map(|(z1, z0)| z1 - z0)];
    positions.iter().copied().zip(before).map(displacement).collect()
}
