//! The band along the stripe's line, straightened, with the stripe's ends and the columns glare makes useless
//! (docs/method.md §6.1 and §6.2).

use std::collections::VecDeque;

use super::box_filter::RunningSums;
use super::stripe_line::{StripeLine, StripeLineFinder};
use crate::frame::GrayFrame;

/// Rows of the band above and below the line \[px\] (docs/method.md §6.1).
pub const BAND_HALF_PX: usize = 16;
/// Rows of the band.
pub const BAND_ROWS: usize = 2 * BAND_HALF_PX + 1;

/// Brightness along the stripe: the core's rows \[px\], its cap \[grey\], the mean along the stripe \[px\] (prototype).
const CORE_HALF_PX: usize = 4;
const CORE_CAP_GREY: f32 = 150.0;
const CORE_ALONG_HALF_PX: usize = 4;
/// The stripe is where it is brighter than this share of its upper quartile, and than this many grey values.
const END_SHARE: f32 = 0.3;
const END_MIN_GREY: f32 = 6.0;
/// Darker stretches up to this length \[px\] are part of the stripe: a gap, a shadow.
const END_BRIDGE_PX: usize = 30;
/// Frames over which the ends are running percentiles, and which: one spatter must not move them (docs/method.md §6.2).
const END_FRAMES: usize = 21;
const END_PERCENTILE: f64 = 0.6;
/// Within this of an end the end itself is the strongest edge \[px\] (docs/method.md §6.2).
const END_MARGIN_PX: usize = 6;
/// Rows of the band at its two rims that show the background \[px\].
const RIM_PX: usize = 7;
/// A rim brighter than its surroundings by this shows spatter or glare \[grey\]: brightest pixel, mean.
const HOT_PEAK_GREY: f32 = 45.0;
const HOT_MEAN_GREY: f32 = 25.0;
/// Half width of those surroundings, and how far a hot column spoils its neighbours \[px\].
const HOT_SURROUND_HALF_PX: usize = 30;
const HOT_REACH_PX: usize = 4;

/// The straightened surroundings of the stripe.
#[derive(Debug, Clone)]
pub struct Band {
    /// The stripe's line in the frame; row `d` of the band is `d` px below it.
    pub line: StripeLine,
    /// The stripe's columns without its ends' margin: the places where a seam can show.
    pub inside: std::ops::Range<usize>,
    width_px: usize,
    grey: Vec<f32>,
    hot: Vec<bool>,
}

impl Band {
    /// Number of columns, that of the frame.
    #[must_use]
    pub const fn width_px(&self) -> usize {
        self.width_px
    }

    /// Grey values of the row `offset_px` below the line, one a column.
    ///
    /// # Panics
    /// When `offset_px` is beyond [`BAND_HALF_PX`].
    #[must_use]
    pub fn row(&self, offset_px: isize) -> &[f32] {
        let row = (offset_px + BAND_HALF_PX as isize) as usize;
        &self.grey[row * self.width_px..(row + 1) * self.width_px]
    }

    /// Columns in which spatter or glare beside the stripe forbids to read anything from it.
    #[must_use]
    pub fn hot(&self) -> &[bool] {
        &self.hot
    }

    /// Background of each column: the mean of the two rims' medians, averaged over 21 columns.
    pub(crate) fn fill_background(&self, background: &mut Vec<f32>, sums: &mut RunningSums) {
        let rim = |u: usize, below: bool| {
            let mut rows = [0.0; 4];
            for (i, value) in rows.iter_mut().enumerate() {
                let row = if below { BAND_ROWS - 4 + i } else { i };
                *value = self.grey[row * self.width_px + u];
            }
            rows.sort_unstable_by(f32::total_cmp);
            0.5 * (rows[1] + rows[2])
        };
        sums.load((0..self.width_px).map(|u| 0.5 * (rim(u, false) + rim(u, true))));
        background.clear();
        background.extend((0..self.width_px).map(|u| sums.mean(u, 10)));
    }
}

/// Straightens frame after frame.
#[derive(Debug, Clone, Default)]
pub struct StripeRectifier {
    finder: StripeLineFinder,
    ends: VecDeque<(usize, usize)>,
    band: Option<Band>,
    sums: RunningSums,
    profile: Vec<f32>,
}

