//! The stripe's ridge along a predicted line, column by column, by a matched filter across the stripe.

use crate::frame::GrayFrame;

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
    /// Background of the column's band \[grey\].
    pub background: f64,
}

/// The zero-mean Gaussian cross-section of unit norm.
pub struct CrossSection {
    weights: Vec<f32>,
    reach: usize,
}

impl CrossSection {
    /// The cross-section of a stripe of `sd_px`, cut off at 2.6 SD.
    pub fn new(sd_px: f64) -> Self {
        let reach = (2.6 * sd_px).ceil() as usize;
        let gauss: Vec<f64> =
            (0..=2 * reach).map(|i| (-0.5 * ((i as f64 - reach as f64) / sd_px).powi(2)).exp()).collect();
        let mean = gauss.iter().sum::<f64>() / gauss.len() as f64;
        let norm = gauss.iter().map(|g| (g - mean).powi(2)).sum::<f64>().sqrt();
        Self { weights: gauss.iter().map(|g| ((g - mean) / norm) as f32).collect(), reach }
    }
}

/// Which percentile of a column's band is its background: below half, since the stripe fills part of the band.
const BACKGROUND_SHARE: f64 = 0.35;

/// How the ridge is sought.
#[derive(Debug, Clone, Copy)]
pub struct Search {
    /// Half-height of the band round the predicted row \[px\].
    pub half_band_px: usize,
    /// SD of the preference for the predicted row \[px\].
    pub prior_sd_px: f64,
}

/// Finds the ridge in each of `columns`; `predicted` gives a column's row.
pub fn ridge(
    frame: &GrayFrame,
    columns: std::ops::Range<usize>,
    predicted: impl Fn(f64) -> f64,
    section: &CrossSection,
    search: Search,
) -> Vec<RidgePoint> {
    let reach = section.reach;
    let half = search.half_band_px.max(reach + 2);
    let rows = 2 * half + 1;
    let (width, height) = (frame.width_px(), frame.height_px());
    let mut band = vec![0.0f32; rows];
    let mut sorted = vec![0u8; rows];
    let mut response = vec![0.0f32; rows];
    let background_rank = (BACKGROUND_SHARE * rows as f64) as usize;
    columns
        .map(|u| {
            let row = predicted(u as f64);
            let centre = row.round();
            let offset = row - centre;
            let top = centre as isize - half as isize;
            for (i, sample) in sorted.iter_mut().enumerate() {
                let v = (top + i as isize).clamp(0, height as isize - 1) as usize;
                *sample = frame.pixels()[v * width + u];
                band[i] = f32::from(*sample);
            }
            let (_, &mut background, _) = sorted.select_nth_unstable(background_rank);
            let background = f32::from(background);
            // One row beyond the searched ones on either side, for the parabola.
            for m in reach - 1..=rows - reach {
                let mut sum = 0.0;
                for (i, weight) in section.weights.iter().enumerate() {
                    sum += weight * band[(m + i).saturating_sub(reach).min(rows - 1)];
                }
                response[m] = sum;
            }
            let mut best = (reach, f32::NEG_INFINITY);
            for (m, &value) in response.iter().enumerate().take(rows - reach).skip(reach) {
                let away = (m as f64 - half as f64 - offset) / search.prior_sd_px;
                let preferred = value.max(0.0) * (-0.5 * away * away).exp() as f32;
                if preferred > best.1 {
                    best = (m, preferred);
                }
            }
            let m = best.0;
            let (a, b, c) = (response[m - 1], response[m], response[m + 1]);
            let curvature = a - 2.0 * b + c;
            let vertex = if curvature.abs() > 1e-6 { (0.5 * (a - c) / curvature).clamp(-1.0, 1.0) } else { 0.0 };
            let piece = &band[m - reach..=m + reach];
            let mean = piece.iter().sum::<f32>() / piece.len() as f32;
            let norm = piece.iter().map(|x| (x - mean).powi(2)).sum::<f32>().sqrt() + 1e-3;
            RidgePoint {
                u_px: u as f64,
                v_px: centre + m as f64 - half as f64 + f64::from(vertex),
                quality: f64::from(b / norm),
                amplitude: f64::from(b),
                background: f64::from(background),
            }
        })
        .collect()
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
