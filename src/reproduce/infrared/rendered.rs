//! The infrared paper from made-up frames: pixels, tip, filter.
//!
//! The paper's frames are not published. The scene `infrared` is its experiment with one number set: how much the melt
//! wanders about the seam, such that the tip alone has about the printed error. Nothing was set by what filters make of
//! it.

use rayon::prelude::*;

use super::{HALF_WIDTH_MM, LABELS, MM_PER_PX, PERIOD_S, PRINTED_MM2, Series, both_mean_squares, estimates};
use crate::kalman::SeriesError;
use crate::meltpool::{Measure, Meter, NoiseLevels, Reading, Refusal, SegmentationError, Threshold, follow};
use crate::reproduce::score::median;
use crate::reproduce::table::{Row, Table};
use crate::synth::pool::{PoolScenario, PoolScene};
use crate::synth::{ScenarioError, builtin};

/// Seeds of the scene, fixed in advance.
const SEEDS: [u64; 3] = [1, 2, 3];
/// The drive that gives the printed ratio under white noise, as in the simulated table.
const DRIVE: f64 = 0.0081;

/// A scene that cannot be rendered, measured or filtered, which the built-in ones do not cause.
#[derive(Debug, thiserror::Error)]
pub enum RenderedError {
    /// The scene cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// OpenCV failed.
    #[error(transparent)]
    Segmentation(#[from] SegmentationError),
    /// A frame has no pixel.
    #[error(transparent)]
    Frame(#[from] crate::frame::FrameSizeError),
    /// A filter broke down.
    #[error(transparent)]
    Series(#[from] SeriesError),
}

/// The table from rendered frames.
///
/// # Errors
/// When a scene cannot be rendered, measured or filtered.
pub fn table() -> Result<Table, RenderedError> {
    rendered(&builtin::pool_scenario("infrared")?, &SEEDS)
}

/// What each frame of a made-up recording gives: the measure, or why there is none.
pub(in crate::reproduce) fn measured(
    scenario: &PoolScenario,
    seed: u64,
    measure: Measure,
) -> Result<(PoolScene, Vec<Result<f64, Refusal>>), RenderedError> {
    let scene = PoolScene::new(scenario, seed)?;
    let mut meter = Meter::new(measure, scenario.image.travel, Threshold::Otsu);
    let values = (0..scene.frame_count())
        .map(|frame| Ok(meter.measure(&scene.render(frame).intensity()?)?.map(|measured| measured.value_px)))
        .collect::<Result<_, RenderedError>>()?;
    Ok((scene, values))
}

fn rendered(scenario: &PoolScenario, seeds: &[u64]) -> Result<Table, RenderedError> {
    let recordings: Vec<(Vec<(f64, f64)>, usize)> =
        seeds.par_iter().map(|&seed| recording(scenario, seed)).collect::<Result<_, RenderedError>>()?;
    let labels = LABELS.into_iter().chain(["seamtrack meltpool, filtered", "seamtrack meltpool, smoothed"]);
    let medians: Vec<(f64, f64)> = (0..LABELS.len() + 2)
        .map(|i| {
            let of = |part: fn(&(f64, f64)) -> f64| median(recordings.iter().map(|(runs, _)| part(&runs[i])).collect());
            (of(|run| run.0), of(|run| run.1))
        })
        .collect();
    let mut rows: Vec<Row> = labels
        .zip(&medians)
        .map(|(label, (signed, sizes))| Row::new(label, [*signed, *sizes, medians[0].0 / signed, medians[0].1 / sizes]))
        .collect();
    for (label, value) in ["measured", "Kalman filter"].iter().zip(PRINTED_MM2) {
        rows.push(Row::of_paper(*label, [None, Some(value), None, Some(PRINTED_MM2[0] / value)]));
    }
    let missing: Vec<usize> = recordings.iter().map(|(_, missing)| *missing).collect();
    Ok(Table {
        title: "Infrared paper, rendered frames: pool, tip, filter".into(),
        noise: format!(
            "rendered: scene infrared, {} frames, seeds {seeds:?}, medians; the melt wanders by {} px (white); frames \
             without a tip: {missing:?}",
            scenario.frames, scenario.pool.tip_jitter_px
        ),
        columns: vec!["MSE [mm²]", "eq. 12 [mm²]", "MSE ratio", "eq. 12 ratio"],
        rows,
    })
}

/// Both mean squares of each estimate, and the frames without a tip.
fn recording(scenario: &PoolScenario, seed: u64) -> Result<(Vec<(f64, f64)>, usize), RenderedError> {
    let (scene, values) = measured(scenario, seed, Measure::Tip)?;
    let beam_px = scenario.image.pool_at[0] * (scenario.image.width_px as f64 - 1.0);
    // The filters start from two frames in a row.
    let first = values.windows(2).position(|pair| pair.iter().all(Result::is_ok)).unwrap_or(0);
    let measured_px: Vec<Option<f64>> = values[first..].iter().map(|value| value.ok().map(|px| px - beam_px)).collect();
    let truth_mm: Vec<f64> =
        (first..values.len()).map(|frame| MM_PER_PX * (scene.truth(frame).tip.u_px - beam_px)).collect();
    debug_assert!(truth_mm.iter().all(|mm| mm.abs() < 2.0 * HALF_WIDTH_MM));
    let series = Series { truth_mm, measured_px };
    let mut paths = estimates(&series, 0.0, DRIVE)?;
    let readings: Vec<Reading> = series
        .measured_px
        .iter()
        .enumerate()
        .map(|(k, px)| Reading { time_s: k as f64 * PERIOD_S, value_px: px.ok_or(Refusal::NoCorner) })
        .collect();
    if let Some(noise) = NoiseLevels::of_series(Measure::Tip, &series.measured_px, PERIOD_S) {
        let path = follow(Measure::Tip, &readings, noise, PERIOD_S)?;
        let or_measured =
            |k: usize, px: Option<(f64, f64)>| px.map(|(px, _)| px).or(series.measured_px[k]).unwrap_or_default();
        paths.push(path.frames.iter().enumerate().map(|(k, frame)| or_measured(k, frame.filtered)).collect());
        paths.push(path.frames.iter().enumerate().map(|(k, frame)| or_measured(k, frame.smooth)).collect());
    }
    // All rows are judged on the frames that have a tip.
    let seen = |path: &[f64]| -> (Vec<f64>, Vec<f64>) {
        let frames = path.iter().zip(&series.truth_mm).zip(&series.measured_px);
        frames.filter(|(_, px)| px.is_some()).map(|((px, mm), _)| (*px, *mm)).unzip()
    };
    let scores = paths.iter().map(|path| {
        let (px, mm) = seen(path);
        both_mean_squares(&px, &mm)
    });
    Ok((scores.collect(), values.iter().filter(|value| value.is_err()).count()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shortened_recording_errs_as_printed_and_the_filters_divide_it_as_far() {
        let scenario = PoolScenario { frames: 300, ..builtin::pool_scenario("infrared").unwrap() };
        let table = rendered(&scenario, &[1, 2]).unwrap();
        let value = |label: &str, column: &str| table.value(label, column).unwrap();
        // 300 white errors: their variance is good to 8 %.
        assert!((value("measured", "MSE [mm²]") / PRINTED_MM2[0] - 1.0).abs() < 0.25, "{table}");
        assert!(value("paper's filter", "MSE ratio") > 2.5, "{table}");
        assert!(value("ours, smoothed", "MSE ratio") > value("paper's filter", "MSE ratio"), "{table}");
        assert!(value("seamtrack meltpool, smoothed", "MSE ratio") > 3.5, "{table}");
    }
}
