//! A measured series through its paper's filter: what is known in each frame, and afterwards given all of them.

use serde::{Deserialize, Serialize};

use super::Measure;
use super::noise::{Noise, NoiseLevels, ONE_VALUE_GATE, REFUSE_SIGMAS};
use super::refusal::Refusal;
use crate::kalman::adaptive::{NoiseAdaptation, complete_frames_gate};
use crate::kalman::{Frame, Gaussian, Model, SeriesError, Trajectory, smoother};

/// So many refused values in a row that agree among themselves start the filter anew; chosen, as the seam tracker's.
const RESTART_AFTER: usize = 5;
/// What every edge of a recording may be off in the same direction \[px\], in every frame, so that no filter can see it.
/// Chosen: the made-up pools' seeds 1 to 3 show 0.05 to 0.1 px a tip and 0.15 to 0.25 px a width, which has two edges.
const EDGE_BIAS_PX: f64 = 0.1;
/// Frames without a value for which the prediction is still given; chosen, as the seam tracker's.
const MOST_COASTING: usize = 20;
/// A prediction whose σ exceeds so many σ of a measurement is none any more; chosen: a pool that changes fast cannot be
/// predicted for long.
const MOST_COASTING_SIGMAS: f64 = 6.0;

/// What is known of the measure in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Not found yet.
    Seeking,
    /// Measured in this frame.
    Tracked,
    /// Predicted; σ grows.
    Coasting,
    /// Not seen for too long: no value.
    Lost,
    /// The frame could not be read.
    Unreadable,
}

/// One frame of the series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Time stamp \[s\], rising.
    pub time_s: f64,
    /// The measured value \[px\], or why there is none.
    pub value_px: Result<f64, Refusal>,
}

/// A value and one σ of it.
pub type Estimated = (f64, f64);

/// What is known in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// How it is known.
    pub status: Status,
    /// The filter's value and σ \[px\], unless seeking, lost or unreadable.
    pub filtered: Option<Estimated>,
    /// Normalised innovation squared over the rows measured, of a value that was taken.
    pub nis: Option<f64>,
    /// The value and σ given the whole recording \[px\], from the first to the last value of a stretch.
    pub smooth: Option<Estimated>,
    /// Why the frame's value was not taken.
    pub refused: Option<Refusal>,
}

/// A followed series.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// One a frame.
    pub frames: Vec<Followed>,
    /// The noise levels that the filter ran with.
    pub noise: NoiseLevels,
}

/// Follows a series with its paper's filter: the tip with coloured process noise, the width with a measurement noise
/// that is learnt on the way unless it was fitted.
///
/// # Errors
/// When time stamps do not rise, or a noise level is no variance.
pub fn follow(measure: Measure, readings: &[Reading], noise: NoiseLevels, period_s: f64) -> Result<Path, SeriesError> {
    let invalid = |reason| SeriesError::InvalidFrame { frame: 0, reason };
    let mut frames = match measure {
        Measure::Tip => Follower::run(&noise.tip_model(period_s).map_err(invalid)?, readings, noise, false)?,
        Measure::Width => Follower::run(&noise.width_model().map_err(invalid)?, readings, noise, true)?,
    };
    if noise.from == Noise::Fit {
        let bias_px = match measure {
            Measure::Tip => EDGE_BIAS_PX,
            Measure::Width => 2.0 * EDGE_BIAS_PX,
        };
        for (_, std_px) in frames.iter_mut().flat_map(|frame| [&mut frame.filtered, &mut frame.smooth]).flatten() {
            *std_px = std_px.hypot(bias_px);
        }
    }
    Ok(Path { frames, noise })
}

/// A stretch over which the filter ran without a restart.
struct Stretch<const N: usize> {
    /// Frame of the trajectory's start.
    first: usize,
    trajectory: Trajectory<N, 2>,
    adaptation: Option<NoiseAdaptation<2>>,
    /// The last frame whose value was taken, and that value.
    last: (usize, f64),
}

