//! One frame at a time.

use seamtrack::frame::IntensityFrame;
use seamtrack::meltpool::{Measure, Measured, Meter, Refusal, Threshold};
use seamtrack::synth::pool::{Body, Light, PoolImage, PoolScenario, PoolScene};
use seamtrack::units::Travel;

fn scenario(extra: &str) -> PoolScenario {
    PoolScenario::from_toml(&format!("description = \"test\"\nframes = 60\n{extra}"), "test").unwrap()
}

fn measured(scene: &PoolScene, measure: Measure, frame: usize) -> Result<Measured, Refusal> {
    let frame = scene.render(frame).intensity().unwrap();
    Meter::new(measure, scene.scenario().image.travel, Threshold::Otsu).measure(&frame).unwrap()
}

/// Bias, standard deviation and refused share.
fn errors(scene: &PoolScene, measure: Measure) -> (f64, f64, f64) {
    let mut errors = vec![];
    let mut refused = std::collections::BTreeMap::new();
    for k in 0..scene.frame_count() {
        let truth = scene.truth(k);
        match measured(scene, measure, k) {
            Ok(m) => errors.push(match measure {
                Measure::Tip => m.value_px - scene.scenario().image.travel.across_px(truth.tip),
                Measure::Width => m.value_px - truth.width_px,
            }),
            Err(refusal) => *refused.entry(refusal).or_insert(0) += 1,
        }
    }
    let n = errors.len().max(1) as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let sd = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt();
    let worst = errors.iter().map(|e| e.abs()).fold(0.0, f64::max);
    println!("{measure:?}: n {n} mean {mean:.3} sd {sd:.3} worst {worst:.3} refused {refused:?}");
    (mean, sd, 1.0 - n / scene.frame_count() as f64)
}

#[test]
fn explore() {
    for (name, extra) in [
        ("plain", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n"),
        ("smooth", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\nraggedness_px=0.0\n"),
        ("ragged", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\nraggedness_px=1.2\n"),
        ("small tip", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\ntip_height_px=7.0\ntip_half_base_px=7.0\n"),
        ("shoulder", "path=[{kind=\"straight\",px_per_frame=1.0}]\n[pool]\ntip_height_px=16.0\n"),
        ("plume", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[light]\nplume_grey=60.0\n"),
        ("plume+", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[light]\nplume_grey=110.0\n"),
        ("seam", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[light]\nseam_grey=100.0\n"),
        ("track", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[light]\ntrack_grey=70.0\n"),
        ("gradient", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[light]\nbackground_grey=50.0\ngradient_grey=80.0\n"),
        ("saturated", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[light]\npool_grey=400.0\n"),
        ("spatter", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[spatter]\ntracks=12.0\n"),
        ("dim", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[light]\npool_grey=40.0\nhot_spot_grey=20.0\n"),
        ("blurred", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\n[light]\nblur_px=3.0\n"),
        ("small", "path=[{kind=\"straight\",px_per_frame=0.1}]\n[pool]\nlength_px=40.0\nwidth_px=30.0\ntip_height_px=8.0\ntip_half_base_px=6.0\n"),
        ("slim ellipse", "[pool]\nlength_px=120.0\nwidth_px=70.0\ntip_height_px=0.0\n"),
        ("round", "[pool]\nlength_px=90.0\nwidth_px=90.0\ntip_height_px=0.0\n"),
        ("all", "path=[{kind=\"straight\",px_per_frame=0.5}]\n[pool]\nraggedness_px=0.8\n[light]\nplume_grey=60.0\nseam_grey=60.0\ntrack_grey=60.0\ngradient_grey=20.0\n[spatter]\ntracks=6.0\n"),
    ] {
        println!("{name}");
        let scene = PoolScene::new(&scenario(extra), 1).unwrap();
        errors(&scene, Measure::Tip);
        errors(&scene, Measure::Width);
        if std::env::var("DUMP").is_ok() {
            let p = scene.render(50);
            image::GrayImage::from_raw(p.width_px as u32, p.height_px as u32, p.greys.iter().map(|g| *g as u8).collect()).unwrap().save(format!("/tmp/mp_{}.png", name.replace(' ', "_"))).unwrap();
        }
    }
}
