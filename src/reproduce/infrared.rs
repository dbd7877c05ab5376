//! The infrared paper: 1000 frames of a melt pool's tip, "covariance" of the error 8.17·10⁻⁴ → 2.31·10⁻⁴ mm².

use crate::kalman::{
    ColouredMeasurement, ColouredProcess, Frame, Gaussian, InvalidParameter, SeriesError, Trajectory, fit, smoother,
    with_displacement,
};

use super::score::{Score, median};
use super::series::{correlated, generator};
use super::table::{Row, Table};

mod rendered;

pub(super) use rendered::measured;
pub use rendered::{RenderedError, table as rendered_table};

const FRAMES: usize = 1000;
/// 1 mm is 114 px, and the path runs from −0.277 to 0.277 mm about the beam.
const MM_PER_PX: f64 = 1.0 / 114.0;
const HALF_WIDTH_MM: f64 = 0.277;
/// The printed "covariances" of equation (12) \[mm²\], measured and filtered.
const PRINTED_MM2: [f64; 2] = [8.1738e-4, 2.3121e-4];
const SIGMA_PX: f64 = 3.26;
const SEEDS: u64 = 20;
const PERIOD_S: f64 = 1e-3;

/// The experiment's tables.
///
/// # Errors
/// When a filter breaks down, which the printed numbers do not cause.
pub fn tables() -> Result<Vec<Table>, SeriesError> {
    // The drive q is not printed: for each noise it is the one that gives the printed ratio (white: 0.0081).
    Ok(vec![worked_step()?, series_table(0.0, 0.0081)?, series_table(0.5, 1.1e-4)?])
}

/// The step the paper computes by hand.
fn worked_step() -> Result<Table, SeriesError> {
    let model = ColouredProcess::printed();
    let invalid = |reason| SeriesError::InvalidFrame { frame: 0, reason };
    let start = model.start_as_printed(238.0, 239.0, 5.0).map_err(invalid)?;
    let frame = Frame::new(PERIOD_S, [Some(239.0), Some(0.0)]);
    let run = Trajectory::filter(start, &[frame], |dt_s| model.state_space(dt_s), None)?;
    let step = &run.steps[0];
    let line = |label: &str, state: &Gaussian<4>| Row::new(label, state.x.iter().copied());
    let paper = |label, values: [f64; 4]| Row::of_paper(label, values.map(Some));
    Ok(Table {
        title: "Infrared paper, the worked step".into(),
        noise: "from [239, 1, 238, 5] with the measurement [239, 0]; P0 = diag(4, 0.4, 1, 0.2)·5 px², R = 5 I px²"
            .into(),
        columns: vec!["x [px]", "ẋ [px/f]", "x before", "w [px/f²]"],
        rows: vec![
            line("ours: predicted", &step.prior),
            paper("predicted", [242.5, 6.0, 239.0, 2.5]),
            line("ours: filtered", &step.update.posterior),
            paper("filtered", [239.45, 4.6364, 237.18, 2.3636]),
        ],
    })
}

struct Series {
    truth_mm: Vec<f64>,
    measured_px: Vec<Option<f64>>,
}

fn series(rho: f64, seed: u64) -> Series {
    let noise = correlated(FRAMES, SIGMA_PX, rho, &mut generator(seed));
    let truth = |k: u32| HALF_WIDTH_MM * (2.0 * f64::from(k) / (FRAMES - 1) as f64 - 1.0);
    let truth_mm: Vec<f64> = (0..).take(FRAMES).map(truth).collect();
    let measured_px = truth_mm.iter().zip(noise).map(|(mm, noise)| Some(mm / MM_PER_PX + noise)).collect();
    Series { truth_mm, measured_px }
}

/// The estimates of a table, in the order of [`estimates`].
const LABELS: [&str; 6] = [
    "measured",
    "paper's filter, R = 5 I px²",
    "ours, causal: coloured measurement noise, matched",
    "ours, smoothed: the same, q by likelihood",
    "limit, causal: a straight path known to be straight",
    "limit, smoothed: the same",
];

/// The mean squares of an estimate's errors \[mm²\]: signed, and of equation (12).
fn both_mean_squares(estimate_px: &[f64], truth_mm: &[f64]) -> (f64, f64) {
    let pairs = || estimate_px.iter().zip(truth_mm);
    let signed: Vec<f64> = pairs().map(|(px, mm)| px * MM_PER_PX - mm).collect();
    let of_sizes: Vec<f64> = pairs().map(|(px, mm)| (px * MM_PER_PX).abs() - mm.abs()).collect();
    (Score::of(&signed).mean_square(), Score::of(&of_sizes).mean_square())
}

fn series_table(rho: f64, drive_variance: f64) -> Result<Table, SeriesError> {
    let labels = LABELS;
    let mut runs = vec![Vec::new(); labels.len()];
    for seed in 1..=SEEDS {
        let series = series(rho, seed);
        for (runs, estimate_px) in runs.iter_mut().zip(estimates(&series, rho, drive_variance)?) {
            runs.push(both_mean_squares(&estimate_px, &series.truth_mm));
        }
    }
    let medians: Vec<(f64, f64)> = runs
        .into_iter()
        .map(|runs| (median(runs.iter().map(|run| run.0).collect()), median(runs.iter().map(|run| run.1).collect())))
        .collect();
    let mut rows: Vec<Row> = labels
        .iter()
        .zip(&medians)
        .map(|(label, (signed, sizes))| {
            Row::new(*label, [*signed, *sizes, medians[0].0 / signed, medians[0].1 / sizes])
        })
        .collect();
    for (label, value) in ["measured", "Kalman filter"].iter().zip(PRINTED_MM2) {
        rows.push(Row::of_paper(*label, [None, Some(value), None, Some(PRINTED_MM2[0] / value)]));
    }
    let colour = if rho == 0.0 { "white".to_owned() } else { format!("of lag-1 correlation {rho}") };
    Ok(Table {
        title: format!("Infrared paper, 1000 frames of a straight skew seam, measurement noise {colour}"),
        noise: format!(
            "simulated: Gaussian, {SIGMA_PX} px, {SEEDS} seeds; the paper's q is not printed: {drive_variance} px²/frame⁴ \
             gives its ratio"
        ),
        columns: vec!["MSE [mm²]", "eq. 12 [mm²]", "MSE ratio", "eq. 12 ratio"],
        rows,
    })
}

