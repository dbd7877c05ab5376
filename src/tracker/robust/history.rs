//! What was accepted in each frame, for the smoother.

use nalgebra::SMatrix;

use super::GEOMETRY_VARIANCE_PX2;
use super::filter::{self, PROCESS_NOISE, VIBRATION_VARIANCE_PX2};
use super::judge::Measured;
use crate::kalman::{ChiSquareGate, Frame, SeriesError, fit};

/// σ above which a smoothed value is not given \[px\]: it bridges short gaps, not long absences.
const LARGEST_STD_PX: f64 = 2.5;

/// The recording so far.
#[derive(Debug, Default)]
pub struct History {
    frames: Vec<Frame<1>>,
    /// For each frame of the recording, its place in `frames`: repeated frames share one.
    places: Vec<usize>,
    step: f64,
    /// Sum and number of the noise scales in use.
    noise: (f64, f64),
}

impl History {
    /// The next frame lies `frames` after the last.
    pub fn step(&mut self, frames: f64) {
        self.step = frames;
    }

    /// Nothing was accepted in it.
    pub fn nothing(&mut self) {
        self.push(None);
    }

    /// `measured` was accepted in it.
    pub fn measured(&mut self, measured: Measured) {
        self.push(Some(measured));
    }

    /// What was accepted in it while the seam was followed, under the noise scale `noise`.
    pub fn frame(&mut self, measured: Option<Measured>, noise: f64) {
        self.noise = (self.noise.0 + noise, self.noise.1 + 1.0);
        self.push(measured);
    }

    /// The next frame repeats the last one.
    pub fn repeated(&mut self) {
        if let Some(&place) = self.places.last() {
            self.places.push(place);
        }
    }

    fn push(&mut self, measured: Option<Measured>) {
        let variance = measured.map(|m| SMatrix::from_element(m.variance_px2));
        self.places.push(self.frames.len());
        self.frames.push(Frame { dt_s: self.step.max(1e-6), z: [measured.map(|m| m.u_px)], R: variance });
    }

    /// Position and its variance in each frame given all frames, its process noise by maximum likelihood.
    pub fn smoothed(&self) -> Result<Vec<Option<(f64, f64)>>, SeriesError> {
        if self.frames.iter().all(|frame| frame.z[0].is_none()) {
            return Ok(vec![None; self.places.len()]);
        }
        let noise = if self.noise.1 > 0.0 { self.noise.0 / self.noise.1 } else { 1.0 };
        let model = filter::model(PROCESS_NOISE, GEOMETRY_VARIANCE_PX2, noise)
            .map_err(|reason| SeriesError::InvalidFrame { frame: 0, reason })?;
        let smoothed = fit::smooth_seam(&model, &self.frames, Some(ChiSquareGate::<1>::P99))?;
        let at = |&place: &usize| {
            let state = smoothed.states[place]?;
            let variance = state.P[(0, 0)].max(0.0) + VIBRATION_VARIANCE_PX2;
            (variance.sqrt() < LARGEST_STD_PX).then_some((state.x[0], variance))
        };
        Ok(self.places.iter().map(at).collect())
    }
}
