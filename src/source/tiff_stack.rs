//! A multi-page TIFF.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::gray::{Decoded, DecodedSource, MOST_PIXELS, SixteenBitScale, check_size, file_name, scale_frames};
use super::{FrameError, FrameSource, Period, SourceError, SourceFrame};

/// Most bytes of a pixel: red, green and blue of 16 bits.
const MOST_BYTES_A_PIXEL: usize = 6;

/// Most pages that are read. Chosen: eleven days at one a second.
const MOST_PAGES: usize = 1_000_000;

/// The pages of a TIFF file.
///
/// A file that is cut short loses its list of pages where it ends: the page that cannot be reached is one that cannot be
/// read. How many there were behind it nobody knows.
pub struct TiffStack {
    path: PathBuf,
    decoder: Decoder<BufReader<File>>,
    next: usize,
    pages: usize,
    period_s: f64,
    scale: Option<SixteenBitScale>,
}

impl TiffStack {
    /// Opens the file, counts its pages, and finds the scale of 16-bit ones from pages spread over it.
    pub fn open(path: &Path, period: Period) -> Result<Self, SourceError> {
        let wrong = |problem| SourceError::Frames { path: path.to_owned(), problem };
        let mut walker = decoder(path)?;
        let promised = walker.get_tag_ascii_string(Tag::ImageDescription).ok().and_then(|text| promised_pages(&text));
        let mut pages = 1;
        while walker.more_images() {
            // A page that cannot be reached counts as well: it ends the list.
            let _ = walker.next_image();
            pages += 1;
            if pages > MOST_PAGES {
                return Err(wrong(format!("it has more than {MOST_PAGES} pages: split the recording")));
            }
        }
        if promised.is_some_and(|promised| promised > pages) {
            let promised = promised.unwrap_or_default();
            return Err(wrong(format!(
                "its description promises {promised} pages, it lists {pages}: copy it again, or save it as BigTIFF"
            )));
        }
        let name = file_name(path);
        let sample = scale_frames(pages).filter_map(|page| {
            walker.seek_to_image(page).ok()?;
            decode_page(&mut walker, &name).ok()
        });
        let scale = SixteenBitScale::of_frames(sample);
        Ok(Self {
            decoder: decoder(path)?,
            path: path.to_owned(),
            next: 0,
            pages,
            period_s: period.without_own_s(),
            scale,
        })
    }
}

/// Pages that a stack of ImageJ says it has, in its description (`images=250`).
fn promised_pages(description: &str) -> Option<usize> {
    let lines = description.starts_with("ImageJ=").then(|| description.lines())?;
    lines.filter_map(|line| line.trim().strip_prefix("images=")).find_map(|number| number.parse().ok())
}

fn decoder(path: &Path) -> Result<Decoder<BufReader<File>>, SourceError> {
    let file = File::open(path).map_err(|source| SourceError::Open { path: path.to_owned(), source })?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MOST_PIXELS as usize * MOST_BYTES_A_PIXEL;
    Ok(Decoder::new(BufReader::new(file))
        .map_err(|source| SourceError::Tiff { path: path.to_owned(), source })?
        .with_limits(limits))
}

fn decode_page(decoder: &mut Decoder<BufReader<File>>, file: &str) -> Result<Decoded, FrameError> {
    let failed = |error: TiffError| FrameError::decode(file, error);
    let (width, height) = decoder.dimensions().map_err(failed)?;
    check_size(file, width, height)?;
    let colour = decoder.colortype().map_err(failed)?;
    let image = match (decoder.read_image().map_err(failed)?, colour) {
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
            let reason = format!("its pages are {other:?}; grey or RGB of 8 or 16 bits is read");
            return Err(FrameError::decode(file, reason));
        }
    };
    image.and_then(Decoded::from_image).ok_or_else(|| FrameError::decode(file, "its page is cut short"))
}

impl DecodedSource for TiffStack {
    fn next_decoded(&mut self) -> Option<SourceFrame<Decoded>> {
        let page = self.next;
        if page == self.pages {
            return None;
        }
        self.next += 1;
        let file = format!("{}[{page}]", file_name(&self.path));
        let reached = if page == 0 { Ok(()) } else { self.decoder.next_image() };
        let picture = match reached {
            Ok(()) => decode_page(&mut self.decoder, &file),
            Err(error) => Err(FrameError::decode(&file, error)),
        };
        Some(SourceFrame { file, time_s: page as f64 * self.period_s, picture })
    }

