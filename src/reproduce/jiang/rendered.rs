//! Jiang 2016 from made-up frames: pixels, width, filter.
//!
//! The paper's frames are not published. The scene `jiang` is its experiment with one number set: how much the melt
//! breathes, such that the width alone has about the printed error. Nothing was set by what filters make of it.

use rayon::prelude::*;

use super::{LABELS, PERIOD_S, PRINTED, Score, Series, estimates};
use crate::meltpool::{Measure, NoiseLevels, Reading, Refusal, follow};
use crate::reproduce::infrared::{RenderedError, measured};
use crate::reproduce::table::{Row, Table};
use crate::synth::builtin;
use crate::synth::pool::PoolScenario;

/// Seeds of the scene, fixed in advance.
const SEEDS: [u64; 5] = [1, 2, 3, 4, 5];

/// The table from rendered frames.
///
/// # Errors
/// When a scene cannot be rendered, measured or filtered.
pub fn table() -> Result<Table, RenderedError> {
    rendered(&builtin::pool_scenario("jiang")?, &SEEDS)
}

fn rendered(scenario: &PoolScenario, seeds: &[u64]) -> Result<Table, RenderedError> {
    let recordings: Vec<(Vec<Score>, usize)> =
        seeds.par_iter().map(|&seed| recording(scenario, seed)).collect::<Result<_, RenderedError>>()?;
    let labels = LABELS.into_iter().chain(["seamtrack meltpool, filtered", "seamtrack meltpool, smoothed"]);
    let scores: Vec<Score> = (0..LABELS.len() + 2)
        .map(|i| Score::median(&recordings.iter().map(|(scores, _)| scores[i]).collect::<Vec<_>>()))
        .collect();
    let raw = scores[0];
    let mut rows: Vec<Row> = labels
        .zip(&scores)
        .map(|(label, score)| {
            let ratios = [raw.mean_absolute / score.mean_absolute, raw.mean_square() / score.mean_square()];
            Row::new(label, [score.mean_absolute, score.mean_square(), ratios[0], ratios[1]])
        })
        .collect();
    for (label, (mean, variance)) in ["image measurement", "Kalman filter"].iter().zip(PRINTED) {
        let ratios = (PRINTED[0].0 / mean, PRINTED[0].1 / variance);
        rows.push(Row::of_paper(*label, [mean, variance, ratios.0, ratios.1].map(Some)));
    }
    let missing: Vec<usize> = recordings.iter().map(|(_, missing)| *missing).collect();
    Ok(Table {
        title: "Jiang 2016, rendered frames: pool, width, filter".into(),
        noise: format!(
            "rendered: scene jiang, {} frames, seeds {seeds:?}, medians; the melt breathes by {} px (white); frames \
             without a width, taken from the frame before: {missing:?}",
            scenario.frames, scenario.pool.width_jitter_px
        ),
        columns: vec!["MAE [mm]", "MSE [mm²]", "MAE ratio", "MSE ratio"],
        rows,
    })
}

/// The score of each estimate, and the frames without a width.
fn recording(scenario: &PoolScenario, seed: u64) -> Result<(Vec<Score>, usize), RenderedError> {
    let (scene, values) = measured(scenario, seed, Measure::Width)?;
    let scale = scenario.mm_per_px.get();
    let first = values.iter().position(Result::is_ok).unwrap_or(0);
    let mut last = 0.0;
    let series = Series {
        truth: (first..values.len()).map(|frame| scale * scene.truth(frame).width_px).collect(),
        measured: values[first..]
            .iter()
            .map(|value| {
                last = value.map_or(last, |px| scale * px);
                last
            })
            .collect(),
    };
    let mut paths = estimates(&series)?;
    let px: Vec<Option<f64>> = values[first..].iter().map(|value| value.ok()).collect();
    if let Some(noise) = NoiseLevels::of_series(Measure::Width, &px, PERIOD_S) {
        let reading = |(k, px): (usize, &Option<f64>)| Reading {
            time_s: k as f64 * PERIOD_S,
            value_px: px.ok_or(Refusal::NoPool),
        };
        let readings: Vec<Reading> = px.iter().enumerate().map(reading).collect();
        let path = follow(Measure::Width, &readings, noise, PERIOD_S)?;
        let or_measured = |k: usize, px: Option<(f64, f64)>| px.map_or(series.measured[k], |(px, _)| scale * px);
        paths.push(path.frames.iter().enumerate().map(|(k, frame)| or_measured(k, frame.filtered)).collect());
        paths.push(path.frames.iter().enumerate().map(|(k, frame)| or_measured(k, frame.smooth)).collect());
    }
    let score = |path: &Vec<f64>| {
        Score::of(&path.iter().zip(&series.truth).map(|(estimate, truth)| estimate - truth).collect::<Vec<_>>())
    };
    Ok((paths.iter().map(score).collect(), values.iter().filter(|value| value.is_err()).count()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_errs_as_printed_and_the_filters_divide_it_as_far() {
        let table = rendered(&builtin::pool_scenario("jiang").unwrap(), &[1, 2]).unwrap();
        let value = |label: &str, column: &str| table.value(label, column).unwrap();
        // 200 white errors: their mean size is good to 5 %.
        assert!((value("image measurement", "MAE [mm]") / PRINTED[0].0 - 1.0).abs() < 0.15, "{table}");
        assert!(value("paper's filter", "MAE ratio") > 2.3, "{table}");
        assert!(value("ours, smoothed", "MAE ratio") > value("paper's filter", "MAE ratio"), "{table}");
        assert!(value("seamtrack meltpool, smoothed", "MAE ratio") > 3.0, "{table}");
    }
}
