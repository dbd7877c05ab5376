//! Where frames come from: a folder of images, a multi-page TIFF, a video, an MCAP log; for the melt-pool sensors a NumPy stack too.
//!
//! Every source is a [`FrameSource`]; a live camera fits the same trait later. An [`IntensitySource`] gives the same
//! recordings in their full depth.

mod cut;
#[cfg(feature = "video")]
mod decoder;
mod folder;
mod gray;
mod intensity;
#[cfg(feature = "mcap")]
mod mcap;
mod npy;
mod tiff_stack;
mod timestamps;
#[cfg(feature = "video")]
mod video;

use std::path::{Path, PathBuf};

pub use cut::{Cut, FrameRange, NoFrameRange};
#[cfg(feature = "video")]
pub use decoder::{decode_videos_by, serve as serve_video};
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

/// Time from frame to frame, for recordings without time stamps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Period {
    /// This, whatever the recording says \[s\].
    Given(f64),
    /// The recording's own frame rate where it has one, as videos do, else this \[s\].
    OwnOr(f64),
}

impl Period {
    /// The period of a recording that has none of its own \[s\].
    #[must_use]
    pub const fn without_own_s(self) -> f64 {
        match self {
            Self::Given(period_s) | Self::OwnOr(period_s) => period_s,
        }
    }
}

impl From<f64> for Period {
    fn from(period_s: f64) -> Self {
        Self::Given(period_s)
    }
}

/// A recording's next frame, decoded or still to be decoded, on whatever thread.
pub enum NextFrame<P = GrayFrame> {
    /// It is there.
    Decoded(SourceFrame<P>),
    /// It is read and decoded by this.
    Encoded(Box<dyn FnOnce() -> SourceFrame<P> + Send>),
}

impl<P> NextFrame<P> {
    /// The frame, decoded now if it was not.
    pub fn decoded(self) -> SourceFrame<P> {
        match self {
            Self::Decoded(frame) => frame,
            Self::Encoded(decode) => decode(),
        }
    }
}

/// A recording, frame by frame.
pub trait FrameSource: Send {
    /// The next frame; none at the end.
    fn next_frame(&mut self) -> Option<SourceFrame>;
    /// The next frame as it comes: where frames do not need one another, they can be decoded side by side.
    fn next_encoded(&mut self) -> Option<NextFrame> {
        self.next_frame().map(NextFrame::Decoded)
    }
    /// Passes over so many frames.
    fn skip(&mut self, frames: usize) {
        for _ in 0..frames {
            if self.next_frame().is_none() {
                break;
            }
        }
    }
    /// Number of frames, where it is known.
    fn frame_count(&self) -> Option<usize>;
    /// What kind of recording this is, in a word.
    fn kind(&self) -> &'static str;
    /// Time from frame to frame where there are no time stamps \[s\].
    fn period_s(&self) -> f64;
    /// What there is to know of the recording before it is used, each in a sentence.
    fn notes(&self) -> &[String] {
        &[]
    }
    /// How 16-bit grey is brought to 8 bits, if the recording is of 16 bits.
    fn sixteen_bit_scale(&self) -> Option<SixteenBitScale> {
        None
    }
    /// The same recording from its first frame on; what was found out about it when it was opened is not found out again.
    ///
    /// # Errors
    /// When it can no longer be opened.
    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError>;
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
        "{} is neither a folder of images, a multi-page TIFF, an MCAP log nor a video that OpenCV can open: convert it to one", .0.display()
    )]
    UnknownKind(PathBuf),
    /// A named pipe, a device or the like.
    #[error("{} is neither a file nor a folder: name the recording's file or folder", .0.display())]
    NotAFile(PathBuf),
    /// A TIFF file that cannot be read.
    #[error("{} is no TIFF that can be read: record or copy it again", path.display())]
    Tiff {
        /// The file.
        path: PathBuf,
        /// The decoder's reason.
        source: tiff::TiffError,
    },
    /// A stack with fewer frames than it says, or with more than are read.
    #[error("{}: {problem}", path.display())]
    Frames {
        /// The file.
        path: PathBuf,
        /// What is wrong with their number, and the remedy.
        problem: String,
    },
    /// A NumPy file that is no stack of frames.
    #[error("{}: {problem}", path.display())]
    NumPy {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and the remedy.
        problem: String,
    },
    /// The decoder of a video hangs, crashes or cannot be started.
    #[error("{}: {problem}", path.display())]
    Decoder {
        /// The file.
        path: PathBuf,
        /// What happened, and the remedy.
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
    #[error(
        "{file} has {width_px} x {height_px} pixels, more than {side} a side or {all} in all: crop or bin the recording",
        side = gray::LONGEST_SIDE_PX, all = gray::MOST_PIXELS
    )]
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

impl FrameError {
    /// `file` cannot be decoded, for this reason.
    pub(crate) fn decode(file: &str, reason: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self::Decode { file: file.to_owned(), source: reason.into() }
    }
}

/// Opens a folder of images, a multi-page TIFF, an MCAP log or a video. `period` gives the time stamps where the recording has
/// none of its own (`timestamps.csv` in the folder).
///
/// # Errors
/// When there is nothing to read at `path`, or its time stamps are wrong.
pub fn open(path: &Path, period: impl Into<Period>) -> Result<Box<dyn FrameSource>, SourceError> {
    let period = period.into();
    Ok(match kind_of(path)? {
        Kind::Folder => Box::new(folder::Folder::open(path, period)?),
        Kind::Tiff => Box::new(tiff_stack::TiffStack::open(path, period)?),
        Kind::Picture => Box::new(folder::Folder::single(path, period)),
        #[cfg(feature = "mcap")]
        Kind::Mcap => Box::new(mcap::Mcap::open(path, period)?),
        #[cfg(not(feature = "mcap"))]
        Kind::Mcap => return Err(SourceError::UnknownKind(path.to_owned())),
        #[cfg(feature = "video")]
        Kind::NumPy | Kind::Other => decoder::open(path, period)?,
        #[cfg(not(feature = "video"))]
        Kind::NumPy | Kind::Other => return Err(SourceError::UnknownKind(path.to_owned())),
    })
}

/// What a path may hold, by its ending.
enum Kind {
    Folder,
    Tiff,
    Picture,
    NumPy,
    Mcap,
    Other,
}

fn kind_of(path: &Path) -> Result<Kind, SourceError> {
    let metadata = std::fs::metadata(path).map_err(|source| SourceError::Open { path: path.to_owned(), source })?;
    if metadata.is_dir() {
        return Ok(Kind::Folder);
    }
    // Opening a named pipe would wait for whoever writes into it.
    if !metadata.is_file() {
        return Err(SourceError::NotAFile(path.to_owned()));
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    Ok(match extension.as_deref() {
        Some("tif" | "tiff") => Kind::Tiff,
        Some("png" | "jpg" | "jpeg" | "bmp") => Kind::Picture,
        Some("npy") => Kind::NumPy,
        Some("mcap") => Kind::Mcap,
        _ => Kind::Other,
    })
}

/// Lets only frames of the first readable frame's size through.
#[derive(Debug, Default)]
pub struct SizeCheck {
    expected_px: Option<(usize, usize)>,
}

impl SizeCheck {
    /// A check of a recording whose size is known.
    #[must_use]
    pub const fn of(size_px: (usize, usize)) -> Self {
        Self { expected_px: Some(size_px) }
    }

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
