//! Where frames come from: a folder of images, a multi-page TIFF, a video; for the melt-pool sensors a NumPy stack too.
//!
//! Every source is a [`FrameSource`]; a live camera fits the same trait later. An [`IntensitySource`] gives the same
//! recordings in their full depth.

mod folder;
mod gray;
mod intensity;
mod npy;
mod tiff_stack;
mod timestamps;
mod video;

use std::path::{Path, PathBuf};

pub use gray::SixteenBitScale;
pub use intensity::{IntensityScale, IntensitySource, open_intensity};

use crate::frame::{GrayFrame, IntensityFrame};

/// One frame on its way to the tracker.
#[derive(Debug)]
pub struct SourceFrame<P = GrayFrame> {
    /// Name of the frame's file, or of its page or picture in a stack.
    pub file: String,
    /// Time stamp \[s\].
    pub time_s: f64,
    /// The picture, or why it could not be read.
    pub picture: Result<P, FrameError>,
}

/// A recording, frame by frame.
pub trait FrameSource: Send {
    /// The next frame; none at the end.
    fn next_frame(&mut self) -> Option<SourceFrame>;
    /// Number of frames, where it is known.
    fn frame_count(&self) -> Option<usize>;
    /// What kind of recording this is, in a word.
    fn kind(&self) -> &'static str;
    /// How 16-bit grey is brought to 8 bits, if the recording is of 16 bits.
    fn sixteen_bit_scale(&self) -> Option<SixteenBitScale> {
        None
    }
}

/// A recording that cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// There is nothing at the path, or it may not be read.
    #[error("cannot open {}: is the path right, and may you read it?", path.display())]
    Open {
        /// The path.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A folder without pictures.
    #[error("{} holds no png, jpg, bmp or tif image: name the folder with the frames", .0.display())]
    NoImages(PathBuf),
    /// A file of a kind that is not read.
    #[error(
        "{} is neither a folder of images, a multi-page TIFF nor a video that OpenCV can open: convert it to one", .0.display()
    )]
    UnknownKind(PathBuf),
    /// A NumPy file that is no stack of frames.
    #[error("{}: {problem}", path.display())]
    NumPy {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and the remedy.
        problem: String,
    },
    /// The time stamps do not fit.
    #[error("{}: {problem}", path.display())]
    TimeStamps {
        /// The time-stamp file.
        path: PathBuf,
        /// What is wrong with it, and the remedy.
        problem: String,
    },
}

/// One frame that cannot be used; the recording goes on.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The file is gone, truncated or no image.
    #[error("{file} cannot be decoded: record or copy it again")]
    Decode {
        /// Name of the file.
        file: String,
        /// The decoder's reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A pixel is NaN or infinite.
    #[error("{file} has a pixel that is not a finite number: replace it by its neighbours, or leave the frame out")]
    NotFinite {
        /// Name of the frame.
        file: String,
    },
    /// The frame is larger than any camera's.
    #[error("{file} has {width_px} x {height_px} pixels, more than {limit} in all: crop or bin the recording", limit = gray::LARGEST_FRAME_PIXELS)]
    TooLarge {
        /// Name of the file.
        file: String,
        /// Columns.
        width_px: u32,
        /// Rows.
        height_px: u32,
    },
    /// The frame's size is not that of the first one.
    #[error("{file} has {got_px:?} pixels where the recording has {expected_px:?}: keep one size a recording")]
    OtherSize {
        /// Name of the file.
        file: String,
        /// Columns and rows of this frame.
        got_px: (usize, usize),
        /// Columns and rows of the first one.
        expected_px: (usize, usize),
    },
}

/// Opens a folder of images, a multi-page TIFF or a video. `period_s` gives the time stamps where the recording has
/// none of its own (`timestamps.csv` in the folder).
///
/// # Errors
/// When there is nothing to read at `path`, or its time stamps are wrong.
pub fn open(path: &Path, period_s: f64) -> Result<Box<dyn FrameSource>, SourceError> {
    let metadata = std::fs::metadata(path).map_err(|source| SourceError::Open { path: path.to_owned(), source })?;
    if metadata.is_dir() {
        return Ok(Box::new(folder::Folder::open(path, period_s)?));
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("tif" | "tiff") => Ok(Box::new(tiff_stack::TiffStack::open(path, period_s)?)),
        Some("png" | "jpg" | "jpeg" | "bmp") => Ok(Box::new(folder::Folder::single(path))),
        _ => Ok(Box::new(video::Video::open(path, period_s)?)),
    }
}

/// Lets only frames of the first readable frame's size through.
#[derive(Debug, Default)]
pub struct SizeCheck {
    expected_px: Option<(usize, usize)>,
}

impl SizeCheck {
    /// The frame again, its picture replaced by [`FrameError::OtherSize`] when it is not of the first one's size.
    pub fn admit(&mut self, frame: SourceFrame) -> SourceFrame {
        self.admit_sized(frame, |picture| (picture.width_px(), picture.height_px()))
    }

    /// As [`Self::admit`], for a frame of full depth.
    pub fn admit_intensity(&mut self, frame: SourceFrame<IntensityFrame>) -> SourceFrame<IntensityFrame> {
        self.admit_sized(frame, |picture| (picture.width_px(), picture.height_px()))
    }

    fn admit_sized<P>(&mut self, frame: SourceFrame<P>, size_px: impl Fn(&P) -> (usize, usize)) -> SourceFrame<P> {
        let SourceFrame { file, time_s, picture } = frame;
        let picture = picture.and_then(|picture| {
            let got_px = size_px(&picture);
            let expected_px = *self.expected_px.get_or_insert(got_px);
            if got_px == expected_px {
                Ok(picture)
            } else {
                Err(FrameError::OtherSize { file: file.clone(), got_px, expected_px })
            }
        });
        SourceFrame { file, time_s, picture }
    }

    /// Columns and rows of the recording, once a frame was read.
    #[must_use]
    pub const fn size_px(&self) -> Option<(usize, usize)> {
        self.expected_px
    }
}
