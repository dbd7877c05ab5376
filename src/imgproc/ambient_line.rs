//! The joint in ambient light: a faint dark or bright line that crosses the stripe's line at the seam (docs/method.md §6).
//!
//! A second witness while no arc burns. The same contrast must show on both sides of the stripe.

use super::box_filter::{Contrast, RunningSums};
use super::notch::robust_scale;
use super::rectify::Band;
use crate::frame::GrayFrame;

/// Rows read on each side of the stripe: from this distance, to this, in steps of \[px\] (prototype, every second row).
const NEAR_PX: isize = 15;
const FAR_PX: isize = 60;
const ROW_STEP_PX: usize = 3;
const ROWS_A_SIDE: usize = ((FAR_PX - NEAR_PX) as usize).div_ceil(ROW_STEP_PX);
/// Slopes tried: columns a row, from −0.6 to 0.6 (prototype).
const SLOPES: i32 = 10;
const SLOPE_STEP: f64 = 0.06;
/// The line is about 3 px wide (prototype).
const LINE: Contrast = Contrast { centre: 1, guard: 3, outer: 8 };
/// Brighter pixels are stripe or spatter \[grey\]; a pixel counts for at most so many robust deviations (prototype).
const GREY_CAP: u8 = 120;
const Z_LIMIT: f32 = 3.0;

/// Looks for the line; owns its buffers.
#[derive(Debug, Clone, Default)]
pub struct AmbientLine {
    sums: RunningSums,
    /// Contrast of the rows above, then below, the nearest first; in robust deviations.
    contrast: Vec<f32>,
    sample: Vec<f32>,
    sides: [Vec<f32>; 2],
    score: Vec<f32>,
}

impl AmbientLine {
    /// One score a column: the mean contrast, in robust deviations, of the best line through that column that shows on
    /// both sides with the same sign. About 0.3 on plain plates, above 1 on a visible joint.
    pub fn score(&mut self, frame: &GrayFrame, band: &Band) -> &[f32] {
        let width = frame.width_px();
        self.fill_contrast(frame, band);
        self.score.clear();
        self.score.resize(width, 0.0);
        for k in -SLOPES..=SLOPES {
            let slope = f64::from(k) * SLOPE_STEP;
            for (side, mean) in self.sides.iter_mut().enumerate() {
                mean.clear();
                mean.resize(width, 0.0);
                for i in 0..ROWS_A_SIDE {
                    let row = side * ROWS_A_SIDE + i;
                    let shift = (slope * offset_px(side, i) as f64).round() as isize;
                    add_shifted(mean, &self.contrast[row * width..(row + 1) * width], shift);
                }
            }
            for ((score, above), below) in self.score.iter_mut().zip(&self.sides[0]).zip(&self.sides[1]) {
                *score = score.max(above.min(*below)).max((-above).min(-below));
            }
        }
        for score in &mut self.score {
            *score /= ROWS_A_SIDE as f32;
        }
        &self.score
    }

    fn fill_contrast(&mut self, frame: &GrayFrame, band: &Band) {
        let (width, last) = (frame.width_px(), frame.height_px() as isize - 1);
        self.contrast.clear();
        for side in 0..2 {
            for i in 0..ROWS_A_SIDE {
                let offset = offset_px(side, i);
                // Outside the frame there is nothing to see.
                let grey = |u: usize| {
                    let v = band.line.v_px(u as f64).round() as isize + offset;
                    if (0..=last).contains(&v) { f32::from(frame.row(v as usize)[u].min(GREY_CAP)) } else { 0.0 }
                };
                self.sums.load((0..width).map(grey));
                self.contrast.extend((0..width).map(|u| self.sums.contrast(u, LINE)));
            }
        }
        self.sample.clear();
        self.sample.extend(self.contrast.iter().step_by(7));
        let (_, sd) = robust_scale(&mut self.sample);
        for value in &mut self.contrast {
            *value = (*value / (sd + 0.1)).clamp(-Z_LIMIT, Z_LIMIT);
        }
    }
}

/// Distance of row `i` of a side from the stripe's line \[px\].
const fn offset_px(side: usize, i: usize) -> isize {
    let distance = NEAR_PX + (i * ROW_STEP_PX) as isize;
    if side == 0 { -distance } else { distance }
}

/// `sum[u] += row[u + shift]` where it exists.
fn add_shifted(sum: &mut [f32], row: &[f32], shift: isize) {
    let by = shift.unsigned_abs().min(row.len());
    let kept = row.len() - by;
    let (sum, row) = if shift >= 0 { (&mut sum[..kept], &row[by..]) } else { (&mut sum[by..], &row[..kept]) };
    for (s, r) in sum.iter_mut().zip(row) {
        *s += r;
    }
}

#[cfg(test)]
mod tests {
    use super::super::rectify::StripeRectifier;
    use super::*;

    #[test]
    fn a_faint_slanted_line_on_both_sides_points_to_where_it_crosses_the_stripe() {
        let (width, height) = (300_usize, 200);
        let pixels = (0..width * height)
            .map(|i| {
                let (u, v) = ((i % width) as f64, (i / width) as f64);
                let plate = 40.0 + 3.0 * ((i * 7919 % 101) as f64 / 101.0 - 0.5);
                let line = -4.0 * (-0.5 * ((u - 140.0 - 0.3 * (v - 100.0)) / 1.2).powi(2)).exp();
                (plate + line + 210.0 * (-0.5 * ((v - 100.0) / 2.4).powi(2)).exp()).round() as u8
            })
            .collect();
        let frame = GrayFrame::new(width, height, pixels).unwrap();
        let mut rectifier = StripeRectifier::default();
        let band = rectifier.rectify(&frame).unwrap().clone();
        let score = AmbientLine::default().score(&frame, &band).to_vec();
        let best = (0..width).fold(0, |best, u| if score[u] > score[best] { u } else { best });
        assert!(best.abs_diff(140) <= 2 && score[best] > 1.0, "{best}: {}", score[best]);
    }
}
