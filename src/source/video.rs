//! A video file through OpenCV.
#![expect(clippy::disallowed_types, reason = "the folder's one door to OpenCV")]

use std::path::Path;

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};
use opencv::imgproc::{COLOR_BGR2GRAY, cvt_color_def};
use opencv::videoio::{CAP_ANY, CAP_PROP_FRAME_COUNT, VideoCapture, VideoCaptureTrait, VideoCaptureTraitConst};

use super::gray::{check_size, file_name};
use super::{FrameError, FrameSource, SourceError, SourceFrame};
use crate::frame::GrayFrame;

/// The pictures of a video file.
pub struct Video {
    name: String,
    capture: VideoCapture,
    number: usize,
    count: Option<usize>,
    period_s: f64,
}

impl Video {
    /// Opens the file with the first of OpenCV's decoders that takes it.
    pub fn open(path: &Path, period_s: f64) -> Result<Self, SourceError> {
        let unknown = || SourceError::UnknownKind(path.to_owned());
        let capture = path
            .to_str()
            .and_then(|name| VideoCapture::from_file(name, CAP_ANY).ok())
            .filter(|capture| capture.is_opened().unwrap_or(false))
            .ok_or_else(unknown)?;
        let frames = capture.get(CAP_PROP_FRAME_COUNT).unwrap_or(0.0);
        let count = (frames.is_finite() && frames >= 1.0).then_some(frames as usize);
        Ok(Self { name: file_name(path), capture, number: 0, count, period_s })
    }

    fn read(&mut self) -> opencv::Result<Option<Mat>> {
        let mut picture = Mat::default();
        Ok(self.capture.read(&mut picture)?.then_some(picture).filter(|p| !p.empty()))
    }
}

fn gray(picture: &Mat, file: &str) -> Result<GrayFrame, FrameError> {
    let failed = |source: Box<dyn std::error::Error + Send + Sync>| FrameError::Decode { file: file.into(), source };
    let (width, height) = (picture.cols(), picture.rows());
    check_size(file, width as u32, height as u32)?;
    let mut gray = Mat::default();
    if picture.channels() == 1 {
        gray = picture.clone();
    } else {
        cvt_color_def(picture, &mut gray, COLOR_BGR2GRAY).map_err(|e| failed(Box::new(e)))?;
    }
    let bytes = gray.data_bytes().map_err(|e| failed(Box::new(e)))?.to_vec();
    GrayFrame::new(width as usize, height as usize, bytes).map_err(|e| failed(Box::new(e)))
}

impl FrameSource for Video {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let number = self.number;
        let file = format!("{}[{number}]", self.name);
        let picture = match self.read() {
            Ok(None) => return None,
            Ok(Some(picture)) => gray(&picture, &file),
            Err(source) => Err(FrameError::Decode { file: file.clone(), source: Box::new(source) }),
        };
        self.number += 1;
        // A decoder that fails for good must not keep the run going for ever.
        if picture.is_err() && self.count.is_none_or(|count| number >= count) {
            return None;
        }
        Some(SourceFrame { file, time_s: number as f64 * self.period_s, picture })
    }

    fn frame_count(&self) -> Option<usize> {
        self.count
    }

    fn kind(&self) -> &'static str {
        "video"
    }
}
