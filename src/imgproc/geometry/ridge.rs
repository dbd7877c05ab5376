//! The stripe's ridge along a predicted line, column by column, by a matched filter across the stripe.

use std::ops::Range;

use arrayvec::ArrayVec;

use crate::frame::GrayFrame;
use crate::imgproc::Pixels;
use crate::lanes::exp_of_negative;

/// What one column shows near its predicted row.
#[derive(Debug, Clone, Copy)]
pub struct RidgePoint {
    /// Column \[px\].
    pub u_px: f64,
    /// Row of the ridge \[px\], sub-pixel.
    pub v_px: f64,
    /// Normalised correlation with the stripe's cross-section, −1 to 1.
    pub quality: f64,
    /// Response of the unit-norm zero-mean matched filter \[grey\].
    pub amplitude: f64,
    /// The column's background is glare: the sensor is full, and little is to be seen.
    pub has_glare: bool,
}

/// Most reach of a cross-section \[px\]. Chosen: stripes of SD 6 px have 16.
const MOST_REACH: usize = 32;

/// The zero-mean Gaussian cross-section of unit norm.
pub struct CrossSection {
    weights: ArrayVec<f32, { 2 * MOST_REACH + 1 }>,
    reach: usize,
}

impl CrossSection {
    /// The cross-section of a stripe of `sd_px`, cut off at 2.6 SD.
    pub fn new(sd_px: f64) -> Self {
        let reach = ((2.6 * sd_px).ceil() as usize).clamp(1, MOST_REACH);
        let gauss = |i: usize| (-0.5 * ((i as f64 - reach as f64) / sd_px).powi(2)).exp();
        let count = 2 * reach + 1;
        let mean = (0..count).map(gauss).sum::<f64>() / count as f64;
        let norm = (0..count).map(|i| (gauss(i) - mean).powi(2)).sum::<f64>().sqrt();
        Self { weights: (0..count).map(|i| ((gauss(i) - mean) / norm) as f32).collect(), reach }
    }
}

/// Which percentile of a column's band is its background: below half, since the stripe fills part of the band.
const BACKGROUND_SHARE: f64 = 0.35;
/// Background above which a column says little: the sensor is full \[grey\].
const GLARE_GREY: u8 = 235;

/// How the ridge is sought.
#[derive(Debug, Clone, Copy)]
pub struct Search {
    /// Half-height of the band round the predicted row \[px\].
    pub half_band_px: usize,
    /// SD of the preference for the predicted row \[px\].
    pub prior_sd_px: f64,
}

/// Columns that are looked at side by side, as the processor multiplies.
const LANES: usize = 8;
/// Most rows of a band, and most columns of one stretch \[px\]. Chosen: half windows go up to 320 px.
const MOST_ROWS: usize = 160;
pub const MOST_COLUMNS: usize = 704;

/// What a stretch of columns shows, from left to right.
pub type Ridge = ArrayVec<RidgePoint, MOST_COLUMNS>;

/// Finds the ridge in each of `columns`, the first [`MOST_COLUMNS`] of them; `predicted` gives a column's row.
pub fn ridge(
    mut pixels: impl Pixels,
    columns: Range<usize>,
    predicted: impl Fn(f64) -> f64,
    section: &CrossSection,
    search: Search,
) -> Ridge {
    let half = search.half_band_px.max(section.reach + 2).min((MOST_ROWS - 1) / 2);
    let columns = columns.start..columns.end.min(columns.start + MOST_COLUMNS);
    let mut reached = (f64::INFINITY, f64::NEG_INFINITY);
    for row in columns.clone().map(|u| predicted(u as f64)) {
        reached = (row.min(reached.0), row.max(reached.1));
    }
    let last = (pixels.size_px().1 - 1) as f64;
    let rows = (reached.0 - half as f64 - 1.0, reached.1 + half as f64 + 1.0);
    let frame = pixels.region(columns.clone(), rows.0.clamp(0.0, last) as usize..rows.1.clamp(0.0, last) as usize + 1);
    let mut bands = Bands { rows: 2 * half + 1, ..Bands::default() };
    let mut points = Ridge::new();
    for first in columns.clone().step_by(LANES) {
        let some = first..columns.end.min(first + LANES);
        bands.read(frame, some.clone(), &predicted);
        bands.respond(section);
        let best = bands.best(section.reach, search.prior_sd_px as f32);
        points.extend(some.enumerate().map(|(lane, u)| bands.point(u, lane, best[lane], section.reach)));
    }
    points
}

/// The bands round the predicted rows of columns beside one another.
struct Bands {
    rows: usize,
    /// Grey, by row of the band.
    grey: [[f32; LANES]; MOST_ROWS],
    /// Response of the matched filter, by row of the band.
    response: [[f32; LANES]; MOST_ROWS],
    /// The band's middle row in the frame, and how far beyond it the predicted row is \[px\].
    centre: [f64; LANES],
    offset: [f32; LANES],
    has_glare: [bool; LANES],
}

