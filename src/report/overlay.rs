//! The recording with the tracker's marks drawn on it, as a folder of PNG files or one video.

use std::path::{Path, PathBuf};

use image::RgbImage;

use super::atomic::{ResultsError, write_atomically};
pub(super) use super::canvas::Rgb;
use super::canvas::{Canvas, VideoFile, frames_of_video};
use super::marks::FrameMarks;
use super::results::{Estimator, PathRow, Status};
use crate::frame::GrayFrame;
use crate::output::WholeFile;
use crate::output::unfinished::{self, Removal};

/// The colours of the page's plots and pictures; each mark has its own shape as well, for colour-blind eyes.
pub(super) const STRIPE: Rgb = [86, 180, 233];
const ROI: Rgb = [160, 160, 160];
pub(super) const KCF: Rgb = [217, 122, 0];
pub(super) const FILTERED: Rgb = [10, 132, 255];
pub(super) const SMOOTHED: Rgb = [0, 160, 106];

pub(super) const fn status_colour(status: Status) -> Rgb {
    match status {
        Status::Seeking => [150, 150, 150],
        Status::Tracked => [0, 158, 115],
        Status::Coasting => [240, 228, 66],
        Status::Lost => [213, 94, 0],
        Status::Unreadable => [204, 121, 167],
    }
}

/// `frame` with stripe, ROI, KCF peak (cross), filtered centre (circle with a line across the stripe) and smoothed
/// centre (diamond), its number and status.
///
/// # Errors
/// When OpenCV refuses, which takes a lack of memory.
pub fn draw_overlay(frame: &GrayFrame, row: &PathRow, marks: &FrameMarks) -> opencv::Result<RgbImage> {
    canvas(frame, row, marks)?.into_rgb()
}

fn canvas(frame: &GrayFrame, row: &PathRow, marks: &FrameMarks) -> opencv::Result<Canvas> {
    let mut canvas = Canvas::of(frame)?;
    if let Some(roi) = marks.roi {
        canvas.outline(roi, ROI)?;
    }
    if marks.stripe.len() > 1 {
        canvas.polyline(&marks.stripe, STRIPE)?;
    }
    if let Some(peak) = row.point(Estimator::Kcf) {
        canvas.strokes(peak, &[[(-7.0, -7.0), (7.0, 7.0)], [(-7.0, 7.0), (7.0, -7.0)]], KCF)?;
    }
    if let Some(centre) = row.point(Estimator::Filtered) {
        canvas.circle(centre, 9.0, FILTERED)?;
        let ticks = [
            [(-16.0, 0.0), (-9.0, 0.0)],
            [(9.0, 0.0), (16.0, 0.0)],
            [(0.0, -16.0), (0.0, -9.0)],
            [(0.0, 9.0), (0.0, 16.0)],
        ];
        canvas.strokes(centre, &ticks, FILTERED)?;
    }
    if let Some(centre) = row.point(Estimator::Smoothed) {
        let (top, right, bottom, left) = ((0.0, -5.0), (5.0, 0.0), (0.0, 5.0), (-5.0, 0.0));
        canvas.strokes(centre, &[[top, right], [right, bottom], [bottom, left], [left, top]], SMOOTHED)?;
    }
    let position = row.x_mm.map_or(String::new(), |x_mm| format!("  {x_mm:.3} mm"));
    canvas.caption(&format!("{}  {}{position}", row.frame, row.status), status_colour(row.status))?;
    Ok(canvas)
}

/// Why the overlay could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OverlayError {
    /// A picture could not be written.
    #[error(transparent)]
    Picture(#[from] ResultsError),
    /// OpenCV has no encoder or no access.
    #[error(
        "cannot write the video {}: OpenCV needs FFmpeg with MPEG-4, and the folder must be writable; \
         --overlay with a folder writes PNG files instead",
        path.display()
    )]
    Video {
        /// The video file.
        path: PathBuf,
    },
    /// The video lacks frames that were written into it.
    #[error("cannot write the video {}: it could not be read back whole; is the disk full?", path.display())]
    Incomplete {
        /// The video file.
        path: PathBuf,
    },
    /// A frame of another size in the middle of a video.
    #[error("cannot add frame {frame} to the video {}: its size differs from the first frame's", path.display())]
    Size {
        /// The video file.
        path: PathBuf,
        /// The frame.
        frame: usize,
    },
    /// OpenCV failed while drawing.
    #[error("OpenCV failed while drawing the overlay")]
    OpenCv(#[from] opencv::Error),
}

