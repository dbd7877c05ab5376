//! What faults do to a picture.

use anyhow::Result;
use seamtrack::frame::GrayFrame;
use seamtrack::units::{PixelPoint, StripeAxis};

/// All light times `gain`, as far as the sensor goes.
pub fn brightened(frame: &GrayFrame, gain: f64) -> GrayFrame {
    let mut bright = frame.clone();
    bright.pixels_mut().iter_mut().for_each(|grey| *grey = (gain * f64::from(*grey)).round().min(255.0) as u8);
    bright
}

/// One grey all over.
pub fn filled(frame: &GrayFrame, grey: u8) -> Result<GrayFrame> {
    Ok(GrayFrame::filled(frame.width_px(), frame.height_px(), grey)?)
}

/// Without its last columns.
pub fn cropped(frame: &GrayFrame, columns: usize) -> Result<GrayFrame> {
    let width = frame.width_px() - columns;
    let pixels = (0..frame.height_px()).flat_map(|v| frame.row(v)[..width].iter().copied()).collect();
    Ok(GrayFrame::new(width, frame.height_px(), pixels)?)
}

/// From row `cut` on the rows of `rest`.
pub fn torn(frame: &GrayFrame, cut: usize, rest: &GrayFrame) -> GrayFrame {
    let mut torn = frame.clone();
    let from = cut * frame.width_px();
    torn.pixels_mut()[from..].copy_from_slice(&rest.pixels()[from..]);
    torn
}

/// Blurred by a Gaussian of this SD \[px\], as three boxes.
pub fn blurred(frame: &GrayFrame, sd_px: f64) -> Result<GrayFrame> {
    // Three boxes of half-width r have the variance r (r + 1).
    let radius = (((1.0 + 4.0 * sd_px * sd_px).sqrt() - 1.0) / 2.0).round().max(1.0) as isize;
    let (width, height) = (frame.width_px(), frame.height_px());
    let mut light: Vec<f32> = frame.pixels().iter().map(|&grey| f32::from(grey)).collect();
    for _ in 0..3 {
        light = boxed(&light, width, height, radius);
    }
    let pixels = light.into_iter().map(|light| (light + 0.5).clamp(0.0, 255.0) as u8).collect();
    Ok(GrayFrame::new(width, height, pixels)?)
}

/// The mean over a square.
fn boxed(light: &[f32], width: usize, height: usize, radius: isize) -> Vec<f32> {
    let mean = |count: usize, at: &dyn Fn(usize) -> f32, out: &mut dyn FnMut(usize, f32)| {
        let place = |i: isize| i.clamp(0, count as isize - 1) as usize;
        let mut sum: f32 = (-radius..=radius).map(|i| at(place(i))).sum();
        for i in 0..count as isize {
            out(i as usize, sum / (2 * radius + 1) as f32);
            sum += at(place(i + radius + 1)) - at(place(i - radius));
        }
    };
    let mut along = vec![0.0; light.len()];
    for v in 0..height {
        mean(width, &|u| light[v * width + u], &mut |u, value| along[v * width + u] = value);
    }
    let mut both = vec![0.0; light.len()];
    for u in 0..width {
        mean(height, &|v| along[v * width + u], &mut |v, value| both[v * width + u] = value);
    }
    both
}

/// A thing before the seam: `half_px` to each side along the stripe, all across it.
pub fn covered(frame: &GrayFrame, axis: StripeAxis, middle: PixelPoint, half_px: f64, grey: u8) -> GrayFrame {
    let mut covered = frame.clone();
    let width = frame.width_px();
    for (i, pixel) in covered.pixels_mut().iter_mut().enumerate() {
        let point = PixelPoint::new((i % width) as f64, (i / width) as f64);
        if (axis.along_px(point) - axis.along_px(middle)).abs() <= half_px {
            // A surface is not one grey.
            *pixel = grey.saturating_add((i * 7919 % 5) as u8);
        }
    }
    covered
}
