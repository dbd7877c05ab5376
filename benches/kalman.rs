//! How long one step of the filters takes. Measured, never asserted.
#![expect(missing_docs, reason = "criterion's macro writes a public function")]

use criterion::{Criterion, criterion_group, criterion_main};
use seamtrack::kalman::{ColouredMeasurement, Imm};

fn steps(criterion: &mut Criterion) {
    let model = ColouredMeasurement::printed();
    let Ok((start, space)) = model.start(320.0).and_then(|start| Ok((start, model.state_space(0.2)?))) else {
        return;
    };
    let mut state = start;
    criterion.bench_function("one step of the augmented model", |bencher| {
        bencher.iter(|| {
            if let Ok(update) = state.predict(&space).update(&space, &[Some(320.5)], None) {
                state = update.posterior;
            }
        });
    });
    let Ok(mut imm) = Imm::<3, 3>::new(start, 0.97) else { return };
    let spaces = [space; 3];
    criterion.bench_function("one step of three interacting models", |bencher| {
        bencher.iter(|| {
            if let Ok(update) = imm.predict(&spaces).update(&spaces, &[Some(320.5)], None) {
                imm = update.posterior;
            }
        });
    });
}

criterion_group!(benches, steps);
criterion_main!(benches);