    fn rewound(&self) -> Result<Self, SourceError> {
        let Self { pages, period_s, scale, .. } = *self;
        Ok(Self { decoder: decoder(&self.path)?, path: self.path.clone(), next: 0, pages, period_s, scale })
    }
}

impl FrameSource for TiffStack {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let scale = self.scale;
        self.next_decoded().map(|frame| frame.in_gray(scale))
    }

    fn skip(&mut self, frames: usize) {
        for _ in 0..frames.min(self.pages - self.next) {
            if self.next > 0 {
                // A page that cannot be reached is the trouble of whoever reads it.
                let _ = self.decoder.next_image();
            }
            self.next += 1;
        }
    }

    fn frame_count(&self) -> Option<usize> {
        Some(self.pages)
    }

    fn kind(&self) -> &'static str {
        "multi-page TIFF"
    }

    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn sixteen_bit_scale(&self) -> Option<SixteenBitScale> {
        self.scale
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(self.rewound()?))
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
        let mut stack = TiffStack::open(&path, Period::Given(0.5)).unwrap();
        assert_eq!(stack.sixteen_bit_scale(), Some(SixteenBitScale { white: 4095 }));
        let frames: Vec<SourceFrame> = std::iter::from_fn(|| stack.next_frame()).collect();
        let greys: Vec<u8> = frames.iter().map(|f| f.picture.as_ref().unwrap().pixels()[0]).collect();
        assert_eq!(greys, [62, 255, 127]);
        assert_eq!(frames[2].time_s, 1.0);
        assert_eq!(frames[2].file, "stack.tif[2]");
    }

    /// Twelve pages, written one after another with each one's list entry behind its pixels.
    fn stack(folder: &Path) -> (std::path::PathBuf, Vec<u8>) {
        let path = folder.join("stack.tif");
        let mut encoder = TiffEncoder::new(File::create(&path).unwrap()).unwrap();
        for page in 0..12_u8 {
            encoder.write_image::<colortype::Gray8>(20, 10, &[page; 200]).unwrap();
        }
        drop(encoder);
        let bytes = std::fs::read(&path).unwrap();
        (path, bytes)
    }

    #[test]
    fn a_stack_that_is_cut_anywhere_never_passes_for_a_shorter_one() {
        let folder = tempfile::tempdir().unwrap();
        let (path, bytes) = stack(folder.path());
        for percent in [1, 5, 20, 50, 75, 90, 99] {
            std::fs::write(&path, &bytes[..bytes.len() * percent / 100]).unwrap();
            let Ok(mut cut) = TiffStack::open(&path, Period::Given(0.5)) else { continue };
            let frames: Vec<_> = std::iter::from_fn(|| cut.next_frame()).collect();
            assert!(frames.iter().any(|frame| frame.picture.is_err()), "{percent} %: {} frames", frames.len());
            assert_eq!(cut.frame_count(), Some(frames.len()));
        }
        std::fs::write(&path, &bytes).unwrap();
        let mut whole = TiffStack::open(&path, Period::Given(0.5)).unwrap();
        assert_eq!(std::iter::from_fn(|| whole.next_frame()).filter(|frame| frame.picture.is_ok()).count(), 12);
    }

    #[test]
    fn a_description_that_promises_more_pages_than_there_are_is_an_error() {
        assert_eq!(promised_pages("ImageJ=1.53t\nimages=250\nslices=250\n"), Some(250));
        assert_eq!(promised_pages("a camera with images=250"), None);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("imagej.tif");
        let mut encoder = TiffEncoder::new(File::create(&path).unwrap()).unwrap();
        let mut image = encoder.new_image::<colortype::Gray8>(4, 3).unwrap();
        image.encoder().write_tag(Tag::ImageDescription, "ImageJ=1.53t\nimages=9\n").unwrap();
        image.write_data(&[7; 12]).unwrap();
        drop(encoder);
        let error = TiffStack::open(&path, Period::Given(0.5)).err().unwrap().to_string();
        assert!(error.contains("promises 9 pages, it lists 1"), "{error}");
    }
}
