//! Recordings in their full depth, for sensors that read temperatures rather than a stripe.

use std::path::Path;

use serde::Serialize;

use super::gray::{Decoded, DecodedSource, SixteenBitScale};
use super::{FrameError, Kind, Period, SourceError, SourceFrame, folder, kind_of, npy, tiff_stack};
#[cfg(feature = "video")]
use super::{FrameSource, decoder};
use crate::frame::IntensityFrame;

/// How the values of a recording become intensities: black becomes 0, white 1, the same for every frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct IntensityScale {
    /// The value that becomes 0.
    pub black: f64,
    /// The value that becomes 1.
    pub white: f64,
    /// Whether a pixel at white has lost its true value: so with integers, not with floating-point numbers.
    pub saturates: bool,
    /// How black and white were found.
    pub rule: &'static str,
}

impl IntensityScale {
    /// Grey values of 8 bits.
    pub const EIGHT_BITS: Self = Self { black: 0.0, white: 255.0, saturates: true, rule: "8 bits: 255 is white" };

    /// Grey values of up to 16 bits.
    #[must_use]
    pub fn of_sixteen_bits(scale: SixteenBitScale) -> Self {
        Self {
            black: 0.0,
            white: f64::from(scale.white),
            saturates: true,
            rule: "16 bits: white is the end of the bit depth (8, 10, 12, 14, 16) that holds 99.9 % of each sampled frame",
        }
    }

    /// The intensity of a value.
    #[must_use]
    pub fn intensity(&self, value: f64) -> f32 {
        ((value - self.black) / (self.white - self.black)) as f32
    }
}

/// A recording of full depth, frame by frame.
pub trait IntensitySource: Send {
    /// The next frame; none at the end.
    fn next_frame(&mut self) -> Option<SourceFrame<IntensityFrame>>;
    /// Number of frames, where it is known.
    fn frame_count(&self) -> Option<usize>;
    /// What kind of recording this is, in a word.
    fn kind(&self) -> &'static str;
    /// Time from frame to frame where there are no time stamps \[s\].
    fn period_s(&self) -> f64;
    /// What there is to know of the recording before it is used, each in a sentence.
    fn notes(&self) -> &[String];
    /// The scale of all its frames.
    fn scale(&self) -> IntensityScale;
    /// As [`FrameSource::again`](super::FrameSource::again).
    ///
    /// # Errors
    /// When it can no longer be opened.
    fn again(&self) -> Result<Box<dyn IntensitySource>, SourceError>;
}

/// Opens a folder of images, a multi-page TIFF, a video, or a NumPy stack (frames, rows, columns), in its full depth.
///
/// # Errors
/// As [`super::open`], and when a NumPy file is no stack of frames.
pub fn open_intensity(path: &Path, period: impl Into<Period>) -> Result<Box<dyn IntensitySource>, SourceError> {
    let period = period.into();
    Ok(match kind_of(path)? {
        Kind::Folder => Box::new(Pictures(folder::Folder::open(path, period)?)),
        #[cfg(feature = "mcap")]
        Kind::Mcap => Box::new(Pictures(super::mcap::Mcap::open(path, period)?)),
        #[cfg(not(feature = "mcap"))]
        Kind::Mcap => return Err(SourceError::UnknownKind(path.to_owned())),
        Kind::NumPy => Box::new(npy::NpyStack::open(path, period)?),
        Kind::Tiff => Box::new(Pictures(tiff_stack::TiffStack::open(path, period)?)),
        Kind::Picture => Box::new(Pictures(folder::Folder::single(path, period))),
        #[cfg(feature = "video")]
        Kind::Other => Box::new(Grey(decoder::open(path, period)?)),
        #[cfg(not(feature = "video"))]
        Kind::Other => return Err(SourceError::UnknownKind(path.to_owned())),
    })
}

/// Pictures of 8 or 16 bits.
struct Pictures<S>(S);

impl<S: DecodedSource + 'static> IntensitySource for Pictures<S> {
    fn next_frame(&mut self) -> Option<SourceFrame<IntensityFrame>> {
        let scale = self.scale();
        let SourceFrame { file, time_s, picture } = self.0.next_decoded()?;
        let picture = picture.and_then(|decoded| {
            let frame = match decoded {
                Decoded::Gray8(frame) => return Ok(IntensityFrame::from(&frame)),
                Decoded::Gray16 { width_px, height_px, pixels } => {
                    let light = pixels.iter().map(|&grey| scale.intensity(f64::from(grey))).collect();
                    IntensityFrame::new(width_px, height_px, light)
                }
            };
            frame.map_err(|error| FrameError::decode(&file, error))
        });
        Some(SourceFrame { file, time_s, picture })
    }

    fn frame_count(&self) -> Option<usize> {
        self.0.frame_count()
    }

    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    fn period_s(&self) -> f64 {
        self.0.period_s()
    }

    fn notes(&self) -> &[String] {
        self.0.notes()
    }

    fn scale(&self) -> IntensityScale {
        self.0.sixteen_bit_scale().map_or(IntensityScale::EIGHT_BITS, IntensityScale::of_sixteen_bits)
    }

    fn again(&self) -> Result<Box<dyn IntensitySource>, SourceError> {
        Ok(Box::new(Self(self.0.rewound()?)))
    }
}

/// A source that has 8 bits only.
#[cfg(feature = "video")]
struct Grey(Box<dyn FrameSource>);

#[cfg(feature = "video")]
impl IntensitySource for Grey {
    fn next_frame(&mut self) -> Option<SourceFrame<IntensityFrame>> {
        let SourceFrame { file, time_s, picture } = self.0.next_frame()?;
        Some(SourceFrame { file, time_s, picture: picture.map(|frame| IntensityFrame::from(&frame)) })
    }

    fn frame_count(&self) -> Option<usize> {
        self.0.frame_count()
    }

    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    fn period_s(&self) -> f64 {
        self.0.period_s()
    }

    fn notes(&self) -> &[String] {
        self.0.notes()
    }

    fn scale(&self) -> IntensityScale {
        IntensityScale::EIGHT_BITS
    }

    fn again(&self) -> Result<Box<dyn IntensitySource>, SourceError> {
        Ok(Box::new(Self(self.0.again()?)))
    }
}
