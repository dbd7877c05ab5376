//! What every model offers a recorded series: its state space, where it starts, and its noise as free parameters.

use super::gaussian::Gaussian;
use super::series::{Frame, SeriesError};
use super::state_space::{InvalidParameter, StateSpace};
use super::{ColouredMeasurement, ColouredProcess, ConstantVelocity, TwoPointCovariance, Width};

/// Largest |atanh| of an autoregression's coefficient the fit may try: beyond it the coefficient rounds to 1.
const MAX_ATANH: f64 = 8.0;

/// A model of N states and M measured rows, with P noise parameters.
pub trait Model<const N: usize, const M: usize, const P: usize>: Copy {
    /// The model over a step of `dt_s` seconds.
    ///
    /// # Errors
    /// When the step is not positive and finite.
    fn space_over(&self, dt_s: f64) -> Result<StateSpace<N, M>, InvalidParameter>;

    /// The state after the first measurements of a series, and the index of the frame it stands at.
    ///
    /// # Errors
    /// When the series has too few measurements.
    fn start_of(&self, frames: &[Frame<M>]) -> Result<(Gaussian<N>, usize), SeriesError>;

    /// The noise parameters without bounds: logarithms of variances, area tangent of a coefficient.
    fn unbounded(&self) -> [f64; P];

    /// The same model with other noise parameters.
    ///
    /// # Errors
    /// When a parameter is not finite after all.
    fn with_unbounded(&self, parameters: &[f64; P]) -> Result<Self, InvalidParameter>;

    /// The noise parameters as they stand in a configuration.
    fn parameters(&self) -> [NoiseParameter; P];
}

/// A noise parameter by name; z is the unit of the measurement, whatever it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseParameter {
    /// Its name on the command line and in TOML.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
}

const fn parameter(name: &'static str, unit: &'static str, value: f64) -> NoiseParameter {
    NoiseParameter { name, unit, value }
}

/// Index and first row of the measured frames.
fn measured<const M: usize>(frames: &[Frame<M>]) -> impl Iterator<Item = (usize, f64)> {
    let first_row =
        |(index, frame): (usize, &Frame<M>)| frame.z[0].filter(|value| value.is_finite()).map(|value| (index, value));
    frames.iter().enumerate().filter_map(first_row)
}

/// The first two measured frames that follow one another: the first value, the second, and the second's index.
fn first_pair<const M: usize>(frames: &[Frame<M>]) -> Result<(f64, f64, usize), SeriesError> {
    let pairs = measured(frames).zip(measured(frames).skip(1));
    pairs
        .filter(|((before, _), (now, _))| before + 1 == *now)
        .map(|((_, z0), (now, z1))| (z0, z1, now))
        .next()
        .ok_or(SeriesError::TooShort { measured: measured(frames).count(), needed: 2 })
}

fn at_frame<T>(frame: usize, value: Result<T, InvalidParameter>) -> Result<T, SeriesError> {
    value.map_err(|reason| SeriesError::InvalidFrame { frame, reason })
}

fn coefficient(unbounded: f64) -> f64 {
    unbounded.clamp(-MAX_ATANH, MAX_ATANH).tanh()
}

impl Model<2, 1, 2> for ConstantVelocity {
    fn space_over(&self, dt_s: f64) -> Result<StateSpace<2, 1>, InvalidParameter> {
        self.state_space(dt_s)
    }

    fn start_of(&self, frames: &[Frame<1>]) -> Result<(Gaussian<2>, usize), SeriesError> {
        let mut first = measured(frames);
        let (Some((i, y1)), Some((k, y2))) = (first.next(), first.next()) else {
            return Err(SeriesError::TooShort { measured: measured(frames).count(), needed: 2 });
        };
        let dt_s = frames[i + 1..=k].iter().map(|frame| frame.dt_s).sum();
        Ok((at_frame(k, self.start_from_two(y1, y2, dt_s, TwoPointCovariance::Exact))?, k))
    }

    fn unbounded(&self) -> [f64; 2] {
        [self.acceleration_variance_mm2_s4().ln(), self.white_variance_mm2().ln()]
    }

    fn with_unbounded(&self, p: &[f64; 2]) -> Result<Self, InvalidParameter> {
        Self::new(p[0].exp(), p[1].exp())?.with_acceleration(self.acceleration())
    }

