//! Zhang 2009: the polyline with outliers (figure 1), and the closed loop on a 500 mm skew weld (figures 3 and 4).
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{DMatrix, DVector, matrix};

use crate::kalman::{
    ChiSquareGate, ConstantVelocity, Frame, Gaussian, Imm, InvalidParameter, SeriesError, StateSpace, Trajectory,
    TwoPointCovariance, fit, smoother,
};

use super::score::Score;
use super::series::{correlated, generator, outliers};
use super::table::{Row, Table};

const PERIOD_S: f64 = 0.4;
const FRAMES: usize = 250;
const SEEDS: u64 = 40;
/// Slopes of the polyline, fifty frames each \[mm/step\]; the paper draws but does not print them.
const SLOPES_MM: [f64; 5] = [0.115, -0.05, 0.1, 0.0, -0.115];
const SEGMENT: usize = FRAMES / SLOPES_MM.len();
/// Sensor error as printed \[mm\].
const SIGMA_MM: f64 = 0.1;
/// Deviation of the interacting models' acceleration \[mm/s²\]: a straight seam, the printed one, a corner.
const ACCELERATIONS_MM_S2: [f64; 3] = [0.01, 0.1, 1.0];
/// Probability that the seam stays what it is from frame to frame, chosen: a corner in thirty frames.
const STAY: f64 = 0.97;
/// Frames in a row beyond the gate that are taken for a jump of the seam, chosen.
const JUMP_FRAMES: u32 = 3;
/// Skew of the weld \[mm/step\]: 30 mm over 500 mm at 5 mm/s and 0.4 s.
const SKEW_MM: f64 = 0.12;

/// The experiment's tables.
///
/// # Errors
/// When a filter breaks down, which the printed numbers do not cause.
pub fn tables() -> Result<Vec<Table>, SeriesError> {
    Ok(vec![polyline_table(0.03)?, polyline_table(0.0)?, closed_loop_table()?])
}

fn invalid(reason: InvalidParameter) -> SeriesError {
    SeriesError::InvalidFrame { frame: 0, reason }
}

/// The paper's matrices: Q as printed (that of T = 0.2 s), or rebuilt for the period of its weld.
fn paper_space(printed_Q: bool) -> Result<StateSpace<2, 1>, SeriesError> {
    let model = ConstantVelocity::printed();
    let space = model.state_space(PERIOD_S).map_err(invalid)?;
    let Qd = if printed_Q { matrix![4e-6, 4e-5; 4e-5, 4e-4] } else { space.Qd };
    Ok(StateSpace { Qd, ..space })
}

fn polyline_table(share: f64) -> Result<Table, SeriesError> {
    let labels = [
        "measured",
        "paper's filter, Q as printed",
        "paper's filter, Q rebuilt for T = 0.4 s",
        "ours, causal: three interacting models, outliers bounded",
        "ours, smoothed: one model, q and R by likelihood",
        "limit, smoothed: corners and outliers known",
    ];
    let mut runs = vec![Vec::new(); labels.len()];
    for seed in 1..=SEEDS {
        let mut rng = generator(seed);
        let noise = correlated(FRAMES, SIGMA_MM, 0.0, &mut rng);
        let misses = outliers(FRAMES, share, (0.5, 1.5), &mut rng);
        let truth: Vec<f64> = (0..FRAMES).map(polyline_mm).collect();
        let error = |k: usize| noise[k] + misses[k].unwrap_or(0.0);
        let measured: Vec<f64> = (0..FRAMES).map(|k| truth[k] + error(k)).collect();
        let sound: Vec<bool> = misses.iter().map(Option::is_none).collect();
        let estimates = [
            measured.clone(),
            linear(&measured, &paper_space(true)?)?,
            linear(&measured, &paper_space(false)?)?,
            interacting(&measured)?,
            smoothed(&measured)?,
            known_corners(&measured, &sound),
        ];
        for (runs, estimate) in runs.iter_mut().zip(estimates) {
            runs.push(Score::of(&estimate.iter().zip(&truth).map(|(x, truth)| x - truth).collect::<Vec<_>>()));
        }
    }
    let row = |(label, runs): (&&str, Vec<Score>)| {
        let score = Score::median(&runs);
        Row::new(*label, [score.mean_absolute, score.rms, score.largest])
    };
    let percent = 100.0 * share;
    Ok(Table {
        title: format!("Zhang 2009, figure 1: polyline with {percent} % outliers (the paper prints no figures)"),
        noise: format!("simulated: up to 0.115 mm/step, white, 0.1 mm; outliers of 0.5 … 1.5 mm; {SEEDS} seeds"),
        columns: vec!["MAE [mm]", "RMS [mm]", "max [mm]"],
        rows: labels.iter().zip(runs).map(row).collect(),
    })
}

