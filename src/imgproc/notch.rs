//! What a hairline joint does to the stripe, scored per column of the rectified band (docs/method.md §6.3).
//!
//! The seam shows as a dark notch, as a sideways glint, as a step of height or of brightness, and no single one of these
//! survives all frames. Each is a contrast along the stripe, in the log domain because the core is saturated, made
//! comparable by a robust z-score over the stripe.

use super::box_filter::{Contrast, RunningSums};
use super::rectify::{BAND_HALF_PX, Band};

/// Centre and flanks along the stripe (prototype: ±1 px against 4 to 9 px).
const HAIRLINE: Contrast = Contrast { centre: 1, guard: 3, outer: 9 };
/// The same for gaps of about 7, 13 and 21 px, so that one score covers a butt joint from hairline to gap (chosen). Only
/// a z-score above the last counts, as the best of three is taken.
const GAPS: [Contrast; 3] = [
    Contrast { centre: 3, guard: 5, outer: 12 },
    Contrast { centre: 6, guard: 8, outer: 18 },
    Contrast { centre: 10, guard: 12, outer: 26 },
];
const GAP_FROM_Z: f32 = 2.0;
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
/// No feature has a smaller deviation, in logarithms or pixels: a perfectly even stripe is no measure (chosen).
const LEAST_SD: f32 = 0.02;
/// How far from a column its relief is sought \[px\]: as far as a hairline's place is known.
const RELIEF_REACH_PX: usize = 2;
/// Fewer columns than this have no robust scale.
const MIN_COLUMNS: usize = 20;

/// Scores the columns of a band; owns its buffers.
#[derive(Debug, Clone, Default)]
pub struct NotchEvidence {
    background: Vec<f32>,
    sums: RunningSums,
    feature: Vec<f32>,
    z: Vec<f32>,
    gap_z: Vec<f32>,
    sample: Vec<f32>,
    score: Vec<f32>,
    relief: Vec<f32>,
    dip: Vec<f32>,
    step: Vec<f32>,
}

/// What of a feature along the stripe is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    /// How much lower it is than on both sides.
    Dip(Contrast),
    /// How much it differs between the sides.
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
        self.relief.clear();
        self.relief.resize(width, 0.0);

        self.feature.clear();
        self.feature.extend((0..width).map(|u| log_mean(-CORE_HALF_PX..=CORE_HALF_PX, CORE_FLOOR_GREY, u)));
        self.fill_z(band, Shape::Dip(HAIRLINE));
        self.add(soft);
        self.dip.clone_from(&self.z);
        self.add_gap(band);
        self.fill_z(band, Shape::Step);
        self.add(either_sign);
        self.step.clear();
        self.step.extend(self.z.iter().map(|z| z.abs()));

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
        self.fill_z(band, Shape::Dip(HAIRLINE));
        self.add(either_sign);
        self.add_relief(1.0);

        for rows in [-FLANK_ROWS.end()..=-FLANK_ROWS.start(), FLANK_ROWS] {
            self.feature.clear();
            self.feature.extend((0..width).map(|u| log_mean(rows.clone(), FLANK_FLOOR_GREY, u)));
            self.fill_z(band, Shape::Dip(HAIRLINE));
            self.add(either_sign);
            self.add_relief(0.5);
        }
        for (u, score) in self.score.iter_mut().enumerate() {
            if !band.inside.contains(&u) {
                *score = 0.0;
            }
        }
        self.background = background;
        &self.score
    }

    /// What column `u_px` has beyond an edge between two brightnesses, in units of the stripe's own noise: the centroid's unsigned
    /// z-score and the mean one of the two flanks, and by how much the dark line exceeds the step; each at its largest
    /// within two columns. Some 2.8 where the stripe only is brighter or darker, 4 to 7 at a seam.
    #[must_use]
    pub fn relief(&self, u_px: f64) -> f32 {
        let u = u_px.round().max(0.0) as usize;
        let near = u.saturating_sub(RELIEF_REACH_PX)..(u + RELIEF_REACH_PX + 1).min(self.relief.len());
        let largest =
            |values: &[f32]| values.get(near.clone()).map_or(0.0, |near| near.iter().copied().fold(0.0, f32::max));
        largest(&self.relief) + (largest(&self.dip) - largest(&self.step)).max(0.0)
    }

    fn add_relief(&mut self, share: f32) {
        for (relief, z) in self.relief.iter_mut().zip(&self.z) {
            *relief += share * z.abs();
        }
    }

    /// Adds what each column's z-score is worth.
    fn add(&mut self, worth: impl Fn(f32) -> f32) {
        for (score, &z) in self.score.iter_mut().zip(&self.z) {
            *score += worth(z);
        }
    }

    /// Adds the best of the gap widths.
    fn add_gap(&mut self, band: &Band) {
        self.gap_z.clear();
        self.gap_z.resize(band.width_px(), GAP_FROM_Z);
        for gap in GAPS {
            self.fill_z(band, Shape::Dip(gap));
            for (best, &z) in self.gap_z.iter_mut().zip(&self.z) {
                *best = best.max(z);
            }
        }
        for (score, &z) in self.score.iter_mut().zip(&self.gap_z) {
            *score += soft(z - GAP_FROM_Z);
        }
    }

    /// Robust z-scores of a shape of `self.feature`; all zero when the stripe is too short to have a scale.
    fn fill_z(&mut self, band: &Band, shape: Shape) {
        self.sums.load(self.feature.iter().copied());
        self.z.clear();
        self.z.extend((0..band.width_px()).map(|u| match shape {
            Shape::Dip(contrast) => -self.sums.contrast(u, contrast),
            Shape::Step => self.sums.step(u, STEP_PX),
        }));
        self.sample.clear();
        self.sample.extend(band.inside.clone().filter(|&u| !band.hot()[u]).map(|u| self.z[u]));
        if self.sample.len() < MIN_COLUMNS {
            self.z.fill(0.0);
            return;
        }
        let (median, sd) = robust_scale(&mut self.sample);
        let sd = sd.max(LEAST_SD);
        self.sums.load(self.z.iter().map(|value| ((value - median) / sd).abs().min(LOCAL_Z_LIMIT)));
        for (u, z) in self.z.iter_mut().enumerate() {
            let local = (self.sums.mean(u, LOCAL_HALF_PX) / MEAN_ABS_Z).max(1.0);
            *z = (*z - median) / (sd * local);
        }
    }
}

