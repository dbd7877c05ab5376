//! The raster that a picture is brought to before anything looks at it.
//!
//! Joints come in all sizes: a gap is 3 px wide in one picture and 250 px in another. What looks at a frame looks through
//! windows of a fixed size, so the picture is brought to them: the raster has `scale` pixels for each of the picture's.
//! Lengths named `_px` behind this point are the raster's.

use std::borrow::Cow;

use crate::frame::GrayFrame;
use crate::units::PixelPoint;

/// A raster of `scale` pixels a picture pixel; pixel centres are integers in both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Raster {
    scale: f64,
}

impl Raster {
    /// The picture's own.
    pub const PICTURE: Self = Self { scale: 1.0 };

    /// The raster in which `coarseness` by `coarseness` pixels of the picture are one.
    #[must_use]
    pub fn coarser(coarseness: usize) -> Self {
        Self { scale: 1.0 / coarseness.max(1) as f64 }
    }

    /// Picture pixels a raster pixel, along each side.
    #[must_use]
    pub fn coarseness(self) -> usize {
        (1.0 / self.scale).round() as usize
    }

    /// Raster pixels a picture pixel.
    #[must_use]
    pub const fn scale(self) -> f64 {
        self.scale
    }

    /// The point of the raster at a point of the picture.
    #[must_use]
    pub fn raster_from_picture(self, point: PixelPoint) -> PixelPoint {
        let turned = |px: f64| (px + 0.5) * self.scale - 0.5;
        PixelPoint::new(turned(point.u_px), turned(point.v_px))
    }

    /// The point of the picture at a point of the raster.
    #[must_use]
    pub fn picture_from_raster(self, point: PixelPoint) -> PixelPoint {
        let turned = |px: f64| (px + 0.5) / self.scale - 0.5;
        PixelPoint::new(turned(point.u_px), turned(point.v_px))
    }

    /// The picture in this raster: each pixel the mean of those it covers. What is left over at the right and lower
    /// border is cut off. `None` where nothing would be left.
    #[must_use]
    pub fn resample(self, picture: &GrayFrame) -> Option<Cow<'_, GrayFrame>> {
        let side = self.coarseness();
        if side <= 1 {
            return Some(Cow::Borrowed(picture));
        }
        let (width, height) = (picture.width_px() / side, picture.height_px() / side);
        let mut frame = GrayFrame::filled(width, height, 0).ok()?;
        for (v, row) in frame.pixels_mut().chunks_exact_mut(width).enumerate() {
            self.mean_row(picture, (0, v * side), row);
        }
        Some(Cow::Owned(frame))
    }

    /// A row of the raster: in each pixel the mean of those of `picture` that it covers, from column and row `first` on.
    ///
    /// # Panics
    /// When the picture does not hold them all.
    pub(crate) fn mean_row(self, picture: &GrayFrame, first: (usize, usize), target: &mut [u8]) {
        /// Raster pixels whose sums are held at a time.
        const BLOCK: usize = 64;
        let side = self.coarseness();
        let count = (side * side) as u32;
        for (block, target) in target.chunks_mut(BLOCK).enumerate() {
            let mut sums = [0u32; BLOCK];
            for v in first.1..first.1 + side {
                let row = &picture.row(v)[first.0 + block * BLOCK * side..][..target.len() * side];
                for (sum, cell) in sums.iter_mut().zip(row.chunks_exact(side)) {
                    *sum += cell.iter().map(|&grey| u32::from(grey)).sum::<u32>();
                }
            }
            for (grey, sum) in target.iter_mut().zip(sums) {
                *grey = ((sum + count / 2) / count) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_comes_back_from_the_raster_and_a_block_is_its_pixel() {
        for coarseness in [1, 2, 5, 8] {
            let raster = Raster::coarser(coarseness);
            let point = PixelPoint::new(123.4, 56.7);
            let back = raster.picture_from_raster(raster.raster_from_picture(point));
            assert!((back.u_px - point.u_px).abs() < 1e-9 && (back.v_px - point.v_px).abs() < 1e-9);
            // The middle of the first block.
            let middle = 0.5 * (coarseness as f64 - 1.0);
            let first = raster.raster_from_picture(PixelPoint::new(middle, middle));
            assert!(first.u_px.abs() < 1e-12 && first.v_px.abs() < 1e-12);
        }
    }

    #[test]
    fn a_pixel_is_the_mean_of_what_it_covers() {
        let picture = GrayFrame::new(5, 4, (0..20).map(|i| 10 * i as u8).collect()).unwrap();
        let coarse = Raster::coarser(2).resample(&picture).unwrap();
        assert_eq!((coarse.width_px(), coarse.height_px()), (2, 2));
        assert_eq!(coarse.pixels(), [30, 50, 130, 150]);
        assert_eq!(Raster::coarser(5).resample(&picture), None);
        assert_eq!(*Raster::PICTURE.resample(&picture).unwrap(), picture);
    }
}