fn polyline_mm(frame: usize) -> f64 {
    (0..frame).map(|k| SLOPES_MM[(k / SEGMENT).min(SLOPES_MM.len() - 1)]).sum()
}

fn frames(measured: &[f64]) -> Vec<Frame<1>> {
    measured.iter().map(|z| Frame::new(PERIOD_S, [Some(*z)])).collect()
}

fn start(measured: &[f64]) -> Result<Gaussian<2>, SeriesError> {
    let model = ConstantVelocity::printed();
    let covariance = TwoPointCovariance::Printed;
    model.start_from_two(measured[0], measured[1], PERIOD_S, covariance).map_err(invalid)
}

fn linear(measured: &[f64], space: &StateSpace<2, 1>) -> Result<Vec<f64>, SeriesError> {
    let run = Trajectory::filter(start(measured)?, &frames(measured)[2..], |_| Ok(*space), None)?;
    Ok(std::iter::once(measured[0]).chain(run.filtered().map(|state| state.x[0])).collect())
}

fn smoothed(measured: &[f64]) -> Result<Vec<f64>, SeriesError> {
    let gate = Some(ChiSquareGate::<1>::P99);
    let frames = frames(measured);
    let (model, _) = fit::maximum_likelihood(&ConstantVelocity::printed(), &frames, gate)?;
    let states = smoother::bryson_frazier(&fit::filter(&model, &frames, gate)?.trajectory);
    Ok(std::iter::once(measured[0]).chain(states.iter().map(|state| state.x[0])).collect())
}

/// Three interacting models; a measurement beyond the 99 % point of the mixture is weighed down, unless it is one of
/// several in a row.
struct Interacting {
    models: Imm<2, 3>,
    spaces: [StateSpace<2, 1>; 3],
    beyond: u32,
}

impl Interacting {
    fn new(start: Gaussian<2>, sigma_mm: f64) -> Result<Self, SeriesError> {
        let mut spaces = [paper_space(false)?; 3];
        for (space, acceleration) in spaces.iter_mut().zip(ACCELERATIONS_MM_S2) {
            let model = ConstantVelocity::new(acceleration * acceleration, sigma_mm * sigma_mm).map_err(invalid)?;
            *space = model.state_space(PERIOD_S).map_err(invalid)?;
        }
        Ok(Self { models: Imm::new(start, STAY).map_err(invalid)?, spaces, beyond: 0 })
    }

    fn step(&mut self, z: f64) -> Result<Gaussian<2>, SeriesError> {
        let broken = |reason| SeriesError::Innovation { frame: 0, reason };
        let prior = self.models.predict(&self.spaces);
        let seen = prior.output().update(&self.spaces[0], &[Some(z)], Some(ChiSquareGate::<1>::P99)).map_err(broken)?;
        self.beyond = if seen.weight < 1.0 { self.beyond + 1 } else { 0 };
        let inflation = if self.beyond < JUMP_FRAMES { (1.0 / seen.weight - 1.0) * seen.weight } else { 0.0 };
        let spaces = self.spaces.map(|space| space.with_R(space.R + seen.S * inflation));
        self.models = prior.update(&spaces, &[Some(z)], None).map_err(broken)?.posterior;
        Ok(self.models.output())
    }

    /// The position expected at the next frame \[mm\].
    fn ahead_mm(&self) -> f64 {
        self.models.predict(&self.spaces).output().x[0]
    }
}

