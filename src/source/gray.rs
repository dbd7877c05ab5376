//! Decoded pictures to 8-bit grey.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

use image::{ColorType, DynamicImage, ImageDecoder, ImageReader, Limits};
use serde::Serialize;

use super::{FrameError, FrameSource, SourceError, SourceFrame};
use crate::frame::GrayFrame;

/// Most pixels of a frame: larger ones are decompression bombs or a mistake. Chosen: what a machine-vision sensor of
/// the largest kind in common use has.
pub const MOST_PIXELS: u64 = 64_000_000;
/// Longest side of a frame \[px\]. Chosen: twice that of such a sensor, as line sensors have it.
pub const LONGEST_SIDE_PX: u32 = 16_384;
/// Most bytes of a pixel while it is decoded: red, green, blue and opacity of 16 bits.
const MOST_BYTES_A_PIXEL: u64 = 8;
/// Frames, spread evenly over a recording, that the scale of 16-bit grey is taken from. Chosen: they meet the stripe
/// wherever it is lit, and are quick to read.
const SCALE_FRAMES: usize = 16;

/// A picture as decoded: 16-bit grey is kept until the recording's scale is known.
#[derive(Debug)]
pub enum Decoded {
    Gray8(GrayFrame),
    Gray16 { width_px: usize, height_px: usize, pixels: Vec<u16> },
}

/// A recording whose pictures can be had as they are decoded, in their full depth.
pub trait DecodedSource: FrameSource + Sized {
    /// The next picture; none at the end.
    fn next_decoded(&mut self) -> Option<SourceFrame<Decoded>>;
    /// What [`FrameSource::again`] gives, as what it is.
    fn rewound(&self) -> Result<Self, SourceError>;
}

