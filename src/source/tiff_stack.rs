//! A multi-page TIFF.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::gray::{Decoded, DecodedSource, LARGEST_FRAME_PIXELS, SixteenBitScale, check_size, file_name};
use super::{FrameError, FrameSource, SourceError, SourceFrame};

/// Pages that a 16-bit recording's scale is taken from.
const SCALE_PAGES: usize = 5;

/// The pages of a TIFF file.
pub struct TiffStack {
    name: String,
    decoder: Option<Decoder<BufReader<File>>>,
    page: usize,
    period_s: f64,
    scale: Option<SixteenBitScale>,
}

impl TiffStack {
    /// Opens the file and reads the scale of its first pages.
    pub fn open(path: &Path, period_s: f64) -> Result<Self, SourceError> {
        let mut first = Self { name: file_name(path), decoder: Some(decoder(path)?), page: 0, period_s, scale: None };
        let mut pages = vec![];
        while pages.len() < SCALE_PAGES
            && let Some((_, page)) = first.next_page()
        {
            pages.extend(page.ok());
        }
        let scale = SixteenBitScale::from_first_frames(&pages);
        Ok(Self { decoder: Some(decoder(path)?), page: 0, scale, ..first })
    }

    fn next_page(&mut self) -> Option<(usize, Result<Decoded, FrameError>)> {
        let page = self.page;
        let mut decoder = self.decoder.take()?;
        self.page += 1;
        let file = format!("{}[{page}]", self.name);
        let decoded = decode_page(&mut decoder, &file);
        if decoder.more_images() && decoder.next_image().is_ok() {
            self.decoder = Some(decoder);
        }
        Some((page, decoded))
    }
}

fn decoder(path: &Path) -> Result<Decoder<BufReader<File>>, SourceError> {
    let file = File::open(path).map_err(|source| SourceError::Open { path: path.to_owned(), source })?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = LARGEST_FRAME_PIXELS as usize * 2;
    Ok(Decoder::new(BufReader::new(file))
        .map_err(|_| SourceError::UnknownKind(PathBuf::from(path)))?
        .with_limits(limits))
}

fn decode_page(decoder: &mut Decoder<BufReader<File>>, file: &str) -> Result<Decoded, FrameError> {
    let failed =
        |source: Box<dyn std::error::Error + Send + Sync>| FrameError::Decode { file: file.to_owned(), source };
    let (width, height) = decoder.dimensions().map_err(|e| failed(Box::new(e)))?;
    check_size(file, width, height)?;
    let colour = decoder.colortype().map_err(|e| failed(Box::new(e)))?;
    let image = match (decoder.read_image().map_err(|e| failed(Box::new(e)))?, colour) {
        (DecodingResult::U8(grey), ColorType::Gray(8)) => {
            image::GrayImage::from_raw(width, height, grey).map(Into::into)
        }
        (DecodingResult::U8(rgb), ColorType::RGB(8)) => image::RgbImage::from_raw(width, height, rgb).map(Into::into),
        (DecodingResult::U16(grey), ColorType::Gray(16)) => {
            image::ImageBuffer::<image::Luma<u16>, _>::from_raw(width, height, grey).map(Into::into)
        }
        (DecodingResult::U16(rgb), ColorType::RGB(16)) => {
            image::ImageBuffer::<image::Rgb<u16>, _>::from_raw(width, height, rgb).map(Into::into)
        }
        (_, other) => {
            return Err(failed(format!("its pages are {other:?}; grey or RGB of 8 or 16 bits is read").into()));
        }
    };
    image.and_then(Decoded::from_image).ok_or_else(|| failed("its page is cut short".into()))
}

impl DecodedSource for TiffStack {
    fn next_decoded(&mut self) -> Option<SourceFrame<Decoded>> {
        let (page, picture) = self.next_page()?;
        let file = format!("{}[{page}]", self.name);
        Some(SourceFrame { file, time_s: page as f64 * self.period_s, picture })
    }
}

impl FrameSource for TiffStack {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let scale = self.scale;
        self.next_decoded().map(|frame| frame.in_gray(scale))
    }

    fn frame_count(&self) -> Option<usize> {
        None
    }

    fn kind(&self) -> &'static str {
        "multi-page TIFF"
    }

    fn sixteen_bit_scale(&self) -> Option<SixteenBitScale> {
        self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiff::encoder::{TiffEncoder, colortype};

    #[test]
    fn every_page_is_a_frame_and_sixteen_bits_share_one_scale() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stack.tif");
        let mut encoder = TiffEncoder::new(File::create(&path).unwrap()).unwrap();
        for grey in [1000u16, 4095, 2047] {
            encoder.write_image::<colortype::Gray16>(4, 3, &[grey; 12]).unwrap();
        }
        drop(encoder);
        let mut stack = TiffStack::open(&path, 0.5).unwrap();
        assert_eq!(stack.sixteen_bit_scale(), Some(SixteenBitScale { white: 4095 }));
        let frames: Vec<SourceFrame> = std::iter::from_fn(|| stack.next_frame()).collect();
        let greys: Vec<u8> = frames.iter().map(|f| f.picture.as_ref().unwrap().pixels()[0]).collect();
        assert_eq!(greys, [62, 255, 127]);
        assert_eq!(frames[2].time_s, 1.0);
        assert_eq!(frames[2].file, "stack.tif[2]");
    }
}