fn interacting(measured: &[f64]) -> Result<Vec<f64>, SeriesError> {
    let mut filter = Interacting::new(start(measured)?, SIGMA_MM)?;
    let rest: Result<Vec<f64>, _> = measured[2..].iter().map(|z| Ok(filter.step(*z)?.x[0])).collect();
    Ok(measured[..2].iter().copied().chain(rest?).collect())
}

/// Least squares over the polylines with the true corners, without the outliers.
fn known_corners(measured: &[f64], sound: &[bool]) -> Vec<f64> {
    let hat = |frame: usize, knot: usize| {
        let distance = (frame as f64 - (knot * SEGMENT) as f64).abs() / SEGMENT as f64;
        (1.0 - distance).max(0.0)
    };
    let weight = |frame: usize| if sound[frame] { 1.0 } else { 0.0 };
    let A = DMatrix::from_fn(FRAMES, SLOPES_MM.len() + 1, hat);
    let weighted = DMatrix::from_fn(FRAMES, SLOPES_MM.len() + 1, |i, j| weight(i) * A[(i, j)]);
    let z = DVector::from_row_slice(measured);
    let normal = weighted.transpose() * &A;
    let knots = normal.lu().solve(&(weighted.transpose() * z)).unwrap_or_else(|| DVector::zeros(A.ncols()));
    (A * knots).iter().copied().collect()
}

/// How the slide is commanded.
#[derive(Debug, Clone, Copy)]
enum Loop {
    /// By the measured deviation.
    Raw,
    /// By the filtered deviation, as the paper does.
    FilteredDeviation,
    /// To the predicted absolute position.
    PredictedPosition,
    /// The same with the three interacting models.
    Interacting,
    /// To the continuation of a straight line through all sound positions.
    KnownStraight,
}

fn closed_loop_table() -> Result<Table, SeriesError> {
    let kinds = [
        ("no filter", Loop::Raw),
        ("paper's filter on the deviation", Loop::FilteredDeviation),
        ("paper's filter on slide + deviation", Loop::PredictedPosition),
        ("ours, causal: interacting models on slide + deviation", Loop::Interacting),
        ("limit, causal: straight and outliers known", Loop::KnownStraight),
    ];
    let mut rows = Vec::new();
    for (label, kind) in kinds {
        let runs: Result<Vec<Score>, _> = (1..=SEEDS).map(|seed| closed_loop(kind, seed)).collect();
        let score = Score::median(&runs?);
        rows.push(Row::new(label, [score.rms, score.largest, score.mean]));
    }
    // "Basically 0.6 to 0.8 mm" without and "0.5 to 0.6 mm" with the filter: read as the largest, upper end.
    rows.push(Row::of_paper("no filter (0.6 … 0.8 mm)", [None, Some(0.8), None]));
    rows.push(Row::of_paper("Kalman filter (0.5 … 0.6 mm)", [None, Some(0.6), None]));
    Ok(Table {
        title: "Zhang 2009, figures 3 and 4: closed loop on a 500 mm weld, 30 mm skew".into(),
        noise: format!("simulated: 0.12 mm/step, white, 0.2 mm, 3 % outliers of up to 1 mm; {SEEDS} seeds"),
        columns: vec!["RMS [mm]", "max [mm]", "mean [mm]"],
        rows,
    })
}