impl SourceFrame<Decoded> {
    /// The frame in 8-bit grey under the recording's scale.
    pub fn in_gray(self, scale: Option<SixteenBitScale>) -> SourceFrame {
        let Self { file, time_s, picture } = self;
        let picture = picture
            .and_then(|decoded| decoded.into_gray(scale).ok_or_else(|| FrameError::decode(&file, "it has no pixel")));
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
    /// The 8-bit grey of a 16-bit one; a white of 0 is one of 1.
    #[must_use]
    pub fn eight_bits(self, grey: u16) -> u8 {
        let white = u64::from(self.white.max(1));
        // Divided by multiplying, as that goes side by side: exact for numerators below 2^24 and divisors below 2^16.
        let reciprocal = (1 << 40) / white + 1;
        (((u64::from(grey) * 255 + white / 2) * reciprocal) >> 40).min(255) as u8
    }

    /// The scale of a recording: the bit depth (8, 10, 12, 14 or 16) into which 99.9 % of the pixels of each frame of a
    /// sample fit; none where no frame is of 16 bits. Cameras of those depths write their values unshifted. Dark frames,
    /// however many, do not lower it.
    pub fn of_frames(sample: impl IntoIterator<Item = Decoded>) -> Option<Self> {
        let scales = sample.into_iter().filter_map(|frame| match frame {
            Decoded::Gray8(_) => None,
            Decoded::Gray16 { pixels, .. } => Self::from_greys(&pixels),
        });
        scales.max_by_key(|scale| scale.white)
    }

    /// The depth into which 99.9 % of these pixels fit; none without any.
    pub fn from_greys(greys: &[u16]) -> Option<Self> {
        let rank = greys.len().checked_sub(1)? * 999 / 1000;
        let fit = |white: u16| greys.iter().filter(|&&grey| grey <= white).count() > rank;
        let white = [8, 10, 12, 14].into_iter().map(|bits| (1 << bits) - 1).find(|&white| fit(white));
        Some(Self { white: white.unwrap_or(u16::MAX) })
    }
}

impl Decoded {
    /// 8-bit grey under the recording's scale.
    pub fn into_gray(self, scale: Option<SixteenBitScale>) -> Option<GrayFrame> {
        match self {
            Self::Gray8(frame) => Some(frame),
            Self::Gray16 { width_px, height_px, pixels } => {
                let scale = scale.unwrap_or(SixteenBitScale { white: u16::MAX });
                let grey = pixels.iter().map(|&grey| scale.eight_bits(grey)).collect();
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

/// The numbers of the frames that the scale of 16-bit grey is taken from.
pub fn scale_frames(count: usize) -> impl Iterator<Item = usize> {
    let sampled = count.min(SCALE_FRAMES);
    (0..sampled).map(move |i| i * count / sampled)
}

/// Whether the file's header says that it holds 16-bit grey; none when it cannot be read.
pub fn is_sixteen_bit(path: &Path) -> Option<bool> {
    let decoder = reader(path).ok()?.into_decoder().ok()?;
    Some(matches!(decoder.color_type(), ColorType::L16 | ColorType::La16))
}

fn reader(path: &Path) -> std::io::Result<ImageReader<BufReader<File>>> {
    // Opening a named pipe would wait for whoever writes into it.
    match std::fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => ImageReader::open(path).and_then(ImageReader::with_guessed_format),
        Ok(_) => Err(std::io::Error::other("it is no file")),
        Err(_) if path.is_symlink() => Err(std::io::Error::other("it is a link that leads nowhere")),
        Err(error) => Err(error),
    }
}

/// Reads and decodes an image file.
pub fn decode(path: &Path) -> Result<Decoded, FrameError> {
    let file = file_name(path);
    decode_image(reader(path).map_err(|error| FrameError::decode(&file, error))?, &file)
}

/// Decodes the image that a reader holds; `file` names it.
pub fn decode_image<R: BufRead + Seek>(reader: ImageReader<R>, file: &str) -> Result<Decoded, FrameError> {
    let failed = |error: image::ImageError| FrameError::decode(file, error);
    let mut decoder = reader.into_decoder().map_err(failed)?;
    let (width_px, height_px) = decoder.dimensions();
    check_size(file, width_px, height_px)?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_PIXELS * MOST_BYTES_A_PIXEL);
    decoder.set_limits(limits).map_err(failed)?;
    let image = DynamicImage::from_decoder(decoder).map_err(failed)?;
    Decoded::from_image(image).ok_or_else(|| FrameError::decode(file, "it has no pixel"))
}

/// Refuses a picture with more pixels than any camera's, before it is decoded.
pub fn check_size(file: &str, width_px: u32, height_px: u32) -> Result<(), FrameError> {
    let is_long = width_px.max(height_px) > LONGEST_SIDE_PX;
    if is_long || u64::from(width_px) * u64::from(height_px) > MOST_PIXELS {
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
        let scale = SixteenBitScale::of_frames([sixteen(pixels.clone())]);
        assert_eq!(scale, Some(SixteenBitScale { white: 4095 }));
        let gray = sixteen(pixels).into_gray(scale).unwrap();
        assert_eq!((gray.pixels()[0], gray.pixels()[1], gray.pixels()[2]), (249, 255, 6));
    }

    #[test]
    fn every_grey_is_rounded_to_the_nearest_of_eight_bits() {
        for white in [1, 3, 255, 1000, 1023, 4095, 16_383, 65_534, u16::MAX] {
            let nearest =
                |grey: u16| ((u32::from(grey) * 255 + u32::from(white) / 2) / u32::from(white)).min(255) as u8;
            assert!((0..=u16::MAX).all(|grey| SixteenBitScale { white }.eight_bits(grey) == nearest(grey)), "{white}");
        }
    }

    #[test]
    fn one_lit_frame_among_dark_ones_gives_the_scale() {
        let frames = (0..16).map(|i| sixteen(vec![if i == 11 { 900 } else { 3 }; 200]));
        assert_eq!(SixteenBitScale::of_frames(frames), Some(SixteenBitScale { white: 1023 }));
    }

    #[test]
    fn long_sides_and_many_pixels_are_refused() {
        assert!(check_size("a", 100_000_000, 1).is_err() && check_size("a", 1, 16_385).is_err());
        assert!(check_size("a", 9000, 9000).is_err() && check_size("a", 16_384, 3900).is_ok());
    }
}