/// The worth of a feature that may differ by either sign.
fn either_sign(z: f32) -> f32 {
    soft(z.abs()) - UNSIGNED_MEAN
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
    (median, 1.4826 * mad)
}

const _: () = assert!(CENTROID_HALF_PX as usize <= BAND_HALF_PX);

#[cfg(test)]
mod tests {
    use super::super::rectify::StripeRectifier;
    use super::*;
    use crate::frame::GrayFrame;

    /// A saturated stripe with a speckle that repeats every 61 columns, its light changed by `light(u)`.
    fn score(light: impl Fn(usize) -> f64) -> Vec<f32> {
        let (width, height) = (400, 100);
        let pixels = (0..width * height)
            .map(|i| {
                let (u, v) = (i % width, i / width);
                let d = v as f64 - 50.0;
                let speckle = 0.75 + 0.5 * ((u * 37 + v * 11) % 61) as f64 / 61.0;
                (20.0 + 300.0 * light(u) * speckle * (-0.5 * (d / 2.4).powi(2)).exp()).min(255.0) as u8
            })
            .collect();
        let frame = GrayFrame::new(width, height, pixels).unwrap();
        let mut rectifier = StripeRectifier::default();
        NotchEvidence::default().score(rectifier.rectify(&frame).unwrap()).to_vec()
    }

    fn best(score: &[f32]) -> usize {
        (0..score.len()).fold(0, |best, u| if score[u] > score[best] { u } else { best })
    }

    #[test]
    fn a_narrow_notch_scores_highest_where_it_is() {
        let score = score(|u| if (179..=181).contains(&u) { 0.2 } else { 1.0 });
        assert!(best(&score).abs_diff(180) <= 1, "{}", best(&score));
        assert!(score[180] > 5.0, "{}", score[180]);
    }

    #[test]
    fn a_gap_of_thirteen_pixels_scores_within_it() {
        let score = score(|u| if (174..=186).contains(&u) { 0.05 } else { 1.0 });
        assert!(best(&score).abs_diff(180) <= 7, "{}", best(&score));
        assert!(score[180] > 5.0, "{}", score[180]);
    }

    #[test]
    fn a_plain_stripe_scores_nowhere_like_a_seam() {
        let score = score(|_| 1.0);
        assert!(score.iter().all(|&s| s < 5.0), "{}", score[best(&score)]);
    }
}