/// The paper's filter from its start; positions \[px\].
fn papers_filter(measured_px: &[Option<f64>], drive_variance: f64) -> Result<Vec<f64>, SeriesError> {
    let invalid = |reason: InvalidParameter| SeriesError::InvalidFrame { frame: 0, reason };
    let model = ColouredProcess::new(drive_variance, 0.5, 5.0, 5.0, PERIOD_S).map_err(invalid)?;
    let frames: Vec<Frame<2>> = with_displacement(measured_px).into_iter().map(|z| Frame::new(PERIOD_S, z)).collect();
    let [z0, z1] = [0, 1].map(|k| measured_px[k].unwrap_or_default());
    let start = model.start_as_printed(z0, z1, 5.0).map_err(invalid)?;
    let run = Trajectory::filter(start, &frames[2..], |dt_s| model.state_space(dt_s), None)?;
    Ok(std::iter::once(z0).chain(run.filtered().map(|state| state.x[0])).collect())
}

fn estimates(series: &Series, rho: f64, drive_variance: f64) -> Result<Vec<Vec<f64>>, SeriesError> {
    let invalid = |reason: InvalidParameter| SeriesError::InvalidFrame { frame: 0, reason };
    let raw: Vec<f64> = series.measured_px.iter().map(|z| z.unwrap_or_default()).collect();
    let frames: Vec<Frame<1>> = series.measured_px.iter().map(|z| Frame::new(PERIOD_S, [*z])).collect();
    let variance = SIGMA_PX * SIGMA_PX;
    // All noise in the colour, which white noise is with ρ = 0; the seam wanders slowly, 1e-5 px²/frame⁴.
    let model = |per_frame4: f64| {
        ColouredMeasurement::new(per_frame4 / PERIOD_S.powi(4), variance * (1.0 - rho * rho), rho, 0.0, PERIOD_S)
            .and_then(|model| model.with_velocity_variance(1.0 / PERIOD_S.powi(2)))
            .map_err(invalid)
    };
    let causal = fit::filter(&model(1e-5)?, &frames, None)?.trajectory;
    let smoothed = fit::smooth_seam(&model(1e-5)?, &frames, None)?;
    let straight = fit::filter(&model(0.0)?, &frames, None)?.trajectory;
    let positions = |states: &mut dyn Iterator<Item = &Gaussian<3>>| states.map(|state| state.x[0]).collect();
    Ok(vec![
        raw,
        papers_filter(&series.measured_px, drive_variance)?,
        positions(&mut causal.filtered()),
        positions(&mut smoothed.states.iter().flatten()),
        positions(&mut straight.filtered()),
        positions(&mut smoother::bryson_frazier(&straight).iter()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_filter_divides_the_variance_of_white_noise_as_its_settled_gain_says() {
        // The filter is linear, so the difference an impulse makes is its weight on each measurement once settled.
        let flat = vec![Some(0.0); 400];
        let mut struck = flat.clone();
        struck[200] = Some(1.0);
        let without = papers_filter(&flat, 0.0081).unwrap();
        let with = papers_filter(&struck, 0.0081).unwrap();
        let weights: f64 = with.iter().zip(&without).map(|(a, b)| (a - b).powi(2)).sum();
        // From the algebraic Riccati equation, solved by another program; 4 % above the printed ratio, which is of
        // equation 12 and of one recording.
        assert!((1.0 / weights - 3.679_966_5).abs() < 1e-6, "{}", 1.0 / weights);
    }

    #[test]
    fn the_printed_ratio_comes_out_and_ours_is_far_beyond_it() {
        let tables = tables().unwrap();
        let ratio = |table: usize, label: &str| tables[table].value(label, "MSE ratio").unwrap();
        // A run's mean square after the filter scatters by 12 % (about 125 independent values), the median of twenty
        // by 3.3 %: three standard errors. The exact ratio is tested above.
        for table in [1, 2] {
            let ratio = tables[table].value("paper's filter", "eq. 12 ratio").unwrap();
            assert!((ratio / 3.535 - 1.0).abs() < 0.1, "{}", tables[table]);
        }
        // Specification: causal 49× under white noise, 24× with slow wander allowed, 19× and 11× at ρ = 0.5.
        assert!(ratio(1, "ours, causal") > 18.0, "{}", tables[1]);
        assert!(ratio(2, "ours, causal") > 8.0, "{}", tables[2]);
        for table in [1, 2] {
            assert!(ratio(table, "ours, smoothed") <= 1.001 * ratio(table, "limit, smoothed"), "{}", tables[table]);
        }
    }

    #[test]
    fn the_worked_step_has_every_printed_digit() {
        let table = worked_step().unwrap();
        let ours = &table.rows[2].values;
        let printed = &table.rows[3].values;
        for ((ours, printed), tolerance) in ours.iter().zip(printed).zip([0.005, 0.00005, 0.005, 0.00005]) {
            assert!((ours.unwrap() - printed.unwrap()).abs() <= tolerance, "{table}");
        }
    }
}
