//! One recording of the campaign, drawn at random: a sensor, a joint in millimetres, a path, a light.
//!
//! Number N of seed S is always the same recording. Kind of joint, light and direction of the stripe go round with the
//! number, so that 40 recordings have each combination once; all else is drawn. What cannot be seen as the kind of joint
//! that it is ([`unseen`]) is drawn anew.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use seamtrack::synth::scenario::{
    Butt, Covers, Edges, Fillet, Image, Joint, Lap, PathTerm, Ramp, Sensor, Severity, Smoke, Spatter, Stripe, Vgroove,
    Vibration,
};
use seamtrack::synth::{Scenario, Scene};
use seamtrack::units::{MmPerPx, StripeAxis};

use crate::visible::{Unseen, unseen};

/// Sizes of pictures \[px\]: width, and height over width.
const WIDTHS_PX: (f64, f64) = (320.0, 2592.0);
const ASPECTS: (f64, f64) = (0.5, 0.8);
const HEIGHTS_PX: (f64, f64) = (240.0, 2048.0);
/// Scale \[mm/px\].
const SCALES_MM_PER_PX: (f64, f64) = (0.015, 0.25);
/// Standard width of the stripe \[px\].
const STRIPES_PX: (f64, f64) = (0.8, 5.0);
/// Largest tilt of the stripe \[degrees\].
const TILT_DEG: f64 = 15.0;
/// Time from frame to frame \[s\].
const PERIODS_S: (f64, f64) = (0.002, 0.2);
/// Brightness of the laser line at gain 1, and the gain: together 60 to 600 grey.
const AMPLITUDES_GREY: (f64, f64) = (150.0, 375.0);
const GAINS: (f64, f64) = (0.4, 1.6);
/// Raggedness of one edge \[mm\]: plates as cut; at least so many pixels, else it could not be seen.
const RAGGEDNESS_MM: (f64, f64) = (0.03, 0.06);
const LEAST_RAGGEDNESS_PX: f64 = 0.1;
/// Vibration along and across the stripe \[mm\]: that of the built-in scenes, 0.115 and 0.65 px of 0.073 mm.
const VIBRATION_MM: (f64, f64) = (0.0084, 0.047);
/// Fastest seam \[px/frame\].
pub const FASTEST_PX: f64 = 6.0;
/// Largest kink of a polyline \[px/frame\]: that of scene J.
const LARGEST_KINK_PX: f64 = 1.65;
/// Length of a picture's shorter side at which spatter, wisps and covers have the size of the built-in scenes \[px\].
const NOMINAL_SIDE_PX: f64 = 480.0;
/// By how much the scenario's own draw varies the numbers drawn here: plates, places, the path's sign.
const VARIATION: f64 = 0.1;

/// Kinds of joint, in the order of the numbers.
pub const KINDS: [&str; 4] = ["butt", "lap", "vgroove", "fillet"];
/// Lights, likewise.
pub const LIGHTS: [(&str, Severity); 5] = [
    ("clean", Severity::Clean),
    ("mild", Severity::Mild),
    ("medium", Severity::Medium),
    ("severe", Severity::Severe),
    ("heavy", Severity::Heavy),
];

/// A recording that can be seen.
pub struct Recording {
    /// Its number in the campaign.
    pub number: u64,
    /// Its kind of joint.
    pub kind: &'static str,
    /// Its light.
    pub light: &'static str,
    /// What `seamtrack synth` renders to the same bytes.
    pub scenario: Scenario,
    /// Why earlier draws of this number were given up.
    pub unseen: Vec<Unseen>,
}

