//! Drawing on a colour copy of a frame, and video files, through OpenCV.
#![expect(clippy::disallowed_types, reason = "the one file of report/ that holds a Mat")]

use std::path::Path;

use image::RgbImage;
use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, Point, Rect, Scalar, Size, Vector};
use opencv::videoio::{
    CAP_FFMPEG, CAP_PROP_FRAME_COUNT, VideoCapture, VideoCaptureTrait, VideoCaptureTraitConst, VideoWriter,
    VideoWriterTrait, VideoWriterTraitConst,
};
use opencv::{Result, imgproc};

use super::marks::RoiBox;
use crate::frame::GrayFrame;
use crate::units::PixelPoint;

/// A colour, red, green, blue.
pub(super) type Rgb = [u8; 3];

/// Fractional bits of OpenCV's sub-pixel coordinates.
const SHIFT: i32 = 4;
const TEXT_SCALE: f64 = 0.5;

/// A colour image to draw on. Lines are thick enough to be seen on a frame of any size.
pub(super) struct Canvas {
    image: Mat,
    thickness: i32,
}

impl Canvas {
    /// A colour copy of `frame`.
    pub(super) fn of(frame: &GrayFrame) -> Result<Self> {
        let gray = Mat::new_rows_cols_with_data(frame.height_px() as i32, frame.width_px() as i32, frame.pixels())?;
        let mut image = Mat::default();
        imgproc::cvt_color(&gray, &mut image, imgproc::COLOR_GRAY2BGR, 0)?;
        let thickness = (frame.width_px() as i32 / 1000).max(1);
        Ok(Self { image, thickness })
    }

    /// A polyline through `points`; without an outline, which would cover the stripe that it runs along.
    pub(super) fn polyline(&mut self, points: &[PixelPoint], colour: Rgb) -> Result<()> {
        let points: Vector<Point> = points.iter().map(|&point| fine(point)).collect();
        imgproc::polylines(&mut self.image, &points, false, bgr(colour), self.thickness, imgproc::LINE_AA, SHIFT)
    }

    /// Colour and thickness of a mark's dark outline, which keeps it apart from glare, and of the mark itself.
    fn outlined(&self, colour: Rgb) -> [(Rgb, i32); 2] {
        [([0, 0, 0], 3 * self.thickness), (colour, self.thickness)]
    }

    /// The outline of a box.
    pub(super) fn outline(&mut self, roi: RoiBox, colour: Rgb) -> Result<()> {
        let whole = |px: f64| px.round().clamp(-1e6, 1e6) as i32;
        let rect = Rect::new(whole(roi.u_px), whole(roi.v_px), whole(roi.width_px), whole(roi.height_px));
        for (colour, thickness) in self.outlined(colour) {
            imgproc::rectangle(&mut self.image, rect, bgr(colour), thickness, imgproc::LINE_8, 0)?;
        }
        Ok(())
    }

    /// A mark at `point`: a line of each of `strokes`, given as the two ends' offsets from the point \[px\].
    pub(super) fn strokes(&mut self, point: PixelPoint, strokes: &[[(f64, f64); 2]], colour: Rgb) -> Result<()> {
        let scale = f64::from(self.thickness);
        for (colour, thickness) in self.outlined(colour) {
            for stroke in strokes {
                let [a, b] = stroke.map(|(u, v)| fine(PixelPoint::new(point.u_px + scale * u, point.v_px + scale * v)));
                imgproc::line(&mut self.image, a, b, bgr(colour), thickness, imgproc::LINE_AA, SHIFT)?;
            }
        }
        Ok(())
    }

    /// A circle round `centre`.
    pub(super) fn circle(&mut self, centre: PixelPoint, radius_px: f64, colour: Rgb) -> Result<()> {
        let radius = (radius_px * f64::from(self.thickness * (1 << SHIFT))).round() as i32;
        for (colour, thickness) in self.outlined(colour) {
            imgproc::circle(&mut self.image, fine(centre), radius, bgr(colour), thickness, imgproc::LINE_AA, SHIFT)?;
        }
        Ok(())
    }