/// Writes the overlay frame by frame. Give it rows with the smoothed columns filled to see the smoothed centre.
///
/// A video has a name of its own until [`finish`](Self::finish); dropped before, it leaves nothing.
pub struct OverlayWriter {
    path: PathBuf,
    frames_per_second: f64,
    target: Target,
}

enum Target {
    Folder,
    Video { unfinished: Unfinished, video: Option<VideoFile>, frames: usize },
}

/// A video under its own name, removed unless it is finished. OpenCV opens it by that name, so a file beside it is locked.
struct Unfinished {
    video: PathBuf,
    /// Holds the place as long as it is not dropped.
    _place: WholeFile,
}

impl Unfinished {
    fn beside(path: &Path) -> std::io::Result<Self> {
        let place = WholeFile::begin(path)?;
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let video = path.with_file_name(format!(".{name}.seamtrack-part.mp4"));
        unfinished::note(&video, Removal::Whole);
        Ok(Self { video, _place: place })
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.video);
        unfinished::forget(&self.video);
    }
}

impl OverlayWriter {
    /// A path that ends in `.mp4` becomes a video of `frames_per_second`, any other a folder of PNG files.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn create(path: &Path, frames_per_second: f64) -> Result<Self, OverlayError> {
        let is_video = is_video(path);
        let folder = if is_video { path.parent().unwrap_or(Path::new("")) } else { path };
        if !folder.as_os_str().is_empty() {
            std::fs::create_dir_all(folder)
                .map_err(|source| ResultsError::Write { path: folder.to_owned(), source })?;
        }
        let target = if is_video {
            let failed = |source| ResultsError::Write { path: path.to_owned(), source };
            Target::Video { unfinished: Unfinished::beside(path).map_err(failed)?, video: None, frames: 0 }
        } else {
            Target::Folder
        };
        Ok(Self { path: path.to_owned(), frames_per_second, target })
    }

    /// Draw and write one frame.
    ///
    /// # Errors
    /// When the picture cannot be written or does not fit into the video.
    pub fn add(&mut self, frame: &GrayFrame, row: &PathRow, marks: &FrameMarks) -> Result<(), OverlayError> {
        self.add_drawing(row.frame, canvas(frame, row, marks)?)
    }

    /// Write a finished drawing of a frame.
    pub(super) fn add_drawing(&mut self, frame: usize, picture: Canvas) -> Result<(), OverlayError> {
        match &mut self.target {
            Target::Folder => {
                let rgb = picture.into_rgb()?;
                let path = self.path.join(format!("{frame:06}.png"));
                let write = |error| std::io::Error::other::<image::ImageError>(error);
                Ok(write_atomically(&path, |file| {
                    let encoder = image::codecs::png::PngEncoder::new(file);
                    rgb.write_with_encoder(encoder).map_err(write)
                })?)
            }
            Target::Video { unfinished, video, frames } => {
                let mut open = match video.take() {
                    Some(open) => open,
                    None => VideoFile::create(&unfinished.video, self.frames_per_second, &picture)?
                        .ok_or_else(|| OverlayError::Video { path: self.path.clone() })?,
                };
                if !open.add(&picture)? {
                    return Err(OverlayError::Size { path: self.path.clone(), frame });
                }
                *video = Some(open);
                *frames += 1;
                Ok(())
            }
        }
    }

    /// Close the video and read it back: OpenCV says nothing when the disk is full.
    ///
    /// # Errors
    /// When the file does not hold every frame.
    pub fn complete(&mut self) -> Result<(), OverlayError> {
        if let Target::Video { unfinished, video, frames } = &mut self.target
            && let Some(open) = video.take()
        {
            open.finish()?;
            if frames_of_video(&unfinished.video)? != *frames {
                return Err(OverlayError::Incomplete { path: self.path.clone() });
            }
        }
        Ok(())
    }

    /// Close the video and give it its name.
    ///
    /// # Errors
    /// When the video cannot be finished.
    pub fn finish(mut self) -> Result<(), OverlayError> {
        self.complete()?;
        if let Target::Video { unfinished, frames: 1.., .. } = &self.target {
            std::fs::rename(&unfinished.video, &self.path)
                .map_err(|source| ResultsError::Write { path: self.path.clone(), source })?;
        }
        Ok(())
    }
}

