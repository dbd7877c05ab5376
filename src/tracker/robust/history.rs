//! What was accepted in each frame, for the smoother.

use nalgebra::SMatrix;

use super::GEOMETRY_VARIANCE_PX2;
use super::filter::{self, PROCESS_NOISE, VIBRATION_VARIANCE_PX2};
use super::judge::Measured;
use super::part::{Part, Parts};
use crate::kalman::{ChiSquareGate, ColouredMeasurement, Frame, Gaussian, SeriesError, fit, smoother};

/// σ above which a smoothed value is not given \[px\]: it bridges short gaps, not long absences.
const LARGEST_STD_PX: f64 = 2.5;

/// Where in the frames a joint begins, and from where on there is nothing to smooth: it ended or was lost for good.
#[derive(Debug, Clone, Copy)]
struct Joint {
    start: usize,
    end: Option<usize>,
}

/// The recording so far.
#[derive(Debug, Default)]
pub struct History {
    parts: Parts,
    frames: Vec<Frame<1>>,
    /// For each frame of the recording, its place in `frames`: repeated frames share one.
    places: Vec<usize>,
    joints: Vec<Joint>,
    step: f64,
    /// Sum and number of the noise scales in use.
    noise: (f64, f64),
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
        self.joints.push(Joint { start: self.frames.len(), end: None });
        self.push(Some(measured));
    }

    /// What was accepted in it while the seam was followed, under the noise scale `noise`.
    pub fn frame(&mut self, measured: Option<Measured>, noise: f64) {
        self.noise = (self.noise.0 + noise, self.noise.1 + 1.0);
        self.push(measured);
        if let (Some(joint), Some(_)) = (self.joints.last_mut(), measured) {
            joint.end = None;
        }
    }

    /// The seam was lost in the last frame, and stays so until something is accepted again.
    pub fn lost(&mut self) {
        if let Some(joint) = self.joints.last_mut() {
            joint.end.get_or_insert(self.frames.len().saturating_sub(1));
        }
    }

    /// The joint ended when it was last seen.
    pub fn ended(&mut self) {
        let last_seen = self.frames.iter().rposition(|frame| frame.z[0].is_some());
        if let Some(joint) = self.joints.last_mut() {
            joint.end = last_seen.map(|last| last + 1);
        }
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
        let noise = if self.noise.1 > 0.0 { self.noise.0 / self.noise.1 } else { 1.0 };
        let model = filter::model(PROCESS_NOISE, GEOMETRY_VARIANCE_PX2, noise)
            .map_err(|reason| SeriesError::InvalidFrame { frame: 0, reason })?;
        let mut states = vec![];
        let nexts = self.joints.iter().skip(1).map(|joint| joint.start).chain([self.frames.len()]);
        for (joint, next) in self.joints.iter().zip(nexts) {
            states.resize(joint.start, None);
            let end = joint.end.unwrap_or(next).min(next);
            states.extend(self.smoothed_joint(&model, &self.frames[joint.start..end], lag)?);
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
