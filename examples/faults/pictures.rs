//! Pictures without a seam, made up.

use anyhow::Result;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use seamtrack::frame::GrayFrame;
use seamtrack::synth::{Scene, builtin};

use crate::paint::blurred;

/// Columns and rows.
const WIDTH: usize = 480;
const HEIGHT: usize = 360;
/// How far what moves goes in a frame \[px\].
const SPEED_PX: f64 = 2.0;

/// The picture of each frame.
pub type Pictures = Box<dyn FnMut(usize) -> Result<GrayFrame>>;
/// Makes the pictures of one seed.
pub type Made = fn(u64) -> Result<Pictures>;

/// All kinds by what they show.
pub const KINDS: [(&str, Made); 21] = [
    ("noise", |seed| each(seed, |random, _, _| random.random())),
    ("noise, still", |seed| still(seed, noise(seed, WIDTH)?)),
    ("clouds, moving", |seed| panned(smoothed(seed, 12.0)?)),
    ("brushed metal, moving", |seed| panned(lines(seed, false)?)),
    ("rolled sheet, moving", |seed| panned(lines(seed, true)?)),
    ("photograph, still", |seed| still(seed, photograph(seed, WIDTH)?)),
    ("photograph, panned", |seed| panned(photograph(seed, 2 * WIDTH)?)),
    ("text, still", |seed| still(seed, text(seed, WIDTH)?)),
    ("text, panned", |seed| panned(text(seed, 2 * WIDTH)?)),
    ("black", |_| grey_all_over(0)),
    ("white", |_| grey_all_over(255)),
    ("black, with the sensor's noise", |seed| each(seed, |random, _, _| random.random_range(0..6))),
    ("checkerboard, panned", |_| panned(checkerboard()?)),
    ("edge of a shadow, moving", |seed| each(seed, |random, frame, (u, _)| shaded(random, frame, u, 120.0))),
    ("plain stripe", |seed| on_stripe(seed, |_, _, _| 1.0)),
    ("plain stripe, still", |seed| still(seed, stripe(seed)?.render(0))),
    ("stripe, the edge of a shadow in the room's light", in_room_light),
    ("stripe, dimmed to 0.3 beyond a moving edge", |seed| {
        on_stripe(seed, |frame, u, _| if (u as f64) < edge_px(frame) { 0.3 } else { 1.0 })
    }),
    ("stripe with a scratch, moving", |seed| on_stripe(seed, |frame, u, at| scratch(u, at + 0.5 * frame as f64))),
    ("stripe with a scratch, still", |seed| on_stripe(seed, |_, u, at| scratch(u, at))),
    ("two stripes, also crossing", two_stripes),
];

fn random(seed: u64, what: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed << 16 | what)
}

fn sized(width: usize, mut grey: impl FnMut(usize, usize) -> u8) -> Result<GrayFrame> {
    let pixels = (0..width * HEIGHT).map(|i| grey(i % width, i / width)).collect();
    Ok(GrayFrame::new(width, HEIGHT, pixels)?)
}

/// Every frame drawn anew, pixel by pixel.
fn each(seed: u64, grey: fn(&mut Pcg64Mcg, usize, (usize, usize)) -> u8) -> Result<Pictures> {
    Ok(Box::new(move |frame| {
        let mut random = random(seed, frame as u64);
        sized(WIDTH, |u, v| grey(&mut random, frame, (u, v)))
    }))
}

fn grey_all_over(grey: u8) -> Result<Pictures> {
    Ok(Box::new(move |_| sized(WIDTH, |_, _| grey)))
}

/// The same picture, but for the sensor's noise.
fn still(seed: u64, picture: GrayFrame) -> Result<Pictures> {
    Ok(Box::new(move |frame| {
        let mut random = random(seed, 1000 + frame as u64);
        let mut picture = picture.clone();
        picture.pixels_mut().iter_mut().for_each(|grey| *grey = grey.saturating_add(random.random_range(0..4)));
        Ok(picture)
    }))
}

