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
/// The sharpness of an outline: the median over it of the light's fall within a ray's reach, over the contrast of pool and
/// surroundings. A step has 1. Chosen: a glow without an edge falls over the whole pool's size, and has less than this.
const LEAST_SHARPNESS: f32 = 0.25;
/// Other outlines are looked for when Otsu's is less sharp than this, and taken when they are sharper than the second.
/// Chosen: thermal pools with soft edges have 0.6 to 0.8, the glow round a hot spot less, the step round the pool more.
const SOFT: f32 = 0.7;
const SHARP: f32 = 0.9;
/// A place of the outline where the light falls by less than this part of the median fall is not the pool's edge; chosen.
const EDGE_CONTRAST: f32 = 0.25;
/// Places at which the sharpness is looked at.
const SHARPNESS_PLACES: usize = 64;
/// Frames whose shorter side is longer than this are opened over 7 px, smaller ones over 3 px. Chosen: sparks and
/// glints are a few pixels wide.
const LARGE_FRAME_PX: usize = 128;

const BORDERS: [Border; 3] = [Border::Side, Border::Front, Border::Behind];

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
    /// Least fall of the light at what counts as the pool's edge.
    pub(super) least_edge: f32,
    /// The first level tried.
    level: u8,
    falls: Vec<f32>,
}

/// Another outline than the first.
#[derive(Debug, Clone, Copy)]
pub(super) enum Other {
    /// Round pixels that are darker than the first level: the pool round its hot spot.
    Wider,
    /// Round pixels that are brighter: the pool in its plume.
    Narrower,
}

impl Pool {
    /// Finds the pool of a picture.
    pub(super) fn find(
        &mut self,
        picture: &Turned<'_>,
        stretched: &Stretched,
        segmenter: &mut Segmenter,
        threshold: Threshold,
    ) -> Result<Result<(), Refusal>, SegmentationError> {
        if stretched.saturated_share > SATURATED_SHARE {
            return Ok(Err(Refusal::Saturated));
        }
        let first = match threshold {
            Threshold::Fixed(light) => stretched.grey_of(light as f32),
            Threshold::Otsu => {
                let split = segmenter.otsu(&stretched.grey, picture.width)?;
                middle(stretched, 0..=255, split)
            }
        };
        self.level = first;
        let sharpness = match self.outline_at(picture, stretched, segmenter, 0..=255, first)? {
            Ok(sharpness) => sharpness,
            Err(refusal) => return Ok(Err(refusal)),
        };
        if sharpness >= SOFT || matches!(threshold, Threshold::Fixed(_)) {
            return Ok(if sharpness >= LEAST_SHARPNESS { Ok(()) } else { Err(Refusal::NoEdge) });
        }
        // A hot spot in the pool may be what Otsu separates first. A wider outline that reaches the border is that of a
        // glow: pools round a hot spot are seen whole.
        let found = self.find_other(picture, stretched, segmenter, Other::Wider)?;
        if found.is_ok() && !BORDERS.iter().any(|&side| self.touches(picture, side)) {
            return Ok(Ok(()));
        }
        Ok(match self.outline_at(picture, stretched, segmenter, 0..=255, first)? {
            Ok(sharpness) if sharpness >= LEAST_SHARPNESS => Ok(()),
            Ok(_) => Err(Refusal::NoEdge),
            Err(refusal) => Err(refusal),
        })
    }

    /// Takes the outline that Otsu finds among the pixels below or above the first level, if it is sharp.
    pub(super) fn find_other(
        &mut self,
        picture: &Turned<'_>,
        stretched: &Stretched,
        segmenter: &mut Segmenter,
        other: Other,
    ) -> Result<Result<(), Refusal>, SegmentationError> {
        let greys = match other {
            Other::Wider => 0..=self.level,
            Other::Narrower => self.level.saturating_add(1)..=255,
        };
        let Some(split) = stretched.otsu_within(greys.clone()) else { return Ok(Err(Refusal::NoPool)) };
        let level = middle(stretched, greys.clone(), split);
        let sharpness = self.outline_at(picture, stretched, segmenter, greys, level)?;
        Ok(sharpness.and_then(|sharpness| if sharpness > SHARP { Ok(()) } else { Err(Refusal::NoEdge) }))
    }

    /// Takes the outline at a level; gives its sharpness, in units of the contrast of the greys of a range below and above.
    fn outline_at(
        &mut self,
        picture: &Turned<'_>,
        stretched: &Stretched,
        segmenter: &mut Segmenter,
        greys: std::ops::RangeInclusive<u8>,
        level: u8,
    ) -> Result<Result<f32, Refusal>, SegmentationError> {
        let (darkest, brightest) = greys.into_inner();
        let medians = (stretched.median_of(darkest..=level), stretched.median_of(level.saturating_add(1)..=brightest));
        let (Some(outside), Some(inside)) = medians else { return Ok(Err(Refusal::NoPool)) };
        let contrast = stretched.light(inside) - stretched.light(outside);
        if contrast < LEAST_CONTRAST.max(LEAST_CONTRAST_OVER_NOISE * stretched.noise) {
            return Ok(Err(Refusal::NoPool));
        }
        let opening_px = if picture.width.min(picture.height) > LARGE_FRAME_PX { 7 } else { 3 };
        self.area_px2 = segmenter.largest(&stretched.grey, picture.width, level, opening_px, &mut self.outline)?;
        if self.area_px2 < LEAST_AREA_PX2.max(LEAST_AREA_SHARE * picture.light.len() as f64) {
            return Ok(Err(Refusal::NoPool));
        }
        self.reach_px = reach_px(self.area_px2);
        let fall = self.fall(picture);
        self.least_edge = EDGE_CONTRAST * fall;
        Ok(Ok(fall / contrast))
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
    pub(super) fn touches(&self, picture: &Turned<'_>, border: Border) -> bool {
        let (right, bottom) = ((picture.width - 1) as f64, (picture.height - 1) as f64);
        self.outline.iter().any(|&point| match border {
            Border::Side => point[0] == 0.0 || point[0] == right,
            Border::Front => point[1] == 0.0,
            Border::Behind => point[1] == bottom,
        })
    }

    /// The median fall of the light across the outline inside the picture; 0 where it does not fall.
    fn fall(&mut self, picture: &Turned<'_>) -> f32 {
        let (right, bottom) = ((picture.width - 1) as f64, (picture.height - 1) as f64);
        let step = (self.outline.len() / SHARPNESS_PLACES).max(1);
        let arm = self.reach_px.min(self.outline.len() / 4).max(1);
        self.falls.clear();
        for index in (0..self.outline.len()).step_by(step) {
            let point = self.outline[index];
            if point[0] > 0.0 && point[1] > 0.0 && point[0] < right && point[1] < bottom {
                let found = edge(picture, point, self.normal(index, arm), self.reach_px);
                self.falls.push(found.map_or(0.0, |edge| edge.contrast));
            }
        }
        let middle = self.falls.len() / 2;
        if self.falls.is_empty() {
            return 0.0;
        }
        *self.falls.select_nth_unstable_by(middle, f32::total_cmp).1
    }
}

/// The level halfway between the medians of the two classes that `split` makes of a range of greys.
fn middle(stretched: &Stretched, greys: std::ops::RangeInclusive<u8>, split: u8) -> u8 {
    let below = stretched.median_of(*greys.start()..=split);
    let above = stretched.median_of(split.saturating_add(1)..=*greys.end());
    below.zip(above).map_or(split, |(below, above)| (0.5 * (below + above)) as u8)
}
