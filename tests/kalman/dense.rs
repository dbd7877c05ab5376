//! The recursions against dense Gaussian conditioning: all states and measurements of a series as one Gaussian
//! vector, which knows no recursion.

use nalgebra::{DMatrix, DVector};
use seamtrack::kalman::adaptive::{NoiseAdaptation, filter_adaptively};
use seamtrack::kalman::literal::LiteralAdaptation;
use seamtrack::kalman::{ChiSquareGate, ColouredMeasurement, Trajectory, smoother};

use crate::vectors::case;

/// Mean and covariance of the state after `at` steps given the measurements of the first `known` steps. Each
/// measurement's R is what the filter says it used, S − H P Hᵀ.
fn conditioned<const N: usize, const M: usize>(
    run: &Trajectory<N, M>,
    at: usize,
    known: usize,
) -> (DVector<f64>, DMatrix<f64>) {
    let dense =
        |rows: usize, columns: usize, value: &dyn Fn(usize, usize) -> f64| DMatrix::from_fn(rows, columns, value);
    let steps = at.max(known);
    // Joint mean and covariance of the states 0..=steps.
    let size = N * (steps + 1);
    let mut mean = DVector::zeros(size);
    let mut covariance = DMatrix::zeros(size, size);
    mean.rows_mut(0, N).copy_from(&run.start.x);
    covariance.view_mut((0, 0), (N, N)).copy_from(&dense(N, N, &|i, j| run.start.P[(i, j)]));
    for k in 0..steps {
        let space = &run.steps[k].space;
        let F = dense(N, N, &|i, j| space.F[(i, j)]);
        let (now, next) = (N * k, N * (k + 1));
        let x = &F * mean.rows(now, N);
        mean.rows_mut(next, N).copy_from(&x);
        let cross = &F * covariance.view((now, 0), (N, next));
        covariance.view_mut((next, 0), (N, next)).copy_from(&cross);
        covariance.view_mut((0, next), (next, N)).copy_from(&cross.transpose());
        let own = &F * covariance.view((now, now), (N, N)) * F.transpose() + dense(N, N, &|i, j| space.Qd[(i, j)]);
        covariance.view_mut((next, next), (N, N)).copy_from(&own);
    }
    // The measured rows: z = H x + v.
    let rows: Vec<(usize, usize)> = (0..known)
        .flat_map(|k| (0..M).filter(move |row| run.steps[k].update.innovation[*row].is_some()).map(move |row| (k, row)))
        .collect();
    let h = |(k, row): (usize, usize)| {
        let mut h = DVector::zeros(size);
        (0..N).for_each(|i| h[N * (k + 1) + i] = run.steps[k].space.H[(row, i)]);
        h
    };
    let H = DMatrix::from_rows(&rows.iter().map(|row| h(*row).transpose()).collect::<Vec<_>>());
    let R = dense(rows.len(), rows.len(), &|i, j| {
        let ((k, row), (other, column)) = (rows[i], rows[j]);
        let step = &run.steps[k];
        let used = step.update.S - step.space.H * step.prior.P * step.space.H.transpose();
        if k == other { used[(row, column)] } else { 0.0 }
    });
    let z = DVector::from_iterator(
        rows.len(),
        rows.iter().map(|(k, row)| {
            let step = &run.steps[*k];
            step.update.innovation[*row].unwrap() + (step.space.H * step.prior.x)[*row]
        }),
    );
    let S = &H * &covariance * H.transpose() + R;
    let gain = &covariance * H.transpose() * S.try_inverse().unwrap();
    let x = &mean + &gain * (z - &H * &mean);
    let P = &covariance - &gain * &H * &covariance;
    (x.rows(N * at, N).into_owned(), P.view((N * at, N * at), (N, N)).into_owned())
}

fn check<const N: usize, const M: usize>(run: &Trajectory<N, M>) {
    let smoothed = smoother::bryson_frazier(run);
    let lagged = smoother::fixed_lag(run, 5);
    let filtered: Vec<_> = run.filtered().collect();
    let end = run.steps.len();
    for at in [0, 1, 8, 21, 35, end] {
        for (known, ours) in [(at, filtered[at]), (end, &smoothed[at]), (end.min(at + 5), &lagged[at])] {
            if known == 0 {
                continue;
            }
            let (x, P) = conditioned(run, at, known);
            let error = (0..N).map(|i| (x[i] - ours.x[i]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-8, "state {at} given {known}: off by {error}");
            let error = (0..N).map(|i| (P[(i, i)] - ours.P[(i, i)]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-8 * run.start.P.amax(), "covariance {at} given {known}: off by {error}");
        }
    }
}

#[test]
fn bounded_innovations_are_measurements_with_more_noise() {
    check(&case("m001_huber").run::<3, 1>(Some(ChiSquareGate::<1>::P99)));
}

#[test]
fn irregular_steps_are_conditioned_exactly() {
    let case = case("m001_variable_T");
    let model = ColouredMeasurement::printed();
    let start = model.start(320.0).unwrap();
    check(&Trajectory::filter(start, &case.frames(), |dt_s| model.state_space(dt_s), None).unwrap());
}

#[test]
fn learnt_noise_is_used_as_it_was_learnt_with_rows_and_frames_missing() {
    let case = case("m004_adaptive_R");
    let space = case.space();
    let (run, _) =
        filter_adaptively(case.start(), &case.frames(), |_| Ok(space), NoiseAdaptation::new(&space.R)).unwrap();
    check::<3, 2>(&run);
}

#[test]
fn two_rows_missing_one_by_one_are_conditioned_exactly() {
    check(&case("m003_worked").run::<4, 2>(None));
}

#[test]
fn the_printed_statistics_are_the_running_means_they_stand_for() {
    let case = case("m004_literal_8steps");
    let space = case.space::<3, 2>();
    let k0 = 20.0;
    let mut filter = LiteralAdaptation::new(case.start(), &space, 20);
    let (mut w, mut eta) = (nalgebra::SVector::<f64, 3>::zeros(), nalgebra::SVector::<f64, 2>::zeros());
    let (mut Q, mut R) = (space.Qd * k0, space.R * k0);
    for (index, z) in case.z.iter().enumerate() {
        let before = filter;
        let step = filter.step(&space, &[z[0], z[1]]);
        let k = k0 + index as f64 + 1.0;
        let e = step.innovation.unwrap();
        let K = step.prior.P * space.H.transpose() * step.S.try_inverse().unwrap();
        w += filter.state.x - space.F * before.state.x;
        eta += e + before.eta;
        Q += K * e * (K * e).transpose() + filter.state.P - space.F * before.state.P * space.F.transpose();
        R += e * e.transpose() - space.H * step.prior.P * space.H.transpose();
        assert!((filter.w - w / k).amax() < 1e-12 && (filter.eta - eta / k).amax() < 1e-12);
        assert!((filter.Q - Q / k).amax() < 1e-12 && (filter.R - R / k).amax() < 1e-12);
        // (11) and (13): with the R̂ before it, the update solves K S = P Hᵀ and takes K S Kᵀ from P.
        let expected = step.prior.P - K * step.S * K.transpose();
        assert!((filter.state.P - expected).amax() < 1e-12);
    }
}
