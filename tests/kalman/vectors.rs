//! Every case of the reference vectors: double precision trajectories from an implementation in another language,
//! cross-checked against four more (`fixtures/kalman_vectors.json`).

use std::collections::BTreeMap;

use nalgebra::{SMatrix, SVector, vector};
use seamtrack::kalman::adaptive::{NoiseAdaptation, filter_adaptively};
use seamtrack::kalman::literal::{LiteralAdaptation, Lost};
use seamtrack::kalman::{
    ChiSquareGate, ColouredMeasurement, ColouredProcess, ConstantVelocity, Frame, Gaussian, StateSpace, Trajectory,
    TwoPointCovariance, Width, gain_table, smoother, with_displacement,
};
use serde::Deserialize;

#[derive(Deserialize)]
struct Vectors {
    cases: BTreeMap<String, Case>,
    steady_state: BTreeMap<String, SteadyState>,
}

#[derive(Deserialize)]
struct SteadyState {
    K: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
pub struct Case {
    F: Vec<Vec<f64>>,
    Qd: Vec<Vec<f64>>,
    H: Vec<Vec<f64>>,
    R: Vec<Vec<f64>>,
    x0: Vec<f64>,
    P0: Vec<Vec<f64>>,
    pub z: Vec<Vec<Option<f64>>>,
    x_pred: Vec<Vec<f64>>,
    x: Vec<Vec<f64>>,
    P_diag: Vec<Vec<f64>>,
    innov: Vec<Vec<Option<f64>>>,
    nis: Vec<Option<f64>>,
    S: Vec<Option<Vec<Vec<f64>>>>,
    P_last: Vec<Vec<f64>>,
    loglik: Option<f64>,
    x_smooth: Option<Vec<Vec<f64>>>,
    P_smooth_diag: Option<Vec<Vec<f64>>>,
    dt: Option<Vec<f64>>,
    f: Option<Vec<f64>>,
    R_after: Option<Vec<Vec<f64>>>,
    y_init: Option<Vec<f64>>,
    w: Option<Vec<Vec<f64>>>,
    eta: Option<Vec<Vec<f64>>>,
    Q3: Option<Vec<Vec<Vec<f64>>>>,
    R2: Option<Vec<Vec<Vec<f64>>>>,
}

fn vectors() -> Vectors {
    let text = include_str!("../../fixtures/kalman_vectors.json");
    serde_json::from_str(text).unwrap()
}

pub fn case(name: &str) -> Case {
    vectors().cases.remove(name).unwrap()
}

fn matrix<const A: usize, const B: usize>(rows: &[Vec<f64>]) -> SMatrix<f64, A, B> {
    SMatrix::from_fn(|i, j| rows[i][j])
}

impl Case {
    pub fn space<const N: usize, const M: usize>(&self) -> StateSpace<N, M> {
        StateSpace::new(matrix(&self.F), matrix(&self.Qd), matrix(&self.H), matrix(&self.R)).unwrap()
    }

    pub fn start<const N: usize>(&self) -> Gaussian<N> {
        Gaussian::new(SVector::from_row_slice(&self.x0), matrix(&self.P0)).unwrap()
    }

    pub fn frames<const M: usize>(&self) -> Vec<Frame<M>> {
        let dt = |k: usize| self.dt.as_ref().map_or(1.0, |dt| dt[k]);
        self.z.iter().enumerate().map(|(k, z)| Frame::new(dt(k), std::array::from_fn(|row| z[row]))).collect()
    }

    pub fn run<const N: usize, const M: usize>(&self, gate: Option<ChiSquareGate<M>>) -> Trajectory<N, M> {
        Trajectory::filter(self.start(), &self.frames(), |_| Ok(self.space()), gate).unwrap()
    }