impl StripeRectifier {
    /// The last frame's band.
    #[must_use]
    pub const fn band(&self) -> Option<&Band> {
        self.band.as_ref()
    }

    /// The band of `frame`, or `None` while no stripe was seen.
    pub fn rectify(&mut self, frame: &GrayFrame) -> Option<&Band> {
        let line = self.finder.find(frame)?;
        let width_px = frame.width_px();
        let mut band = self.band.take().filter(|band| band.width_px == width_px).unwrap_or_else(|| {
            // Ends of another picture say nothing of this one.
            self.ends.clear();
            Band {
                line,
                inside: 0..width_px,
                width_px,
                grey: vec![0.0; BAND_ROWS * width_px],
                hot: vec![false; width_px],
            }
        });
        band.line = line;
        sample(frame, &mut band);
        band.inside = self.find_inside(&band);
        self.mark_hot(&mut band);
        Some(self.band.insert(band))
    }

    fn find_inside(&mut self, band: &Band) -> std::ops::Range<usize> {
        let width = band.width_px;
        let half = BAND_HALF_PX as isize;
        let core = CORE_HALF_PX as isize;
        let mean = |u: usize, rows: std::ops::RangeInclusive<isize>, cap: f32| {
            let count = rows.clone().count() as f32;
            rows.map(|d| band.row(d)[u].min(cap)).sum::<f32>() / count
        };
        self.sums.load((0..width).map(|u| {
            let rims = mean(u, -half..=4 - half, f32::MAX) + mean(u, half - 4..=half, f32::MAX);
            mean(u, -core..=core, CORE_CAP_GREY) - 0.5 * rims
        }));
        self.profile.clear();
        self.profile.extend((0..width).map(|u| self.sums.mean(u, CORE_ALONG_HALF_PX)));
        let mut sorted = self.profile.clone();
        let (_, quartile, _) = sorted.select_nth_unstable_by(width * 3 / 4, f32::total_cmp);
        let threshold = (END_SHARE * *quartile).max(END_MIN_GREY);
        if let Some(run) = longest_run(&self.profile, threshold) {
            self.ends.push_back(run);
            if self.ends.len() > END_FRAMES {
                self.ends.pop_front();
            }
        }
        if self.ends.is_empty() {
            return 0..width;
        }
        let percentile = |mut values: Vec<usize>, share: f64| {
            let nth = (share * (values.len() - 1) as f64).round() as usize;
            *values.select_nth_unstable(nth).1
        };
        let first = percentile(self.ends.iter().map(|run| run.0).collect(), END_PERCENTILE);
        let end = percentile(self.ends.iter().map(|run| run.1).collect(), 1.0 - END_PERCENTILE);
        let first = (first + END_MARGIN_PX).min(width);
        first..end.saturating_sub(END_MARGIN_PX).max(first)
    }

    fn mark_hot(&mut self, band: &mut Band) {
        let width = band.width_px;
        let rims = || (0..RIM_PX).chain(BAND_ROWS - RIM_PX..BAND_ROWS);
        self.profile.clear();
        for u in 0..width {
            let mut values = [0.0; 2 * RIM_PX];
            for (value, row) in values.iter_mut().zip(rims()) {
                *value = band.grey[row * width + u];
            }
            values.sort_unstable_by(f32::total_cmp);
            self.profile.push(0.5 * (values[RIM_PX - 1] + values[RIM_PX]));
        }
        self.sums.load(self.profile.iter().copied());
        band.hot.fill(false);
        for u in 0..width {
            let surround = self.sums.mean(u, HOT_SURROUND_HALF_PX);
            let (mut peak, mut sum) = (0.0_f32, 0.0);
            for row in rims() {
                let grey = band.grey[row * width + u];
                peak = peak.max(grey);
                sum += grey;
            }
            if peak > surround + HOT_PEAK_GREY || sum / (2 * RIM_PX) as f32 > surround + HOT_MEAN_GREY {
                band.hot[u.saturating_sub(HOT_REACH_PX)..(u + HOT_REACH_PX + 1).min(width)].fill(true);
            }
        }
    }
}

