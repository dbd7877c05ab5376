//! A filter step allocates nothing.

use seamtrack::kalman::{ChiSquareGate, ColouredMeasurement, Imm};

#[test]
fn neither_the_filter_nor_the_interacting_models_allocate_in_a_step() {
    let model = ColouredMeasurement::printed();
    let start = model.start(320.0).unwrap();
    let mut state = start;
    let mut imm = Imm::<3, 3>::new(start, 0.97).unwrap();
    let counted = allocation_counter::measure(|| {
        for k in 0..1000 {
            let space = model.state_space(0.2).unwrap();
            let z = [(k % 7 != 3).then(|| 320.0 + 0.5 * f64::from(k))];
            state = state.predict(&space).update(&space, &z, Some(ChiSquareGate::<1>::P99)).unwrap().posterior;
            let spaces = [0.01, 1.0, 100.0]
                .map(|q| model.with_acceleration_variance(q).and_then(|model| model.state_space(0.2)).unwrap());
            imm = imm.predict(&spaces).update(&spaces, &z, None).unwrap().posterior;
        }
    });
    assert!(state.x[0] > 700.0 && imm.output().x[0] > 700.0);
    assert_eq!(counted.count_total, 0);
    assert_eq!(
        allocation_counter::measure(|| drop(std::hint::black_box(vec![state; 2]))).count_total,
        1,
        "the counter counts"
    );
}
