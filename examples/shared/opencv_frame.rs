//! A frame as OpenCV's trackers want it.

use opencv::core::{Mat, MatTraitConst};
use seamtrack::frame::GrayFrame;

/// The frame with three channels.
pub fn image_of(frame: &GrayFrame) -> opencv::Result<Mat> {
    let grey = Mat::from_slice(frame.pixels())?;
    let grey = grey.reshape(1, frame.height_px() as i32)?;
    let mut colour = Mat::default();
    opencv::imgproc::cvt_color_def(&grey, &mut colour, opencv::imgproc::COLOR_GRAY2BGR)?;
    Ok(colour)
}
