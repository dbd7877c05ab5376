//! How much a measured series scatters, and how much what it measures moves: from the series itself, or the papers'.

use serde::{Deserialize, Serialize};

use super::Measure;
use crate::kalman::{ChiSquareGate, ColouredProcess, Frame, InvalidParameter, Model, Width};

/// Where the filter's noise levels come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Noise {
    /// From the recording: the scatter from third differences, the motion by likelihood.
    #[default]
    Fit,
    /// The papers' levels, whatever the recording: tip R = 5 I px², width 0.035 mm.
    Paper,
}

/// The noise levels a filter runs with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NoiseLevels {
    /// Variance of one measurement \[px²\].
    pub measurement_px2: f64,
    /// What drives the motion: the tip's acceleration \[px²/frame⁴\], the width's \[px²/s⁴\].
    pub drive: f64,
    /// Where they come from. The papers' filters take each value twice, as itself and in its displacement from the one
    /// before, as if both erred independently, and Jiang's learns its noise on the way; fitted, a value counts once.
    pub from: Noise,
}

/// A value farther than so many σ of its innovation is refused; chosen: one in two million by chance. Nearer ones are
/// bounded by [`ONE_VALUE_GATE`].
pub(super) const REFUSE_SIGMAS: f64 = 5.0;
/// The 99 % rule on a value alone.
pub(super) const ONE_VALUE_GATE: ChiSquareGate<2> = ChiSquareGate::<2>::P99;
/// First values that belong together lie within so many σ of a straight line's second difference; chosen.
const START_SIGMAS: f64 = 3.0;
/// So far off it they may be at any noise \[px\]; chosen: a recording may be quiet in one part and lively in another.
const START_PX: f64 = 2.0;
/// Measured frames that the motion is fitted to at most; chosen: more change little and take long.
const FITTED_FRAMES: usize = 1000;
/// Fewest third differences for an estimate of the scatter; chosen.
const FEWEST_DIFFERENCES: usize = 12;
/// Variance of the second difference of white noise over its own: 1 + 4 + 1.
const SECOND_DIFFERENCE: f64 = 6.0;
/// Variance of the third difference of white noise over its own: 1 + 9 + 9 + 1.
const THIRD_DIFFERENCE: f64 = 20.0;
/// Standard deviation of normal noise over its median absolute value.
const SIGMA_OVER_MEDIAN: f64 = 1.482_6;
/// No measurement is trusted further than this \[px\]; chosen: the edges of a pool are not sharper.
const LEAST_SIGMA_PX: f64 = 0.02;
/// Drives that are tried \[px²/frame⁴\], two a decade; chosen: from a straight seam to a jump in each frame.
const DRIVE_DECADES: std::ops::RangeInclusive<i32> = -16..=0;
/// The infrared paper's own acceleration colour a frame.
const COLOUR: f64 = 0.5;
/// Standard deviation of Jiang's widths \[mm\]: mean absolute error 0.028 mm over √(2/π).
const JIANG_SIGMA_MM: f64 = 0.028 / 0.797_884_560_802_865_4;

impl NoiseLevels {
    /// The papers' levels; `mm_per_px` turns Jiang's millimetres into pixels.
    #[must_use]
    pub fn of_papers(measure: Measure, mm_per_px: f64) -> Self {
        match measure {
            Measure::Tip => {
                let [drive, _, measurement_px2, _] = ColouredProcess::printed().noise();
                Self { measurement_px2, drive, from: Noise::Paper }
            }
            Measure::Width => Self {
                measurement_px2: (JIANG_SIGMA_MM / mm_per_px).powi(2),
                drive: Width::ACCELERATION_VARIANCE_MM2_S4 / (mm_per_px * mm_per_px),
                from: Noise::Paper,
            },
        }
    }

    /// The levels of a measured series, one value a frame, `period_s` apart; none when it is too short to tell.
    #[must_use]
    pub fn of_series(measure: Measure, values_px: &[Option<f64>], period_s: f64) -> Option<Self> {
        let measurement_px2 = scatter(values_px)?;
        let levels = |drive| Self { measurement_px2, drive, from: Noise::Fit };
        let start =
            |three: &[Option<f64>]| matches!(*three, [Some(a), Some(b), Some(c)] if levels(0.0).on_a_line([a, b, c]));
        let first = values_px.windows(3).position(start)?;
        let fitted = &values_px[first..values_px.len().min(first + FITTED_FRAMES)];
        let frames: Vec<Frame<2>> = fitted.iter().map(|&value| Frame::new(period_s, [value, None])).collect();
        let likelihood = |half_decade: i32| {
            let levels = levels(drive(measure, half_decade, period_s));
            let fit = match measure {
                Measure::Tip => levels.tip_model(period_s).ok().and_then(|model| likelihood(&model, &frames)),
                Measure::Width => levels.width_model().ok().and_then(|model| likelihood(&model, &frames)),
            };
            fit.unwrap_or(f64::NEG_INFINITY)
        };
        let scored = DRIVE_DECADES.map(|half_decade| (half_decade, likelihood(half_decade)));
        let (best, _) = scored.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(levels(drive(measure, best, period_s)))
    }

    /// Whether first values lie on a straight line, as those of one motion do.
    pub(super) fn on_a_line(&self, [a, b, c]: [f64; 3]) -> bool {
        (c - 2.0 * b + a).abs() <= self.start_tolerance_px()
    }

