//! The stripe's centreline by the grey-centroid method (Du 2022, section 3.1), column by column.

use std::ops::Range;

use crate::frame::GrayFrame;

/// How far from the stripe's path its centre is sought \[px\]. Chosen: deeper than a narrow gap, wide enough for the
/// median of a column's stretch to be its background.
const PATH_REACH_PX: usize = 20;

/// How far from a column the strong columns are looked for \[px\], and the least that they have as a share of all strong
/// ones. Chosen: longer than a spatter or a gap is wide; darker plates are rare.
const STRONG_REACH_PX: usize = 80;
const DARKEST_SHARE: f32 = 0.2;

/// What counts as stripe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentrelineSettings {
    /// Least height of a column's peak above its background \[grey\]. Chosen: three times a dark camera's noise.
    pub least_contrast_grey: f32,
    /// Least height as a fraction of the strong columns' height. Chosen: the ends of a stripe fade, halos are weaker.
    pub least_contrast_ratio: f32,
    /// The band: grey above background + this fraction of the peak's height. Chosen as in the prototype.
    pub band_ratio: f32,
    /// Longest half-width of the band \[px\]; bounds what a glare can pull.
    pub band_half_width_px: usize,
}

impl Default for CentrelineSettings {
    fn default() -> Self {
        Self { least_contrast_grey: 15.0, least_contrast_ratio: 0.25, band_ratio: 0.35, band_half_width_px: 12 }
    }
}

/// The stripe's centre in each column, where there is one.
#[derive(Debug, Clone, PartialEq)]
pub struct Centreline {
    /// Row of the stripe's centre in each column \[px\], sub-pixel.
    pub v_px: Vec<Option<f32>>,
}

impl Centreline {
    /// The row in column `u`, if the stripe is seen there.
    #[must_use]
    pub fn at(&self, u: usize) -> Option<f32> {
        self.v_px.get(u).copied().flatten()
    }

    /// The longest stretch of columns in which the stripe is seen, bridging gaps of up to `bridge_px` columns:
    /// first column and one past the last.
    #[must_use]
    pub fn extent(&self, bridge_px: usize) -> Option<(usize, usize)> {
        let mut best: Option<(usize, usize)> = None;
        let mut run: Option<(usize, usize)> = None;
        for u in (0..self.v_px.len()).filter(|&u| self.v_px[u].is_some()) {
            run = Some(match run {
                Some((first, end)) if u - end <= bridge_px => (first, u + 1),
                _ => (u, u + 1),
            });
            if run.map(|(a, b)| b - a) > best.map(|(a, b)| b - a) {
                best = run;
            }
        }
        best
    }
}

/// Extracts the centreline of a horizontal stripe: in each column the centroid Σ v·g / Σ g over the band round the
/// column's brightest pixel, g being the grey value above the band's threshold.
///
/// The column's median is its background, so glare that fills a column does not pass for stripe.
#[must_use]
pub fn extract(frame: &GrayFrame, settings: &CentrelineSettings) -> Centreline {
    extract_within(frame, settings, usize::MAX, |_| 0..frame.height_px())
}

/// The same near the stripe's `path`, its row in each column: spatter and reflections elsewhere do not count. The strong
/// columns are those nearby, since one plate may be much darker than the other.
#[must_use]
pub fn extract_along(frame: &GrayFrame, settings: &CentrelineSettings, path: &[usize]) -> Centreline {
    extract_within(frame, settings, STRONG_REACH_PX, |u| {
        path[u].saturating_sub(PATH_REACH_PX)..(path[u] + PATH_REACH_PX + 1).min(frame.height_px())
    })
}

fn extract_within(
    frame: &GrayFrame,
    settings: &CentrelineSettings,
    strong_reach_px: usize,
    rows: impl Fn(usize) -> Range<usize>,
) -> Centreline {
    let width = frame.width_px();
    let rows: Vec<Range<usize>> = (0..width).map(rows).collect();
    let mut peak_row: Vec<usize> = rows.iter().map(|rows| rows.start).collect();
    let mut peak = vec![0u8; width];
    let mut histograms = vec![[0u32; 256]; width];
    let first = rows.iter().map(|rows| rows.start).min().unwrap_or(0);
    let end = rows.iter().map(|rows| rows.end).max().unwrap_or(0);
    for v in first..end {
        for (u, &grey) in frame.row(v).iter().enumerate().filter(|(u, _)| rows[*u].contains(&v)) {
            histograms[u][grey as usize] += 1;
            if grey > peak[u] {
                peak[u] = grey;
                peak_row[u] = v;
            }
        }
    }
    let mut background = vec![0u8; width];
    for (u, histogram) in histograms.iter().enumerate() {
        background[u] = median_of(histogram, rows[u].len());
        peak_row[u] = middle_of_plateau(frame, u, peak_row[u], peak[u]);
    }
    let contrasts: Vec<f32> = (0..width).map(|u| f32::from(peak[u]) - f32::from(background[u])).collect();
    let strong = strong_columns(&contrasts, strong_reach_px);
    let centre = |(u, &contrast): (usize, &f32)| {
        let threshold = f32::from(background[u]) + settings.band_ratio * contrast;
        let least = settings.least_contrast_grey.max(settings.least_contrast_ratio * strong[u]);
        (contrast >= least).then(|| centroid(frame, u, peak_row[u], threshold, settings.band_half_width_px))
    };
    Centreline { v_px: contrasts.iter().enumerate().map(centre).collect() }
}

