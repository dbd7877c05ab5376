//! The response map: its peak and its peak-to-sidelobe ratio.

use crate::lanes;
use crate::units::PixelPoint;

/// What the filter answers on one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// The peak in image coordinates, sub-pixel.
    pub peak: PixelPoint,
    /// The response at its highest pixel; 1 for the training patch itself.
    pub value: f32,
    /// Peak-to-sidelobe ratio (max − mean)/SD over the whole response (Du 2022, eq. 9).
    pub psr: f32,
    /// The PSR that an ideal response of this window and label has: [`psr_ceiling`].
    pub psr_ceiling: f32,
}

impl Response {
    /// PSR over its ceiling: comparable between windows and labels, unlike the raw value (METHOD: T = 8 is 0.57 here).
    #[must_use]
    pub fn psr_ratio(&self) -> f32 {
        self.psr / self.psr_ceiling
    }
}

/// The PSR of an ideal response, a Gaussian of SD `label_sd_px` in a window of `pixels`:
/// (1 − m)/√(π s²/N − m²) with m = 2π s²/N. Derived from eq. 9 of Du 2022.
#[must_use]
pub fn psr_ceiling(label_sd_px: f64, pixels: usize) -> f64 {
    let area = std::f64::consts::PI * label_sd_px * label_sd_px / pixels as f64;
    let mean = 2.0 * area;
    (1.0 - mean) / (area - mean * mean).sqrt()
}

/// The highest element of a wrapped response: signed shift along u and v \[px\], parabolic sub-pixel, and its value.
pub(super) fn peak_shift(response: &[f32], width: usize, height: usize) -> (f64, f64, f32) {
    let largest = lanes::largest(response);
    let best = response.iter().position(|&r| r == largest).unwrap_or(0);
    let (u, v) = (best % width, best / width);
    let at = |u: usize, v: usize| f64::from(response[v * width + u]);
    let du = parabola(at((u + width - 1) % width, v), at(u, v), at((u + 1) % width, v));
    let dv = parabola(at(u, (v + height - 1) % height), at(u, v), at(u, (v + 1) % height));
    let signed = |i: usize, n: usize| if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
    (signed(u, width) + du, signed(v, height) + dv, response[best])
}

/// Offset of a parabola's vertex from the middle of three samples, within half a sample.
fn parabola(left: f64, middle: f64, right: f64) -> f64 {
    let curvature = left - 2.0 * middle + right;
    if curvature > -1e-12 { 0.0 } else { (0.5 * (left - right) / curvature).clamp(-0.5, 0.5) }
}

/// (max − mean)/SD of the whole response.
pub(super) fn psr(response: &[f32], max: f32) -> f32 {
    let n = response.len() as f64;
    let mean = lanes::sum(response) / n;
    let variance = lanes::sum_of_squares_about(response, mean as f32) / n;
    let sd = variance.sqrt();
    if sd > 0.0 { ((f64::from(max) - mean) / sd) as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ceiling_of_an_ideal_response_is_the_one_of_the_method_note() {
        // ROI 80 x 60, label SD 0.1 sqrt(80*60), padding 1, 1.5, 2, 2.5; and SD 3.5 px at padding 2.5.
        let sd = 0.1 * 4800f64.sqrt();
        for (pixels, ceiling) in [(4800, 5.6), (10_800, 8.5), (19_200, 11.3), (30_000, 14.1)] {
            assert!((psr_ceiling(sd, pixels) - ceiling).abs() < 0.06, "{pixels}");
        }
        assert!((psr_ceiling(3.5, 30_000) - 28.0).abs() < 0.3);
    }

    #[test]
    fn the_psr_of_a_drawn_gaussian_label_reaches_its_ceiling() {
        let (width, height, sd) = (200usize, 150usize, 6.928);
        let wrapped = |i: usize, n: usize| i.min(n - i) as f64;
        let label: Vec<f32> = (0..width * height)
            .map(|i| {
                let (u, v) = (wrapped(i % width, width), wrapped(i / width, height));
                (-(u * u + v * v) / (2.0 * sd * sd)).exp() as f32
            })
            .collect();
        approx::assert_relative_eq!(f64::from(psr(&label, 1.0)), psr_ceiling(sd, width * height), max_relative = 1e-3);
    }

    #[test]
    fn a_flat_response_has_no_psr() {
        assert_eq!(psr(&[0.3; 64], 0.3), 0.0);
    }
}
