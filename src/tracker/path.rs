//! The path of a recording, smoothed.
//!
//! A [`Session`](super::Session) forgets; what is to be smoothed over a whole recording is collected here, one estimate a
//! frame. Each joint is smoothed by itself, with the noise that was measured while it was followed.

use nalgebra::SMatrix;

use super::TrackerError;
use super::estimate::{Estimate, SeamEstimate};
use super::robust::filter::{self, PROCESS_NOISE, VIBRATION_VARIANCE_PX2};
use super::robust::height::{self, Reading};
use super::robust::noise::WHITE_VARIANCE_PX2;
use super::view::View;
use crate::kalman::{ChiSquareGate, Frame, Gaussian, fit};
use crate::units::PixelPoint;

/// σ above which a smoothed value is not given, in pixels of the view: it bridges short gaps, not long absences.
const LARGEST_STD_PX: f64 = 2.5;

/// Frames before a joint was found in which it may have been seen.
pub const REMEMBERED: usize = 7;

/// A measurement as the filter took it: position along the stripe and across it, each with its R. The correlation filter
/// measures along it alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    pub along: Reading,
    pub across: Option<Reading>,
}

/// What the smoother is to know of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Memory {
    /// Time since the frame before \[beats\]; 0 for a repeated picture, which stands for the same moment.
    pub beats: f64,
    pub event: Event,
}

impl Memory {
    /// One beat later, and nothing known.
    pub const NOTHING: Self = Self { beats: 1.0, event: Event::Nothing };
}

/// What became of the joint in a frame.
#[expect(clippy::large_enum_variant, reason = "it is copied with an estimate, and nothing beside a frame")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// None is followed.
    Nothing,
    /// A joint was found, or the one that is followed has jumped; `before` is where it was in the frames before, the newest first, and `row_bias_px2` what no smoother
    /// averages out of its row \[px²\].
    Found { view: View, measured: Measured, before: [Option<Measured>; REMEMBERED], row_bias_px2: f64 },
    /// It was followed, under the noise scale `noise` and a shaking of the plates of variance `shaking_px2`, and no smoother averages
    /// `lasting_px2` out of its place along the stripe.
    Followed { measured: Option<Measured>, noise: f64, shaking_px2: f64, lasting_px2: f64 },
    /// It was lost, and stays so until something is accepted again.
    Lost,
    /// It ended when it was last seen.
    Ended,
}

/// A joint's part of the recording.
#[derive(Debug)]
struct Joint {
    view: View,
    row_bias_px2: f64,
    start: usize,
    /// From where on there is nothing to smooth: it ended, or was lost for good.
    end: Option<usize>,
    last_seen: usize,
    /// Sums of noise scale, shaking, and what no smoother averages away, and their number.
    noise: f64,
    shaking_px2: f64,
    lasting_px2: f64,
    count: f64,
}

impl Joint {
    fn mean(&self, sum: f64, otherwise: f64) -> f64 {
        if self.count > 0.0 { sum / self.count } else { otherwise }
    }
}

/// The recording so far.
#[derive(Debug)]
pub struct SeamPath {
    fits_process_noise: bool,
    along: Vec<Frame<1>>,
    across: Vec<Frame<1>>,
    /// For each frame of the recording its place among those: repeated frames share one.
    places: Vec<usize>,
    joints: Vec<Joint>,
}

impl Default for SeamPath {
    fn default() -> Self {
        Self { fits_process_noise: true, along: vec![], across: vec![], places: vec![], joints: vec![] }
    }
}

impl SeamPath {
    /// Without the search for the likeliest process noise.
    #[cfg(feature = "ablation")]
    #[must_use]
    pub fn without_fit(self) -> Self {
        Self { fits_process_noise: false, ..self }
    }

    /// The estimate of the next frame.
    pub fn push(&mut self, estimate: &Estimate) {
        let Memory { beats, event } = estimate.memory;
        if beats <= 0.0
            && let Some(&place) = self.places.last()
        {
            self.places.push(place);
            return;
        }
        let frame = self.along.len();
        let measured = match event {
            Event::Found { measured, .. } => Some(measured),
            Event::Followed { measured, .. } => measured,
            Event::Nothing | Event::Lost | Event::Ended => None,
        };
        match event {
            Event::Found { view, before, row_bias_px2, .. } => {
                // What was followed until now ended when it was last seen: what was predicted since was not so.
                if let Some(joint) = self.joints.last_mut() {
                    joint.end.get_or_insert(joint.last_seen + 1);
                }
                let start = self.recall(&before);
                self.joints.push(Joint {
                    view,
                    row_bias_px2,
                    start,
                    end: None,
                    last_seen: frame,
                    noise: 0.0,
                    shaking_px2: 0.0,
                    lasting_px2: 0.0,
                    count: 0.0,
                });
            }
            Event::Followed { noise, shaking_px2, lasting_px2, measured } => {
                if let Some(joint) = self.joints.last_mut() {
                    joint.noise += noise;
                    joint.shaking_px2 += shaking_px2;
                    joint.lasting_px2 += lasting_px2;
                    joint.count += 1.0;
                    if measured.is_some() {
                        (joint.end, joint.last_seen) = (None, frame);
                    }
                }
            }
            Event::Lost => {
                if let Some(joint) = self.joints.last_mut() {
                    joint.end.get_or_insert(frame);
                }
            }
            Event::Ended => {
                if let Some(joint) = self.joints.last_mut() {
                    joint.end = Some(joint.last_seen + 1);
                }
            }
            Event::Nothing => {}
        }
        self.places.push(frame);
        self.along.push(row(beats, measured.map(|m| m.along)));
        self.across.push(row(beats, measured.and_then(|m| m.across)));
    }