fn median_of(histogram: &[u32; 256], count: usize) -> u8 {
    let mut seen = 0;
    for (grey, &n) in (0u8..=255).zip(histogram) {
        seen += n as usize;
        if 2 * seen > count {
            return grey;
        }
    }
    255
}

/// A saturated core is a plateau: its first pixel is not its middle.
fn middle_of_plateau(frame: &GrayFrame, u: usize, first: usize, peak: u8) -> usize {
    let width = frame.width_px();
    let column = &frame.pixels()[u..];
    let length = (first..frame.height_px()).take_while(|v| column[v * width] == peak).count();
    first + length.saturating_sub(1) / 2
}

/// What a well-lit column near each column has: the 90th percentile over `reach_px` to the left or to the right of it,
/// whichever is less, but no less than a share of that of all columns.
fn strong_columns(contrasts: &[f32], reach_px: usize) -> Vec<f32> {
    let all = strong(contrasts);
    let near = |u: usize| {
        let left = strong(&contrasts[u.saturating_sub(reach_px)..=u]);
        let right = strong(&contrasts[u..u.saturating_add(reach_px).min(contrasts.len())]);
        left.min(right).max(DARKEST_SHARE * all)
    };
    let is_whole = reach_px >= contrasts.len();
    (0..contrasts.len()).map(|u| if is_whole { all } else { near(u) }).collect()
}

/// The 90th percentile: what a well-lit column has.
fn strong(contrasts: &[f32]) -> f32 {
    if contrasts.is_empty() {
        return 0.0;
    }
    let mut sorted = contrasts.to_vec();
    let rank = sorted.len() * 9 / 10;
    let (_, value, _) = sorted.select_nth_unstable_by(rank, f32::total_cmp);
    *value
}

fn centroid(frame: &GrayFrame, u: usize, peak_row: usize, threshold: f32, half_width: usize) -> f32 {
    let width = frame.width_px();
    let above = |v: usize| f32::from(frame.pixels()[v * width + u]) - threshold;
    let (mut weight, mut moment) = (0.0, 0.0);
    let mut add = |v: usize| {
        let g = above(v);
        if g <= 0.0 {
            return false;
        }
        weight += g;
        moment += g * (v as f32 - peak_row as f32);
        true
    };
    let _ = (peak_row..(peak_row + half_width + 1).min(frame.height_px())).take_while(|&v| add(v)).count();
    let _ = (peak_row.saturating_sub(half_width)..peak_row).rev().take_while(|&v| add(v)).count();
    peak_row as f32 + if weight > 0.0 { moment / weight } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stripe(width: usize, height: usize, centre: impl Fn(usize) -> Option<f32>, amplitude: f32) -> GrayFrame {
        let mut pixels = vec![0; width * height];
        for v in 0..height {
            for u in 0..width {
                let light = centre(u).map_or(0.0, |c| amplitude * (-0.5 * ((v as f32 - c) / 2.4).powi(2)).exp());
                pixels[v * width + u] = (9.0 + light).round().min(255.0) as u8;
            }
        }
        GrayFrame::new(width, height, pixels).unwrap()
    }

    #[test]
    fn a_gaussian_stripe_is_found_to_a_twentieth_of_a_pixel() {
        let truth = |u: usize| Some(40.0 + 0.03 * u as f32);
        let line = extract(&stripe(200, 90, truth, 190.0), &CentrelineSettings::default());
        for u in 0..200 {
            let error = line.at(u).unwrap() - truth(u).unwrap();
            assert!(error.abs() < 0.05, "column {u}: {error}");
        }
    }

    #[test]
    fn a_saturated_core_keeps_its_middle() {
        let line = extract(&stripe(60, 90, |_| Some(40.3), 900.0), &CentrelineSettings::default());
        assert!((line.at(30).unwrap() - 40.3).abs() < 0.15);
    }

    #[test]
    fn columns_without_stripe_have_no_centre_and_the_extent_says_where_it_ends() {
        let seen = |u: usize| (30..150).contains(&u) && !(80..90).contains(&u);
        let line = extract(&stripe(200, 90, |u| seen(u).then_some(45.0), 190.0), &CentrelineSettings::default());
        assert!((0..200).all(|u| line.at(u).is_some() == seen(u)));
        assert_eq!(line.extent(20), Some((30, 150)));
        assert_eq!(line.extent(5), Some((90, 150)));
    }

    #[test]
    fn a_dark_frame_has_no_stripe() {
        let line = extract(&GrayFrame::filled(64, 48, 7).unwrap(), &CentrelineSettings::default());
        assert_eq!(line.extent(60), None);
    }
}
