//! Decoded pictures to 8-bit grey.

use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageReader, Limits};
use serde::Serialize;

use super::{FrameError, FrameSource, SourceFrame};
use crate::frame::GrayFrame;

/// More pixels than a frame may have: larger ones are decompression bombs or a mistake. Chosen: three times the
/// largest machine-vision sensors in use.
pub const LARGEST_FRAME_PIXELS: u64 = 200_000_000;

/// A picture as decoded: 16-bit grey is kept until the recording's scale is known.
#[derive(Debug)]
pub enum Decoded {
    Gray8(GrayFrame),
    Gray16 { width_px: usize, height_px: usize, pixels: Vec<u16> },
}

/// A recording whose pictures can be had as they are decoded, in their full depth.
pub trait DecodedSource: FrameSource {
    /// The next picture; none at the end.
    fn next_decoded(&mut self) -> Option<SourceFrame<Decoded>>;
}

impl SourceFrame<Decoded> {
    /// The frame in 8-bit grey under the recording's scale.
    pub fn in_gray(self, scale: Option<SixteenBitScale>) -> SourceFrame {
        let Self { file, time_s, picture } = self;
        let picture = picture.and_then(|decoded| {
            decoded
                .into_gray(scale)
                .ok_or_else(|| FrameError::Decode { file: file.clone(), source: "it has no pixel".into() })
        });
        SourceFrame { file, time_s, picture }
    }
}

/// The grey value of a 16-bit recording that becomes 255.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SixteenBitScale {
    /// 16-bit grey that becomes 255.
    pub white: u16,
}

impl SixteenBitScale {
    /// The scale of a recording from its first frames: the bit depth (8, 10, 12, 14 or 16) into which 99.9 % of their
    /// pixels fit. Cameras of those depths write their values unshifted.
    pub fn from_first_frames(frames: &[Decoded]) -> Option<Self> {
        let mut greys: Vec<u16> = frames
            .iter()
            .filter_map(|frame| match frame {
                Decoded::Gray8(_) => None,
                Decoded::Gray16 { pixels, .. } => Some(pixels),
            })
            .flatten()
            .copied()
            .collect();
        Self::from_greys(&mut greys)
    }

    /// The scale of a recording from a sample of its pixels, by the same rule; none without any.
    pub fn from_greys(greys: &mut [u16]) -> Option<Self> {
        if greys.is_empty() {
            return None;
        }
        let rank = (greys.len() - 1) * 999 / 1000;
        let (_, &mut robust_maximum, _) = greys.select_nth_unstable(rank);
        let depth = [8, 10, 12, 14].into_iter().find(|&bits| u32::from(robust_maximum) < 1 << bits);
        Some(Self { white: depth.map_or(u16::MAX, |bits| (1 << bits) - 1) })
    }
}

impl Decoded {
    /// 8-bit grey under the recording's scale.
    pub fn into_gray(self, scale: Option<SixteenBitScale>) -> Option<GrayFrame> {
        match self {
            Self::Gray8(frame) => Some(frame),
            Self::Gray16 { width_px, height_px, pixels } => {
                let white = u32::from(scale.map_or(u16::MAX, |s| s.white));
                let grey = pixels.iter().map(|&p| ((u32::from(p) * 255 + white / 2) / white).min(255) as u8).collect();
                GrayFrame::new(width_px, height_px, grey).ok()
            }
        }
    }

    /// Decodes a picture in memory.
    pub fn from_image(image: DynamicImage) -> Option<Self> {
        let (width_px, height_px) = (image.width() as usize, image.height() as usize);
        match image {
            DynamicImage::ImageLuma16(_) | DynamicImage::ImageLumaA16(_) => {
                Some(Self::Gray16 { width_px, height_px, pixels: image.into_luma16().into_raw() })
            }
            _ => GrayFrame::new(width_px, height_px, image.into_luma8().into_raw()).ok().map(Self::Gray8),
        }
    }
}

/// Reads and decodes an image file.
pub fn decode(path: &Path) -> Result<Decoded, FrameError> {
    let file = file_name(path);
    let failed = |source: Box<dyn std::error::Error + Send + Sync>| FrameError::Decode { file: file.clone(), source };
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format).map_err(|e| failed(Box::new(e)))?;
    let mut decoder = reader.into_decoder().map_err(|e| failed(Box::new(e)))?;
    let (width_px, height_px) = decoder.dimensions();
    check_size(&file, width_px, height_px)?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(LARGEST_FRAME_PIXELS * 8);
    decoder.set_limits(limits).map_err(|e| failed(Box::new(e)))?;
    let image = DynamicImage::from_decoder(decoder).map_err(|e| failed(Box::new(e)))?;
    Decoded::from_image(image).ok_or_else(|| failed("it has no pixel".into()))
}

/// Refuses a picture with more pixels than any camera's, before it is decoded.
pub fn check_size(file: &str, width_px: u32, height_px: u32) -> Result<(), FrameError> {
    if u64::from(width_px) * u64::from(height_px) > LARGEST_FRAME_PIXELS {
        return Err(FrameError::TooLarge { file: file.to_owned(), width_px, height_px });
    }
    Ok(())
}

/// The name of a file without its folder.
pub fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sixteen(pixels: Vec<u16>) -> Decoded {
        Decoded::Gray16 { width_px: pixels.len(), height_px: 1, pixels }
    }

    #[test]
    fn a_twelve_bit_recording_fills_the_eight_bits_and_a_hot_pixel_does_not_darken_it() {
        let mut pixels = vec![100u16; 5000];
        pixels[0] = 4000;
        pixels.extend(vec![4095; 20]);
        pixels[1] = 65_535;
        let scale = SixteenBitScale::from_first_frames(&[sixteen(pixels.clone())]);
        assert_eq!(scale, Some(SixteenBitScale { white: 4095 }));
        let gray = sixteen(pixels).into_gray(scale).unwrap();
        assert_eq!((gray.pixels()[0], gray.pixels()[1], gray.pixels()[2]), (249, 255, 6));
    }
}