struct Follower<'a, const N: usize, const P: usize, T: Model<N, 2, P>> {
    model: &'a T,
    noise: NoiseLevels,
    learns: bool,
    readings: &'a [Reading],
    frames: Vec<Followed>,
    stretch: Option<Stretch<N>>,
    seen: bool,
    outliers: Vec<f64>,
}

impl<'a, const N: usize, const P: usize, T: Model<N, 2, P>> Follower<'a, N, P, T> {
    fn run(
        model: &'a T,
        readings: &'a [Reading],
        noise: NoiseLevels,
        paper_learns: bool,
    ) -> Result<Vec<Followed>, SeriesError> {
        let mut follower = Self {
            model,
            noise,
            learns: paper_learns && noise.from == Noise::Paper,
            readings,
            frames: Vec::with_capacity(readings.len()),
            stretch: None,
            seen: false,
            outliers: vec![],
        };
        for k in 0..readings.len() {
            let followed = follower.step(k)?;
            follower.frames.push(followed);
        }
        follower.close();
        Ok(follower.frames)
    }

    fn as_printed(&self) -> bool {
        self.noise.from == Noise::Paper
    }

    fn step(&mut self, k: usize) -> Result<Followed, SeriesError> {
        let value = self.readings[k].value_px;
        if self.outliers_agree() {
            self.close();
        }
        let Some(mut stretch) = self.stretch.take() else { return self.seek(k) };
        let dt_s = self.readings[k].time_s - self.readings[k - 1].time_s;
        let (taken, refused) = match value {
            Err(refusal) => (None, Some(refusal)),
            Ok(value) if self.is_outlier(&stretch, k, dt_s, value)? => {
                if self.outliers.len() == RESTART_AFTER {
                    self.outliers.remove(0);
                }
                self.outliers.push(value);
                (None, Some(Refusal::Outlier))
            }
            Ok(value) => (Some(value), None),
        };
        let before = Some(stretch.last).filter(|&(frame, _)| self.as_printed() && frame + 1 == k);
        let displacement = taken.zip(before).map(|(now, (_, before))| now - before);
        let space = |dt_s| {
            let space = self.model.space_over(dt_s)?;
            Ok(stretch.adaptation.map_or(space, |adaptation| space.with_R(adaptation.R())))
        };
        let frame = Frame::new(dt_s, [taken, displacement]);
        let gate = if self.as_printed() { complete_frames_gate() } else { ONE_VALUE_GATE };
        let step = *stretch.trajectory.push(&frame, space, Some(gate)).map_err(|error| error.at_frame(k))?;
        if let Some(adaptation) = &mut stretch.adaptation {
            adaptation.learn(&step);
        }
        if let Some(value) = taken {
            stretch.last = (k, value);
            self.outliers.clear();
        }
        let sigma_px = estimated(&step.update.posterior).1;
        let is_vague = taken.is_none() && sigma_px > MOST_COASTING_SIGMAS * self.noise.measurement_px2.sqrt();
        if is_vague || k - stretch.last.0 > MOST_COASTING {
            self.stretch = Some(stretch);
            self.close();
            return Ok(self.without_value(value, refused));
        }
        self.stretch = Some(stretch);
        let status = match (taken, refused) {
            (Some(_), _) => Status::Tracked,
            (None, Some(Refusal::Unreadable)) => Status::Unreadable,
            (None, _) => Status::Coasting,
        };
        let filtered = (status != Status::Unreadable).then(|| estimated(&step.update.posterior));
        Ok(Followed { status, filtered, nis: step.update.nis, smooth: None, refused })
    }

