//! The grey frame every stage reads, and the frame of full depth that the melt-pool sensors read.

use crate::units::PixelRect;

/// An owned 8-bit grey image, rows after one another without padding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GrayFrame {
    width_px: usize,
    height_px: usize,
    pixels: Vec<u8>,
}

/// A frame's pixel buffer does not fit its size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a frame of {width_px} x {height_px} pixels needs at least one pixel and {expected} bytes, got {got}",
    expected = width_px * height_px)]
pub struct FrameSizeError {
    width_px: usize,
    height_px: usize,
    got: usize,
}

impl GrayFrame {
    /// A frame of `width_px` columns and `height_px` rows.
    ///
    /// # Errors
    /// When `pixels.len() != width_px * height_px`, or the frame has no pixel.
    pub fn new(width_px: usize, height_px: usize, pixels: Vec<u8>) -> Result<Self, FrameSizeError> {
        if pixels.is_empty() || width_px.checked_mul(height_px) != Some(pixels.len()) {
            return Err(FrameSizeError { width_px, height_px, got: pixels.len() });
        }
        Ok(Self { width_px, height_px, pixels })
    }

    /// A frame of one grey value.
    ///
    /// # Errors
    /// When the frame has no pixel.
    pub fn filled(width_px: usize, height_px: usize, grey: u8) -> Result<Self, FrameSizeError> {
        Self::new(width_px, height_px, vec![grey; width_px * height_px])
    }

    /// A frame of one dark pixel.
    pub(crate) fn dot() -> Self {
        Self { width_px: 1, height_px: 1, pixels: vec![0] }
    }

    /// Number of columns.
    #[must_use]
    pub const fn width_px(&self) -> usize {
        self.width_px
    }

    /// Number of rows.
    #[must_use]
    pub const fn height_px(&self) -> usize {
        self.height_px
    }

    /// All pixels, row by row.
    #[must_use]
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// All pixels, row by row, for writing.
    pub fn pixels_mut(&mut self) -> &mut [u8] {
        &mut self.pixels
    }

    /// The pixels' memory, to be used again.
    #[must_use]
    pub fn into_pixels(self) -> Vec<u8> {
        self.pixels
    }

    /// One row.
    ///
    /// # Panics
    /// When `v` is not below [`Self::height_px`].
    #[must_use]
    pub fn row(&self, v: usize) -> &[u8] {
        &self.pixels[v * self.width_px..(v + 1) * self.width_px]
    }

    /// The grey value at column `u`, row `v`; the border continues outside.
    #[must_use]
    pub fn at_clamped(&self, u: isize, v: isize) -> u8 {
        let u = u.clamp(0, self.width_px as isize - 1) as usize;
        let v = v.clamp(0, self.height_px as isize - 1) as usize;
        self.pixels[v * self.width_px + u]
    }

    /// The part of the frame that `rect` covers; `None` when it covers nothing of it.
    #[must_use]
    pub fn cropped(&self, rect: PixelRect) -> Option<Self> {
        let part = rect.within((self.width_px, self.height_px))?;
        let rows = part.v_px..part.v_end_px();
        let pixels = rows.flat_map(|v| &self.row(v)[part.u_px..part.u_end_px()]).copied().collect();
        Some(Self { width_px: part.width_px, height_px: part.height_px, pixels })
    }

    /// The frame with rows and columns exchanged.
    #[must_use]
    pub fn transposed(&self) -> Self {
        // In tiles, so that both sides stay in the cache.
        const TILE: usize = 32;
        let (w, h) = (self.width_px, self.height_px);
        let mut pixels = vec![0; w * h];
        for v0 in (0..h).step_by(TILE) {
            for u0 in (0..w).step_by(TILE) {
                for v in v0..(v0 + TILE).min(h) {
                    for u in u0..(u0 + TILE).min(w) {
                        pixels[u * h + v] = self.pixels[v * w + u];
                    }
                }
            }
        }
        Self { width_px: h, height_px: w, pixels }
    }
}

/// An owned grey image of full depth: one `f32` a pixel, 0 at the recording's black and 1 at its white. Values beyond
/// both are kept.
#[derive(Debug, Clone, PartialEq)]
pub struct IntensityFrame {
    width_px: usize,
    height_px: usize,
    pixels: Vec<f32>,
}

impl IntensityFrame {
    /// A frame of `width_px` columns and `height_px` rows.
    ///
    /// # Errors
    /// When `pixels.len() != width_px * height_px`, or the frame has no pixel.
    pub fn new(width_px: usize, height_px: usize, pixels: Vec<f32>) -> Result<Self, FrameSizeError> {
        if pixels.is_empty() || width_px.checked_mul(height_px) != Some(pixels.len()) {
            return Err(FrameSizeError { width_px, height_px, got: pixels.len() });
        }
        Ok(Self { width_px, height_px, pixels })
    }

    /// Number of columns.
    #[must_use]
    pub const fn width_px(&self) -> usize {
        self.width_px
    }

    /// Number of rows.
    #[must_use]
    pub const fn height_px(&self) -> usize {
        self.height_px
    }

    /// All pixels, row by row.
    #[must_use]
    pub fn pixels(&self) -> &[f32] {
        &self.pixels
    }

    /// The frame in 8 bits, for looking at: black becomes 0, white 255.
    #[must_use]
    pub fn to_gray(&self) -> GrayFrame {
        let grey = |&light: &f32| (255.0 * light + 0.5).clamp(0.0, 255.0) as u8;
        GrayFrame { width_px: self.width_px, height_px: self.height_px, pixels: self.pixels.iter().map(grey).collect() }
    }
}

impl From<&GrayFrame> for IntensityFrame {
    fn from(frame: &GrayFrame) -> Self {
        let pixels = frame.pixels.iter().map(|&grey| f32::from(grey) / 255.0).collect();
        Self { width_px: frame.width_px, height_px: frame.height_px, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposing_twice_gives_the_frame_back() {
        let frame = GrayFrame::new(70, 33, (0..70 * 33).map(|i| (i % 251) as u8).collect()).unwrap();
        let turned = frame.transposed();
        assert_eq!((turned.width_px(), turned.height_px()), (33, 70));
        assert_eq!(turned.at_clamped(5, 60), frame.at_clamped(60, 5));
        assert_eq!(turned.transposed(), frame);
    }

    #[test]
    fn a_part_has_the_pixels_it_covers_and_what_lies_outside_is_left_out() {
        let frame = GrayFrame::new(4, 3, (0..12).collect()).unwrap();
        let part = |u_px, v_px, width_px, height_px| frame.cropped(PixelRect { u_px, v_px, width_px, height_px });
        assert_eq!(part(1, 1, 2, 2).unwrap().pixels(), [5, 6, 9, 10]);
        assert_eq!(part(3, 2, usize::MAX, 9).unwrap().pixels(), [11]);
        assert_eq!(part(4, 0, 1, 1), None);
    }

    #[test]
    fn a_buffer_that_does_not_fit_is_refused() {
        assert!(GrayFrame::new(2, 2, vec![0; 3]).is_err());
        assert!(GrayFrame::new(0, 0, vec![]).is_err());
    }
}
