//! The only file of this folder that knows OpenCV: threshold, opening, contours.
#![expect(clippy::disallowed_types, reason = "the folder's one door to OpenCV")]

use opencv::core::{Mat, Point, Size, Vector};
use opencv::imgproc;

/// OpenCV refused a picture.
#[derive(Debug, thiserror::Error)]
#[error("OpenCV cannot segment a frame of {width_px} x {height_px} pixels")]
pub struct SegmentationError {
    width_px: usize,
    height_px: usize,
    source: opencv::Error,
}

/// OpenCV's part of the segmentation, with its buffers.
#[derive(Debug)]
pub(super) struct Segmenter {
    mask: Mat,
    opened: Mat,
    contours: Vector<Vector<Point>>,
}

impl Segmenter {
    pub(super) fn new() -> Self {
        Self { mask: Mat::default(), opened: Mat::default(), contours: Vector::new() }
    }

    /// Otsu's level of a grey picture: its brighter class lies above.
    pub(super) fn otsu(&mut self, grey: &[u8], width: usize) -> Result<u8, SegmentationError> {
        let height = grey.len() / width;
        let level = Mat::new_rows_cols_with_data(height as i32, width as i32, grey).and_then(|grey| {
            let kind = imgproc::THRESH_BINARY | imgproc::THRESH_OTSU;
            imgproc::threshold(&grey, &mut self.mask, 0.0, 255.0, kind)
        });
        level.map(|level| level as u8).map_err(|source| failed(width, height, source))
    }

    /// Writes the outline of the largest bright region above `level` into `outline`, pixel by pixel as a closed curve,
    /// after an opening over a square of `opening_px`; gives its area \[px²\], 0 when there is none.
    pub(super) fn largest(
        &mut self,
        grey: &[u8],
        width: usize,
        level: u8,
        opening_px: usize,
        outline: &mut Vec<[f64; 2]>,
    ) -> Result<f64, SegmentationError> {
        let height = grey.len() / width;
        self.trace(grey, width, level, opening_px, outline).map_err(|source| failed(width, height, source))
    }

    fn trace(
        &mut self,
        grey: &[u8],
        width: usize,
        level: u8,
        opening_px: usize,
        outline: &mut Vec<[f64; 2]>,
    ) -> opencv::Result<f64> {
        let grey = Mat::new_rows_cols_with_data((grey.len() / width) as i32, width as i32, grey)?;
        imgproc::threshold(&grey, &mut self.mask, f64::from(level), 255.0, imgproc::THRESH_BINARY)?;
        let side = opening_px as i32;
        let kernel = imgproc::get_structuring_element_def(imgproc::MORPH_ELLIPSE, Size::new(side, side))?;
        imgproc::morphology_ex_def(&self.mask, &mut self.opened, imgproc::MORPH_OPEN, &kernel)?;
        imgproc::find_contours_def(
            &self.opened,
            &mut self.contours,
            imgproc::RETR_EXTERNAL,
            imgproc::CHAIN_APPROX_NONE,
        )?;
        let mut largest = (0.0, 0);
        for (i, contour) in self.contours.iter().enumerate() {
            let area = imgproc::contour_area_def(&contour)?;
            if area > largest.0 {
                largest = (area, i);
            }
        }
        outline.clear();
        if largest.0 > 0.0 {
            let contour = self.contours.get(largest.1)?;
            outline.extend(contour.iter().map(|point| [f64::from(point.x), f64::from(point.y)]));
        }
        Ok(largest.0)
    }
}

fn failed(width_px: usize, height_px: usize, source: opencv::Error) -> SegmentationError {
    SegmentationError { width_px, height_px, source }
}
