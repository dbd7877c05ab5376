//! Hot particles: streaks drawn by the exposure, and slow ones out of focus.

use rand::Rng;
use rand_distr::{Distribution, Exp1, Poisson};
use rand_pcg::Pcg64Mcg;

use super::canvas::Canvas;
use super::noise::{Component, generator, normal};
use super::scenario::Spatter;
use crate::units::PixelPoint;

/// A burst brings this many times the usual tracks, and at least so many (chosen).
const BURST_FACTOR: f64 = 3.0;
const BURST_TRACKS: f64 = 8.0;
/// Chance that a drop lands near the stripe in a frame of a burst, and how near (chosen).
const LANDING_CHANCE: f64 = 0.5;
const LANDING_SPREAD_PX: f32 = 110.0;
/// Scatter of the tracks' direction about the direction from the arc \[rad\] (chosen).
const DIRECTION_SD_RAD: f32 = 0.45;

/// Adds the particles of one frame that fly from the arc.
pub(super) fn add_spatter(
    spatter: &Spatter,
    burst: bool,
    arc: PixelPoint,
    seed: u64,
    tick: usize,
    canvas: &mut Canvas,
) {
    let mean = if burst { (BURST_FACTOR * spatter.tracks).max(BURST_TRACKS) } else { spatter.tracks };
    let Ok(poisson) = Poisson::new(mean) else {
        return; // mean 0: no particle
    };
    let mut rng = generator(seed, tick as u64, Component::Spatter);
    let count = poisson.sample(&mut rng) as usize;
    for _ in 0..count {
        let at = (rng.random_range(0.0..canvas.width_px() as f32), rng.random_range(0.0..canvas.height_px() as f32));
        let from_arc = (at.1 - arc.v_px as f32).atan2(at.0 - arc.u_px as f32);
        let direction = from_arc + DIRECTION_SD_RAD * normal(&mut rng);
        if rng.random::<f64>() < spatter.blobs {
            add_blob(at, direction, spatter.thickness as f32, &mut rng, canvas);
        } else {
            add_streak(at, direction, spatter, &mut rng, canvas);
        }
    }
    if burst && rng.random_bool(LANDING_CHANCE) {
        // A drop that lands beside the stripe still glows.
        let spread_px = spatter.thickness as f32 * LANDING_SPREAD_PX;
        let at = (
            arc.u_px as f32 + spread_px * normal(&mut rng),
            0.5 * canvas.height_px() as f32 + spread_px * normal(&mut rng),
        );
        add_blob(at, 0.0, spatter.thickness as f32, &mut rng, canvas);
    }
}

/// A straight, slightly bending streak: bright head, fading tail.
fn add_streak(head: (f32, f32), direction: f32, spatter: &Spatter, rng: &mut Pcg64Mcg, canvas: &mut Canvas) {
    let length_px = spatter.length_px as f32;
    let exponential: f32 = Exp1.sample(rng);
    let length = length_px * (0.25 + 0.75 * exponential).min(6.0);
    let sigma = spatter.thickness as f32 * rng.random_range(0.7..2.1_f32);
    let grey = 90.0
        + 220.0 * {
            let e: f32 = Exp1.sample(rng);
            e
        }
        .min(4.0);
    let bend = 0.15 * normal(rng) / length_px;
    let (sin, cos) = direction.sin_cos();
    let reach = 3.5 * sigma + 0.5 * bend.abs() * length * length;
    let tail = (head.0 - length * cos, head.1 - length * sin);
    let (x0, x1) = (head.0.min(tail.0) - reach, head.0.max(tail.0) + reach);
    let (y0, y1) = (head.1.min(tail.1) - reach, head.1.max(tail.1) + reach);
    for_each_pixel(canvas, (x0, x1), (y0, y1), |x, y| {
        let (dx, dy) = (x - head.0, y - head.1);
        let behind = -(dx * cos + dy * sin);
        let beside = dy * cos - dx * sin - 0.5 * bend * behind * behind;
        let past_end = (-behind).max(behind - length).max(0.0);
        let brightness = 1.0 - 0.75 * (behind / length).clamp(0.0, 1.0);
        grey * brightness * (-0.5 * (beside * beside + past_end * past_end) / (sigma * sigma)).exp()
    });
}

/// A particle out of focus: a disc with a brighter rim, drawn out a little by its motion.
fn add_blob(centre: (f32, f32), direction: f32, thickness: f32, rng: &mut Pcg64Mcg, canvas: &mut Canvas) {
    let radius = thickness * rng.random_range(1.5..7.0_f32);
    let stretch = rng.random_range(1.0..3.0_f32);
    let grey = 45.0
        + 120.0 * {
            let e: f32 = Exp1.sample(rng);
            e
        }
        .min(3.0);
    let rim = rng.random_range(0.0..0.8_f32);
    let (sin, cos) = direction.sin_cos();
    let reach = 1.3 * radius * stretch + 2.0;
    for_each_pixel(canvas, (centre.0 - reach, centre.0 + reach), (centre.1 - reach, centre.1 + reach), |x, y| {
        let (dx, dy) = (x - centre.0, y - centre.1);
        let along = (dx * cos + dy * sin) / stretch;
        let across = dy * cos - dx * sin;
        let r = (along * along + across * across).sqrt() / radius;
        let disc = 1.0 / (1.0 + ((r - 1.0) * 2.5 * radius).exp());
        grey * disc * (1.0 - rim + rim * r * r)
    });
}

fn for_each_pixel(canvas: &mut Canvas, x: (f32, f32), y: (f32, f32), light: impl Fn(f32, f32) -> f32) {
    let columns = (x.0.max(0.0) as i64)..=(x.1.min(canvas.width_px() as f32 - 1.0) as i64);
    for row in (y.0.max(0.0) as i64)..=(y.1.min(canvas.height_px() as f32 - 1.0) as i64) {
        for column in columns.clone() {
            canvas.add(column, row, light(column as f32, row as f32));
        }
    }
}
