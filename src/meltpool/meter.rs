//! One frame in, one measure out.

use super::Measure;
use super::cv::{SegmentationError, Segmenter};
use super::grey::Stretched;
use super::pool::{Other, Pool, Threshold};
use super::refusal::Refusal;
use super::tip::{Tip, TipMeter};
use super::travel::Turned;
use super::width::WidthMeter;
use crate::frame::IntensityFrame;
use crate::units::{PixelPoint, Travel};

/// What was measured in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The tip's image coordinate across the travel, or the pool's width \[px\].
    pub value_px: f64,
    /// Where in the image: the tip twice, or the two ends of the width.
    pub ends: [PixelPoint; 2],
}

/// Measures frames of one recording; its buffers are made once.
#[derive(Debug)]
pub struct Meter {
    measure: Measure,
    travel: Travel,
    threshold: Threshold,
    size_px: (usize, usize),
    turned: Vec<f32>,
    stretched: Stretched,
    segmenter: Segmenter,
    pool: Pool,
    tip: TipMeter,
    width: WidthMeter,
}

impl Meter {
    /// A meter of one quantity.
    #[must_use]
    pub fn new(measure: Measure, travel: Travel, threshold: Threshold) -> Self {
        Self {
            measure,
            travel,
            threshold,
            size_px: (0, 0),
            turned: vec![],
            stretched: Stretched::default(),
            segmenter: Segmenter::new(),
            pool: Pool::default(),
            tip: TipMeter::default(),
            width: WidthMeter::default(),
        }
    }

    /// Measures a frame, or says why it cannot be measured.
    ///
    /// # Errors
    /// When OpenCV refuses the frame, for example for want of memory.
    pub fn measure(&mut self, frame: &IntensityFrame) -> Result<Result<Measured, Refusal>, SegmentationError> {
        self.size_px = (frame.width_px(), frame.height_px());
        let mut buffer = std::mem::take(&mut self.turned);
        let measured = self.measure_turned(&Turned::new(frame, self.travel, &mut buffer));
        self.turned = buffer;
        measured
    }

    fn measure_turned(&mut self, picture: &Turned<'_>) -> Result<Result<Measured, Refusal>, SegmentationError> {
        self.stretched.set(picture);
        self.pool.outline.clear();
        if let Err(refusal) = self.pool.find(picture, &self.stretched, &mut self.segmenter, self.threshold)? {
            return Ok(Err(refusal));
        }
        Ok(match self.measure {
            Measure::Tip => self.find_tip(picture)?.map(|tip| {
                let corner = self.in_image(tip.corner);
                Measured { value_px: tip.corner[0], ends: [corner, corner] }
            }),
            Measure::Width => self
                .width
                .measure(picture, &self.pool)
                .map(|width| Measured { value_px: width.width_px, ends: width.ends.map(|end| self.in_image(end)) }),
        })
    }

    /// The tip; without a corner on the first outline, that of another one.
    fn find_tip(&mut self, picture: &Turned<'_>) -> Result<Result<Tip, Refusal>, SegmentationError> {
        let first = self.tip.measure(picture, &self.pool);
        if first != Err(Refusal::NoCorner) || self.threshold != Threshold::Otsu {
            return Ok(first);
        }
        for other in [Other::Narrower, Other::Wider] {
            let found = self.pool.find_other(picture, &self.stretched, &mut self.segmenter, other)?;
            if let Ok(tip) = found.and_then(|()| self.tip.measure(picture, &self.pool)) {
                return Ok(Ok(tip));
            }
        }
        Ok(first)
    }

    fn in_image(&self, point: [f64; 2]) -> PixelPoint {
        self.travel.image_from_turned(point, self.size_px)
    }

    /// The outline of the region that the last frame's pool was taken for, in the image; empty when there was none.
    pub fn outline(&self) -> impl Iterator<Item = PixelPoint> + '_ {
        self.pool.outline.iter().map(|&point| self.travel.image_from_turned(point, self.size_px))
    }
}
