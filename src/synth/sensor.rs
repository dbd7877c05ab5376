//! From light to grey values: exposure, bloom, noise, quantisation.

use super::canvas::Canvas;
use super::noise::{Component, generator, normal};
use super::scenario::Sensor;
use crate::frame::GrayFrame;
use crate::units::StripeAxis;

/// Grey value at which a pixel is full.
const FULL_GREY: f32 = 255.0;
/// Light beyond which a pixel's overflow no longer grows \[grey\] (chosen: the electrons drain).
const OVERFLOW_LIMIT_GREY: f32 = 1500.0;
/// Side of the cells on which bloom spreads \[px\]; it reaches about two cells.
const BLOOM_CELL_PX: usize = 4;

/// Multiplies by gain and exposure and spreads the light above saturation.
pub(super) fn expose(sensor: &Sensor, exposure: f64, canvas: &mut Canvas) {
    let gain = (sensor.gain * exposure.max(0.1)) as f32;
    canvas.change(|_, _, value| *value *= gain);
    let (width, height) = (canvas.width_px(), canvas.height_px());
    let (columns, rows) = (width / BLOOM_CELL_PX + 2, height / BLOOM_CELL_PX + 2);
    let mut overflow = vec![0.0_f32; columns * rows];
    let mut any = false;
    for (row, line) in canvas.light().chunks_exact(width).enumerate() {
        for (column, &value) in line.iter().enumerate() {
            if value > FULL_GREY {
                any = true;
                let cell = (row / BLOOM_CELL_PX) * columns + column / BLOOM_CELL_PX;
                overflow[cell] += (value - FULL_GREY).min(OVERFLOW_LIMIT_GREY);
            }
        }
    }
    if !any || sensor.bloom <= 0.0 {
        return;
    }
    let share = sensor.bloom as f32 / (BLOOM_CELL_PX * BLOOM_CELL_PX) as f32;
    let blurred = blurred(&overflow, columns, rows);
    let at = |x: f64, y: f64| {
        // The grid's values belong to cell centres; the field is asked at cell corners.
        let (i, j) = (x as usize / BLOOM_CELL_PX, y as usize / BLOOM_CELL_PX);
        let cell = |i: usize, j: usize| blurred[j.min(rows - 1) * columns + i.min(columns - 1)];
        let (left, above) = (i.saturating_sub(1), j.saturating_sub(1));
        0.25 * share * (cell(left, above) + cell(i, above) + cell(left, j) + cell(i, j))
    };
    canvas.change_by_field(BLOOM_CELL_PX, at, |bloom, value| *value += bloom);
}

/// A separable 1-2-1 blur.
fn blurred(grid: &[f32], columns: usize, rows: usize) -> Vec<f32> {
    let at = |g: &[f32], i: usize, j: usize| g[j * columns + i];
    let mut along = vec![0.0; grid.len()];
    for j in 0..rows {
        for i in 0..columns {
            let (left, right) = (i.saturating_sub(1), (i + 1).min(columns - 1));
            along[j * columns + i] = 0.25 * (at(grid, left, j) + 2.0 * at(grid, i, j) + at(grid, right, j));
        }
    }
    let mut both = vec![0.0; grid.len()];
    for j in 0..rows {
        let (above, below) = (j.saturating_sub(1), (j + 1).min(rows - 1));
        for i in 0..columns {
            both[j * columns + i] = 0.25 * (at(&along, i, above) + 2.0 * at(&along, i, j) + at(&along, i, below));
        }
    }
    both
}

/// Reads the canvas out into an image whose stripe runs along `axis`.
///
/// # Errors
/// When the canvas has no pixel.
pub(super) fn read_out(
    sensor: &Sensor,
    axis: StripeAxis,
    seed: u64,
    tick: usize,
    canvas: &Canvas,
) -> Result<GrayFrame, crate::frame::FrameSizeError> {
    let (along, across) = (canvas.width_px(), canvas.height_px());
    let (width, height) = match axis {
        StripeAxis::Horizontal => (along, across),
        StripeAxis::Vertical => (across, along),
    };
    let mut fixed = generator(seed, 0, Component::FixedPattern);
    let columns: Vec<f32> = (0..width).map(|_| sensor.column_noise_grey as f32 * normal(&mut fixed)).collect();
    let mut rng = generator(seed, tick as u64, Component::Sensor);
    let (read2, shot) = ((sensor.read_noise_grey * sensor.read_noise_grey) as f32, sensor.shot_noise_grey as f32);
    let light = canvas.light();
    let mut pixels = Vec::with_capacity(width * height);
    for row in 0..height {
        for (column, offset) in columns.iter().enumerate() {
            let light = match axis {
                StripeAxis::Horizontal => light[row * along + column],
                StripeAxis::Vertical => light[column * along + row],
            };
            let deviation = (read2 + shot * light.clamp(0.0, FULL_GREY)).sqrt();
            let grey = light + offset + deviation * normal(&mut rng);
            pixels.push((grey + 0.5).clamp(0.0, FULL_GREY) as u8);
        }
    }
    GrayFrame::new(width, height, pixels)
}