/// Linear interpolation down the columns; the frame's border rows continue outside.
fn sample(frame: &GrayFrame, band: &mut Band) {
    let (width, last) = (band.width_px, frame.height_px() as isize - 1);
    for u in 0..width {
        let top = band.line.v_px(u as f64) - BAND_HALF_PX as f64;
        let (first, part) = (top.floor() as isize, (top - top.floor()) as f32);
        let grey = |v: isize| f32::from(frame.pixels()[v.clamp(0, last) as usize * width + u]);
        let mut above = grey(first);
        for row in 0..BAND_ROWS {
            let below = grey(first + row as isize + 1);
            band.grey[row * width + u] = above + part * (below - above);
            above = below;
        }
    }
}

/// First and one-past-last column of the longest stretch above `threshold`, short breaks bridged.
fn longest_run(profile: &[f32], threshold: f32) -> Option<(usize, usize)> {
    let mut best: Option<(usize, usize)> = None;
    let mut run: Option<(usize, usize)> = None;
    for u in (0..profile.len()).filter(|&u| profile[u] > threshold) {
        run = Some(match run {
            Some((first, end)) if u - end <= END_BRIDGE_PX => (first, u + 1),
            _ => (u, u + 1),
        });
        if let Some((first, end)) = run
            && best.is_none_or(|(f, e)| end - first > e - f)
        {
            best = run;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stripe of σ 2.4 px on `columns`, 235 grey over 20.
    fn stripe(columns: std::ops::Range<usize>) -> GrayFrame {
        let mut frame = GrayFrame::filled(400, 200, 20).unwrap();
        for v in 0..200 {
            for u in columns.clone() {
                let d = v as f64 - (100.0 + 0.04 * u as f64);
                frame.pixels_mut()[v * 400 + u] = (20.0 + 235.0 * (-0.5 * (d / 2.4).powi(2)).exp()) as u8;
            }
        }
        frame
    }

    #[test]
    fn a_tilted_stripe_lies_on_row_zero_of_its_band() {
        let mut rectifier = StripeRectifier::default();
        let band = rectifier.rectify(&stripe(50..350)).unwrap();
        for u in 60..340 {
            let (sum, moment) = (-16..=16).fold((0.0, 0.0), |(s, m), d| {
                let grey = band.row(d)[u] - 20.0;
                (s + grey, m + grey * d as f32)
            });
            assert!((moment / sum).abs() < 0.2, "column {u}: {}", moment / sum);
        }
    }

    #[test]
    fn the_inside_leaves_out_the_ends_and_one_blinded_frame_does_not_move_it() {
        let mut rectifier = StripeRectifier::default();
        for _ in 0..5 {
            rectifier.rectify(&stripe(50..350));
        }
        let inside = rectifier.rectify(&stripe(120..350)).unwrap().inside.clone();
        assert!(inside.start.abs_diff(56) <= 4 && inside.end.abs_diff(344) <= 4, "{inside:?}");
    }

    #[test]
    fn a_narrower_frame_forgets_the_ends_of_the_wider_ones() {
        let mut rectifier = StripeRectifier::default();
        for _ in 0..30 {
            rectifier.rectify(&stripe(50..390));
        }
        let mut narrow = GrayFrame::filled(150, 200, 20).unwrap();
        for v in 98..104 {
            narrow.pixels_mut()[v * 150 + 10..v * 150 + 140].fill(200);
        }
        let inside = rectifier.rectify(&narrow).unwrap().inside.clone();
        assert!(inside.end <= 150 && inside.start < inside.end, "{inside:?}");
    }

    #[test]
    fn a_spatter_beside_the_stripe_makes_its_columns_hot() {
        let mut frame = stripe(50..350);
        for v in 90..96 {
            frame.pixels_mut()[v * 400 + 200..v * 400 + 203].fill(255);
        }
        let mut rectifier = StripeRectifier::default();
        let band = rectifier.rectify(&frame).unwrap();
        assert!(band.hot()[196..206].iter().all(|&hot| hot));
        assert_eq!(band.hot().iter().filter(|&&hot| hot).count(), 11);
    }
}
