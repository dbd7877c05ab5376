//! One frame at a time, against the truth of made-up pools.

use proptest::prelude::*;
use seamtrack::frame::IntensityFrame;
use seamtrack::meltpool::{Border, Measure, Measured, Meter, Refusal, Threshold};
use seamtrack::synth::pool::{PoolScenario, PoolScene};
use seamtrack::units::Travel;

const SKEW: &str = "path=[{kind=\"straight\",px_per_frame=0.5}]\n";

fn scene(extra: &str) -> PoolScene {
    let text = format!("description = \"test\"\nframes = 40\n{extra}");
    PoolScene::new(&PoolScenario::from_toml(&text, "test").unwrap(), 7).unwrap()
}

fn measured(scene: &PoolScene, measure: Measure, frame: usize) -> Result<Measured, Refusal> {
    let frame = scene.render(frame).intensity().unwrap();
    Meter::new(measure, scene.scenario().image.travel, Threshold::Otsu).measure(&frame).unwrap()
}

/// Errors of the frames with a value \[px\].
fn errors(scene: &PoolScene, measure: Measure) -> Vec<f64> {
    let travel = scene.scenario().image.travel;
    let error = |frame: usize| {
        let truth = scene.truth(frame);
        let true_px = match measure {
            Measure::Tip => travel.across_px(truth.tip),
            Measure::Width => truth.width_px,
        };
        measured(scene, measure, frame).ok().map(|measured| measured.value_px - true_px)
    };
    (0..scene.frame_count()).filter_map(error).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn rms(values: &[f64]) -> f64 {
    mean(&values.iter().map(|value| value * value).collect::<Vec<_>>()).sqrt()
}

#[test]
fn a_smooth_pool_is_measured_to_a_fraction_of_a_pixel() {
    let scene = scene(&format!("{SKEW}[pool]\nraggedness_px = 0.0\n"));
    let tips = errors(&scene, Measure::Tip);
    assert!(tips.len() == 40 && rms(&tips) < 0.15, "{tips:?}");
    let widths = errors(&scene, Measure::Width);
    assert!(widths.len() == 40 && rms(&widths) < 0.08, "{widths:?}");
}

#[test]
fn the_tip_is_where_the_flanks_meet_even_off_the_middle_of_the_front() {
    // The corner crosses from one shoulder of the pool to the other: its foremost pixel is up to 20 px from the pool's.
    let scene = scene("path=[{kind=\"straight\",px_per_frame=1.0}]\n[pool]\n");
    let tips = errors(&scene, Measure::Tip);
    assert!(tips.len() == 40 && mean(&tips).abs() < 0.25 && rms(&tips) < 0.8, "{} {}", mean(&tips), rms(&tips));
}

#[test]
fn plume_seam_track_and_gradient_do_not_move_the_measures() {
    let light = "plume_grey = 60.0\nseam_grey = 60.0\ntrack_grey = 60.0\ngradient_grey = 40.0\n";
    let scene = scene(&format!("{SKEW}[pool]\n[light]\n{light}"));
    for measure in [Measure::Tip, Measure::Width] {
        let errors = errors(&scene, measure);
        assert!(errors.len() >= 38, "{measure:?}: {} frames", errors.len());
        assert!(mean(&errors).abs() < 0.4 && rms(&errors) < 1.0, "{measure:?} {} {}", mean(&errors), rms(&errors));
    }
}

#[test]
fn a_change_of_emissivity_changes_neither_measure() {
    let scene = scene("[pool]\nraggedness_px = 0.0\n[emissivity]\nstep = 0.3\n");
    for measure in [Measure::Tip, Measure::Width] {
        let errors = errors(&scene, measure);
        let (before, after) = errors.split_at(20);
        assert!((mean(before) - mean(after)).abs() < 0.1, "{measure:?}: {} {}", mean(before), mean(after));
    }
}

#[test]
fn every_direction_of_travel_gives_the_same_value() {
    for measure in [Measure::Tip, Measure::Width] {
        let up = scene(&format!("{SKEW}[pool]\n"));
        let frame = up.render(5).intensity().unwrap();
        let expected = Meter::new(measure, Travel::Up, Threshold::Otsu).measure(&frame).unwrap().unwrap();
        let (w, h) = (frame.width_px(), frame.height_px());
        for travel in [Travel::Down, Travel::Left, Travel::Right] {
            let size = if travel.is_along_columns() { (w, h) } else { (h, w) };
            let mut pixels = vec![0.0; w * h];
            for y in 0..h {
                for x in 0..w {
                    let point = travel.image_from_turned([x as f64, y as f64], size);
                    pixels[point.v_px as usize * size.0 + point.u_px as usize] = frame.pixels()[y * w + x];
                }
            }
            let turned = IntensityFrame::new(size.0, size.1, pixels).unwrap();
            let found = Meter::new(measure, travel, Threshold::Otsu).measure(&turned).unwrap().unwrap();
            assert!((found.value_px - expected.value_px).abs() < 1e-6, "{measure:?} {travel}");
        }
    }
}

#[test]
fn what_cannot_be_measured_is_refused_with_its_reason() {
    let refusal = |scene: &PoolScene, measure| measured(scene, measure, 0).unwrap_err();
    let round = scene("[pool]\ntip_height_px = 0.0\nraggedness_px = 0.0\nlength_px = 90.0\n");
    assert_eq!(refusal(&round, Measure::Tip), Refusal::NoCorner);
    let absent = scene("[pool]\n[flaws]\nabsent = [[0, 0]]\n");
    let flooded = scene("[pool]\n[flaws]\nflooded = [[0, 0]]\n");
    for measure in [Measure::Tip, Measure::Width] {
        assert_eq!(refusal(&absent, measure), Refusal::NoPool);
        assert_eq!(refusal(&flooded, measure), Refusal::Saturated);
    }
    let cut = |pool_at: &str| scene(&format!("[image]\npool_at = {pool_at}\n[pool]\n"));
    assert_eq!(refusal(&cut("[0.5, 0.1]"), Measure::Tip), Refusal::Border(Border::Front));
    assert_eq!(refusal(&cut("[0.1, 0.5]"), Measure::Width), Refusal::Border(Border::Side));
    assert_eq!(refusal(&cut("[0.5, 1.05]"), Measure::Width), Refusal::Border(Border::Behind));
}

#[test]
fn what_is_whole_is_measured_although_the_pool_touches_the_border_elsewhere() {
    // Its tail lies beyond the picture: tip and widest place do not.
    let scene = scene("[image]\npool_at = [0.5, 0.85]\n[pool]\nraggedness_px = 0.0\n");
    for measure in [Measure::Tip, Measure::Width] {
        let errors = errors(&scene, measure);
        assert!(errors.len() == 40 && rms(&errors) < 0.3, "{measure:?} {} {}", errors.len(), rms(&errors));
    }
}

#[test]
fn frames_of_noise_or_of_one_value_or_of_one_pixel_show_no_pool() {
    let flat = |w: usize, h: usize, light: f32| IntensityFrame::new(w, h, vec![light; w * h]).unwrap();
    for frame in [flat(1, 1, 0.5), flat(1, 40, 0.2), flat(64, 64, 0.3), flat(3, 3, 0.0)] {
        for measure in [Measure::Tip, Measure::Width] {
            let found = Meter::new(measure, Travel::Up, Threshold::Otsu).measure(&frame).unwrap();
            assert_eq!(found, Err(Refusal::NoPool));
        }
    }
}

#[test]
fn sixteen_bits_show_a_pool_that_eight_would_not() {
    let text = "[image]\nbits = 16\n[pool]\nraggedness_px = 0.0\n[light]\nbackground_grey = 2.0\npool_grey = 12.0\n\
                hot_spot_grey = 0.0\nread_noise_grey = 0.05\nshot_noise_grey = 0.0\n";
    let errors = errors(&scene(text), Measure::Width);
    assert!(errors.len() == 40 && rms(&errors) < 0.1, "{errors:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn an_ellipse_anywhere_without_noise_has_its_width_to_a_tenth_of_a_pixel(
        width in 30.0..150.0_f64, length in 40.0..160.0_f64, across in 0.45..0.55_f64, blur in 0.6..2.0_f64,
    ) {
        let text = format!(
            "[image]\npool_at = [{across}, 0.5]\n[pool]\nwidth_px = {width}\nlength_px = {length}\n\
             tip_height_px = 0.0\nraggedness_px = 0.0\n[light]\nhot_spot_grey = 0.0\nblur_px = {blur}\n\
             read_noise_grey = 0.0\nshot_noise_grey = 0.0\n"
        );
        let scene = scene(&text);
        let found = measured(&scene, Measure::Width, 0).unwrap();
        // Blur moves a curved edge inwards by σ²/2r, r the radius of curvature at the widest place.
        let curvature = 2.0 * width / (length * length);
        let allowed = 0.12 + 2.0 * blur * blur * curvature;
        prop_assert!((found.value_px - width).abs() < allowed, "{} for {width}", found.value_px);
    }

    #[test]
    fn no_picture_makes_the_meter_fail(
        (w, h, pixels) in (1usize..40, 1usize..40)
            .prop_flat_map(|(w, h)| (Just(w), Just(h), proptest::collection::vec(-0.5..1.5_f32, w * h))),
        right in any::<bool>(),
    ) {
        let frame = IntensityFrame::new(w, h, pixels).unwrap();
        let travel = if right { Travel::Right } else { Travel::Down };
        for measure in [Measure::Tip, Measure::Width] {
            if let Ok(found) = Meter::new(measure, travel, Threshold::Otsu).measure(&frame).unwrap() {
                prop_assert!(found.value_px.is_finite());
            }
        }
    }
}
