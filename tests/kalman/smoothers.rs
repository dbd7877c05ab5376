//! The smoothers against one another.

use seamtrack::kalman::smoother::{bryson_frazier, fixed_lag, rauch_tung_striebel};
use seamtrack::kalman::{ChiSquareGate, ColouredMeasurement, Frame, Trajectory};

use crate::vectors::case;

fn largest_difference<const N: usize>(
    a: &[seamtrack::kalman::Gaussian<N>],
    b: &[seamtrack::kalman::Gaussian<N>],
) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| (a.x - b.x).amax().max((a.P - b.P).amax())).fold(0.0, f64::max)
}

#[test]
fn both_smoothers_agree_wherever_both_exist() {
    for name in ["m000_T0.2_printed", "m000_T0.4_exact"] {
        let run = case(name).run::<2, 1>(None);
        assert!(largest_difference(&bryson_frazier(&run), &rauch_tung_striebel(&run).unwrap()) < 1e-8);
    }
    for gate in [None, Some(ChiSquareGate::<1>::P99)] {
        let run = case("m001_huber").run::<3, 1>(gate);
        assert!(largest_difference(&bryson_frazier(&run), &rauch_tung_striebel(&run).unwrap()) < 1e-8);
    }
    let run = case("m004_fixed").run::<3, 2>(None);
    assert!(largest_difference(&bryson_frazier(&run), &rauch_tung_striebel(&run).unwrap()) < 1e-8);
}

#[test]
fn a_lag_of_nothing_is_the_filter_and_a_lag_of_everything_the_smoother() {
    let run = case("m001_printed").run::<3, 1>(None);
    let filtered: Vec<_> = run.filtered().copied().collect();
    assert!(largest_difference(&fixed_lag(&run, 0), &filtered) < 1e-12);
    assert!(largest_difference(&fixed_lag(&run, run.steps.len()), &bryson_frazier(&run)) < 1e-9);
}

#[test]
fn later_measurements_never_raise_the_variance() {
    let run = case("m001_printed").run::<3, 1>(None);
    let (lagged, smoothed) = (fixed_lag(&run, 10), bryson_frazier(&run));
    for ((filtered, lagged), smoothed) in run.filtered().zip(&lagged).zip(&smoothed) {
        assert!(smoothed.P[(0, 0)] <= lagged.P[(0, 0)] + 1e-12);
        assert!(lagged.P[(0, 0)] <= filtered.P[(0, 0)] + 1e-12);
    }
}

#[test]
fn a_gap_is_bridged_with_a_variance_that_is_largest_in_its_middle() {
    let model = ColouredMeasurement::printed();
    let z = |k: usize| if (40..60).contains(&k) { None } else { Some(300.0 + 0.5 * k as f64) };
    let frames: Vec<_> = (0..100).map(|k| Frame::new(0.2, [z(k)])).collect();
    let start = model.start(299.5).unwrap();
    let run = Trajectory::filter(start, &frames, |dt_s| model.state_space(dt_s), None).unwrap();
    let smoothed = bryson_frazier(&run);
    let variance = |k: usize| smoothed[k + 1].P[(0, 0)];
    assert!((smoothed[51].x[0] - 325.0).abs() < 0.2, "{}", smoothed[51].x[0]);
    assert!(variance(50) > variance(41) && variance(50) > variance(58));
    assert!(run.steps[50].update.nis.is_none());
}
