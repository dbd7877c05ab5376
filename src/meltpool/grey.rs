//! The grey stretch: a picture between its own darkest and brightest light, in 8 bits, for segmentation only.

use super::travel::Turned;

/// Ranks that become black and white: one pixel in a hundred is darker, one in a thousand brighter. Chosen: a pool
/// takes more of the picture than that, hot pixels and sparks less.
const BLACK_SHARE: f64 = 0.01;
const WHITE_SHARE: f64 = 0.999;
/// About so many pixels are ranked. Chosen: the ranks are good to a fraction of a grey value.
const RANKED_PIXELS: usize = 8_192;
/// Median of |a − b| of two normal numbers over their standard deviation.
const MEDIAN_DIFFERENCE: f32 = 0.953_9;

/// A picture stretched to 8 bits.
#[derive(Debug, Default)]
pub(super) struct Stretched {
    pub(super) grey: Vec<u8>,
    /// Intensity of grey 0 and of grey 255.
    black: f32,
    white: f32,
    /// Standard deviation of the pixels' noise, as intensity.
    pub(super) noise: f32,
    /// Part of the pixels at or above the recording's white.
    pub(super) saturated_share: f64,
    histogram: Vec<u32>,
    ranked: Vec<f32>,
}

impl Stretched {
    /// Stretches a picture; the buffers are reused.
    pub(super) fn set(&mut self, picture: &Turned<'_>) {
        let step = picture.light.len().div_ceil(RANKED_PIXELS);
        self.ranked.clear();
        self.ranked.extend(picture.light.windows(2).step_by(step).map(|pair| (pair[0] - pair[1]).abs()));
        let middle = self.ranked.len() / 2;
        self.noise = rank(&mut self.ranked, middle) / MEDIAN_DIFFERENCE;
        self.ranked.clear();
        self.ranked.extend(picture.light.iter().step_by(step));
        let count = self.ranked.len();
        let saturated = self.ranked.iter().filter(|&&light| light >= 1.0).count();
        self.saturated_share = saturated as f64 / count as f64;
        self.black = rank(&mut self.ranked, (BLACK_SHARE * count as f64) as usize);
        self.white = rank(&mut self.ranked, (WHITE_SHARE * count as f64) as usize);
        let scale = if self.white > self.black { 255.0 / (self.white - self.black) } else { 0.0 };
        self.grey.clear();
        let black = self.black;
        self.grey.extend(picture.light.iter().map(|light| ((light - black) * scale + 0.5) as u8));
        self.histogram.clear();
        self.histogram.resize(256, 0);
        for &grey in &self.grey {
            self.histogram[usize::from(grey)] += 1;
        }
    }

    /// The intensity of a grey value.
    pub(super) fn light(&self, grey: f32) -> f32 {
        self.black + grey / 255.0 * (self.white - self.black)
    }

    /// The grey value of an intensity, within 0 to 254.
    pub(super) fn grey_of(&self, light: f32) -> u8 {
        let range = (self.white - self.black).max(f32::MIN_POSITIVE);
        (255.0 * (light - self.black) / range).clamp(0.0, 254.0) as u8
    }

    /// Otsu's level among the greys of a range: those up to it are the darker class. None when there is one grey only.
    pub(super) fn otsu_within(&self, greys: std::ops::RangeInclusive<u8>) -> Option<u8> {
        let bins = || greys.clone().map(|grey| (grey, f64::from(grey), f64::from(self.histogram[usize::from(grey)])));
        let total: f64 = bins().map(|(_, _, count)| count).sum();
        let sum: f64 = bins().map(|(_, grey, count)| grey * count).sum();
        let (mut count_below, mut sum_below) = (0.0, 0.0);
        let mut best = (0.0, None);
        for (level, grey, count) in bins() {
            count_below += count;
            sum_below += grey * count;
            let count_above = total - count_below;
            if count_below == 0.0 || count_above <= 0.0 {
                continue;
            }
            let difference = (sum - sum_below) / count_above - sum_below / count_below;
            let between = count_below * count_above * difference * difference;
            if between > best.0 {
                best = (between, Some(level));
            }
        }
        best.1
    }

    /// The median grey of the pixels in a range of grey values; none without any.
    pub(super) fn median_of(&self, greys: std::ops::RangeInclusive<u8>) -> Option<f32> {
        let range = usize::from(*greys.start())..=usize::from(*greys.end());
        let count: u32 = self.histogram[range.clone()].iter().sum();
        let mut below = 0;
        let bin = range.clone().find(|&grey| {
            below += self.histogram[grey];
            2 * below >= count
        });
        bin.filter(|_| count > 0).map(|grey| grey as f32)
    }
}

fn rank(values: &mut [f32], index: usize) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let last = values.len() - 1;
    *values.select_nth_unstable_by(index.min(last), f32::total_cmp).1
}