    fn parameters(&self) -> [NoiseParameter; 2] {
        [
            parameter("acceleration-variance", "z²/s⁴", self.acceleration_variance_mm2_s4()),
            parameter("white-variance", "z²", self.white_variance_mm2()),
        ]
    }
}

impl Model<3, 1, 4> for ColouredMeasurement {
    fn space_over(&self, dt_s: f64) -> Result<StateSpace<3, 1>, InvalidParameter> {
        self.state_space(dt_s)
    }

    fn start_of(&self, frames: &[Frame<1>]) -> Result<(Gaussian<3>, usize), SeriesError> {
        let (index, z0) = measured(frames).next().ok_or(SeriesError::TooShort { measured: 0, needed: 1 })?;
        let own = frames[index].R.map_or(Ok(*self), |variance| self.with_white_variance(variance[(0, 0)]));
        Ok((at_frame(index, own.and_then(|model| model.start(z0)))?, index))
    }

    fn unbounded(&self) -> [f64; 4] {
        [
            self.acceleration_variance_px2_s4().ln(),
            self.colour_drive_variance_px2().ln(),
            self.colour_coefficient().atanh(),
            self.white_variance_px2().ln(),
        ]
    }

    fn with_unbounded(&self, p: &[f64; 4]) -> Result<Self, InvalidParameter> {
        Self::new(p[0].exp(), p[1].exp(), coefficient(p[2]), p[3].exp(), self.period_s())?
            .with_velocity_variance(self.velocity_variance_px2_s2())
    }

    fn parameters(&self) -> [NoiseParameter; 4] {
        [
            parameter("acceleration-variance", "z²/s⁴", self.acceleration_variance_px2_s4()),
            parameter("colour-drive-variance", "z² a period", self.colour_drive_variance_px2()),
            parameter("colour-coefficient", "1 a period", self.colour_coefficient()),
            parameter("white-variance", "z²", self.white_variance_px2()),
        ]
    }
}

impl Model<4, 2, 4> for ColouredProcess {
    fn space_over(&self, dt_s: f64) -> Result<StateSpace<4, 2>, InvalidParameter> {
        self.state_space(dt_s)
    }

    fn start_of(&self, frames: &[Frame<2>]) -> Result<(Gaussian<4>, usize), SeriesError> {
        let (z0, z1, index) = first_pair(frames)?;
        Ok((at_frame(index, self.start_from_two(z0, z1))?, index))
    }

    fn unbounded(&self) -> [f64; 4] {
        let [q, colour, position, displacement] = self.noise();
        [q.ln(), colour.atanh(), position.ln(), displacement.ln()]
    }

    fn with_unbounded(&self, p: &[f64; 4]) -> Result<Self, InvalidParameter> {
        Self::new(p[0].exp(), coefficient(p[1]), p[2].exp(), p[3].exp(), self.period_s())
    }

    fn parameters(&self) -> [NoiseParameter; 4] {
        let [q, colour, position, displacement] = self.noise();
        [
            parameter("drive-variance", "z²/frame⁴", q),
            parameter("colour-coefficient", "1 a frame", colour),
            parameter("position-variance", "z²", position),
            parameter("displacement-variance", "z²", displacement),
        ]
    }
}

impl Model<3, 2, 2> for Width {
    fn space_over(&self, dt_s: f64) -> Result<StateSpace<3, 2>, InvalidParameter> {
        self.state_space(dt_s)
    }

    fn start_of(&self, frames: &[Frame<2>]) -> Result<(Gaussian<3>, usize), SeriesError> {
        let (w0, w1, index) = first_pair(frames)?;
        Ok((at_frame(index, self.start_from_two(w0, w1, frames[index].dt_s))?, index))
    }

    fn unbounded(&self) -> [f64; 2] {
        [self.acceleration_variance_mm2_s4().ln(), self.white_variance_mm2().ln()]
    }

    fn with_unbounded(&self, p: &[f64; 2]) -> Result<Self, InvalidParameter> {
        Self::new(p[0].exp(), p[1].exp())
    }

    fn parameters(&self) -> [NoiseParameter; 2] {
        [
            parameter("acceleration-variance", "z²/s⁴", self.acceleration_variance_mm2_s4()),
            parameter("white-variance", "z²", self.white_variance_mm2()),
        ]
    }
}
