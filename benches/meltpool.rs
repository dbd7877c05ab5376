//! How many frames a second the melt-pool measures take from memory, on one core. Measured, never asserted.
#![expect(missing_docs, reason = "criterion's macro writes a public function")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use seamtrack::frame::IntensityFrame;
use seamtrack::meltpool::{Measure, Meter, Threshold};
use seamtrack::synth::builtin;
use seamtrack::synth::pool::PoolScene;

/// Frames of 320 × 256 that are measured in turn.
const FRAMES: usize = 16;

fn frames(name: &str) -> Option<(Vec<IntensityFrame>, seamtrack::units::Travel)> {
    let scenario = builtin::pool_scenario(name).ok()?;
    let scene = PoolScene::new(&scenario, 1).ok()?;
    let frames = (0..FRAMES).map(|i| scene.render(i).intensity().ok()).collect::<Option<_>>()?;
    Some((frames, scenario.image.travel))
}

fn measures(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("melt pool, 320 x 256");
    group.throughput(Throughput::Elements(1));
    for (name, measure) in [
        ("pool-tip", Measure::Tip),
        ("pool-tip-plume", Measure::Tip),
        ("pool-tip-16bit", Measure::Tip),
        ("pool-width", Measure::Width),
    ] {
        let Some((frames, travel)) = frames(name) else { continue };
        let mut meter = Meter::new(measure, travel, Threshold::Otsu);
        let mut next = 0;
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                next = (next + 1) % frames.len();
                meter.measure(&frames[next]).is_ok()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, measures);
criterion_main!(benches);
