//! Du 2022, tables 2 and 3: a butt and a lap weld seen by the KCF alone and through the augmented Kalman filter.
//!
//! The paper publishes neither frames nor paths. [`simulated_tables`] replaces the KCF by noise with its printed mean
//! absolute error; [`rendered::tables`] runs the whole program over made-up frames.

pub mod rendered;

use crate::kalman::{ColouredMeasurement, Frame, Gaussian, Imm, InvalidParameter, SeriesError, fit, smoother};
use crate::units::MmPerPx;

use super::score::{Score, median};
use super::series::{MEAN_ABSOLUTE_GAUSSIAN, correlated, generator};
use super::table::{Row, Table};

const FRAMES: usize = 250;
const PERIOD_S: f64 = 0.2;
/// Slope of the printed paths \[px/frame\].
const SLOPE_PX: f64 = 0.548;
const SEEDS: u64 = 40;
/// Variance of the white part of the measurement noise that ours reckons with \[px²\].
const WHITE_VARIANCE_PX2: f64 = 0.1;
/// Process noise of the three interacting models \[px²/frame⁴\]: a straight seam, a bending one, a corner.
const ACCELERATIONS_PX2_FRAME4: [f64; 3] = [1e-7, 2e-4, 3e-2];
/// Probability that the seam stays what it is from frame to frame, chosen: 0.98 would cost a third more error on the
/// straight path and gain nothing at a corner.
const STAY: f64 = 0.998;

/// The two joints of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joint {
    /// Table 2.
    Butt,
    /// Table 3.
    Lap,
}

/// What the paper prints of a joint: mean, largest and deviation of the absolute error \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    /// The KCF alone.
    pub kcf: [f64; 3],
    /// The KCF with the Kalman filter.
    pub filtered: [f64; 3],
}

/// The errors of one way to find the seam, estimate − truth, over one or several runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Runs {
    /// Which way.
    pub label: String,
    /// Errors of each run \[mm\].
    pub errors_mm: Vec<Vec<f64>>,
}

impl Joint {
    /// Both, in the order of the paper's tables.
    pub const BOTH: [Self; 2] = [Self::Butt, Self::Lap];

    /// The paper's figures.
    #[must_use]
    pub const fn printed(self) -> Printed {
        match self {
            Self::Butt => Printed { kcf: [0.065, 0.308, 0.056], filtered: [0.034, 0.137, 0.027] },
            Self::Lap => Printed { kcf: [0.044, 0.314, 0.044], filtered: [0.021, 0.105, 0.018] },
        }
    }

    /// Number and name of the paper's table.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Butt => "Du 2022, table 2, butt weld",
            Self::Lap => "Du 2022, table 3, lap weld",
        }
    }

    /// Lag-1 correlation of the KCF's error under which the printed filter gains what the paper prints.
    const fn correlation(self) -> f64 {
        match self {
            Self::Butt => 0.68,
            Self::Lap => 0.60,
        }
    }
}

/// The joint's table from any runs, the paper's two lines below them; each figure is the median over the runs.
#[must_use]
pub fn table(joint: Joint, what: &str, noise: String, runs: &[Runs]) -> Table {
    let ours = runs.iter().map(|runs| {
        let scores: Vec<Score> = runs.errors_mm.iter().map(|errors| Score::of(errors)).collect();
        let score = Score::median(&scores);
        Row::new(&runs.label, [score.mean_absolute, score.largest, score.deviation_of_absolute])
    });
    let printed = joint.printed();
    let paper = [("KCF", printed.kcf), ("proposed algorithm", printed.filtered)];
    let paper = paper.map(|(label, values)| Row::of_paper(label, values.map(Some)));
    Table {
        title: format!("{}: {what}", joint.title()),
        noise,
        columns: vec!["MAE [mm]", "max [mm]", "std|e| [mm]"],
        rows: ours.chain(paper).collect(),
    }
}

/// Both tables with the KCF replaced by correlated noise: the printed straight path, then the same with a corner.
///
/// # Errors
/// When a filter breaks down, which the printed numbers do not cause.
pub fn simulated_tables() -> Result<Vec<Table>, SeriesError> {
    let mut tables = Vec::new();
    for joint in Joint::BOTH {
        tables.push(simulated(joint, "straight path", SLOPE_PX)?);
    }
    tables.push(simulated(Joint::Butt, "corner to 0 px/frame at half way", 0.0)?);
    Ok(tables)
}