    /// A line of text with a dark outline at the top left, and a border in its colour.
    pub(super) fn caption(&mut self, text: &str, colour: Rgb) -> Result<()> {
        let scale = TEXT_SCALE * f64::from(self.thickness);
        let at = Point::new(8 * self.thickness, 20 * self.thickness);
        for (colour, thickness) in [([0, 0, 0], 4 * self.thickness), (colour, self.thickness)] {
            let font = imgproc::FONT_HERSHEY_SIMPLEX;
            imgproc::put_text(&mut self.image, text, at, font, scale, bgr(colour), thickness, imgproc::LINE_AA, false)?;
        }
        let whole = Rect::new(0, 0, self.image.cols(), self.image.rows());
        imgproc::rectangle(&mut self.image, whole, bgr(colour), 3 * self.thickness, imgproc::LINE_8, 0)
    }

    /// The drawing as an image.
    pub(super) fn into_rgb(self) -> Result<RgbImage> {
        let (width, height) = (self.image.cols() as u32, self.image.rows() as u32);
        let mut bytes = self.image.data_bytes()?.to_vec();
        bytes.chunks_exact_mut(3).for_each(|pixel| pixel.swap(0, 2));
        let misfit = || opencv::Error::new(opencv::core::StsUnmatchedSizes, "the drawing is not an RGB image");
        RgbImage::from_raw(width, height, bytes).ok_or_else(misfit)
    }
}

fn fine(point: PixelPoint) -> Point {
    let fixed = |px: f64| (px * f64::from(1 << SHIFT)).round().clamp(-1e8, 1e8) as i32;
    Point::new(fixed(point.u_px), fixed(point.v_px))
}

fn bgr([red, green, blue]: Rgb) -> Scalar {
    Scalar::new(f64::from(blue), f64::from(green), f64::from(red), 0.0)
}

/// Pictures that a video file holds by its own account, if the first one can be read; else none.
pub(super) fn frames_of_video(path: &Path) -> Result<usize> {
    let Some(name) = path.to_str() else { return Ok(0) };
    let mut video = VideoCapture::from_file(name, CAP_FFMPEG)?;
    let mut first = Mat::default();
    let is_readable = video.is_opened()? && video.read(&mut first)? && !first.empty();
    Ok(if is_readable { video.get(CAP_PROP_FRAME_COUNT)?.max(0.0) as usize } else { 0 })
}

/// A video file being written.
pub(super) struct VideoFile {
    writer: VideoWriter,
    size: Size,
}

impl VideoFile {
    /// Open `path`; `None` when OpenCV cannot encode MPEG-4 or write there.
    pub(super) fn create(path: &Path, frames_per_second: f64, first: &Canvas) -> Result<Option<Self>> {
        let size = first.image.size()?;
        // H.264, which browsers play; where FFmpeg has no encoder for it, MPEG-4 part 2.
        for codec in [['a', 'v', 'c', '1'], ['m', 'p', '4', 'v']] {
            let codec = VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3])?;
            let writer = VideoWriter::new_with_backend(path, CAP_FFMPEG, codec, frames_per_second, size, true)?;
            if writer.is_opened()? {
                return Ok(Some(Self { writer, size }));
            }
        }
        Ok(None)
    }

    /// Append a picture; `false` when its size is not that of the first one (OpenCV would drop it in silence).
    pub(super) fn add(&mut self, picture: &Canvas) -> Result<bool> {
        if picture.image.size()? != self.size {
            return Ok(false);
        }
        self.writer.write(&picture.image).map(|()| true)
    }

    /// Write the end of the file.
    pub(super) fn finish(mut self) -> Result<()> {
        self.writer.release()
    }
}