/// A part of a wide picture, further to the right in each frame.
fn panned(wide: GrayFrame) -> Result<Pictures> {
    Ok(Box::new(move |frame| {
        let left = ((SPEED_PX * frame as f64) as usize).min(wide.width_px() - WIDTH);
        sized(WIDTH, |u, v| wide.row(v)[left + u])
    }))
}

fn noise(seed: u64, width: usize) -> Result<GrayFrame> {
    let mut random = random(seed, 1);
    sized(width, |_, _| random.random())
}

/// The picture with its darkest pixel black and its brightest one white.
fn stretched(mut picture: GrayFrame) -> GrayFrame {
    let (low, high) = picture.pixels().iter().fold((255, 0), |(low, high), &grey| (grey.min(low), grey.max(high)));
    let range = f64::from(high - low).max(1.0);
    picture.pixels_mut().iter_mut().for_each(|grey| *grey = (255.0 * f64::from(*grey - low) / range) as u8);
    picture
}

fn smoothed(seed: u64, sd_px: f64) -> Result<GrayFrame> {
    Ok(stretched(blurred(&stretched(blurred(&noise(seed, 2 * WIDTH)?, sd_px / 2.0)?), sd_px)?))
}

/// Fine lines along the rows or along the columns, ragged and uneven.
fn lines(seed: u64, along_rows: bool) -> Result<GrayFrame> {
    let (mut random, clouds) = (random(seed, 2), smoothed(seed, 20.0)?);
    let count = if along_rows { HEIGHT } else { 2 * WIDTH };
    let strengths: Vec<f64> = (0..count).map(|_| random.random_range(20.0..230.0)).collect();
    let noise = noise(seed + 1, 2 * WIDTH)?;
    let picture = sized(2 * WIDTH, |u, v| {
        let strength = strengths[if along_rows { v } else { u }];
        let (cloud, noise) = (f64::from(clouds.row(v)[u]) / 255.0, f64::from(noise.row(v)[u]) / 255.0);
        (strength * (0.4 + 0.6 * cloud) + 25.0 * noise).min(255.0) as u8
    })?;
    blurred(&picture, 1.0)
}

/// Shaded things one before another, out of focus and not.
fn photograph(seed: u64, width: usize) -> Result<GrayFrame> {
    let mut random = random(seed, 3);
    let mut picture = sized(width, |u, v| (60 + 80 * u / width + 60 * v / HEIGHT) as u8)?;
    for thing in 0..40 {
        let (middle_u, middle_v) = (random.random_range(0.0..width as f64), random.random_range(0.0..HEIGHT as f64));
        let (half_u, half_v) = (random.random_range(4.0..90.0), random.random_range(4.0..90.0));
        let (turn, round): (f64, bool) = (random.random_range(0.0..3.2), random.random());
        let (grey, shade): (f64, f64) = (random.random_range(10.0..245.0), random.random_range(-60.0..60.0));
        let (sin, cos) = turn.sin_cos();
        for (i, pixel) in picture.pixels_mut().iter_mut().enumerate() {
            let (du, dv) = ((i % width) as f64 - middle_u, (i / width) as f64 - middle_v);
            let (x, y) = ((cos * du + sin * dv) / half_u, (cos * dv - sin * du) / half_v);
            let inside = if round { x * x + y * y < 1.0 } else { x.abs() < 1.0 && y.abs() < 1.0 };
            if inside {
                *pixel = (grey + shade * x).clamp(0.0, 255.0) as u8;
            }
        }
        if thing % 10 == 9 {
            picture = blurred(&picture, 1.5)?;
        }
    }
    Ok(picture)
}

