//! What a hairline joint does to the stripe, scored per column of the rectified band (METHOD.md §6.3).
//!
//! The seam shows as a dark notch, as a sideways glint, as a step of height or of brightness, and no single one of these
//! survives all frames. Each is a contrast along the stripe, in the log domain because the core is saturated, made
//! comparable by a robust z-score over the stripe.

use super::box_filter::{Contrast, RunningSums};
use super::rectify::{BAND_HALF_PX, Band};

/// Centre and flanks along the stripe (prototype: ±1 px against 4 to 9 px).
const HAIRLINE: Contrast = Contrast { centre: 1, guard: 3, outer: 9 };
/// A step of brightness is the difference of the means of so many columns on both sides (chosen).
const STEP_PX: usize = 8;
/// Rows of the core, of the stripe's two flanks, and of its centroid \[px from the line\].
const CORE_HALF_PX: isize = 5;
const FLANK_ROWS: std::ops::RangeInclusive<isize> = 4..=9;
const CENTROID_HALF_PX: isize = 9;
/// Grey added before the logarithm: the noise floor of a mean of 11 rows, and of 6 rows.
const CORE_FLOOR_GREY: f32 = 6.0;
const FLANK_FLOOR_GREY: f32 = 4.0;
/// The centroid counts the light above the first, up to the second \[grey\]; a column with less than the third keeps
/// its centroid near the line.
const CENTROID_MIN_GREY: f32 = 10.0;
const CENTROID_CAP_GREY: f32 = 160.0;
const CENTROID_MIN_SUM_GREY: f32 = 300.0;
/// Beyond about this a z-score counts by its logarithm: one feature alone must not decide (chosen).
const SOFT_Z: f32 = 4.0;
/// Mean of an unsigned score without a seam, taken off so that the sum is near zero there.
const UNSIGNED_MEAN: f32 = 0.67;
/// Where the stripe is noisier than elsewhere (dimmed by smoke, mostly), its own scale counts: half width of the
/// surroundings \[px\], the z-score a column adds to it at most, and the mean unsigned z-score of plain noise.
const LOCAL_HALF_PX: usize = 30;
const LOCAL_Z_LIMIT: f32 = 3.0;
const MEAN_ABS_Z: f32 = 0.8;
/// Fewer columns than this have no robust scale.
const MIN_COLUMNS: usize = 20;

/// Scores the columns of a band; owns its buffers.
#[derive(Debug, Clone, Default)]
pub struct NotchEvidence {
    background: Vec<f32>,
    sums: RunningSums,
    feature: Vec<f32>,
    contrast: Vec<f32>,
    sample: Vec<f32>,
    score: Vec<f32>,
}

/// What of a feature along the stripe speaks for a seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sign {
    /// A value lower than on both sides.
    Dip,
    /// A value lower or higher than on both sides.
    DipOrBump,
    /// A value that differs between the sides.
    Step,
}

impl NotchEvidence {
    /// One score a column, dimensionless: near 0 on plain stripe, 5 to 8 at a seam, 0 outside `band.inside`.
    pub fn score(&mut self, band: &Band) -> &[f32] {
        let width = band.width_px();
        let mut background = std::mem::take(&mut self.background);
        band.fill_background(&mut background, &mut self.sums);
        let light = |d: isize, u: usize| (band.row(d)[u] - background[u]).max(0.0);
        let log_mean = |rows: std::ops::RangeInclusive<isize>, floor: f32, u: usize| {
            let count = rows.clone().count() as f32;
            (rows.map(|d| light(d, u)).sum::<f32>() / count + floor).ln()
        };
        self.score.clear();
        self.score.resize(width, 0.0);

        self.feature.clear();
        self.feature.extend((0..width).map(|u| log_mean(-CORE_HALF_PX..=CORE_HALF_PX, CORE_FLOOR_GREY, u)));
        self.add_feature(band, Sign::Dip);
        self.add_feature(band, Sign::Step);

        self.feature.clear();
        self.feature.extend((0..width).map(|u| {
            let (mut sum, mut moment) = (0.0, 0.0);
            for d in -CENTROID_HALF_PX..=CENTROID_HALF_PX {
                let weight = (light(d, u) - CENTROID_MIN_GREY).clamp(0.0, CENTROID_CAP_GREY);
                sum += weight;
                moment += weight * d as f32;
            }
            moment / sum.max(CENTROID_MIN_SUM_GREY)
        }));
        self.add_feature(band, Sign::DipOrBump);

        for rows in [-FLANK_ROWS.end()..=-FLANK_ROWS.start(), FLANK_ROWS] {
            self.feature.clear();
            self.feature.extend((0..width).map(|u| log_mean(rows.clone(), FLANK_FLOOR_GREY, u)));
            self.add_feature(band, Sign::DipOrBump);
        }
        for (u, score) in self.score.iter_mut().enumerate() {
            if !band.inside.contains(&u) {
                *score = 0.0;
            }
        }
        self.background = background;
        &self.score
    }

    /// Adds the soft robust z-score of the contrast of `self.feature` to the score.
    fn add_feature(&mut self, band: &Band, sign: Sign) {
        self.sums.load(self.feature.iter().copied());
        self.contrast.clear();
        self.contrast.extend((0..band.width_px()).map(|u| match sign {
            Sign::Dip | Sign::DipOrBump => -self.sums.contrast(u, HAIRLINE),
            Sign::Step => self.sums.step(u, STEP_PX),
        }));
        self.sample.clear();
        self.sample.extend(band.inside.clone().filter(|&u| !band.hot()[u]).map(|u| self.contrast[u]));
        if self.sample.len() < MIN_COLUMNS {
            return;
        }
        let (median, sd) = robust_scale(&mut self.sample);
        self.sums.load(self.contrast.iter().map(|value| ((value - median) / sd).abs().min(LOCAL_Z_LIMIT)));
        for (u, (score, &value)) in self.score.iter_mut().zip(&self.contrast).enumerate() {
            let local = (self.sums.mean(u, LOCAL_HALF_PX) / MEAN_ABS_Z).max(1.0);
            let z = (value - median) / (sd * local);
            *score += if sign == Sign::Dip { soft(z) } else { soft(z.abs()) - UNSIGNED_MEAN };
        }
    }
}

/// Linear up to about [`SOFT_Z`], logarithmic beyond.
fn soft(z: f32) -> f32 {
    SOFT_Z * (z.abs() / SOFT_Z).ln_1p().copysign(z)
}

/// Median, and standard deviation from the median absolute deviation. Reorders and overwrites `sample`.
pub(crate) fn robust_scale(sample: &mut [f32]) -> (f32, f32) {
    let middle = sample.len() / 2;
    let median = *sample.select_nth_unstable_by(middle, f32::total_cmp).1;
    for value in sample.iter_mut() {
        *value = (*value - median).abs();
    }
    let mad = *sample.select_nth_unstable_by(middle, f32::total_cmp).1;
    (median, 1.4826 * mad + 1e-6)
}

const _: () = assert!(CENTROID_HALF_PX as usize <= BAND_HALF_PX);
