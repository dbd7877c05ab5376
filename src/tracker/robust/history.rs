//! What was accepted in each frame, for the smoother.

use nalgebra::SMatrix;

use super::GEOMETRY_VARIANCE_PX2;
use super::filter::{self, PROCESS_NOISE, VIBRATION_VARIANCE_PX2};
use super::judge::Measured;
use super::part::{Part, Parts};
use crate::kalman::{ChiSquareGate, ColouredMeasurement, Frame, Gaussian, SeriesError, fit, smoother};

/// σ above which a smoothed value is not given \[px\]: it bridges short gaps, not long absences.
const LARGEST_STD_PX: f64 = 2.5;

/// The recording so far.
#[derive(Debug, Default)]
pub struct History {
    parts: Parts,
    frames: Vec<Frame<1>>,
    /// For each frame of the recording, its place in `frames`: repeated frames share one.
    places: Vec<usize>,
    /// Where in `frames` each joint begins.
    starts: Vec<usize>,
    step: f64,
}

impl History {
    /// Nothing yet.
    pub fn new(parts: Parts) -> Self {
        Self { parts, ..Self::default() }
    }

    /// The next frame lies `frames` after the last.
    pub fn step(&mut self, frames: f64) {
        self.step = frames;
    }

    /// Nothing was accepted in it.
    pub fn nothing(&mut self) {
        self.push(None);
    }

    /// A joint was found in it, at `measured`.
    pub fn found(&mut self, measured: Measured) {
        self.starts.push(self.frames.len());
        self.push(Some(measured));
    }

    /// What was accepted in it while the seam was followed.
    pub fn frame(&mut self, measured: Option<Measured>) {
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

    /// Position and its variance in each frame given all frames, or those up to `lag` after it, the process noise by
    /// maximum likelihood. Each joint is smoothed by itself.
    pub fn smoothed(&self, lag: Option<usize>) -> Result<Vec<Option<(f64, f64)>>, SeriesError> {
        let model = filter::model(PROCESS_NOISE, GEOMETRY_VARIANCE_PX2, true)
            .map_err(|reason| SeriesError::InvalidFrame { frame: 0, reason })?;
        let mut states = vec![];
        let ends = self.starts.iter().skip(1).copied().chain([self.frames.len()]);
        for (start, end) in self.starts.iter().copied().zip(ends) {
            states.resize(start, None);
            states.extend(self.smoothed_joint(&model, &self.frames[start..end], lag)?);
        }
        states.resize(self.frames.len(), None);
        let at = |&place: &usize| {
            let state: Gaussian<3> = states[place]?;
            let variance = state.P[(0, 0)].max(0.0) + VIBRATION_VARIANCE_PX2;
            (variance.sqrt() < LARGEST_STD_PX).then_some((state.x[0], variance))
        };
        Ok(self.places.iter().map(at).collect())
    }

    fn smoothed_joint(
        &self,
        model: &ColouredMeasurement,
        frames: &[Frame<1>],
        lag: Option<usize>,
    ) -> Result<Vec<Option<Gaussian<3>>>, SeriesError> {
        let gate = Some(ChiSquareGate::<1>::P99);
        match lag {
            Some(lag) => fit::smooth_seam_lagged(model, frames, gate, lag),
            None if self.parts.has(Part::SmootherFit) => Ok(fit::smooth_seam(model, frames, gate)?.states),
            None => {
                let run = fit::filter(model, frames, gate)?;
                let states = smoother::bryson_frazier(&run.trajectory).into_iter().map(Some);
                Ok(std::iter::repeat_n(None, run.first).chain(states).collect())
            }
        }
    }
}