    /// Writes what was seen before a joint was found into those frames, as far back as no joint is known: the first of
    /// them.
    fn recall(&mut self, before: &[Option<Measured>; REMEMBERED]) -> usize {
        let frame = self.along.len();
        let free = self.joints.last().map_or(0, |joint| joint.end.unwrap_or(frame));
        let mut first = frame;
        for (age, measured) in (1..).zip(before) {
            let Some(measured) = measured else { continue };
            let Some(place) = frame.checked_sub(age).filter(|place| *place >= free) else { break };
            self.along[place] = row(self.along[place].dt_s, Some(measured.along));
            self.across[place] = row(self.across[place].dt_s, measured.across);
            first = place;
        }
        first
    }

    /// The seam in each frame, in the picture, given all frames; none where it was not seen and cannot be bridged.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn smoothed(&self) -> Result<Vec<Option<SeamEstimate>>, TrackerError> {
        let mut states = vec![None; self.along.len()];
        let nexts = self.joints.iter().skip(1).map(|joint| joint.start).chain([self.along.len()]);
        for (joint, next) in self.joints.iter().zip(nexts) {
            let frames = joint.start..joint.end.unwrap_or(next).min(next);
            let along = self.smoothed_along(joint, &self.along[frames.clone()])?;
            let across = self.smoothed_across(joint, &self.across[frames.clone()])?;
            for ((state, along), across) in states[frames].iter_mut().zip(along).zip(across) {
                *state = along.zip(across).and_then(|(along, across)| {
                    estimate(along, joint.mean(joint.lasting_px2, 0.0), across, &joint.view)
                });
            }
        }
        Ok(self.places.iter().map(|&place| states[place]).collect())
    }

    fn smoothed_along(&self, joint: &Joint, frames: &[Frame<1>]) -> Result<Vec<Option<Reading>>, TrackerError> {
        let model = filter::model(PROCESS_NOISE, WHITE_VARIANCE_PX2, joint.mean(joint.noise, 1.0))?;
        let gate = Some(ChiSquareGate::<1>::P99);
        let states = if self.fits_process_noise {
            fit::smooth_seam(&model, frames, gate)?.states
        } else {
            fit::filter(&model, frames, gate)?.smoothed()
        };
        let position = |state: Gaussian<3>| (state.x[0], state.P[(0, 0)].max(0.0) + VIBRATION_VARIANCE_PX2);
        Ok(states.into_iter().map(|state| state.map(position)).collect())
    }

    fn smoothed_across(&self, joint: &Joint, frames: &[Frame<1>]) -> Result<Vec<Option<Reading>>, TrackerError> {
        let model = height::model(joint.mean(joint.shaking_px2, height::FIRST_SHAKING_PX2), WHITE_VARIANCE_PX2)?;
        let states = fit::filter(&model, frames, Some(ChiSquareGate::<1>::P99))?.smoothed();
        let reading = |state: Gaussian<3>| {
            let (v_px, variance_px2) = height::reading(&state);
            (v_px, variance_px2 + joint.row_bias_px2)
        };
        Ok(states.into_iter().map(|state| state.map(reading)).collect())
    }
}

/// A row of a series, `beats` after the one before.
fn row(beats: f64, reading: Option<Reading>) -> Frame<1> {
    Frame {
        dt_s: beats.max(1e-6),
        z: [reading.map(|(px, _)| px)],
        R: reading.map(|(_, variance_px2)| SMatrix::from_element(variance_px2)),
    }
}

/// The seam from its coordinates in the view, if they are sure enough to be told; what lasts of the first one's variance,
/// `lasting_px2`, is no absence.
pub fn estimate(along: Reading, lasting_px2: f64, across: Reading, view: &View) -> Option<SeamEstimate> {
    let (std_px, std_across_px) = ((along.1 + lasting_px2).sqrt(), across.1.sqrt());
    let seam = SeamEstimate { centre: PixelPoint::new(along.0, across.0), std_px, std_across_px };
    (along.1.sqrt() < LARGEST_STD_PX).then(|| seam.in_picture(view))
}
