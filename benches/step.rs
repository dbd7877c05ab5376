//! How long a step of the tracker takes, by what it is doing and by the size of the picture, and the parts of it. Measured, never
//! asserted; beside OpenCV's trackers in one run: `make speed`.
#![expect(missing_docs, reason = "criterion's macro writes a public function")]
#![expect(clippy::unwrap_used, reason = "a bench that cannot go on has nothing to measure")]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use seamtrack::config::Config;
use seamtrack::frame::GrayFrame;
use seamtrack::imgproc::geometry::{JointKind, learn};
use seamtrack::imgproc::{MedianKernel, median};
use seamtrack::kcf::Kcf;
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::RobustSettings;
use seamtrack::units::{MmPerPx, PixelPoint};
use seamtrack::{Sensor, Session, SessionSettings};

/// Sizes of pictures \[px\].
const SIZES_PX: [(usize, usize); 4] = [(640, 480), (1280, 960), (2048, 1088), (2592, 2048)];
/// Frames that a session has seen before it is timed, and those that it is then timed on, forth and back.
const WARM_UP: usize = 60;
const FRAMES: usize = 90;

fn frames(name: &str, (width_px, height_px): (usize, usize)) -> (Vec<GrayFrame>, PixelPoint) {
    let mut scenario = builtin::scenario(name).unwrap();
    scenario.frames = FRAMES;
    (scenario.image.width_px, scenario.image.height_px) = (width_px, height_px);
    scenario.recorder.repeated = 0.0;
    let scene = Scene::new(&scenario, 61).unwrap();
    ((0..FRAMES).map(|i| scene.render(i)).collect(), scene.truth(0).seam.unwrap_or(PixelPoint::new(0.0, 0.0)))
}

fn session() -> Session {
    let sensor = Sensor::Scale(MmPerPx::DU_2022);
    Session::new(&SessionSettings { sensor, ..SessionSettings::new(Config::default().method().unwrap()) }).unwrap()
}

/// The frames forth and back without end, each with a later stamp.
fn run(frames: &[GrayFrame]) -> impl Iterator<Item = (f64, &GrayFrame)> {
    let there_and_back = frames.iter().chain(frames.iter().rev()).cycle();
    there_and_back.enumerate().map(|(i, frame)| (0.2 * i as f64, frame))
}

fn following(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("a step that follows");
    for name in ["A-butt", "B-lap", "D-vgroove-sine", "E-fillet"] {
        follow(&mut group, name, name, SIZES_PX[0]);
    }
    for size in &SIZES_PX[1..] {
        follow(&mut group, "A-butt", &format!("A-butt at {} x {}", size.0, size.1), *size);
    }
}

fn follow<M: criterion::measurement::Measurement>(
    group: &mut criterion::BenchmarkGroup<'_, M>,
    scene: &str,
    label: &str,
    size: (usize, usize),
) {
    let (frames, _) = frames(scene, size);
    let (mut session, mut run) = (session(), run(&frames));
    for (stamp_s, frame) in run.by_ref().take(WARM_UP) {
        session.step(frame, stamp_s).unwrap();
    }
    group.bench_function(label, |bencher| {
        bencher.iter(|| {
            let (stamp_s, frame) = run.next().unwrap();
            black_box(session.step(frame, stamp_s).unwrap());
        });
    });
}

fn seeking(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("a step that seeks, on a plate without a seam");
    group.sample_size(30);
    for size in SIZES_PX {
        let (frames, _) = frames("flat", size);
        let (mut session, mut run) = (session(), run(&frames));
        group.bench_function(BenchmarkId::from_parameter(format!("{} x {}", size.0, size.1)), |bencher| {
            bencher.iter(|| {
                let (stamp_s, frame) = run.next().unwrap();
                black_box(session.step(frame, stamp_s).unwrap());
            });
        });
    }
}

fn parts(criterion: &mut Criterion) {
    let (frames, seam) = frames("A-butt", SIZES_PX[0]);
    let frame = median(&frames[0], MedianKernel::Three);
    let mut kcf = Kcf::new(RobustSettings::default().kcf).unwrap();
    kcf.train(&frame, seam);
    criterion.bench_function("KCF: detection", |bencher| bencher.iter(|| black_box(kcf.detect(&frame, seam))));
    criterion.bench_function("KCF: update", |bencher| bencher.iter(|| kcf.update(&frame, seam, 0.03)));
    criterion.bench_function("median of 3 x 3, whole picture", |bencher| {
        bencher.iter(|| black_box(median(&frames[0], MedianKernel::Three)));
    });
    let learned = learn(&frame, seam, JointKind::Butt).unwrap();
    let mut model = learned.model;
    model.learn(&model.fit(&frame, learned.place.u_px, 0.0, 12.0).unwrap());
    criterion.bench_function("fit of a butt joint", |bencher| {
        bencher.iter(|| black_box(model.fit(&frame, learned.place.u_px, 0.0, 12.0)));
    });
}

criterion_group!(benches, following, seeking, parts);
criterion_main!(benches);