    /// Starts from this frame and the one before, if both have values that lie with the one before them on a straight
    /// line: a plume or a spatter gives one or two wild ones. As printed, two values are enough.
    fn seek(&mut self, k: usize) -> Result<Followed, SeriesError> {
        let value = self.readings[k].value_px;
        let value_of = |frame: usize| self.readings[frame].value_px.ok();
        let recent =
            |needed: usize| (k + 1).checked_sub(needed).map(|first| (first..=k).filter_map(value_of).collect());
        let recent: Vec<f64> = recent(if self.as_printed() { 2 } else { 3 }).unwrap_or_default();
        let (z0, z1) = match recent[..] {
            [z0, z1] if self.as_printed() && (z1 - z0).abs() <= self.noise.start_tolerance_px() => (z0, z1),
            [before, z0, z1] if self.noise.on_a_line([before, z0, z1]) => (z0, z1),
            _ => return Ok(self.without_value(value, value.err())),
        };
        let dt_s = self.readings[k].time_s - self.readings[k - 1].time_s;
        let frames = [z0, z1].map(|z| Frame::new(dt_s, [Some(z), None]));
        let (start, _) = self.model.start_of(&frames).map_err(|error| error.at_frame(k))?;
        let space = self.model.space_over(dt_s).map_err(|reason| SeriesError::InvalidFrame { frame: k, reason })?;
        self.stretch = Some(Stretch {
            first: k,
            trajectory: Trajectory { start, steps: vec![] },
            adaptation: self.learns.then(|| NoiseAdaptation::new(&space.R)),
            last: (k, z1),
        });
        self.seen = true;
        Ok(Followed {
            status: Status::Tracked,
            filtered: Some(estimated(&start)),
            nis: None,
            smooth: None,
            refused: None,
        })
    }

    /// Whether enough values were refused in a row that agree among themselves.
    fn outliers_agree(&self) -> bool {
        self.outliers.len() == RESTART_AFTER && spread(&self.outliers) <= self.noise.start_tolerance_px()
    }

    fn is_outlier(&self, stretch: &Stretch<N>, k: usize, dt_s: f64, value: f64) -> Result<bool, SeriesError> {
        let invalid = |reason| SeriesError::InvalidFrame { frame: k, reason };
        let space = self.model.space_over(dt_s).map_err(invalid)?;
        let measurement = stretch.adaptation.map_or(space.R, |adaptation| adaptation.R())[(0, 0)];
        let state = stretch.trajectory.steps.last().map_or(stretch.trajectory.start, |step| step.update.posterior);
        let prior = state.predict(&space);
        let variance = prior.P[(0, 0)] + measurement;
        Ok((value - prior.x[0]).powi(2) > REFUSE_SIGMAS * REFUSE_SIGMAS * variance)
    }

    /// A frame without any value.
    fn without_value(&self, value: Result<f64, Refusal>, refused: Option<Refusal>) -> Followed {
        let status = match value {
            Err(Refusal::Unreadable) => Status::Unreadable,
            _ if self.seen => Status::Lost,
            _ => Status::Seeking,
        };
        Followed { status, filtered: None, nis: None, smooth: None, refused }
    }

    /// Ends the stretch: its frames get their smoothed values.
    fn close(&mut self) {
        self.outliers.clear();
        let Some(mut stretch) = self.stretch.take() else { return };
        stretch.trajectory.steps.truncate(stretch.last.0 - stretch.first);
        let smoothed = smoother::bryson_frazier(&stretch.trajectory);
        for (frame, state) in (stretch.first..).zip(&smoothed) {
            if let Some(followed) = self.frames.get_mut(frame) {
                followed.smooth = Some(estimated(state));
            }
        }
    }
}

fn spread(values: &[f64]) -> f64 {
    let ends = |(low, high): (f64, f64), &value: &f64| (value.min(low), value.max(high));
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    high - low
}

