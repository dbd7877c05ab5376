//! The molten pool in a picture: its outline, and whether it is one.

use super::cv::{SegmentationError, Segmenter};
use super::edge::{edge, reach_px};
use super::grey::Stretched;
use super::refusal::{Border, Refusal};
use super::travel::Turned;

/// A frame with more of its pixels at white than this shows no outline to trust. Chosen: no pool that is to be measured
/// fills half the picture.
const SATURATED_SHARE: f64 = 0.5;
/// Least contrast of pool and surroundings, in units of the recording's white; chosen, 5 of 255 grey values.
const LEAST_CONTRAST: f32 = 0.02;
/// Least contrast over the pixels' noise; chosen: noise alone, split in two, has a contrast of 1.35.
const LEAST_CONTRAST_OVER_NOISE: f32 = 4.0;
/// Least area of a pool \[px²\], and as a part of the frame; chosen: less is a spark.
const LEAST_AREA_PX2: f64 = 12.0;
const LEAST_AREA_SHARE: f64 = 0.001;
/// An edge has at least this part of the contrast between pool and surroundings within a ray's reach; chosen: a glow
/// without an edge falls over the whole pool's size.
const EDGE_CONTRAST: f32 = 0.25;
/// A pool has such an edge along at least this part of its outline; chosen.
const EDGE_SHARE: f64 = 0.4;
/// Times a region without an edge is split again: a plume may be what Otsu separates first, the pool second.
const SPLITS: usize = 2;
/// Frames whose shorter side is longer than this are opened over 7 px, smaller ones over 3 px. Chosen: sparks and
/// glints are a few pixels wide.
const LARGE_FRAME_PX: usize = 128;

/// The level between pool and surroundings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Threshold {
    /// Otsu's two classes in each frame, then the middle between their medians.
    Otsu,
    /// A fixed intensity of the recording (0 black, 1 white).
    Fixed(f64),
}

/// The pool of one frame.
#[derive(Debug, Default)]
pub(super) struct Pool {
    /// Outermost pixels of the pool in order, closed.
    pub(super) outline: Vec<[f64; 2]>,
    pub(super) area_px2: f64,
    /// How far rays across the outline reach \[px\].
    pub(super) reach_px: usize,
    /// Least contrast of what counts as the pool's edge.
    pub(super) least_edge: f32,
}

impl Pool {
    /// Finds the pool of a picture.
    pub(super) fn find(
        &mut self,
        picture: &Turned,
        stretched: &Stretched,
        segmenter: &mut Segmenter,
        threshold: Threshold,
    ) -> Result<Result<(), Refusal>, SegmentationError> {
        if stretched.saturated_share > SATURATED_SHARE {
            return Ok(Err(Refusal::Saturated));
        }
        let mut level = match threshold {
            Threshold::Fixed(light) => stretched.grey_of(light as f32),
            Threshold::Otsu => middle(stretched, 0, segmenter.otsu(&stretched.grey, picture.width)?),
        };
        for split in 0..=SPLITS {
            let contrast = match classes(stretched, level) {
                Some((outside, inside)) => stretched.light(inside) - stretched.light(outside),
                None => 0.0,
            };
            if contrast < LEAST_CONTRAST.max(LEAST_CONTRAST_OVER_NOISE * stretched.noise) {
                return Ok(Err(if split == 0 { Refusal::NoPool } else { Refusal::NoEdge }));
            }
            let opening_px = if picture.width.min(picture.height) > LARGE_FRAME_PX { 7 } else { 3 };
            self.area_px2 =
                segmenter.largest(&stretched.grey, picture.width, level, opening_px, &mut self.outline)?;
            if self.area_px2 < LEAST_AREA_PX2.max(LEAST_AREA_SHARE * picture.light.len() as f64) {
                return Ok(Err(Refusal::NoPool));
            }
            self.reach_px = reach_px(self.area_px2);
            self.least_edge = EDGE_CONTRAST * contrast;
            if self.edge_share(picture) >= EDGE_SHARE {
                return Ok(Ok(()));
            }
            if let Threshold::Fixed(_) = threshold {
                break;
            }
            level = middle(stretched, level, otsu_above(stretched, level));
        }
        Ok(Err(Refusal::NoEdge))
    }

    /// The outward unit normal at a place of the outline, from the points `arm` before and after it.
    pub(super) fn normal(&self, index: usize, arm: usize) -> [f64; 2] {
        let count = self.outline.len();
        let (before, after) = (self.outline[(index + count - arm) % count], self.outline[(index + arm) % count]);
        let (dx, dy) = (after[0] - before[0], after[1] - before[1]);
        let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
        // OpenCV gives outer contours against the clock as seen in a picture whose rows count downwards.
        [-dy / length, dx / length]
    }

    /// The sides of the picture that the pool reaches, of the turned picture.
    pub(super) fn touches(&self, picture: &Turned, border: Border) -> bool {
        let (right, bottom) = ((picture.width - 1) as f64, (picture.height - 1) as f64);
        self.outline.iter().any(|&point| match border {
            Border::Side => point[0] == 0.0 || point[0] == right,
            Border::Front => point[1] == 0.0,
            Border::Behind => point[1] == bottom,
        })
    }

    /// Part of the outline inside the picture that has an edge.
    fn edge_share(&self, picture: &Turned) -> f64 {
        let (right, bottom) = ((picture.width - 1) as f64, (picture.height - 1) as f64);
        let step = (self.outline.len() / 64).max(1);
        let arm = self.reach_px.min(self.outline.len() / 4).max(1);
        let (mut inside, mut with_edge) = (0, 0);
        for index in (0..self.outline.len()).step_by(step) {
            let point = self.outline[index];
            if point[0] == 0.0 || point[1] == 0.0 || point[0] == right || point[1] == bottom {
                continue;
            }
            inside += 1;
            let found = edge(picture, point, self.normal(index, arm), self.reach_px);
            with_edge += usize::from(found.is_some_and(|edge| edge.contrast >= self.least_edge));
        }
        if inside == 0 { 0.0 } else { f64::from(with_edge as u32) / f64::from(inside) }
    }
}

/// Median grey below and above a level; none when a class is empty.
fn classes(stretched: &Stretched, level: u8) -> Option<(f32, f32)> {
    Some((stretched.median_of(0..=level)?, stretched.median_of(level.saturating_add(1)..=255)?))
}

/// The level halfway between the medians of the two classes that `split` makes of the greys above `from`.
fn middle(stretched: &Stretched, from: u8, split: u8) -> u8 {
    let (below, above) = (stretched.median_of(from..=split.max(from)), stretched.median_of(split.saturating_add(1)..=255));
    below.zip(above).map_or(split, |(below, above)| (0.5 * (below + above)) as u8)
}

/// Otsu's level of the pixels brighter than `level`.
fn otsu_above(stretched: &Stretched, level: u8) -> u8 {
    let bins = stretched.bins(level);
    let total: f64 = bins.iter().map(|(_, count)| count).sum();
    let sum: f64 = bins.iter().map(|(grey, count)| grey * count).sum();
    let (mut count_below, mut sum_below) = (0.0, 0.0);
    let mut best = (0.0, level);
    for &(grey, count) in &bins {
        count_below += count;
        sum_below += grey * count;
        let count_above = total - count_below;
        if count_below == 0.0 || count_above <= 0.0 {
            continue;
        }
        let difference = (sum - sum_below) / count_above - sum_below / count_below;
        let between = count_below * count_above * difference * difference;
        if between > best.0 {
            best = (between, grey as u8);
        }
    }
    best.1
}