/// Lines of letters, dark on light or light on dark.
fn text(seed: u64, width: usize) -> Result<GrayFrame> {
    // A letter is a pattern of 5 x 7 cells.
    let mut random = random(seed, 4);
    let alphabet: Vec<[u8; 7]> = (0..26).map(|_| std::array::from_fn(|_| random.random_range(1..32))).collect();
    let cell = random.random_range(1..4);
    let (paper, ink) = if random.random() { (230, 20) } else { (15, 240) };
    let mut page = vec![paper; width * HEIGHT];
    let (step_u, step_v) = (6 * cell, 11 * cell);
    for (row, line) in (step_v..HEIGHT - step_v).step_by(step_v).enumerate() {
        for column in (10..width.saturating_sub(step_u + 10)).step_by(step_u) {
            let is_space = random.random_range(0..6) == 0;
            let letter = alphabet[random.random_range(0..alphabet.len())];
            if is_space || row % 9 == 8 {
                continue;
            }
            for (v, u) in (0..7 * cell).flat_map(|v| (0..5 * cell).map(move |u| (v, u))) {
                if letter[v / cell] >> (u / cell) & 1 == 1 {
                    page[(line + v) * width + column + u] = ink;
                }
            }
        }
    }
    blurred(&GrayFrame::new(width, HEIGHT, page)?, 0.8)
}

fn checkerboard() -> Result<GrayFrame> {
    sized(2 * WIDTH, |u, v| if (u / 30 + v / 30) % 2 == 0 { 30 } else { 220 })
}

/// Where a shadow's edge is.
fn edge_px(frame: usize) -> f64 {
    60.0 + SPEED_PX * 3.0 * frame as f64
}

/// A surface of this grey, in the shadow to the left of the edge.
fn shaded(random: &mut Pcg64Mcg, frame: usize, u: usize, grey: f64) -> u8 {
    let soft = 1.0 / (1.0 + (-(u as f64 - edge_px(frame)) / 4.0).exp());
    (grey * (0.25 + 0.75 * soft) + random.random_range(0.0..6.0)) as u8
}

/// A plate without a joint under the laser.
fn stripe(seed: u64) -> Result<Scene> {
    let mut scenario = builtin::scenario("flat")?;
    (scenario.image.width_px, scenario.image.height_px) = (WIDTH, HEIGHT);
    Ok(Scene::new(&scenario, seed)?)
}

/// That plate in a light of the room that does not reach beyond an edge.
fn in_room_light(seed: u64) -> Result<Pictures> {
    let scene = stripe(seed)?;
    Ok(Box::new(move |frame| {
        let mut random = random(seed, frame as u64);
        let mut picture = scene.render(frame);
        for (i, grey) in picture.pixels_mut().iter_mut().enumerate() {
            *grey = grey.saturating_add(shaded(&mut random, frame, i % WIDTH, 60.0));
        }
        Ok(picture)
    }))
}

/// That plate, its light times a factor of frame, column and a random column.
fn on_stripe(seed: u64, factor: fn(usize, usize, f64) -> f64) -> Result<Pictures> {
    let scene = stripe(seed)?;
    let at = random(seed, 5).random_range(100.0..WIDTH as f64 - 100.0);
    Ok(Box::new(move |frame| {
        let mut picture = scene.render(frame);
        for (i, grey) in picture.pixels_mut().iter_mut().enumerate() {
            *grey = (f64::from(*grey) * factor(frame, i % WIDTH, at)) as u8;
        }
        Ok(picture)
    }))
}

/// How much light a scratch of some 3 px leaves.
fn scratch(u: usize, at_px: f64) -> f64 {
    1.0 - 0.85 * (-0.5 * ((u as f64 - at_px) / 1.4).powi(2)).exp()
}

/// A second stripe over the first: parallel for even seeds, else crossing it.
fn two_stripes(seed: u64) -> Result<Pictures> {
    let scene = stripe(seed)?;
    Ok(Box::new(move |frame| {
        let one = scene.render(frame);
        let slope = if seed.is_multiple_of(2) { 0.0 } else { 0.35 };
        let below = if seed.is_multiple_of(2) { 70.0 } else { 0.0 };
        sized(WIDTH, |u, v| {
            let moved = v as f64 - below - slope * (u as f64 - WIDTH as f64 / 2.0);
            one.row(v)[u].max(one.at_clamped(u as isize, moved.round() as isize))
        })
    }))
}
