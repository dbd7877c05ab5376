//! The hairline tracker on real stripes from the first raw frame on: found, followed, smoothed, and not found where the
//! seam was painted over; clean and in composited arcs.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod real;

use real::Shot;
use real::paint::{Paint, without_seam};
use seamtrack::frame::GrayFrame;
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::{
    EvidenceRow, HairlineEstimate, HairlineTracker, Method, RobustSettings, SeamPresence, Session, SessionSettings,
    smooth,
};
use seamtrack::units::StripeAxis;

const SCANS: [&str; 2] = ["abb-butt-scan1", "abb-butt-scan4"];

/// What the tracker made of a recording: an estimate a recorded frame, an evidence row a new one.
struct Run {
    estimates: Vec<Option<HairlineEstimate>>,
    evidence: Vec<EvidenceRow>,
}

/// Tracks every new frame, changed by `change(shot, number of new frames before)`.
fn run(shots: &[&Shot], change: impl Fn(&Shot, usize) -> GrayFrame) -> Run {
    let mut tracker = HairlineTracker::default();
    let mut run = Run { estimates: Vec::new(), evidence: Vec::new() };
    for shot in shots {
        let repeated = shot.repeated && !run.estimates.is_empty();
        let estimate = if repeated {
            run.estimates.last().copied().flatten()
        } else {
            let estimate = tracker.step(&change(shot, run.evidence.len()));
            run.evidence.push(tracker.evidence().clone());
            estimate
        };
        run.estimates.push(estimate);
    }
    run
}

fn is(estimate: &Option<HairlineEstimate>, presence: SeamPresence) -> bool {
    estimate.is_some_and(|e| e.presence == presence)
}