fn simulated(joint: Joint, what: &str, second_slope_px: f64) -> Result<Table, SeriesError> {
    let labels = [
        "simulated KCF",
        "paper's filter, printed numbers",
        "ours, causal: three interacting models, matched noise",
        "ours, smoothed: matched noise, q by likelihood",
        "limit, causal: a straight path known to be straight",
        "limit, smoothed: the same",
    ];
    let straight = second_slope_px == SLOPE_PX;
    let count = if straight { labels.len() } else { labels.len() - 2 };
    let mut runs: Vec<Runs> =
        labels[..count].iter().map(|label| Runs { label: (*label).into(), errors_mm: Vec::new() }).collect();
    let (scale, rho) = (MmPerPx::DU_2022.get(), joint.correlation());
    let sigma_px = joint.printed().kcf[0] / MEAN_ABSOLUTE_GAUSSIAN / scale;
    let mut printed_nis = Vec::new();
    for seed in 1..=SEEDS {
        let noise = correlated(FRAMES, sigma_px, rho, &mut generator(seed));
        let half = FRAMES / 2;
        let truth_at =
            |k: usize| 320.0 + SLOPE_PX * k.min(half) as f64 + second_slope_px * k.saturating_sub(half) as f64;
        let truth: Vec<f64> = (0..FRAMES).map(truth_at).collect();
        let measured: Vec<f64> = truth.iter().zip(&noise).map(|(truth, noise)| truth + noise).collect();
        for (runs, estimate) in runs.iter_mut().zip(estimates(&measured, sigma_px, rho)?) {
            runs.errors_mm.push(estimate.iter().zip(&truth).map(|(x, truth)| scale * (x - truth)).collect());
        }
        let printed = fit::filter(&ColouredMeasurement::printed(), &frames(&measured), None)?;
        printed_nis.push(printed.trajectory.nis().sum::<f64>() / (FRAMES - 1) as f64);
    }
    let noise = format!(
        "simulated: 250 frames at 0.2 s, 0.548 px/frame, Gaussian of lag-1 correlation {rho}, scaled to the printed \
         mean absolute error of the KCF; {SEEDS} seeds; mean NIS of the printed filter {:.2}, 1 if its noises were right",
        median(printed_nis)
    );
    Ok(table(joint, what, noise, &runs))
}

fn frames(measured: &[f64]) -> Vec<Frame<1>> {
    measured.iter().map(|z| Frame::new(PERIOD_S, [Some(*z)])).collect()
}

fn estimates(measured: &[f64], sigma_px: f64, rho: f64) -> Result<Vec<Vec<f64>>, SeriesError> {
    let invalid = |reason: InvalidParameter| SeriesError::InvalidFrame { frame: 0, reason };
    let frames = frames(measured);
    let drive = sigma_px * sigma_px * (1.0 - rho * rho);
    let model = |per_frame4: f64, white: f64| {
        let acceleration = per_frame4 / PERIOD_S.powi(4);
        ColouredMeasurement::new(acceleration, drive, rho, white, PERIOD_S).map_err(invalid)
    };
    let positions = |states: &mut dyn Iterator<Item = &Gaussian<3>>| states.map(|state| state.x[0]).collect();
    let printed = fit::filter(&ColouredMeasurement::printed(), &frames, None)?.trajectory;
    let smoothed = fit::smooth_seam(&model(1e-5, WHITE_VARIANCE_PX2)?, &frames, None)?;
    let straight = fit::filter(&model(0.0, 0.0)?, &frames, None)?.trajectory;

    let mut spaces = [model(0.0, WHITE_VARIANCE_PX2)?.state_space(PERIOD_S).map_err(invalid)?; 3];
    for (space, q) in spaces.iter_mut().zip(ACCELERATIONS_PX2_FRAME4) {
        *space = model(q, WHITE_VARIANCE_PX2)?.state_space(PERIOD_S).map_err(invalid)?;
    }
    let start = model(0.0, WHITE_VARIANCE_PX2)?.start(measured[0]).map_err(invalid)?;
    let mut models = Imm::new(start, STAY).map_err(invalid)?;
    let mut interacting = vec![measured[0]];
    for (frame, z) in measured.iter().enumerate().skip(1) {
        let update = models.predict(&spaces).update(&spaces, &[Some(*z)], None);
        models = update.map_err(|reason| SeriesError::Innovation { frame, reason })?.posterior;
        interacting.push(models.output().x[0]);
    }
    Ok(vec![
        measured.to_vec(),
        positions(&mut printed.filtered()),
        interacting,
        positions(&mut smoothed.states.iter().flatten()),
        positions(&mut straight.filtered()),
        positions(&mut smoother::bryson_frazier(&straight).iter()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_filter_gains_what_the_paper_prints_when_the_noise_is_as_coloured() {
        for joint in Joint::BOTH {
            let table = simulated(joint, "", SLOPE_PX).unwrap();
            let printed = joint.printed();
            let mean = |label: &str| table.value(label, "MAE [mm]").unwrap();
            assert!((mean("simulated KCF") / printed.kcf[0] - 1.0).abs() < 0.05, "{table}");
            assert!((mean("paper's filter") / printed.filtered[0] - 1.0).abs() < 0.1, "{table}");
            assert!(mean("ours, causal") < mean("paper's filter"), "{table}");
            assert!(mean("ours, smoothed") < 0.6 * mean("paper's filter"), "{table}");
            assert!(mean("limit, causal") < mean("ours, causal"), "{table}");
            assert!(mean("limit, smoothed") < mean("ours, smoothed"), "{table}");
        }
    }

    #[test]
    fn at_a_corner_the_printed_filter_is_worse_than_none_and_ours_is_not() {
        let table = simulated(Joint::Butt, "", 0.0).unwrap();
        let mean = |label: &str| table.value(label, "MAE [mm]").unwrap();
        assert!(mean("paper's filter") > 1.5 * mean("simulated KCF"), "{table}");
        assert!(mean("ours, causal") < 0.9 * mean("simulated KCF"), "{table}");
        assert!(mean("ours, smoothed") < 0.6 * mean("simulated KCF"), "{table}");
    }
}
