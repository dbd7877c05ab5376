//! A filter run on series drawn from its own model must know its own error.

use seamtrack::kalman::consistency::{mean_band_999, nees};
use seamtrack::kalman::{
    ColouredMeasurement, ColouredProcess, ConstantVelocity, Gaussian, StateSpace, Trajectory, TwoPointCovariance, Width,
};

use crate::simulation::simulate;

const RUNS: u64 = 200;
const STEPS: usize = 100;

/// The last NEES of each run are independent of one another; so are all innovations.
fn check<const N: usize, const M: usize>(space: StateSpace<N, M>, start: Gaussian<N>, dt_s: f64) {
    let (mut nees_sum, mut nis_sum, mut lagged, mut squared) = (0.0, 0.0, 0.0, 0.0);
    for seed in 1..=RUNS {
        let series = simulate(&space, &start, dt_s, STEPS, seed);
        let run = Trajectory::filter(start, &series.frames, |_| Ok(space), None).unwrap();
        let last = &run.steps.last().unwrap().update.posterior;
        nees_sum += nees(last, series.truth.last().unwrap()).unwrap();
        nis_sum += run.nis().sum::<f64>();
        let first_row = |k: usize| run.steps[k].update.innovation[0].unwrap() / run.steps[k].update.S[(0, 0)].sqrt();
        for k in 1..STEPS {
            lagged += first_row(k) * first_row(k - 1);
            squared += first_row(k).powi(2);
        }
    }
    let runs = usize::try_from(RUNS).unwrap();
    let (low, high) = mean_band_999(runs, N);
    let mean_nees = nees_sum / runs as f64;
    assert!((low..high).contains(&mean_nees), "mean NEES {mean_nees} is not within {low} … {high}");
    let (low, high) = mean_band_999(runs * STEPS, M);
    let mean_nis = nis_sum / (runs * STEPS) as f64;
    assert!((low..high).contains(&mean_nis), "mean NIS {mean_nis} is not within {low} … {high}");
    let correlation = lagged / squared;
    assert!(correlation.abs() < 3.29 / ((runs * STEPS) as f64).sqrt(), "innovations are coloured: {correlation}");
}

#[test]
fn zhangs_filter_is_consistent() {
    let model = ConstantVelocity::printed();
    let start = model.start_from_two(1.0, 1.1, 0.4, TwoPointCovariance::Exact).unwrap();
    check(model.state_space(0.4).unwrap(), start, 0.4);
}

#[test]
fn dus_filter_is_consistent_with_strongly_coloured_noise() {
    let model = ColouredMeasurement::new(0.5, 0.7, 0.68, 0.1, 0.2).unwrap();
    check(model.state_space(0.2).unwrap(), model.start(320.0).unwrap(), 0.2);
}

#[test]
fn the_infrared_filter_is_consistent() {
    let model = ColouredProcess::new(0.01, 0.5, 5.0, 5.0, 1.0).unwrap();
    check(model.state_space(1.0).unwrap(), model.start_as_printed(238.0, 239.0, 0.0).unwrap(), 1.0);
}

#[test]
fn jiangs_filter_is_consistent() {
    let model = Width::new(1e-3, 1.2e-3).unwrap();
    let start = model.start_from_two(2.0, 2.01, 0.1).unwrap();
    check(model.state_space(0.1).unwrap(), start, 0.1);
}

#[test]
fn the_approximate_bands_lie_within_two_thousandths_of_the_exact_ones() {
    let vectors: serde_json::Value = serde_json::from_str(include_str!("../../fixtures/kalman_vectors.json")).unwrap();
    for count in [50, 100, 250, 1000] {
        for dof in [1, 2] {
            let exact = &vectors["chi2"][format!("n{count}_dof{dof}")];
            let (low, high) = mean_band_999(count, dof);
            let difference = (low - exact[0].as_f64().unwrap()).abs().max((high - exact[3].as_f64().unwrap()).abs());
            assert!(difference < 0.0025, "{count} values of {dof} dof: off by {difference}");
        }
    }
}
