//! The seam's own look on the log band, learned while tracking (docs/method.md §6.4).
//!
//! With the mean look `t` at the seam, zero mean elsewhere, and the band's variance per row the same in both places,
//! the log likelihood ratio of a patch `x` is linear (Fisher's discriminant): `tᵀΣ⁻¹x − ½ tᵀΣ⁻¹t`.

use super::box_filter::RunningSums;
use super::rectify::Band;

/// Half size of the template along and across the stripe \[px\]: 15 × 21 (docs/method.md §6.4).
const HALF_ALONG_PX: usize = 7;
const HALF_ACROSS_PX: isize = 10;
const ALONG: usize = 2 * HALF_ALONG_PX + 1;
const ACROSS: usize = 2 * HALF_ACROSS_PX as usize + 1;
/// Grey added before the logarithm (prototype), half width of the local mean taken off \[px\], and the largest value.
const FLOOR_GREY: f32 = 10.0;
const LOCAL_HALF_PX: usize = 20;
const LOG_LIMIT: f32 = 1.5;
/// Least variance of a row: a dark row must not weigh without limit.
const VARIANCE_FLOOR: f32 = 0.02;
/// Learning rate (docs/method.md §6.4), and the first patches' mean, shrunk towards no look at all.
const RATE: f32 = 0.06;
const SHRINK_FRAMES: f32 = 3.0;
/// Neighbouring pixels are correlated: about one in seven counts (prototype).
const INDEPENDENT_SHARE: f32 = 0.15;

/// The learned template with its buffers.
#[derive(Debug, Clone)]
pub struct NotchTemplate {
    look: Vec<f32>,
    learned_frames: u32,
    /// `ACROSS` rows of the log band, local mean taken off.
    log_band: Vec<f32>,
    variance: [f32; ACROSS],
    background: Vec<f32>,
    sums: RunningSums,
    log_ratio: Vec<f32>,
}

impl Default for NotchTemplate {
    fn default() -> Self {
        Self {
            look: vec![0.0; ACROSS * ALONG],
            learned_frames: 0,
            log_band: Vec::new(),
            variance: [1.0; ACROSS],
            background: Vec::new(),
            sums: RunningSums::default(),
            log_ratio: Vec::new(),
        }
    }
}

impl NotchTemplate {
    /// Log likelihood ratio a column \[nats\] of the learned look; all zero before anything was learned.
    pub fn log_ratio(&mut self, band: &Band) -> &[f32] {
        self.fill_log_band(band);
        let width = band.width_px();
        self.log_ratio.clear();
        self.log_ratio.resize(width, 0.0);
        if self.learned_frames == 0 || width < ALONG {
            return &self.log_ratio;
        }
        let mut self_match = 0.0;
        for row in 0..ACROSS {
            let pixels = &self.log_band[row * width..(row + 1) * width];
            for (i, &look) in self.look[row * ALONG..(row + 1) * ALONG].iter().enumerate() {
                let weight = INDEPENDENT_SHARE * look / self.variance[row];
                self_match += weight * look;
                let out = &mut self.log_ratio[HALF_ALONG_PX..width - HALF_ALONG_PX];
                for (o, pixel) in out.iter_mut().zip(&pixels[i..]) {
                    *o += weight * pixel;
                }
            }
        }
        for value in &mut self.log_ratio {
            *value -= 0.5 * self_match;
        }
        &self.log_ratio
    }

    /// Learns the look at `u_px` of the band last given to [`Self::log_ratio`]. Columns outside the frame count as plain.
    pub fn learn(&mut self, u_px: f64) {
        let width = self.background.len();
        self.learned_frames += 1;
        let rate = RATE.max(1.0 / (self.learned_frames as f32 + SHRINK_FRAMES));
        let (first, part) = (u_px.floor() as isize - HALF_ALONG_PX as isize, (u_px - u_px.floor()) as f32);
        for row in 0..ACROSS {
            let pixels = &self.log_band[row * width..(row + 1) * width];
            let at = |u: isize| usize::try_from(u).ok().and_then(|u| pixels.get(u)).copied().unwrap_or(0.0);
            for (i, look) in self.look[row * ALONG..(row + 1) * ALONG].iter_mut().enumerate() {
                let u = first + i as isize;
                let pixel = at(u) + part * (at(u + 1) - at(u));
                *look += rate * (pixel - *look);
            }
        }
    }

    /// Forgets everything: another seam has another look.
    pub fn forget(&mut self) {
        self.look.fill(0.0);
        self.learned_frames = 0;
    }

    fn fill_log_band(&mut self, band: &Band) {
        let width = band.width_px();
        band.fill_background(&mut self.background, &mut self.sums);
        self.log_band.resize(ACROSS * width, 0.0);
        for (row, out) in self.log_band.chunks_exact_mut(width).enumerate() {
            let grey = band.row(row as isize - HALF_ACROSS_PX);
            for ((o, g), background) in out.iter_mut().zip(grey).zip(&self.background) {
                *o = ((g - background).max(0.0) + FLOOR_GREY).ln();
            }
            self.sums.load(out.iter().copied());
            for (u, o) in out.iter_mut().enumerate() {
                *o = (*o - self.sums.mean(u, LOCAL_HALF_PX)).clamp(-LOG_LIMIT, LOG_LIMIT);
            }
            let inside = &out[band.inside.clone()];
            let n = inside.len().max(1) as f32;
            let mean = inside.iter().sum::<f32>() / n;
            self.variance[row] = inside.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / n + VARIANCE_FLOOR;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rectify::StripeRectifier;
    use super::*;
    use crate::frame::GrayFrame;

    /// A stripe with a speckle of its own in each frame and a notch at `notch`.
    fn frame(number: usize, notch: usize) -> GrayFrame {
        let (width, height) = (300, 80);
        let pixels = (0..width * height)
            .map(|i| {
                let (u, v) = (i % width, i / width);
                let speckle = 0.6 + 0.8 * ((i * 7919 + number * 104_729) % 211) as f64 / 211.0;
                let light = if u.abs_diff(notch) <= 1 { 0.4 } else { 1.0 };
                (20.0 + 200.0 * light * speckle * (-0.5 * ((v as f64 - 40.0) / 2.4).powi(2)).exp()) as u8
            })
            .collect();
        GrayFrame::new(width, height, pixels).unwrap()
    }

    #[test]
    fn a_learned_look_is_recognised_at_another_place_and_forgotten_on_demand() {
        let (mut rectifier, mut template) = (StripeRectifier::default(), NotchTemplate::default());
        for number in 0..20 {
            let band = rectifier.rectify(&frame(number, 120)).unwrap();
            template.log_ratio(band);
            template.learn(120.0);
        }
        let log_ratio = template.log_ratio(rectifier.rectify(&frame(77, 200)).unwrap()).to_vec();
        let best = (0..300).fold(0, |best, u| if log_ratio[u] > log_ratio[best] { u } else { best });
        assert!(best.abs_diff(200) <= 1 && log_ratio[best] > 1.0, "{best}: {}", log_ratio[best]);
        template.forget();
        assert!(template.log_ratio(rectifier.rectify(&frame(78, 200)).unwrap()).iter().all(|&x| x == 0.0));
    }
}
