//! `seamtrack filter`: a measured series in; estimates, σ, innovations, NIS and the smoothed series out.

mod measurements;
mod output;
mod parameters;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use clap::Args;
use seamtrack::kalman::adaptive::{NoiseAdaptation, complete_frames_gate, filter_adaptively};
use seamtrack::kalman::fit::{self, Filtered};
use seamtrack::kalman::literal::LiteralAdaptation;
use seamtrack::kalman::{ChiSquareGate, Frame, Gaussian, Model, Width, smoother, with_displacement};
use seamtrack::output::{Existing, Reads, WholeFolder};
use serde_json::{Map, json};

use measurements::Measurements;
use output::{Outcome, Row};
use parameters::{ModelKind, Parameters};

use super::say;

/// Frames the start's noise statistics count for in the printed equations: with 0 every matrix is lost at once.
const LITERAL_START_FRAMES: u32 = 20;

/// Lines that are fitted in seconds; of more, the user is told.
const QUICK_FIT_LINES: usize = 20_000;

/// Filter and smooth any measured series with the model of a paper
///
/// The series is a CSV with the columns time_s,z1 and, for coloured-process and adaptive, z2 (the change of z1 since
/// the line before; taken from z1 where the column is absent). An empty cell is a missing measurement. z1 must be an
/// absolute position: where a slide follows the seam, give slide position + measured deviation.
#[derive(Debug, Args)]
pub struct Filter {
    /// The measured series
    input: PathBuf,
    /// Which paper's filter
    #[arg(long)]
    model: ModelKind,
    /// Find the noise parameters under which the series is most likely, starting from the given ones
    #[arg(long)]
    fit: bool,
    /// Weigh down measurements beyond the 99 % point of χ² (adaptive does so anyway)
    #[arg(long)]
    gate: bool,
    /// Use equations 15-19 of Jiang 2016 as printed (adaptive); says where they lose positive definiteness
    #[arg(long)]
    literal: bool,
    /// Smooth with N later lines only, at most 1000, instead of the whole series
    #[arg(long, value_name = "N")]
    fixed_lag: Option<usize>,
    /// Folder for filter.csv and filter.json [default: results/<name>]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Noise parameters as TOML, named as the flags are; flags come first
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Replace the results of an earlier run
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    parameters: Parameters,
}

impl Filter {
    /// Filters the series and writes the results.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let from_file = self.config.as_deref().map(Parameters::read).transpose()?.unwrap_or_default();
        let parameters = self.parameters.or(from_file);
        parameters.check_belong_to(self.model)?;
        if self.literal && (self.model != ModelKind::Adaptive || self.fit) {
            bail!("--literal is of --model adaptive, without --fit");
        }
        if self.fixed_lag.is_some_and(|lag| lag > smoother::LONGEST_LAG) {
            bail!(
                "--fixed-lag is at most {} lines: leave it out to smooth with the whole series",
                smoother::LONGEST_LAG
            );
        }
        let folder = self.folder();
        let mut reads = Reads::default();
        [Some(&self.input), self.config.as_ref()].into_iter().flatten().for_each(|file| reads.add(file));
        reads.refuse(&folder, "-o")?;
        let results = WholeFolder::begin(&folder, Existing::forced(self.force))?;
        let series = Measurements::read(&self.input)?;
        if self.fit && series.time_s.len() > QUICK_FIT_LINES {
            say::tell(&format!("fitting {} measurements takes minutes; a part of them may do", series.time_s.len()));
        }
        let name = || self.input.display().to_string();
        let outcome = self.outcome(&series, &parameters).with_context(name)?;
        outcome.check_finite().with_context(name)?;
        let run = [
            ("input", json!(self.input.to_string_lossy())),
            ("model", json!(clap::ValueEnum::to_possible_value(&self.model).map(|value| value.get_name().to_owned()))),
            ("fitted", json!(self.fit)),
            ("fixed_lag", json!(self.fixed_lag)),
        ];
        let run = run.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        let summary = outcome.summary(run);
        output::write(results.path(), &series, &outcome, &summary)?;
        results.finish()?;
        let mut text = format!("{}\n", say::shown(&folder.join(output::CSV_NAME)));
        for parameter in &outcome.parameters {
            text += &format!("{} = {} # {}\n", parameter.name, output::digits(parameter.value), parameter.unit);
        }
        text += &output::nis_line(&summary);
        say::print(&text).context("the results are written, but")?;
        Ok(ExitCode::SUCCESS)
    }

    fn folder(&self) -> PathBuf {
        let name = self.input.file_stem().unwrap_or_else(|| "series".as_ref());
        self.output.clone().unwrap_or_else(|| Path::new("results").join(name))
    }

    fn outcome(&self, series: &Measurements, parameters: &Parameters) -> anyhow::Result<Outcome> {
        let period_s = series.median_step_s();
        match self.model {
            ModelKind::White => self.filtered(parameters.white()?, &one_row(series)?, 1.0),
            ModelKind::ColouredMeasurement => {
                self.filtered(parameters.coloured_measurement(period_s)?, &one_row(series)?, 1.0)
            }
            ModelKind::ColouredProcess => {
                let model = parameters.coloured_process(period_s)?;
                self.filtered(model, &two_rows(series), 1.0 / model.period_s())
            }
            ModelKind::Adaptive if self.literal => literal(&parameters.width()?, &two_rows(series)),
            ModelKind::Adaptive => self.adaptive(parameters.width()?, &two_rows(series)),
        }
    }

    /// Any model with noises that stay as they are; `per_second` turns its velocity into one a second.
    fn filtered<const N: usize, const M: usize, const P: usize>(
        &self,
        model: impl Model<N, M, P>,
        frames: &[Frame<M>],
        per_second: f64,
    ) -> anyhow::Result<Outcome> {
        let gate = self.gate.then(gate::<M>);
        let model = if self.fit { fit::maximum_likelihood(&model, frames, gate)?.0 } else { model };
        let run = fit::filter(&model, frames, gate)?;
        Ok(self.told(&model, &run, frames.len(), per_second))
    }

    fn adaptive(&self, model: Width, frames: &[Frame<2>]) -> anyhow::Result<Outcome> {
        let gate = Some(complete_frames_gate());
        let model = if self.fit { fit::maximum_likelihood(&model, frames, gate)?.0 } else { model };
        let (start, first) = model.start_of(frames)?;
        let adaptation = NoiseAdaptation::new(&model.state_space(1.0)?.R);
        let space_over = |dt_s| model.state_space(dt_s);
        let (trajectory, learnt) = filter_adaptively(start, &frames[first + 1..], space_over, adaptation)?;
        let mut outcome = self.told(&model, &Filtered { first, trajectory }, frames.len(), 1.0);
        if let Some(noise) = learnt.last() {
            outcome.more.insert("learnt_variances".into(), json!([noise[(0, 0)], noise[(1, 1)]]));
        }
        Ok(outcome)
    }

    fn told<const N: usize, const M: usize, const P: usize>(
        &self,
        model: &impl Model<N, M, P>,
        run: &Filtered<N, M>,
        lines: usize,
        per_second: f64,
    ) -> Outcome {
        let trajectory = &run.trajectory;
        let smoothed = match self.fixed_lag {
            Some(lag) => smoother::fixed_lag(trajectory, lag),
            None => smoother::bryson_frazier(trajectory),
        };
        let mut rows = vec![Row::default(); lines];
        for (i, (filtered, smooth)) in trajectory.filtered().zip(&smoothed).enumerate() {
            let row = &mut rows[run.first + i];
            *row = state_row(filtered, per_second);
            row.smooth_x = Some(smooth.x[0]);
            row.smooth_x_std = Some(smooth.P[(0, 0)].max(0.0).sqrt());
        }
        for (row, step) in rows[run.first + 1..].iter_mut().zip(&trajectory.steps) {
            let update = &step.update;
            row.innovation1 = update.innovation.first().copied().flatten();
            row.innovation2 = update.innovation.get(1).copied().flatten();
            row.nis = update.nis;
            row.weight = update.nis.map(|_| update.weight);
        }
        let parameters = model.parameters().to_vec();
        let log_likelihood = Some(trajectory.log_likelihood());
        Outcome { rows, parameters, log_likelihood, measured_rows: M, more: Map::new() }
    }
}