/// The error slide − seam at each frame, after the two frames that start the filter.
fn closed_loop(kind: Loop, seed: u64) -> Result<Score, SeriesError> {
    let mut rng = generator(seed);
    let noise = correlated(FRAMES, 2.0 * SIGMA_MM, 0.0, &mut rng);
    let misses = outliers(FRAMES, 0.03, (0.0, 1.0), &mut rng);
    let seam = |k: usize| SKEW_MM * k as f64;
    let error = |k: usize| noise[k] + misses[k].unwrap_or(0.0);
    // Deviation z = seam − slide + error; position y = slide + z. The first correction uses the deviation as it is.
    let mut slide = error(0);
    let first = [error(0), seam(1) + error(1)];
    let deviations = [error(0), seam(1) - slide + error(1)];
    let space = paper_space(false)?;
    let on_deviation = matches!(kind, Loop::FilteredDeviation);
    let mut state = start(if on_deviation { &deviations } else { &first })?;
    let mut models = Interacting::new(start(&first)?, 2.0 * SIGMA_MM)?;
    slide = match kind {
        Loop::Raw | Loop::FilteredDeviation => slide + deviations[1],
        Loop::PredictedPosition | Loop::KnownStraight => state.predict(&space).x[0],
        Loop::Interacting => models.ahead_mm(),
    };
    let mut line = StraightLine::default();
    (0..2).filter(|k| misses[*k].is_none()).for_each(|k| line.add(k as f64, first[k]));
    let broken = |reason| SeriesError::Innovation { frame: 0, reason };
    let mut errors = Vec::with_capacity(FRAMES);
    for (k, miss) in misses.iter().enumerate().skip(2) {
        errors.push(slide - seam(k));
        let deviation = seam(k) - slide + error(k);
        let position = slide + deviation;
        let filter = |state: &Gaussian<2>, z| state.predict(&space).update(&space, &[Some(z)], None).map_err(broken);
        match kind {
            Loop::Raw => slide += deviation,
            Loop::FilteredDeviation => {
                state = filter(&state, deviation)?.posterior;
                slide += state.x[0];
            }
            Loop::PredictedPosition => {
                state = filter(&state, position)?.posterior;
                slide = state.predict(&space).x[0];
            }
            Loop::Interacting => {
                models.step(position)?;
                slide = models.ahead_mm();
            }
            Loop::KnownStraight => {
                if miss.is_none() {
                    line.add(k as f64, position);
                }
                slide = line.at((k + 1) as f64).unwrap_or(position);
            }
        }
    }
    Ok(Score::of(&errors))
}

/// A straight line through points, by least squares.
#[derive(Debug, Clone, Copy, Default)]
struct StraightLine {
    count: f64,
    t: f64,
    tt: f64,
    y: f64,
    ty: f64,
}

impl StraightLine {
    fn add(&mut self, t: f64, y: f64) {
        self.count += 1.0;
        self.t += t;
        self.tt += t * t;
        self.y += y;
        self.ty += t * y;
    }

    fn at(&self, t: f64) -> Option<f64> {
        let determinant = self.count * self.tt - self.t * self.t;
        let slope = (self.count * self.ty - self.t * self.y) / determinant;
        (determinant > 0.0).then(|| self.y / self.count + slope * (t - self.t / self.count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_pass_the_papers_filter_weakened_and_ours_hardly_at_all() {
        let table = polyline_table(0.03).unwrap();
        let largest = |label: &str| table.value(label, "max [mm]").unwrap();
        let rms = |label: &str| table.value(label, "RMS [mm]").unwrap();
        assert!(largest("paper's filter, Q rebuilt") > 0.4 * largest("measured"), "{table}");
        assert!(largest("ours, causal") < 0.7 * largest("paper's filter, Q rebuilt"), "{table}");
        assert!(rms("ours, causal") < rms("paper's filter, Q as printed"), "{table}");
        assert!(rms("ours, smoothed") < rms("ours, causal"), "{table}");
        assert!(rms("limit, smoothed") < rms("ours, smoothed"), "{table}");
    }

    #[test]
    fn filtering_the_deviation_leaves_the_lag_and_filtering_the_position_none() {
        let table = closed_loop_table().unwrap();
        let mean = |label: &str| table.value(label, "mean [mm]").unwrap();
        assert!((mean("no filter") + SKEW_MM).abs() < 0.01, "{table}");
        assert!((mean("paper's filter on the deviation") + SKEW_MM).abs() < 0.02, "{table}");
        assert!(mean("paper's filter on slide").abs() < 0.01 && mean("ours, causal").abs() < 0.01, "{table}");
        let rms = |label: &str| table.value(label, "RMS [mm]").unwrap();
        assert!(rms("ours, causal") < rms("paper's filter on slide"), "{table}");
        assert!(rms("limit, causal") < rms("ours, causal"), "{table}");
    }
}