fn estimated<const N: usize>(state: &Gaussian<N>) -> Estimated {
    (state.x[0], state.P[(0, 0)].max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: NoiseLevels = NoiseLevels { measurement_px2: 0.04, drive: 1e-4, from: Noise::Fit };

    /// A tip that moves by 0.1 px a frame, but for the frames of `change`.
    fn followed(frames: usize, change: impl Fn(usize) -> Option<Result<f64, Refusal>>) -> Vec<Followed> {
        let reading = |k: usize| {
            let wobble = if k.is_multiple_of(2) { 0.1 } else { -0.1 };
            let value_px = change(k).unwrap_or(Ok(100.0 + 0.1 * k as f64 + wobble));
            Reading { time_s: k as f64 * 1e-3, value_px }
        };
        follow(Measure::Tip, &(0..frames).map(reading).collect::<Vec<_>>(), NOISE, 1e-3).unwrap().frames
    }

    fn statuses(frames: &[Followed]) -> String {
        let letter = |frame: &Followed| match frame.status {
            Status::Seeking => 's',
            Status::Tracked => 't',
            Status::Coasting => 'c',
            Status::Lost => 'l',
            Status::Unreadable => 'u',
        };
        frames.iter().map(letter).collect()
    }

    #[test]
    fn three_values_start_it_a_gap_is_predicted_with_growing_sigma_and_bridged_by_the_smoother() {
        let frames = followed(40, |k| (k < 3 || (20..25).contains(&k)).then_some(Err(Refusal::NoPool)));
        assert_eq!(statuses(&frames), "s".repeat(5) + &"t".repeat(15) + "ccccc" + &"t".repeat(15));
        let sigma = |k: usize| frames[k].filtered.unwrap().1;
        assert!((20..25).all(|k| sigma(k) > sigma(k - 1)) && sigma(26) < sigma(24));
        assert!(frames[5..].iter().all(|frame| frame.smooth.is_some()) && frames[4].smooth.is_none());
        assert!((frames[22].smooth.unwrap().0 - 102.2).abs() < 0.2);
        assert_eq!((frames[22].nis, frames[22].refused), (None, Some(Refusal::NoPool)));
    }

    #[test]
    fn a_stray_value_is_refused_and_does_not_move_the_estimate() {
        let frames = followed(30, |k| (k == 20).then_some(Ok(140.0)));
        assert_eq!((frames[20].status, frames[20].refused), (Status::Coasting, Some(Refusal::Outlier)));
        assert!((frames[20].filtered.unwrap().0 - 102.0).abs() < 0.3);
    }

    #[test]
    fn a_lasting_jump_starts_it_anew_but_scattered_strays_do_not() {
        let jumped = followed(40, |k| (k >= 20).then_some(Ok(140.0 + 0.02 * (k % 3) as f64)));
        assert_eq!(statuses(&jumped[18..27]), "ttccccctt");
        assert!((jumped[30].filtered.unwrap().0 - 140.0).abs() < 0.2);
        let scattered = followed(40, |k| (20..27).contains(&k).then_some(Ok(140.0 + 9.0 * (k % 4) as f64)));
        assert_eq!(statuses(&scattered[18..29]), "ttccccccctt");
    }

    #[test]
    fn what_stays_away_is_lost_and_found_again() {
        let frames = followed(70, |k| (20..50).contains(&k).then_some(Err(Refusal::NoPool)));
        assert_eq!(statuses(&frames[19..21]), "tc");
        assert_eq!((frames[45].status, frames[45].filtered, frames[45].smooth), (Status::Lost, None, None));
        assert_eq!(statuses(&frames[49..54]), "llltt");
    }

    #[test]
    fn two_wild_values_that_agree_do_not_find_what_was_lost() {
        let wild = |k: usize| if matches!(k, 44 | 45) { Ok(140.0) } else { Err(Refusal::NoPool) };
        let frames = followed(70, |k| (20..50).contains(&k).then(|| wild(k)));
        assert_eq!(statuses(&frames[43..54]), "llllllllltt");
    }

    #[test]
    fn as_printed_a_value_counts_twice_and_fitted_once() {
        let reading = |k: u32| Reading { time_s: f64::from(k), value_px: Ok(f64::from(k)) };
        let readings: Vec<Reading> = (0..60).map(reading).collect();
        for measure in [Measure::Tip, Measure::Width] {
            let sigma = |from| {
                let path = follow(measure, &readings, NoiseLevels { from, ..NOISE }, 1.0).unwrap();
                path.frames[10].filtered.unwrap().1
            };
            assert!(sigma(Noise::Fit) > 1.1 * sigma(Noise::Paper), "{} {}", sigma(Noise::Fit), sigma(Noise::Paper));
        }
    }

    #[test]
    fn a_series_without_a_value_is_sought_to_its_end() {
        assert_eq!(statuses(&followed(4, |_| Some(Err(Refusal::Unreadable)))), "uuuu");
        assert_eq!(statuses(&followed(4, |_| Some(Err(Refusal::Saturated)))), "ssss");
    }
}