/// Draws recording `number` of the campaign `seed`.
pub fn draw(seed: u64, number: u64) -> Recording {
    let mut rng = Pcg64Mcg::seed_from_u64(seed.wrapping_mul(1_000_003).wrapping_add(number));
    let kind = KINDS[(number % 4) as usize];
    let (light, severity) = LIGHTS[(number / 4 % 5) as usize];
    let axis = if (number / 20).is_multiple_of(2) { StripeAxis::Horizontal } else { StripeAxis::Vertical };
    let mut given_up = vec![];
    loop {
        let scenario = scenario(seed * 100_000 + number, kind, severity, axis, &mut rng);
        match Scene::new(&scenario, scenario.seed).map_or(Some(Unseen::PathTooLong), |scene| unseen(&scene)) {
            Some(reason) => given_up.push(reason),
            None => return Recording { number, kind, light, scenario, unseen: given_up },
        }
    }
}

/// Peak speed of the seam along the stripe \[px/frame\], without vibration.
pub fn peak_speed_px(scenario: &Scenario) -> f64 {
    let frames = scenario.frames as f64;
    let at = |tick: usize| scenario.path.iter().map(|term| term.at(tick as f64, frames)).sum::<f64>();
    (1..scenario.frames).map(|tick| (at(tick) - at(tick - 1)).abs()).fold(0.0, f64::max)
}

fn between(rng: &mut Pcg64Mcg, (low, high): (f64, f64)) -> f64 {
    rng.random_range(low..=high)
}

/// Every octave alike.
fn by_octave(rng: &mut Pcg64Mcg, (low, high): (f64, f64)) -> f64 {
    rng.random_range(low.ln()..=high.ln()).exp()
}

fn scenario(seed: u64, kind: &str, severity: Severity, axis: StripeAxis, rng: &mut Pcg64Mcg) -> Scenario {
    let width = by_octave(rng, WIDTHS_PX);
    let height = (width * between(rng, ASPECTS)).clamp(HEIGHTS_PX.0, HEIGHTS_PX.1);
    let mm = by_octave(rng, SCALES_MM_PER_PX);
    // Large pictures take long to render.
    let frames = match width * height {
        pixels if pixels < 0.5e6 => 120,
        pixels if pixels < 1.5e6 => 100,
        _ => 80,
    };
    let tilt_deg = between(rng, (-TILT_DEG, TILT_DEG));
    let size = width.min(height) / NOMINAL_SIDE_PX;
    let level = severity.disturbances();
    Scenario {
        description: format!("random sensor: a {kind} joint"),
        seed,
        frames,
        period_s: by_octave(rng, PERIODS_S),
        mm_per_px: MmPerPx::new(mm).unwrap_or(MmPerPx::DU_2022),
        variation: VARIATION,
        severity,
        arc_on_frame: 15,
        path: path(frames as f64, rng),
        height: vec![],
        joint: joint(kind, mm, tilt_deg, rng),
        edges: Edges { raggedness_px: (between(rng, RAGGEDNESS_MM) / mm).max(LEAST_RAGGEDNESS_PX), ..Edges::default() },
        extent: Default::default(),
        image: Image { width_px: width.round() as usize, height_px: height.round() as usize, stripe: axis },
        stripe: Stripe {
            sigma_px: by_octave(rng, STRIPES_PX),
            amplitude_grey: by_octave(rng, AMPLITUDES_GREY),
            speckle: between(rng, (0.2, 0.38)),
            reflectance: between(rng, (0.08, 0.22)),
            // A fillet's tilt is in its legs; its corner stays on a level line.
            tilt: if kind == "fillet" { 0.0 } else { tilt_deg.to_radians().tan() },
            ..Stripe::default()
        },
        sensor: Sensor { background_grey: between(rng, (3.0, 20.0)), gain: by_octave(rng, GAINS), ..Sensor::default() },
        vibration: Vibration { along_px: VIBRATION_MM.0 / mm, across_px: VIBRATION_MM.1 / mm, ..Vibration::default() },
        recorder: Default::default(),
        arc: None,
        spatter: Some(Spatter { length_px: size * level.spatter.length_px, thickness: size, ..level.spatter }),
        smoke: Some(Smoke { wisp_px: size * level.smoke.wisp_px, ..level.smoke }),
        covers: Some(Covers { half_width_px: size * level.covers.half_width_px, ..level.covers }),
        false_stripe: None,
        tacks: vec![],
        plates: Default::default(),
        change: Default::default(),
        rivals: Default::default(),
        view: Default::default(),
        camera: None,
        laser: None,
    }
}