/// Whether an overlay at `path` is a video, by its name; else it is a folder.
#[must_use]
pub fn is_video(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mp4"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::marks::RoiBox;
    use crate::units::PixelPoint;

    fn scene() -> (GrayFrame, PathRow, FrameMarks) {
        let row = PathRow {
            kcf_u_px: Some(60.0),
            kcf_v_px: Some(40.0),
            u_px: Some(80.0),
            v_px: Some(40.0),
            smooth_u_px: Some(81.0),
            smooth_v_px: Some(40.0),
            ..PathRow::empty(3, String::new(), 0.6, Status::Coasting)
        };
        let marks = FrameMarks {
            stripe: vec![PixelPoint::new(0.0, 70.0), PixelPoint::new(159.0, 70.0)],
            roi: Some(RoiBox { u_px: 50.0, v_px: 30.0, width_px: 60.0, height_px: 30.0 }),
        };
        (GrayFrame::filled(160, 100, 20).unwrap(), row, marks)
    }

    #[test]
    fn every_mark_is_where_it_belongs() {
        let (frame, row, marks) = scene();
        let rgb = draw_overlay(&frame, &row, &marks).unwrap();
        assert!(rgb.get_pixel(100, 70).0[2] > 200, "stripe");
        assert_eq!(rgb.get_pixel(50, 57).0, ROI, "box, where no smoothed edge of another mark reaches");
        assert!(rgb.get_pixel(60, 40).0[0] > 200, "cross of the KCF peak");
        assert!(rgb.get_pixel(92, 40).0[2] > 200, "tick of the filtered centre");
        assert!(rgb.get_pixel(92, 42).0.iter().all(|&c| c < 15), "a dark outline: {:?}", rgb.get_pixel(92, 42));
        assert_eq!(rgb.get_pixel(0, 50).0, status_colour(Status::Coasting));
        assert_eq!(rgb.get_pixel(30, 90).0, [20, 20, 20], "the rest is the frame");
    }

    #[test]
    fn a_folder_gets_one_png_a_frame() {
        let dir = tempfile::tempdir().unwrap();
        let (frame, row, marks) = scene();
        let mut overlay = OverlayWriter::create(&dir.path().join("a/b"), 5.0).unwrap();
        overlay.add(&frame, &row, &marks).unwrap();
        overlay.finish().unwrap();
        let read = image::open(dir.path().join("a/b/000003.png")).unwrap().into_rgb8();
        assert_eq!(read, draw_overlay(&frame, &row, &marks).unwrap());
    }

    #[test]
    fn a_video_gets_every_frame_and_refuses_another_size() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("overlay.mp4");
        let (frame, row, marks) = scene();
        let mut overlay = OverlayWriter::create(&path, 5.0).unwrap();
        for _ in 0..4 {
            overlay.add(&frame, &row, &marks).unwrap();
        }
        let other = GrayFrame::filled(80, 100, 20).unwrap();
        assert!(matches!(overlay.add(&other, &row, &marks), Err(OverlayError::Size { frame: 3, .. })));
        drop(overlay);
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0, "an unfinished video goes");
        let mut overlay = OverlayWriter::create(&path, 5.0).unwrap();
        for _ in 0..4 {
            overlay.add(&frame, &row, &marks).unwrap();
        }
        overlay.finish().unwrap();
        assert!(std::fs::read(&path).unwrap().windows(4).any(|tag| tag == b"ftyp"));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}