    /// States to 1e-9 absolute, covariances and NIS to 1e-8 relative, smoothed to 1e-8.
    fn check<const N: usize, const M: usize>(&self, trajectory: &Trajectory<N, M>) {
        for (k, step) in trajectory.steps.iter().enumerate() {
            let update = &step.update;
            near(step.prior.x.as_slice(), &self.x_pred[k], 1e-9, k);
            near(update.posterior.x.as_slice(), &self.x[k], 1e-9, k);
            near_relative(update.posterior.P.diagonal().as_slice(), &self.P_diag[k], k);
            // The reference of the learnt noise records no NIS for an incomplete frame.
            if self.nis[k].is_some() || self.z[k].iter().all(Option::is_none) {
                near_optional(update.nis, self.nis[k], k);
            }
            for row in 0..M {
                let given = self.innov[k].get(row).copied().flatten();
                match (update.innovation[row], given) {
                    (Some(ours), Some(theirs)) => near(&[ours], &[theirs], 1e-9, k),
                    (ours, theirs) => assert_eq!(ours.is_some(), theirs.is_some(), "frame {k}, row {row}"),
                }
            }
            let present: Vec<usize> = (0..M).filter(|row| update.innovation[*row].is_some()).collect();
            if let Some(S) = &self.S[k] {
                for (i, row) in present.iter().enumerate() {
                    for (j, column) in present.iter().enumerate() {
                        near_relative(&[update.S[(*row, *column)]], &[S[i][j]], k);
                    }
                }
            }
        }
        let last = trajectory.steps.last().unwrap().update.posterior.P;
        let scale = last.amax();
        near((last / scale).as_slice(), (matrix::<N, N>(&self.P_last) / scale).as_slice(), 1e-8, self.z.len());
        if let Some(loglik) = self.loglik {
            near(&[trajectory.log_likelihood()], &[loglik], 1e-9 * loglik.abs(), self.z.len());
        }
        if let (Some(x), Some(P)) = (&self.x_smooth, &self.P_smooth_diag) {
            for (k, smoothed) in smoother::bryson_frazier(trajectory).iter().skip(1).enumerate() {
                near(smoothed.x.as_slice(), &x[k], 1e-8, k);
                near(smoothed.P.diagonal().as_slice(), &P[k], 1e-8, k);
            }
        }
    }
}

fn near(ours: &[f64], theirs: &[f64], tolerance: f64, frame: usize) {
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() <= tolerance, "frame {frame}: {a} is not {b}");
    }
}

fn near_relative(ours: &[f64], theirs: &[f64], frame: usize) {
    for (a, b) in ours.iter().zip(theirs) {
        // Where the covariance is exactly singular the variance left is rounding.
        assert!((a - b).abs() <= 1e-8 * b.abs() + 1e-14, "frame {frame}: {a} is not {b}");
    }
}

fn near_optional(ours: Option<f64>, theirs: Option<f64>, frame: usize) {
    match (ours, theirs) {
        (Some(a), Some(b)) => near_relative(&[a], &[b], frame),
        (a, b) => assert_eq!(a.is_some(), b.is_some(), "frame {frame}"),
    }
}

#[test]
fn zhangs_filter_runs_the_reference_trajectories_from_its_two_point_starts() {
    for (name, dt_s, covariance) in
        [("m000_T0.2_printed", 0.2, TwoPointCovariance::Printed), ("m000_T0.4_exact", 0.4, TwoPointCovariance::Exact)]
    {
        let case = case(name);
        let y = case.y_init.clone().unwrap();
        let start = ConstantVelocity::printed().start_from_two(y[0], y[1], dt_s, covariance).unwrap();
        near(start.x.as_slice(), &case.x0, 1e-12, 0);
        near(start.P.as_slice(), case.start::<2>().P.as_slice(), 1e-12, 0);
        let space = ConstantVelocity::printed().state_space(dt_s).unwrap();
        near(space.Qd.as_slice(), case.space::<2, 1>().Qd.as_slice(), 1e-15, 0);
        case.check(&Trajectory::filter(start, &case.frames(), |_| Ok(space), None).unwrap());
    }
}

#[test]
fn dus_filter_runs_the_reference_trajectory_from_one_position() {
    let case = case("m001_printed");
    let model = ColouredMeasurement::printed();
    let start = model.start(320.0).unwrap();
    near(start.P.as_slice(), case.start::<3>().P.as_slice(), 1e-12, 0);
    let frames = case.frames();
    case.check(&Trajectory::filter(start, &frames, |_| model.state_space(0.2), None).unwrap());
}