/// Absolute errors \[px\] of all frames with a clear seam and a reference.
fn errors(shots: &[&Shot], run: &Run) -> Vec<f64> {
    shots
        .iter()
        .zip(&run.estimates)
        .filter(|(_, estimate)| is(estimate, SeamPresence::Present))
        .filter_map(|(shot, estimate)| Some((estimate.as_ref()?.seam.u_px - shot.reference_px?).abs()))
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn worst(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// SD of the third differences over √20: the deviation of white noise that would look as restless.
fn jitter(values: &[f64]) -> f64 {
    let third: Vec<f64> = values.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).collect();
    let centre = mean(&third);
    (third.iter().map(|d| (d - centre).powi(2)).sum::<f64>() / third.len() as f64 / 20.0).sqrt()
}

/// A constant-velocity filter over the single frames' observations, to see what they are good for.
fn kalman(observations: &[(f64, f64)], start_velocity: f64) -> Vec<f64> {
    const ACCELERATION_PX2: f64 = 0.03;
    let (mut u, mut v) = (observations[0].0, start_velocity);
    let (mut p_uu, mut p_uv, mut p_vv) = (1.0, 0.0, 0.5);
    observations
        .iter()
        .map(|&(z, sd)| {
            u += v;
            p_uu += 2.0 * p_uv + p_vv + 0.25 * ACCELERATION_PX2;
            p_uv += p_vv + 0.5 * ACCELERATION_PX2;
            p_vv += ACCELERATION_PX2;
            let s = p_uu + sd * sd;
            let (k_u, k_v, innovation) = (p_uu / s, p_uv / s, z - u);
            u += k_u * innovation;
            v += k_v * innovation;
            p_vv -= k_v * p_uv;
            p_uv -= k_u * p_uv;
            p_uu -= k_u * p_uu;
            u
        })
        .collect()
}

#[test]
fn the_seam_of_a_real_scan_is_found_followed_and_smoothed() {
    let Some(folder) = real::folder() else { return };
    for name in SCANS {
        let shots = real::scan(&folder, name);
        let shots: Vec<&Shot> = shots.iter().collect();
        let run = run(&shots, |shot, _| shot.frame.clone());

        let visible = shots.iter().position(|shot| shot.reference_px.is_some()).unwrap();
        let confirmed = run.estimates.iter().position(|e| is(e, SeamPresence::Present)).unwrap();
        assert!((visible..visible + 25).contains(&confirmed), "{name}: visible {visible}, confirmed {confirmed}");

        let causal = errors(&shots, &run);
        eprintln!(
            "{name}: visible at {visible}, confirmed at {confirmed}; causal mean {:.2} worst {:.2} px over {} frames",
            mean(&causal),
            worst(&causal),
            causal.len()
        );
        assert!(mean(&causal) <= 1.5 && worst(&causal) <= 5.0);
        let left = shots[confirmed..].iter().filter(|shot| shot.reference_px.is_some()).count();
        assert_eq!(causal.len(), left, "{name}: every frame after the confirmation has a clear seam");

        let new =
            || shots.iter().zip(&run.estimates).filter(|(shot, e)| !shot.repeated && is(e, SeamPresence::Present));
        let path: Vec<f64> = new().filter_map(|(_, e)| Some(e.as_ref()?.seam.u_px)).collect();
        let alone: Vec<(f64, f64)> =
            new().filter_map(|(_, e)| e.as_ref()?.observation.map(|o| (o.u_px, o.sd_px))).collect();
        let start = run.estimates[confirmed].unwrap().grid.velocity_px;
        let filtered = kalman(&alone, start);
        let alone: Vec<f64> = alone.iter().map(|o| o.0).collect();
        eprintln!(
            "{name}: jitter of the grid's path {:.3}, of single observations {:.3}, of these filtered {:.3} px",
            jitter(&path),
            jitter(&alone),
            jitter(&filtered)
        );
        assert!(jitter(&path) <= 0.25 && jitter(&filtered) <= 0.25);

        let smoothed = smooth(&run.evidence);
        let new = shots.iter().filter(|shot| !shot.repeated);
        let errors: Vec<f64> =
            new.zip(&smoothed).filter_map(|(shot, s)| Some((s.u_px - shot.reference_px?).abs())).collect();
        eprintln!("{name}: smoothed mean {:.2} worst {:.2} px", mean(&errors), worst(&errors));
        assert!(mean(&errors) <= 1.4 && worst(&errors) <= 4.0);
    }
}

/// Frames in which the program's default tracker claims to know the seam.
fn frames_with_a_value(frames: impl Iterator<Item = GrayFrame>) -> usize {
    let method = Method::Robust(RobustSettings::default());
    let axis = Some(StripeAxis::Horizontal);
    let mut session = Session::new(&SessionSettings { axis, ..SessionSettings::new(method) }).unwrap();
    let estimates = frames.enumerate().map(|(i, frame)| session.step(&frame, 0.2 * i as f64).unwrap());
    estimates.filter(|estimate| estimate.seam.is_some()).count()
}

#[test]
fn a_stripe_whose_seam_is_painted_over_stays_seeking() {
    let Some(folder) = real::folder() else { return };
    for name in SCANS {
        let shots = real::scan(&folder, name);
        let shots: Vec<&Shot> = shots.iter().filter(|shot| shot.reference_px.is_some()).collect();
        for paint in [Paint::Moved, Paint::Mirrored, Paint::Smooth] {
            let run = run(&shots, |shot, _| without_seam(&shot.frame, shot.reference_px.unwrap(), paint));
            let most = worst(&run.estimates.iter().flatten().map(|e| e.grid.presence).collect::<Vec<_>>());
            eprintln!("{name}, seam painted over ({paint:?}): probability of a seam at most {most:.4}");
            assert!(run.estimates.iter().all(|e| is(e, SeamPresence::Seeking)));
            assert!(most < 0.05);
            let frames = shots.iter().map(|shot| without_seam(&shot.frame, shot.reference_px.unwrap(), paint));
            assert_eq!(frames_with_a_value(frames), 0, "{name}, {paint:?}: the whole tracker");
        }
        let scene = arc("severe", &shots, 1);
        let control = run(&shots, |shot, i| {
            scene.composite(i, &without_seam(&shot.frame, shot.reference_px.unwrap(), Paint::Mirrored))
        });
        assert!(control.estimates.iter().all(|e| is(e, SeamPresence::Seeking)), "{name}, severe arc, no seam");
    }
}

/// The arc, smoke and spatter of the built-in hairline scenes, as large as the scans.
fn arc(level: &str, shots: &[&Shot], seed: u64) -> Scene {
    let mut scenario = builtin::scenario(&format!("hairline-{level}")).unwrap();
    scenario.image.stripe = StripeAxis::Horizontal;
    (scenario.image.width_px, scenario.image.height_px) = (shots[0].frame.width_px(), shots[0].frame.height_px());
    scenario.path.clear();
    scenario.recorder.repeated = 0.0;
    scenario.frames = shots.len();
    Scene::new(&scenario, seed).unwrap()
}

#[test]
fn a_composited_arc_costs_frames_but_never_gives_a_wrong_place_or_a_false_seam() {
    let Some(folder) = real::folder() else { return };
    for name in SCANS {
        let shots = real::scan(&folder, name);
        let shots: Vec<&Shot> = shots.iter().filter(|shot| shot.reference_px.is_some() && !shot.repeated).collect();
        for (level, mean_px, worst_px) in [("mild", 1.6, 6.0), ("medium", 1.6, 6.0), ("severe", 2.0, 12.0)] {
            let scene = arc(level, &shots, 1);
            let seam = run(&shots, |shot, i| scene.composite(i, &shot.frame));
            let causal = errors(&shots, &seam);
            eprintln!(
                "{name}, {level} arc: mean {:.2} worst {:.2} px, clear on {} of {} frames",
                mean(&causal),
                worst(&causal),
                causal.len(),
                shots.len()
            );
            assert!(mean(&causal) <= mean_px && worst(&causal) <= worst_px);
        }
        let scene = arc("severe", &shots, 1);
        let control = run(&shots, |shot, i| {
            scene.composite(i, &without_seam(&shot.frame, shot.reference_px.unwrap(), Paint::Mirrored))
        });
        assert!(control.estimates.iter().all(|e| is(e, SeamPresence::Seeking)), "{name}, severe arc, no seam");
    }
}
