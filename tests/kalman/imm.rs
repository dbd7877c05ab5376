//! The interacting models against what they must reduce to.

use seamtrack::kalman::{ColouredMeasurement, Frame, Gaussian, Imm, StateSpace, Trajectory};

fn model(acceleration_variance_px2_s4: f64) -> ColouredMeasurement {
    ColouredMeasurement::new(acceleration_variance_px2_s4, 0.1, 0.5, 0.1, 0.2).unwrap()
}

fn spaces<const K: usize>(accelerations: [f64; K]) -> [StateSpace<3, 1>; K] {
    accelerations.map(|q| model(q).state_space(0.2).unwrap())
}

/// A straight seam with a corner of 3 px a frame at frame 60, and a fixed ripple for noise.
fn cornered(k: usize) -> f64 {
    let bend = if k > 60 { 3.0 * (k - 60) as f64 } else { 0.0 };
    300.0 + bend + 0.3 * (1.7 * k as f64).sin()
}

fn start() -> Gaussian<3> {
    model(1.0).start(300.0).unwrap()
}

#[test]
fn one_model_alone_is_the_kalman_filter() {
    let spaces = spaces([0.3]);
    let mut imm = Imm::new(start(), 0.9).unwrap();
    let mut alone = start();
    for k in 1..50 {
        let z = [Some(cornered(k))];
        imm = imm.predict(&spaces).update(&spaces, &z, None).unwrap().posterior;
        alone = alone.predict(&spaces[0]).update(&spaces[0], &z, None).unwrap().posterior;
    }
    assert!((imm.output().x - alone.x).amax() < 1e-9 && (imm.output().P - alone.P).amax() < 1e-9);
}

#[test]
fn models_that_never_switch_are_weighed_by_their_whole_likelihood() {
    let accelerations = [1e-3, 1e-1, 10.0];
    let spaces = spaces(accelerations);
    let mut imm = Imm::new(start(), 1.0).unwrap();
    let mut log_likelihood = 0.0;
    let frames: Vec<_> = (1..40).map(|k| Frame::new(0.2, [Some(cornered(k))])).collect();
    for frame in &frames {
        let update = imm.predict(&spaces).update(&spaces, &frame.z, None).unwrap();
        log_likelihood += update.log_likelihood;
        imm = update.posterior;
    }
    let each = accelerations.map(|q| {
        let run = Trajectory::filter(start(), &frames, |dt_s| model(q).state_space(dt_s), None).unwrap();
        run.log_likelihood().exp()
    });
    let total: f64 = each.iter().sum();
    for (probability, likelihood) in imm.probabilities.iter().zip(each) {
        assert!((probability - likelihood / total).abs() < 1e-9);
    }
    assert!((log_likelihood - (total / 3.0).ln()).abs() < 1e-9);
}

#[test]
fn a_corner_hands_the_probability_to_the_restless_model_and_a_straight_gives_it_back() {
    let spaces = spaces([1e-4, 1e-1, 20.0]);
    let mut imm = Imm::new(start(), 0.97).unwrap();
    let mut restless = Vec::new();
    for k in 1..160 {
        imm = imm.predict(&spaces).update(&spaces, &[Some(cornered(k))], None).unwrap().posterior;
        restless.push(imm.probabilities[2]);
        assert!((imm.probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    let after_corner = restless[60..66].iter().copied().fold(0.0, f64::max);
    assert!(restless[55] < 0.1 && after_corner > 0.8 && restless[150] < 0.1, "{after_corner} {restless:?}");
}

#[test]
fn a_missing_frame_moves_no_probability_but_by_the_transition() {
    let spaces = spaces([1e-4, 1e-1, 20.0]);
    let imm = Imm::new(start(), 0.97).unwrap().predict(&spaces);
    let after = imm.update(&spaces, &[None], None).unwrap();
    assert_eq!(after.posterior, imm);
    assert_eq!(after.log_likelihood, 0.0);
    assert_eq!(imm.nis(&spaces[0], &[None]).unwrap(), None);
    assert!(imm.nis(&spaces[0], &[Some(330.0)]).unwrap().unwrap() > 20.0);
}
