//! The numbers of a scenario drawn afresh for a seed.

use rand::Rng;

use super::noise::{Component, generator};
use super::scenario::{Disturbances, Joint, PathTerm, Ramp, Scenario, Side};

/// A scenario with this seed's own numbers, and what a scenario leaves to the seed.
#[derive(Debug, Clone)]
pub(super) struct Drawn {
    /// The scenario, its numbers varied.
    pub(super) scenario: Scenario,
    /// Its disturbances, varied, the arc's side decided.
    pub(super) disturbances: Disturbances,
    /// Where the middle of the path lies along the stripe, as an offset from the image's middle, −1 to 1.
    pub(super) along_offset: f64,
    /// The same across the stripe.
    pub(super) across_offset: f64,
    /// Brightness of the left and right plate relative to the stripe's amplitude.
    pub(super) plate_gains: [f64; 2],
}

/// How much the plates' brightness differs from seed to seed, as a multiple of the scenario's variation. Chosen: real
/// plates differ by a third.
const PLATE_GAIN_VARIATION: f64 = 1.2;

/// How much a bead differs from seed to seed in its groove, relative to everything else (chosen: a welder fills the
/// groove that is there).
const BEAD_VARIATION: f64 = 0.4;

/// Draws the numbers of a seed.
pub(super) fn drawn(scenario: &Scenario, seed: u64) -> Drawn {
    let mut rng = generator(seed, 0, Component::Variation);
    let variation = scenario.variation;
    let varied = variation > 0.0;
    let mut signed = || rng.random_range(-1.0..=1.0);
    let along_offset = if varied { signed() } else { 0.0 };
    let across_offset = if varied { signed() } else { 0.0 };
    let mut plate_gains = [signed(), signed()].map(|x| 1.0 + PLATE_GAIN_VARIATION * variation * x);
    let path_sign = if varied && signed() < 0.0 { -1.0 } else { 1.0 };
    let tilt_sign = if varied && signed() < 0.0 { -1.0 } else { 1.0 };
    let mirrored = varied && signed() < 0.0;
    let side_choice = signed();
    let mut factor = || 1.0 + variation * signed();

    let mut s = scenario.clone();
    for term in &mut s.path {
        vary_term(term, path_sign, &mut factor);
    }
    for term in &mut s.height {
        vary_term(term, 1.0, &mut factor);
    }
    let mut used = Vec::new();
    let mut remembered = || {
        let drawn = factor();
        used.push(drawn);
        drawn
    };
    vary_joint(&mut s.joint, mirrored, &mut remembered);
    if let Some(change) = &mut s.change {
        // The same factors: only what the scenario changes, changes.
        let mut again = used.iter().copied().cycle();
        vary_joint(&mut change.joint, mirrored, &mut || again.next().unwrap_or(1.0));
    }
    for tack in &mut s.tacks {
        tack.height_px *= factor();
        tack.half_width_px *= factor();
    }
    s.edges.raggedness_px *= factor();
    s.stripe.sigma_px *= factor();
    // Amplitudes vary by half as much: 185 to 215 about 200.
    s.stripe.amplitude_grey *= 0.5 + 0.5 * factor();
    s.stripe.speckle *= factor();
    s.stripe.reflectance *= factor();
    s.stripe.tilt *= tilt_sign * factor();
    s.stripe.sag_px *= factor();
    s.sensor.background_grey *= factor();
    s.sensor.read_noise_grey *= factor();
    s.vibration.along_px *= factor();
    s.vibration.across_px *= factor();
    if let Some(stripe) = &mut s.false_stripe {
        stripe.offset_px *= factor();
        stripe.shift_px *= factor();
        stripe.strength = (stripe.strength * factor()).min(1.0);
    }
    let mut d = scenario.disturbances();
    d.arc.glare_grey *= factor();
    d.arc.flicker *= factor();
    d.arc.reach *= factor();
    d.spatter.tracks *= factor();
    d.spatter.burst_share = (d.spatter.burst_share * factor()).min(0.95);
    d.spatter.length_px *= factor();
    d.smoke.share = (d.smoke.share * factor()).min(0.95);
    d.smoke.opacity = (d.smoke.opacity * factor()).min(0.95);
    d.smoke.wisp_px *= factor();
    if d.arc.side == Side::Any {
        // The arc mostly sits behind or before the stripe, seldom at its end.
        let horizontal = scenario.image.stripe == crate::units::StripeAxis::Horizontal;
        let (behind, before, one_end, other_end) = if horizontal {
            (Side::Bottom, Side::Top, Side::Left, Side::Right)
        } else {
            (Side::Right, Side::Left, Side::Top, Side::Bottom)
        };
        d.arc.side = match side_choice {
            x if x < -0.2 => behind,
            x if x < 0.5 => before,
            x if x < 0.75 => one_end,
            _ => other_end,
        };
    }
    // Of a V-groove these are its width's and its depth's: its beads fit it.
    let groove = [used.first(), used.get(1)].map(|factor| factor.copied().unwrap_or(1.0));
    vary_plates(&mut s, groove, &mut factor);
    plate_gains[0] *= s.plates.finish.left_brightness;
    plate_gains[1] *= s.plates.finish.right_brightness;
    Drawn { scenario: s, disturbances: d, along_offset, across_offset, plate_gains }
}

