//! Noise parameters found by likelihood.

use nalgebra::matrix;
use seamtrack::kalman::fit::{filter, maximum_likelihood, smooth_seam};
use seamtrack::kalman::{ColouredMeasurement, ConstantVelocity, Frame, TwoPointCovariance};

use crate::simulation::simulate;

/// 99.9 % points of χ² with 1 and 2 degrees of freedom.
const CHI2_999: [f64; 2] = [10.828, 13.816];

#[test]
fn the_fit_is_as_likely_as_the_truth_and_the_truth_within_its_confidence_region() {
    let truth = ConstantVelocity::new(0.04, 0.02).unwrap();
    let start = truth.start_from_two(0.0, 0.05, 0.2, TwoPointCovariance::Exact).unwrap();
    let series = simulate(&truth.state_space(0.2).unwrap(), &start, 0.2, 800, 1);
    let guess = ConstantVelocity::new(10.0, 1.0).unwrap();
    let (_, fitted) = maximum_likelihood(&guess, &series.frames, None).unwrap();
    let of_truth = filter(&truth, &series.frames, None).unwrap().trajectory.log_likelihood();
    let ratio = 2.0 * (fitted - of_truth);
    assert!((-1e-6..CHI2_999[1]).contains(&ratio), "likelihood ratio {ratio}");
}

#[test]
fn a_seam_is_smoothed_with_the_process_noise_that_fits_it() {
    let truth = ColouredMeasurement::new(0.5, 0.01, 0.5, 1.0, 0.2).unwrap();
    let series = simulate(&truth.state_space(0.2).unwrap(), &truth.start(320.0).unwrap(), 0.2, 400, 1);
    let given = truth.with_acceleration_variance(100.0).unwrap();
    let smoothed = smooth_seam(&given, &series.frames, None).unwrap();
    let of_truth = filter(&truth, &series.frames, None).unwrap().trajectory.log_likelihood();
    let ratio = 2.0 * (smoothed.log_likelihood - of_truth);
    assert!((-1e-6..CHI2_999[0]).contains(&ratio), "likelihood ratio {ratio}");
    let inside = series.truth.iter().zip(smoothed.states.iter().flatten());
    let inside = inside.filter(|(x, state)| (x[0] - state.x[0]).abs() < 2.0 * state.P[(0, 0)].sqrt()).count();
    assert!((360..=396).contains(&inside), "{inside} of 400 within two sigma");
}

#[test]
fn a_frames_own_noise_replaces_the_models_and_leading_gaps_have_no_estimate() {
    let model = ColouredMeasurement::printed();
    let mut frames = vec![Frame::new(0.2, [None]); 3];
    for k in 0..60 {
        let position = 300.0 + 0.5 * f64::from(k);
        let (z, R) = if k % 10 == 5 { (position + 8.0, 400.0) } else { (position, 0.05) };
        frames.push(Frame { dt_s: 0.2, z: [Some(z)], R: Some(matrix![R]) });
    }
    let smoothed = smooth_seam(&model, &frames, None).unwrap();
    assert!(smoothed.states[..3].iter().all(Option::is_none));
    for (k, state) in smoothed.states[3..].iter().enumerate() {
        let error = state.as_ref().unwrap().x[0] - (300.0 + 0.5 * k as f64);
        assert!(error.abs() < 0.1, "frame {k}: {error}");
    }
}

#[test]
fn nothing_measured_is_an_error_that_says_so() {
    let error = smooth_seam(&ColouredMeasurement::printed(), &[Frame::new(0.2, [None]); 5], None).unwrap_err();
    assert_eq!(error.to_string(), "the series has 0 measured frames, but the filter starts from 1");
}

#[test]
fn a_frame_out_of_time_is_named() {
    let mut frames = vec![Frame::new(0.2, [Some(1.0)]); 5];
    frames[3].dt_s = -0.2;
    let error = smooth_seam(&ColouredMeasurement::printed(), &frames, None).unwrap_err();
    assert_eq!(error.to_string(), "frame 3: the time step [s] is -0.2, but must be greater than 0");
}