/// A joint in millimetres, at a scale of `mm` per pixel. Depths are as they appear, across the stripe.
fn joint(kind: &str, mm: f64, tilt_deg: f64, rng: &mut Pcg64Mcg) -> Joint {
    let mut px = |range_mm: (f64, f64)| by_octave(rng, range_mm) / mm;
    match kind {
        "butt" => Joint::Butt(Butt {
            gap_px: Ramp::Constant(px((0.3, 4.0))),
            depth_px: px((0.5, 3.0)),
            hi_lo_px: Ramp::Constant(0.0),
            bent_edge_px: px((0.02, 0.25)).min(50.0),
            bent_length_px: px((0.4, 1.2)),
            floor_reflectance: between(rng, (0.0, 0.6)),
        }),
        "lap" => Joint::Lap(Lap {
            step_px: Ramp::Constant(px((1.0, 8.0))),
            shadow_px: px((0.1, 0.6)),
            glint: between(rng, (0.0, 0.5)),
            upper_on_right: false,
        }),
        "vgroove" => {
            let half_width_px = 0.5 * px((3.0, 25.0));
            let root_px = px((0.1, 1.5)).min(0.4 * half_width_px);
            Joint::Vgroove(Vgroove {
                half_width_px,
                depth_px: half_width_px * between(rng, (0.5, 1.2)),
                root_gap_px: Ramp::Constant(root_px),
                hi_lo_px: Ramp::Constant(0.0),
                flank_reflectance: between(rng, (0.45, 0.9)),
                right_half_width_px: None,
            })
        }
        _ => {
            let toe_px = px((0.2, 1.2));
            let leg_deg = (between(rng, (15.0, 45.0)), between(rng, (15.0, 45.0)));
            Joint::Fillet(Fillet {
                left_slope: (leg_deg.0 + tilt_deg).to_radians().tan(),
                right_slope: (tilt_deg - leg_deg.1).to_radians().tan(),
                toe_px,
                inner_reflection: between(rng, (0.0, 0.5)),
            })
        }
    }
}

/// A path that a torch might take: no faster than [`FASTEST_PX`], a sine turning by one radian in ten frames or more, a
/// corner no sharper than [`LARGEST_KINK_PX`].
fn path(frames: f64, rng: &mut Pcg64Mcg) -> Vec<PathTerm> {
    let speed_px = between(rng, (0.0, FASTEST_PX));
    vec![match rng.random_range(0..4) {
        0 => PathTerm::Straight { px_per_frame: if rng.random() { speed_px } else { -speed_px } },
        1 => {
            let period_frames = between(rng, (63.0, 160.0));
            PathTerm::Sine {
                amplitude_px: speed_px * period_frames / std::f64::consts::TAU,
                period_frames,
                phase_deg: between(rng, (0.0, 360.0)),
            }
        }
        2 => {
            // The fastest of a hyperbolic tangent is 1.472 times what nine tenths of the travel in that time make.
            let duration_frames = between(rng, (0.4 * frames, frames));
            PathTerm::SCurve { travel_px: speed_px * duration_frames / 1.472, duration_frames, centre: 0.5 }
        }
        _ => {
            let mut slope_px = speed_px;
            let pieces = rng.random_range(2..=4);
            let slopes = (0..pieces).map(|_| {
                let here = slope_px;
                slope_px = (slope_px + between(rng, (-LARGEST_KINK_PX, LARGEST_KINK_PX))).clamp(-speed_px, speed_px);
                here
            });
            PathTerm::Polyline { px_per_frame: slopes.collect() }
        }
    }]
}
