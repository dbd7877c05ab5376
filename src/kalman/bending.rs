//! A path that bends: Singer's correlated acceleration (Singer 1970, IEEE Trans. Aerospace and Electronic Systems 6(4))
//! under the coloured measurement noise of Du 2022.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{SMatrix, matrix};

use super::ColouredMeasurement;
use super::state_space::{InvalidParameter, StateSpace, not_negative, positive};

/// Parameters of the model with state \[u px, u̇ px/s, ü px/s², v px\]: position, velocity, acceleration and coloured
/// measurement noise.
///
/// The acceleration is a first-order autoregression in continuous time: a bend goes on for a while. On top of it comes
/// the white acceleration of [`ColouredMeasurement`], here white in continuous time: kinks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bending {
    measured: ColouredMeasurement,
    acceleration_variance_px2_s4: f64,
    bend_s: f64,
}

impl Bending {
    /// Adds to the model `measured` an acceleration of stationary variance `acceleration_variance_px2_s4` that keeps
    /// 1/e of its value over `bend_s` seconds.
    ///
    /// # Errors
    /// When the variance is negative or the time not positive.
    pub fn new(
        measured: ColouredMeasurement,
        acceleration_variance_px2_s4: f64,
        bend_s: f64,
    ) -> Result<Self, InvalidParameter> {
        not_negative("the bend's acceleration variance [px²/s⁴]", acceleration_variance_px2_s4)?;
        positive("the bend's duration [s]", bend_s)?;
        Ok(Self { measured, acceleration_variance_px2_s4, bend_s })
    }

    /// The model over a step of `dt_s` seconds.
    ///
    /// # Errors
    /// When the step is not positive and finite.
    pub fn state_space(&self, dt_s: f64) -> Result<StateSpace<4, 1>, InvalidParameter> {
        let T = positive("the time step [s]", dt_s)?;
        let colour = self.measured.state_space(dt_s)?;
        let a = 1.0 / self.bend_s;
        let (x, e) = (a * T, (-a * T).exp());
        let (e2, scale) = (e * e, 2.0 * a * self.acceleration_variance_px2_s4);
        // Singer 1970, equation (16): the covariance that the acceleration's drive gathers over T.
        let q11 = (1.0 - e2 + 2.0 * x + 2.0 * x.powi(3) / 3.0 - 2.0 * x * x - 4.0 * x * e) / (2.0 * a.powi(5));
        let q12 = (e2 + 1.0 - 2.0 * e + 2.0 * x * e - 2.0 * x + x * x) / (2.0 * a.powi(4));
        let q13 = (1.0 - e2 - 2.0 * x * e) / (2.0 * a.powi(3));
        let q22 = (4.0 * e - 3.0 - e2 + 2.0 * x) / (2.0 * a.powi(3));
        let q23 = (e2 + 1.0 - 2.0 * e) / (2.0 * a * a);
        let q33 = (1.0 - e2) / (2.0 * a);
        let kink = self.measured.acceleration_variance_px2_s4() * self.measured.period_s();
        let mut Qd: SMatrix<f64, 4, 4> = matrix![
            q11, q12, q13, 0.0;
            q12, q22, q23, 0.0;
            q13, q23, q33, 0.0;
            0.0, 0.0, 0.0, 0.0]
            * scale;
        Qd[(0, 0)] += kink * T.powi(3) / 3.0;
        Qd[(0, 1)] += kink * T * T / 2.0;
        Qd[(1, 0)] += kink * T * T / 2.0;
        Qd[(1, 1)] += kink * T;
        Qd[(3, 3)] = colour.Qd[(2, 2)];
        Ok(StateSpace {
            F: matrix![
                1.0, T, (x - 1.0 + e) / (a * a), 0.0;
                0.0, 1.0, (1.0 - e) / a, 0.0;
                0.0, 0.0, e, 0.0;
                0.0, 0.0, 0.0, colour.F[(2, 2)]],
            Qd,
            H: matrix![1.0, 0.0, 0.0, 1.0],
            R: colour.R,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn model() -> Bending {
        Bending::new(ColouredMeasurement::printed(), 0.04, 3.0).unwrap()
    }

    #[test]
    fn two_half_steps_gather_as_much_as_a_whole_one() {
        let (whole, half) = (model().state_space(0.4).unwrap(), model().state_space(0.2).unwrap());
        assert_relative_eq!(half.F * half.F, whole.F, epsilon = 1e-12);
        assert_relative_eq!(half.F * half.Qd * half.F.transpose() + half.Qd, whole.Qd, epsilon = 1e-9);
    }

    #[test]
    fn the_process_noise_is_that_of_the_drive_integrated_in_small_steps() {
        let (steps, T) = (4000, 0.8);
        let model = Bending::new(ColouredMeasurement::printed().with_acceleration_variance(0.0).unwrap(), 0.04, 0.5);
        let whole = model.unwrap().state_space(T).unwrap().Qd.fixed_view::<3, 3>(0, 0).into_owned();
        let (dt, a) = (T / f64::from(steps), 2.0);
        let F = matrix![1.0, dt, 0.5 * dt * dt; 0.0, 1.0, dt; 0.0, 0.0, 1.0 - a * dt];
        let mut gathered = SMatrix::<f64, 3, 3>::zeros();
        for _ in 0..steps {
            gathered = F * gathered * F.transpose();
            gathered[(2, 2)] += 2.0 * a * 0.04 * dt;
        }
        assert_relative_eq!(gathered, whole, max_relative = 2e-3, epsilon = 1e-9);
    }
}
