//! The recordings, as a camera of any fineness and frame rate sees them.

use rayon::prelude::*;
use seamtrack::frame::GrayFrame;
use seamtrack::synth::scenario::{
    Butt, Covers, Edges, Extent, Fillet, Hairline, Image, Joint, Lap, PathTerm, Ramp, Recorder, Sensor, Severity,
    Smoke, Spatter, Stripe, Vgroove, Vibration,
};
use seamtrack::synth::{Scenario, Scene};
use seamtrack::units::{MmPerPx, StripeAxis};

/// Joint and light.
pub const SCENES: [&str; 6] =
    ["butt, mild", "lap, mild", "vgroove, medium", "fillet, medium", "butt, medium", "hairline, clean"];
/// Those but the hairline, whose notches are looked for at fixed widths and whose presence is counted in frames: at twice the
/// resolution it is found 9 frames later, at twice the frame rate 4 (docs/units.md).
pub const SCALE_FREE: [&str; 5] = ["butt, mild", "lap, mild", "vgroove, medium", "fillet, medium", "butt, medium"];
/// Length of a recording at the nominal frame rate.
const FRAMES: usize = 60;
/// Fixed in advance.
const SEED: u64 = 1;

/// A camera beside the nominal one: 416 × 288 pixels of 0.073 mm (a hairline's: 0.217 mm), a frame every 0.2 s.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    /// Pixels for one of the nominal camera, along and across.
    pub fineness: usize,
    /// Frames for one of the nominal camera.
    pub rate: usize,
}

impl Default for Camera {
    fn default() -> Self {
        Self { fineness: 1, rate: 1 }
    }
}

/// A rendered recording.
pub struct Recording {
    pub frames: Vec<GrayFrame>,
    pub period_s: f64,
    pub mm_per_px: f64,
    pub axis: StripeAxis,
    /// Pixels along the stripe.
    pub along_px: usize,
}

/// Renders a scene.
pub fn recorded(name: &str, camera: Camera) -> Recording {
    let scenario = scenario(name, camera);
    let scene = Scene::new(&scenario, SEED).unwrap();
    let frames: Vec<GrayFrame> = (0..scene.frame_count()).into_par_iter().map(|i| scene.render(i)).collect();
    let along_px = match scene.axis() {
        StripeAxis::Horizontal => scenario.image.width_px,
        StripeAxis::Vertical => scenario.image.height_px,
    };
    let mm_per_px = scenario.mm_per_px.get();
    Recording { frames, period_s: scenario.period_s, mm_per_px, axis: scene.axis(), along_px }
}

/// Scenes A, B, D, E and the hairline on a winding path, lengths in pixels of the nominal camera times its fineness.
fn scenario(name: &str, camera: Camera) -> Scenario {
    let (fineness, rate) = (camera.fineness as f64, camera.rate as f64);
    let px = |nominal_px: f64| fineness * nominal_px;
    // A process correlated by `per_frame` from one nominal frame to the next.
    let correlation = |per_frame: f64| per_frame.powf(1.0 / rate);
    let (kind, light) = name.split_once(", ").unwrap();
    let severity = match light {
        "clean" => Severity::Clean,
        "mild" => Severity::Mild,
        _ => Severity::Medium,
    };
    let joint = match kind {
        "butt" => Joint::Butt(Butt {
            gap_px: Ramp::Constant(px(13.0)),
            depth_px: px(24.0),
            bent_edge_px: px(3.5),
            bent_length_px: px(11.0),
            ..Butt::default()
        }),
        "lap" => Joint::Lap(Lap { step_px: Ramp::Constant(px(24.0)), shadow_px: px(5.0), ..Lap::default() }),
        "vgroove" => Joint::Vgroove(Vgroove {
            half_width_px: px(36.0),
            depth_px: px(34.0),
            root_gap_px: Ramp::Constant(px(3.0)),
            ..Vgroove::default()
        }),
        "fillet" => Joint::Fillet(Fillet { toe_px: px(6.0), ..Fillet::default() }),
        _ => Joint::Hairline(Hairline {
            width_px: px(1.3),
            bump_px: px(1.2),
            travel_px_per_frame: px(8.8) / rate,
            ..Hairline::default()
        }),
    };
    let is_hairline = kind == "hairline";
    let level = severity.disturbances();
    Scenario {
        description: name.to_owned(),
        seed: SEED,
        frames: camera.rate * FRAMES,
        period_s: 0.2 / rate,
        mm_per_px: MmPerPx::new(if is_hairline { 0.217 } else { 0.073 } / fineness).unwrap(),
        variation: 0.0,
        severity,
        arc_on_frame: 15 * camera.rate,
        path: vec![PathTerm::Sine { amplitude_px: px(25.0), period_frames: 90.0 * rate, phase_deg: 20.0 }],
        height: vec![],
        joint,
        edges: Edges { raggedness_px: px(if is_hairline { 0.0 } else { 0.6 }), correlation: correlation(0.5) },
        extent: Extent::default(),
        image: Image {
            width_px: 416 * camera.fineness,
            height_px: 288 * camera.fineness,
            stripe: StripeAxis::Horizontal,
        },
        stripe: if is_hairline {
            Stripe { sigma_px: px(1.7), amplitude_grey: 420.0, length_px: Some(px(320.0)), ..Stripe::default() }
        } else {
            Stripe { sigma_px: px(2.4), ..Stripe::default() }
        },
        sensor: Sensor { background_grey: if is_hairline { 41.0 } else { 9.0 }, ..Sensor::default() },
        vibration: Vibration { along_px: px(0.115), across_px: px(0.65), correlation: correlation(0.3) },
        recorder: Recorder::default(),
        arc: None,
        spatter: Some(Spatter { length_px: px(level.spatter.length_px), thickness: fineness, ..level.spatter }),
        smoke: Some(Smoke { wisp_px: px(level.smoke.wisp_px), ..level.smoke }),
        covers: Some(Covers { half_width_px: px(level.covers.half_width_px), ..level.covers }),
        false_stripe: None,
        tacks: vec![],
        plates: Default::default(),
        change: None,
        rivals: Default::default(),
        view: Default::default(),
        camera: None,
        laser: None,
    }
}