/// What was added to the scenario later is drawn last, so that older scenes keep their numbers.
fn vary_plates(s: &mut Scenario, [width, depth]: [f64; 2], factor: &mut impl FnMut() -> f64) {
    for marks in &mut s.plates.marks {
        marks.reflectance *= factor();
        marks.relief_px *= factor();
        marks.beside_px *= factor();
    }
    for bead in &mut s.plates.beads {
        let mut own = || 1.0 + BEAD_VARIATION * (factor() - 1.0);
        bead.beside_px *= width * own();
        bead.half_width_px *= width * own();
        bead.top_px *= depth * own();
        bead.crown_px *= depth * own();
        bead.brightness *= factor();
    }
    for reflection in &mut s.rivals.reflections {
        reflection.below_px *= factor();
        reflection.slope *= factor();
        reflection.strength *= factor();
    }
    for stripe in &mut s.rivals.stripes {
        stripe.below_px *= factor();
        stripe.brightness *= factor();
    }
}

fn vary_term(term: &mut PathTerm, sign: f64, factor: &mut impl FnMut() -> f64) {
    match term {
        PathTerm::Straight { px_per_frame } => *px_per_frame *= sign,
        PathTerm::Polyline { px_per_frame } => px_per_frame.iter_mut().for_each(|slope| *slope *= sign * factor()),
        PathTerm::Sine { amplitude_px, period_frames, phase_deg } => {
            *amplitude_px *= sign * factor();
            *period_frames *= factor();
            *phase_deg += 360.0 * (factor() - 1.0);
        }
        PathTerm::SCurve { travel_px, duration_frames, centre } => {
            *travel_px *= sign * factor();
            *duration_frames *= factor();
            *centre *= factor();
        }
    }
}

fn vary_joint(joint: &mut Joint, mirrored: bool, factor: &mut impl FnMut() -> f64) {
    let ramp = |course: &mut Ramp, factor: f64| *course = course.scaled(factor);
    match joint {
        Joint::Butt(j) => {
            ramp(&mut j.gap_px, factor());
            j.depth_px *= factor();
            ramp(&mut j.hi_lo_px, factor());
            j.bent_edge_px *= factor();
            // The floor is the least certain number of all: twice the variation.
            j.floor_reflectance *= 2.0 * factor() - 1.0;
        }
        Joint::Lap(j) => {
            ramp(&mut j.step_px, factor());
            j.shadow_px *= factor();
            j.glint *= factor();
            j.upper_on_right ^= mirrored;
        }
        Joint::Vgroove(j) => {
            let width = factor();
            j.half_width_px *= width;
            j.right_half_width_px = j.right_half_width_px.map(|px| px * width);
            j.depth_px *= factor();
            ramp(&mut j.root_gap_px, factor());
            ramp(&mut j.hi_lo_px, factor());
            j.flank_reflectance *= factor();
        }
        Joint::Fillet(j) => {
            j.left_slope *= factor();
            j.right_slope *= factor();
            j.toe_px *= factor();
            j.inner_reflection *= factor();
        }
        Joint::Hairline(j) => {
            j.width_px *= factor();
            j.dip *= factor();
            j.bump_px *= factor();
            j.step *= factor();
            j.ambient_line_grey *= factor();
            j.travel_px_per_frame *= factor();
        }
        Joint::Flat => {}
    }
}