#[test]
fn a_bounded_innovation_runs_the_reference_trajectory() {
    let case = case("m001_huber");
    let trajectory = case.run::<3, 1>(Some(ChiSquareGate::<1>::P99));
    case.check(&trajectory);
    let f = case.f.clone().unwrap();
    assert!(f.iter().any(|f| *f < 1.0));
    for (k, step) in trajectory.steps.iter().enumerate() {
        near(&[step.update.weight], &[f[k]], 1e-9, k);
    }
}

#[test]
fn dus_filter_keeps_the_noises_statistics_over_irregular_steps() {
    let case = case("m001_variable_T");
    let model = ColouredMeasurement::printed();
    let start = model.start(320.0).unwrap();
    case.check(&Trajectory::filter(start, &case.frames(), |dt_s| model.state_space(dt_s), None).unwrap());
}

#[test]
fn measurement_noise_that_is_all_coloured_runs_the_reference_trajectory() {
    let case = case("m001_R0_coloured");
    let model = ColouredMeasurement::new(0.01, 1.0, 0.5, 0.0, 0.2).unwrap();
    let start = model.start(320.0).unwrap();
    case.check(&Trajectory::filter(start, &case.frames(), |_| model.state_space(0.2), None).unwrap());
}

#[test]
fn the_infrared_papers_worked_step_comes_out_in_exact_fractions() {
    let model = ColouredProcess::printed();
    let space = model.state_space(model.period_s()).unwrap();
    let prior = model.start_as_printed(238.0, 239.0, 5.0).unwrap().predict(&space);
    near(prior.x.as_slice(), &[242.5, 6.0, 239.0, 2.5], 1e-12, 0);
    near(space.measurement_from_state(&prior.x).as_slice(), &[242.5, 3.5], 1e-12, 0);
    let update = prior.update(&space, &[Some(239.0), Some(0.0)], None).unwrap();
    let exact = [2634.0 / 11.0, 51.0 / 11.0, 2609.0 / 11.0, 26.0 / 11.0];
    near(update.posterior.x.as_slice(), &exact, 1e-12, 0);
    near_optional(update.nis, Some(21.0 / 11.0), 0);
    let printed = [(239.45, 2), (4.6364, 4), (237.18, 2), (2.3636, 4)];
    for (ours, (theirs, digits)) in update.posterior.x.iter().zip(printed) {
        assert_eq!(format!("{ours:.digits$}"), format!("{theirs:.digits$}"));
    }
}

#[test]
fn the_infrared_filter_runs_the_reference_trajectory_and_drops_the_displacement_after_a_gap() {
    let case = case("m003_worked");
    let model = ColouredProcess::new(0.01, 0.5, 5.0, 5.0, 1.0).unwrap();
    let start = model.start_as_printed(238.0, 239.0, 5.0).unwrap();
    case.check(&Trajectory::filter(start, &case.frames(), |_| model.state_space(1.0), None).unwrap());
    let rows = with_displacement(&[Some(1.0), Some(3.0), None, Some(4.0), Some(4.5)]);
    assert_eq!(
        rows,
        [[Some(1.0), None], [Some(3.0), Some(2.0)], [None, None], [Some(4.0), None], [Some(4.5), Some(0.5)]]
    );
}

#[test]
fn jiangs_filter_with_fixed_noise_runs_the_reference_trajectory() {
    let case = case("m004_fixed");
    let model = Width::new(1e-3, case.R[0][0]).unwrap();
    let start = model.start_from_two(case.x0[2], case.x0[0], 0.1).unwrap();
    near(start.P.as_slice(), case.start::<3>().P.as_slice(), 1e-12, 0);
    case.check(&Trajectory::filter(start, &case.frames(), |_| model.state_space(0.1), None).unwrap());
}

#[test]
fn learnt_measurement_noise_runs_the_reference_trajectory() {
    let case = case("m004_adaptive_R");
    let space = case.space();
    let adaptation = NoiseAdaptation::new(&space.R);
    let (trajectory, learnt) = filter_adaptively(case.start(), &case.frames(), |_| Ok(space), adaptation).unwrap();
    case.check::<3, 2>(&trajectory);
    for (k, R) in learnt.iter().enumerate() {
        near_relative(R.diagonal().as_slice(), &case.R_after.as_ref().unwrap()[k], k);
    }
}

