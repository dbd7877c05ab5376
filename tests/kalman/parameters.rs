//! Parameters no filter can be built from are refused with the reason.

use nalgebra::{matrix, vector};
use seamtrack::kalman::{
    Acceleration, ColouredMeasurement, ColouredProcess, ConstantVelocity, Gaussian, Imm, InnovationNotPositive,
    InvalidParameter, StateSpace, Width,
};

fn reason<T: std::fmt::Debug>(result: Result<T, InvalidParameter>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn no_measurement_noise_at_all_is_refused() {
    let said = "both measurement noises are 0, so the innovation would have no variance: give one of them";
    assert_eq!(reason(ColouredMeasurement::new(0.01, 0.0, 0.5, 0.0, 0.2)), said);
    assert!(ColouredMeasurement::new(0.01, 0.0, 0.5, 5.0, 0.2).is_ok());
    assert!(ColouredMeasurement::new(0.01, 0.01, 0.5, 0.0, 0.2).is_ok());
    assert!(ColouredMeasurement::new(0.01, 0.0, 0.5, 5.0, 0.2).unwrap().with_white_variance(0.0).is_err());
}

#[test]
fn a_coefficient_on_or_outside_the_unit_circle_is_refused() {
    for psi in [1.0, -1.0, 1.5, f64::NAN] {
        assert!(ColouredMeasurement::new(0.01, 0.01, psi, 5.0, 0.2).is_err(), "{psi}");
        assert!(ColouredProcess::new(0.01, psi, 5.0, 5.0, 1.0).is_err(), "{psi}");
    }
    let said = reason(ColouredMeasurement::new(0.01, 0.01, 1.0, 5.0, 0.2));
    assert_eq!(said, "the coloured noise's coefficient ψ is 1, but must lie between -1 and 1, both excluded");
}

#[test]
fn a_step_of_time_that_does_not_go_forward_is_refused() {
    for dt_s in [0.0, -0.2, f64::NAN, f64::INFINITY] {
        assert!(ColouredMeasurement::printed().state_space(dt_s).is_err(), "{dt_s}");
        assert!(ConstantVelocity::printed().state_space(dt_s).is_err(), "{dt_s}");
        assert!(ColouredProcess::printed().state_space(dt_s).is_err(), "{dt_s}");
        assert!(Width::new(1e-3, 1e-3).unwrap().state_space(dt_s).is_err(), "{dt_s}");
    }
    let continuous = Acceleration::Continuous { period_s: 0.0 };
    assert!(ConstantVelocity::printed().with_acceleration(continuous).is_err());
}

#[test]
fn negative_and_undefined_variances_are_refused() {
    assert!(ConstantVelocity::new(-0.01, 0.01).is_err());
    assert!(ConstantVelocity::new(0.01, 0.0).is_err());
    assert!(ConstantVelocity::new(0.01, f64::NAN).is_err());
    assert!(ColouredMeasurement::new(f64::INFINITY, 0.01, 0.5, 5.0, 0.2).is_err());
    assert!(ColouredProcess::new(0.01, 0.5, 5.0, -1.0, 1.0).is_err());
    assert!(Width::new(1e-3, -1.0).is_err());
    assert!(ColouredMeasurement::printed().start_from_clean(320.0, -0.1).is_err());
    assert!(ColouredMeasurement::printed().start(f64::NAN).is_err());
}

#[test]
fn a_matrix_that_is_not_a_covariance_is_refused() {
    let said = "P is not a covariance: it must be symmetric with no negative eigenvalue";
    assert_eq!(reason(Gaussian::new(vector![0.0, 0.0], matrix![1.0, 2.0; 2.0, 1.0])), said);
    let (F, H) = (matrix![1.0, 0.2; 0.0, 1.0], matrix![1.0, 0.0]);
    assert!(StateSpace::new(F, matrix![1.0, 0.5; 0.0, 1.0], H, matrix![1.0]).is_err());
    assert!(StateSpace::new(F, matrix![1.0, 0.5; 0.5, 1.0], H, matrix![-1.0]).is_err());
    assert!(StateSpace::new(F * f64::NAN, matrix![1.0, 0.5; 0.5, 1.0], H, matrix![1.0]).is_err());
}

#[test]
fn a_probability_outside_its_range_is_refused() {
    let start = ColouredMeasurement::printed().start(320.0).unwrap();
    assert!(Imm::<3, 3>::new(start, 1.1).is_err() && Imm::<3, 3>::new(start, f64::NAN).is_err());
}

#[test]
fn an_innovation_without_variance_is_an_error_not_a_division_by_zero() {
    let space = StateSpace::new(matrix![1.0], matrix![0.0], matrix![1.0], matrix![0.0]).unwrap();
    let certain = Gaussian::new(vector![1.0], matrix![0.0]).unwrap();
    assert_eq!(certain.update(&space, &[Some(1.0)], None), Err(InnovationNotPositive));
}

#[test]
fn measurements_that_are_not_finite_count_as_missing() {
    let model = ColouredMeasurement::printed();
    let space = model.state_space(0.2).unwrap();
    let prior = model.start(320.0).unwrap().predict(&space);
    for z in [f64::NAN, f64::INFINITY] {
        let update = prior.update(&space, &[Some(z)], None).unwrap();
        assert_eq!((update.posterior, update.nis, update.log_likelihood), (prior, None, 0.0));
    }
}