/// The printed equations of Jiang 2016. Their NIS may be negative; there is no likelihood and no smoother.
fn literal(model: &Width, frames: &[Frame<2>]) -> anyhow::Result<Outcome> {
    let (start, first) = model.start_of(frames)?;
    let mut filter = LiteralAdaptation::new(start, &model.state_space(frames[first].dt_s)?, LITERAL_START_FRAMES);
    let mut rows = vec![Row::default(); frames.len()];
    rows[first] = state_row(&start, 1.0);
    let mut lost = None;
    for (line, frame) in frames.iter().enumerate().skip(first + 1) {
        let step = filter.step(&model.state_space(frame.dt_s)?, &frame.z);
        lost = lost.or(step.lost.map(|matrix| (line, matrix)));
        rows[line] = state_row(&filter.state, 1.0);
        rows[line].innovation1 = step.innovation.map(|e| e[0]).filter(|e| e.is_finite());
        rows[line].innovation2 = step.innovation.map(|e| e[1]).filter(|e| e.is_finite());
        rows[line].nis = step.nis.filter(|nis| nis.is_finite());
    }
    let mut more = Map::new();
    if let Some((line, matrix)) = lost {
        say::tell(&format!("from measurement {} on {matrix} is no covariance any more: do not trust σ", line + 1));
        more.insert("lost_definiteness".into(), json!({"measurement": line + 1, "matrix": matrix.to_string()}));
    }
    let parameters = model.parameters().to_vec();
    Ok(Outcome { rows, parameters, log_likelihood: None, measured_rows: 2, more })
}

/// The state's part of a row. A variance that is no longer positive has no σ.
fn state_row<const N: usize>(state: &Gaussian<N>, per_second: f64) -> Row {
    let std = |i: usize| Some(state.P[(i, i)]).filter(|variance| *variance >= 0.0).map(f64::sqrt);
    Row {
        x: Some(state.x[0]).filter(|x| x.is_finite()),
        x_std: std(0),
        velocity: Some(state.x[1] * per_second).filter(|velocity| velocity.is_finite()),
        velocity_std: std(1).map(|std| std * per_second),
        ..Row::default()
    }
}

fn one_row(series: &Measurements) -> anyhow::Result<Vec<Frame<1>>> {
    if series.z2.is_some() {
        bail!("the chosen model measures one column: remove z2");
    }
    let steps = series.steps_s();
    Ok(steps.iter().zip(&series.z1).map(|(dt_s, z1)| Frame::new(*dt_s, [*z1])).collect())
}

fn two_rows(series: &Measurements) -> Vec<Frame<2>> {
    let rows = match &series.z2 {
        Some(z2) => series.z1.iter().zip(z2).map(|(z1, z2)| [*z1, *z2]).collect(),
        None => with_displacement(&series.z1),
    };
    series.steps_s().into_iter().zip(rows).map(|(dt_s, z)| Frame::new(dt_s, z)).collect()
}

/// The 99 % rule for M = 1 or 2 rows.
fn gate<const M: usize>() -> ChiSquareGate<M> {
    ChiSquareGate { thresholds: std::array::from_fn(|row| ChiSquareGate::<2>::P99.thresholds[row.min(1)]) }
}