impl Default for Bands {
    fn default() -> Self {
        Self {
            rows: 0,
            grey: [[0.0; LANES]; MOST_ROWS],
            response: [[0.0; LANES]; MOST_ROWS],
            centre: [0.0; LANES],
            offset: [0.0; LANES],
            has_glare: [false; LANES],
        }
    }
}

impl Bands {
    fn read(&mut self, frame: &GrayFrame, columns: Range<usize>, predicted: impl Fn(f64) -> f64) {
        let (width, height) = (frame.width_px(), frame.height_px());
        let half = self.rows / 2;
        let background_rank = (BACKGROUND_SHARE * self.rows as f64) as usize;
        for (lane, u) in columns.enumerate() {
            let row = predicted(u as f64);
            let centre = row.round();
            (self.centre[lane], self.offset[lane]) = (centre, (row - centre) as f32);
            let top = centre as isize - half as isize;
            let mut dark = 0;
            for (i, grey) in self.grey[..self.rows].iter_mut().enumerate() {
                let v = (top + i as isize).clamp(0, height as isize - 1) as usize;
                let sample = frame.pixels()[v * width + u];
                dark += usize::from(sample <= GLARE_GREY);
                grey[lane] = f32::from(sample);
            }
            self.has_glare[lane] = dark <= background_rank;
        }
    }

    /// One row beyond the searched ones on either side, for the parabola.
    fn respond(&mut self, section: &CrossSection) {
        let reach = section.reach;
        for m in reach - 1..=self.rows - reach {
            let mut sums = [0.0; LANES];
            for (i, &weight) in section.weights.iter().enumerate() {
                let grey = &self.grey[(m + i).saturating_sub(reach).min(self.rows - 1)];
                for (sum, grey) in sums.iter_mut().zip(grey) {
                    *sum += weight * grey;
                }
            }
            self.response[m] = sums;
        }
    }

    /// The row of the band with the largest response, those near the prediction preferred.
    fn best(&self, reach: usize, prior_sd_px: f32) -> [usize; LANES] {
        let scale = -0.5 / (prior_sd_px * prior_sd_px);
        let (mut best, mut most) = ([reach as i32; LANES], [f32::NEG_INFINITY; LANES]);
        for m in reach..self.rows - reach {
            let away = m as f32 - (self.rows / 2) as f32;
            for lane in 0..LANES {
                let away = away - self.offset[lane];
                let response = self.response[m][lane];
                let lit = if response > 0.0 { response } else { 0.0 };
                let preferred = lit * exp_of_negative(scale * away * away);
                best[lane] = if preferred > most[lane] { m as i32 } else { best[lane] };
                most[lane] = if preferred > most[lane] { preferred } else { most[lane] };
            }
        }
        best.map(|m| m as usize)
    }

    fn point(&self, u: usize, lane: usize, m: usize, reach: usize) -> RidgePoint {
        let response = |m: usize| self.response[m][lane];
        let (a, b, c) = (response(m - 1), response(m), response(m + 1));
        let curvature = a - 2.0 * b + c;
        let vertex = if curvature.abs() > 1e-6 { (0.5 * (a - c) / curvature).clamp(-1.0, 1.0) } else { 0.0 };
        let piece = || self.grey[m - reach..=m + reach].iter().map(|grey| grey[lane]);
        let mean = piece().sum::<f32>() / (2 * reach + 1) as f32;
        let norm = piece().map(|x| (x - mean).powi(2)).sum::<f32>().sqrt() + 1e-3;
        RidgePoint {
            u_px: u as f64,
            v_px: self.centre[lane] + m as f64 - (self.rows / 2) as f64 + f64::from(vertex),
            quality: f64::from(b / norm),
            amplitude: f64::from(b),
            has_glare: self.has_glare[lane],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ridge_of_a_tilted_stripe_is_found_to_a_twentieth_of_a_pixel() {
        let truth = |u: f64| 40.2 + 0.05 * u;
        let mut frame = GrayFrame::filled(120, 90, 0).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 120) as f64, (i / 120) as f64);
            *pixel = (30.0 + 180.0 * (-0.5 * ((v - truth(u)) / 2.4).powi(2)).exp()).round() as u8;
        }
        let search = Search { half_band_px: 14, prior_sd_px: 6.4 };
        for point in ridge(&frame, 0..120, |u| truth(u) + 2.0, &CrossSection::new(2.4), search) {
            assert!((point.v_px - truth(point.u_px)).abs() < 0.05, "{point:?}");
            // Half a pixel off the grid leaves exp(−0.25/(4·2.4²)) = 0.99, the cut-off tails a little less.
            assert!(point.quality > 0.95, "{point:?}");
        }
    }
}
