//! A video file through OpenCV.
#![expect(clippy::disallowed_types, reason = "the folder's one door to OpenCV")]

use std::path::{Path, PathBuf};

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};
use opencv::imgproc::{COLOR_BGR2GRAY, cvt_color_def};
use opencv::videoio::{
    CAP_FFMPEG, CAP_PROP_FPS, CAP_PROP_FRAME_COUNT, VideoCapture, VideoCaptureTrait, VideoCaptureTraitConst,
};

use super::gray::{check_size, file_name};
use super::{FrameError, FrameSource, Period, SourceError, SourceFrame};
use crate::frame::GrayFrame;

/// Containers whose header counts the frames; of the others the number is an estimate from duration and rate.
const COUNTED: [&str; 4] = ["mp4", "mov", "m4v", "avi"];
/// Frames, and part of them, by which an estimated number may be wrong. Chosen: the rounding of both ends.
const ESTIMATE_FRAMES: usize = 2;
const ESTIMATE_SHARE: usize = 100;
/// Most frames that are given as unreadable where a file ends early: a damaged header may promise any number.
pub const MOST_MISSING: usize = 100_000;
/// Frame rates that are believed \[1/s\]: from a frame in three hours to the fastest cameras.
const FRAME_RATES: std::ops::RangeInclusive<f64> = 1e-4..=1e6;

/// The pictures of a video file. Where it ends before the number of frames that it promises, the rest are frames that
/// cannot be read.
pub struct Video {
    path: PathBuf,
    capture: VideoCapture,
    number: usize,
    count: Option<usize>,
    /// Frames that must come, by the header.
    promised: usize,
    ended: bool,
    period_s: f64,
}

impl Video {
    /// Opens the file with FFmpeg: other decoders behind OpenCV may wait for ever on a file that was cut.
    pub fn open(path: &Path, period: Period) -> Result<Self, SourceError> {
        let unknown = || SourceError::UnknownKind(path.to_owned());
        let capture = path
            .to_str()
            .and_then(|name| VideoCapture::from_file(name, CAP_FFMPEG).ok())
            .filter(|capture| capture.is_opened().unwrap_or(false))
            .ok_or_else(unknown)?;
        let frames = capture.get(CAP_PROP_FRAME_COUNT).unwrap_or(0.0);
        let count = (frames.is_finite() && frames >= 1.0).then_some(frames as usize);
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        let promised = match count {
            Some(count) if COUNTED.contains(&ending.as_str()) => count,
            Some(count) => count.saturating_sub(ESTIMATE_FRAMES.max(count / ESTIMATE_SHARE)),
            None => 0,
        };
        let rate = capture.get(CAP_PROP_FPS).ok().filter(|rate| FRAME_RATES.contains(rate));
        let period_s = match (period, rate) {
            (Period::OwnOr(_), Some(rate)) => 1.0 / rate,
            (period, _) => period.without_own_s(),
        };
        Ok(Self { path: path.to_owned(), capture, number: 0, count, promised, ended: false, period_s })
    }

    /// Frames that must come.
    pub const fn promised(&self) -> usize {
        self.promised
    }

    fn read(&mut self) -> opencv::Result<Option<Mat>> {
        let mut picture = Mat::default();
        Ok(self.capture.read(&mut picture)?.then_some(picture).filter(|p| !p.empty()))
    }

    /// The next picture, or, once the file has ended, why a promised one is missing; none at the end.
    fn next_picture(&mut self, file: &str) -> Option<Result<GrayFrame, FrameError>> {
        let mut reason = None;
        if !self.ended {
            match self.read() {
                Ok(Some(picture)) => return Some(gray(&picture, file)),
                Ok(None) => {}
                Err(error) => reason = Some(FrameError::decode(file, error)),
            }
            self.ended = true;
            self.promised = self.promised.min(self.number.saturating_add(MOST_MISSING));
        }
        let promised = self.promised;
        let why = || format!("the file ends before it, of {promised} frames that its header promises");
        let missing = || FrameError::decode(file, why());
        (self.number < promised).then(|| Err(reason.unwrap_or_else(missing)))
    }
}

fn gray(picture: &Mat, file: &str) -> Result<GrayFrame, FrameError> {
    let (width, height) = (picture.cols(), picture.rows());
    check_size(file, width as u32, height as u32)?;
    let mut gray = Mat::default();
    if picture.channels() == 1 {
        gray = picture.clone();
    } else {
        cvt_color_def(picture, &mut gray, COLOR_BGR2GRAY).map_err(|error| FrameError::decode(file, error))?;
    }
    let bytes = gray.data_bytes().map_err(|error| FrameError::decode(file, error))?.to_vec();
    GrayFrame::new(width as usize, height as usize, bytes).map_err(|error| FrameError::decode(file, error))
}

impl FrameSource for Video {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let number = self.number;
        let file = format!("{}[{number}]", file_name(&self.path));
        let picture = self.next_picture(&file)?;
        self.number += 1;
        Some(SourceFrame { file, time_s: number as f64 * self.period_s, picture })
    }

    fn frame_count(&self) -> Option<usize> {
        self.count
    }

    fn kind(&self) -> &'static str {
        "video"
    }

    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(Self::open(&self.path, Period::Given(self.period_s))?))
    }
}