#[test]
fn jiangs_printed_equations_run_the_reference_trajectory_and_say_where_they_break() {
    let case = case("m004_literal_8steps");
    let space = case.space::<3, 2>();
    let mut filter = LiteralAdaptation::new(case.start(), &space, 20);
    for (k, z) in case.z.iter().enumerate() {
        let step = filter.step(&space, &[z[0], z[1]]);
        near(step.prior.x.as_slice(), &case.x_pred[k], 1e-9, k);
        near(filter.state.x.as_slice(), &case.x[k], 1e-9, k);
        near(filter.state.P.diagonal().as_slice(), &case.P_diag[k], 1e-9, k);
        near_relative(&[step.nis.unwrap()], &[case.nis[k].unwrap()], k);
        near(filter.w.as_slice(), &case.w.as_ref().unwrap()[k], 1e-9, k);
        near(filter.eta.as_slice(), &case.eta.as_ref().unwrap()[k], 1e-9, k);
        near(filter.Q.as_slice(), matrix::<3, 3>(&case.Q3.as_ref().unwrap()[k]).as_slice(), 1e-9, k);
        near(filter.R.as_slice(), matrix::<2, 2>(&case.R2.as_ref().unwrap()[k]).as_slice(), 1e-9, k);
        if k == 0 {
            assert_eq!(step.lost, Some(Lost::Q));
        }
        assert!(step.lost.is_some(), "frame {k}");
    }
}

#[test]
fn gains_settle_where_the_riccati_equation_says() {
    let steady = vectors().steady_state;
    let expect = |name: &str, K: &[f64]| {
        let reference: Vec<f64> = steady[name].K.iter().map(|row| row[0]).collect();
        near(K, &reference, 1e-9, 0);
    };
    for (name, dt_s) in [("000_T0.2", 0.2), ("000_T0.4", 0.4)] {
        let model = ConstantVelocity::printed();
        let P0 = model.start_from_two(0.0, 0.0, dt_s, TwoPointCovariance::Exact).unwrap().P;
        let gains = gain_table(&model.state_space(dt_s).unwrap(), P0, 400).unwrap();
        expect(name, gains.last().unwrap().as_slice());
    }
    let model = ColouredMeasurement::printed();
    let gains = gain_table(&model.state_space(0.2).unwrap(), model.start(0.0).unwrap().P, 2000).unwrap();
    expect("001_printed", gains.last().unwrap().as_slice());
}

#[test]
fn zhangs_printed_start_is_the_table_in_the_paper() {
    let model = ConstantVelocity::printed();
    let P = |covariance| model.start_from_two(0.0, 0.0, 0.2, covariance).unwrap().P;
    let printed = P(TwoPointCovariance::Printed);
    near(printed.as_slice(), &[0.010_004, 0.050_04, 0.050_04, 0.500_4], 1e-12, 0);
    near(P(TwoPointCovariance::Exact).as_slice(), &[0.01, 0.05, 0.05, 0.500_1], 1e-12, 0);
    let Qd = model.state_space(0.2).unwrap().Qd;
    near(Qd.as_slice(), &[4e-6, 4e-5, 4e-5, 4e-4], 1e-15, 0);
}

#[test]
fn the_exact_two_point_start_is_the_limit_of_knowing_nothing() {
    let model = ConstantVelocity::printed();
    let space = model.state_space(0.4).unwrap();
    let nothing = Gaussian { x: vector![0.0, 0.0], P: SMatrix::identity() * 1e6 };
    let first = nothing.update(&space, &[Some(3.0)], None).unwrap().posterior;
    let second = first.predict(&space).update(&space, &[Some(3.2)], None).unwrap().posterior;
    let start = model.start_from_two(3.0, 3.2, 0.4, TwoPointCovariance::Exact).unwrap();
    assert!((second.x - start.x).amax() < 1e-6 && (second.P - start.P).amax() < 1e-6);
}