    /// How far first values that belong together may lie off \[px\].
    pub(super) fn start_tolerance_px(&self) -> f64 {
        START_PX.max(START_SIGMAS * (SECOND_DIFFERENCE * self.measurement_px2).sqrt())
    }

    /// The infrared paper's model with these levels; as in the paper, position and displacement have one variance.
    pub(super) fn tip_model(&self, period_s: f64) -> Result<ColouredProcess, InvalidParameter> {
        ColouredProcess::new(self.drive, COLOUR, self.measurement_px2, self.measurement_px2, period_s)
    }

    /// Jiang's model with these levels, in pixels.
    pub(super) fn width_model(&self) -> Result<Width, InvalidParameter> {
        Width::new(self.drive, self.measurement_px2)
    }
}

/// The drive of a step on the grid, in the model's own unit.
fn drive(measure: Measure, half_decade: i32, period_s: f64) -> f64 {
    let per_frame4 = 10_f64.powf(0.5 * f64::from(half_decade));
    match measure {
        Measure::Tip => per_frame4,
        Measure::Width => per_frame4 / period_s.powi(4),
    }
}

/// How likely the series is under a model. A refused value costs as much as one at the limit: otherwise a few wild
/// ones would outvote the rest and the motion would be found as wild as they.
fn likelihood<const N: usize, const P: usize>(model: &impl Model<N, 2, P>, frames: &[Frame<2>]) -> Option<f64> {
    let (mut state, first) = model.start_of(frames).ok()?;
    let mut sum = 0.0;
    for frame in &frames[first + 1..] {
        let space = model.space_over(frame.dt_s).ok()?;
        state = state.predict(&space);
        let Some(value) = frame.z[0] else { continue };
        let limit_px = REFUSE_SIGMAS * (state.P[(0, 0)] + space.R[(0, 0)]).sqrt();
        let bounded = value.clamp(state.x[0] - limit_px, state.x[0] + limit_px);
        let update = state.update(&space, &[Some(bounded), None], Some(ONE_VALUE_GATE)).ok()?;
        sum += update.log_likelihood;
        if value == bounded {
            state = update.posterior;
        }
    }
    Some(sum)
}

/// The variance of white noise on a smooth series \[px²\], robust: from the median of its third differences.
fn scatter(values_px: &[Option<f64>]) -> Option<f64> {
    let third = |four: &[Option<f64>]| Some((four[3]? - four[0]? - 3.0 * (four[2]? - four[1]?)).abs());
    let mut differences: Vec<f64> = values_px.windows(4).filter_map(third).collect();
    if differences.len() < FEWEST_DIFFERENCES {
        return None;
    }
    let middle = differences.len() / 2;
    let median = *differences.select_nth_unstable_by(middle, f64::total_cmp).1;
    Some(((SIGMA_OVER_MEDIAN * median).powi(2) / THIRD_DIFFERENCE).max(LEAST_SIGMA_PX * LEAST_SIGMA_PX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn noisy(sigma: f64, value: impl Fn(f64) -> f64) -> Vec<Option<f64>> {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        (0..600).map(|k| Some(value(f64::from(k)) + sigma * normal())).collect()
    }

    #[test]
    fn the_scatter_is_that_of_the_noise_whatever_the_series_does_below_it() {
        let mut series = noisy(0.3, |k| 100.0 + 0.2 * k + 20.0 * (k / 80.0).sin());
        for k in (0..600).step_by(25) {
            series[k] = Some(500.0);
        }
        series[77] = None;
        // The median of 600 correlated values is good to some 5 %, and one stray value in 25 spoils 4 of 25 differences.
        let sigma = scatter(&series).unwrap().sqrt();
        assert!((0.27..0.38).contains(&sigma), "{sigma}");
    }

    #[test]
    fn a_straight_series_is_given_a_smaller_drive_than_a_wandering_one() {
        for measure in [Measure::Tip, Measure::Width] {
            let straight = NoiseLevels::of_series(measure, &noisy(0.3, |k| 0.1 * k), 0.1).unwrap();
            let wandering = NoiseLevels::of_series(measure, &noisy(0.3, |k| 9.0 * (k / 6.0).sin()), 0.1).unwrap();
            assert!(wandering.drive > 100.0 * straight.drive, "{straight:?} {wandering:?}");
        }
    }

    #[test]
    fn wild_values_do_not_make_a_straight_series_wander() {
        let straight = noisy(0.3, |k| 0.1 * k);
        let mut spoilt = straight.clone();
        spoilt[1] = Some(30.0);
        for k in (20..600).step_by(20) {
            spoilt[k] = Some(30.0 + (k % 70) as f64);
            spoilt[k + 1] = None;
        }
        let drive = |series: &[Option<f64>]| NoiseLevels::of_series(Measure::Tip, series, 0.1).unwrap().drive;
        assert!(drive(&spoilt) <= 10.0 * drive(&straight), "{} {}", drive(&spoilt), drive(&straight));
    }

    #[test]
    fn a_few_values_tell_nothing() {
        assert_eq!(NoiseLevels::of_series(Measure::Tip, &[Some(1.0); 9], 0.1), None);
        assert_eq!(NoiseLevels::of_series(Measure::Tip, &[None; 90], 0.1), None);
    }
}
