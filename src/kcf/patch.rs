//! The windowed feature patch: grey in \[0,1\], mean removed, times a cosine window.

use crate::frame::GrayFrame;
use crate::imgproc::Pixels;
use crate::lanes;
use crate::units::PixelPoint;

/// The separable cosine (Hann) window, zero just outside the patch.
#[derive(Debug, Clone)]
pub struct CosineWindow {
    along_u: Vec<f32>,
    along_v: Vec<f32>,
}

impl CosineWindow {
    /// A window of `width` × `height` pixels.
    pub fn new(width: usize, height: usize) -> Self {
        let hann = |n: usize| {
            (1..=n)
                .map(|i| (0.5 - 0.5 * (std::f64::consts::TAU * i as f64 / (n + 1) as f64).cos()) as f32)
                .collect::<Vec<_>>()
        };
        Self { along_u: hann(width), along_v: hann(height) }
    }

    /// Removes the mean of `patch` and applies the window, in place.
    pub fn apply(&self, patch: &mut [f32]) {
        let width = self.along_u.len();
        let mean = (lanes::sum(patch) / patch.len() as f64) as f32;
        for (row, wv) in patch.chunks_exact_mut(width).zip(&self.along_v) {
            for (value, wu) in row.iter_mut().zip(&self.along_u) {
                *value = (*value - mean) * wu * wv;
            }
        }
    }
}

/// Reads patches of one width out of frames.
#[derive(Debug, Clone)]
pub struct Sampler {
    /// A row of the frame, one pixel longer than the patch.
    row: Vec<f32>,
    /// Two rows between the frame's columns: the upper and the lower one of the patch's row.
    between: [Vec<f32>; 2],
}

impl Sampler {
    /// For patches of `width` columns.
    pub fn new(width: usize) -> Self {
        Self { row: vec![0.0; width + 1], between: [vec![0.0; width], vec![0.0; width]] }
    }

    /// Samples the pixels round `centre` bilinearly into `patch`, as grey in \[0,1\]; the frame's border continues outwards.
    /// Pixel (width/2, height/2) of the patch lies on `centre`.
    pub fn sample(&mut self, mut pixels: impl Pixels, centre: PixelPoint, patch: &mut [f32]) {
        let width = self.between[0].len();
        let height = patch.len() / width;
        let (u0, v0) = (centre.u_px.floor(), centre.v_px.floor());
        let (fu, fv) = ((centre.u_px - u0) as f32, (centre.v_px - v0) as f32);
        let (left, top) = (u0 as isize - (width / 2) as isize, v0 as isize - (height / 2) as isize);
        let reached = |first: isize, n: usize| first.max(0) as usize..(first + n as isize + 1).max(0) as usize;
        let border = pixels.size_px();
        // Beyond the border it is the border that is read.
        let reached = |first: isize, n: usize, size: usize| {
            let range = reached(first, n);
            range.start.min(size - 1)..range.end.max(1)
        };
        let frame = pixels.region(reached(left, width, border.0), reached(top, height, border.1));
        self.between_columns(frame, (left, top), fu);
        for (j, target) in patch.chunks_exact_mut(width).enumerate() {
            self.between.swap(0, 1);
            self.between_columns(frame, (left, top + j as isize + 1), fu);
            for ((value, upper), lower) in target.iter_mut().zip(&self.between[1]).zip(&self.between[0]) {
                *value = upper + fv * (lower - upper);
            }
        }
    }

    /// The row `v` of the frame, `fu` of a pixel beyond the columns from `left` on, into the first of the two rows.
    fn between_columns(&mut self, frame: &GrayFrame, (left, v): (isize, isize), fu: f32) {
        const SCALE: f32 = 1.0 / 255.0;
        let row = frame.row(v.clamp(0, frame.height_px() as isize - 1) as usize);
        let inside = usize::try_from(left).ok().and_then(|left| row.get(left..left + self.row.len()));
        match inside {
            Some(pixels) => {
                for (value, &grey) in self.row.iter_mut().zip(pixels) {
                    *value = SCALE * f32::from(grey);
                }
            }
            None => {
                for (i, value) in self.row.iter_mut().enumerate() {
                    *value = SCALE * f32::from(frame.at_clamped(left + i as isize, v));
                }
            }
        }
        for (value, pair) in self.between[0].iter_mut().zip(self.row.windows(2)) {
            *value = pair[0] + fu * (pair[1] - pair[0]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_ramp_is_sampled_exactly_between_pixels_and_near_the_border() {
        let frame = GrayFrame::new(40, 30, (0..1200).map(|i| (3 * (i % 40) + 2 * (i / 40)) as u8).collect()).unwrap();
        let mut patch = vec![0.0; 8 * 6];
        for centre in [PixelPoint::new(20.25, 15.5), PixelPoint::new(4.5, 3.25)] {
            Sampler::new(8).sample(&frame, centre, &mut patch);
            for j in 0..6 {
                for i in 0..8 {
                    let (u, v) = (centre.u_px + i as f64 - 4.0, centre.v_px + j as f64 - 3.0);
                    let expected = (3.0 * u + 2.0 * v) / 255.0;
                    assert!((f64::from(patch[j * 8 + i]) - expected).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn the_window_removes_the_mean_and_fades_to_the_border() {
        let mut patch = vec![0.7; 20 * 10];
        CosineWindow::new(20, 10).apply(&mut patch);
        assert!(patch.iter().all(|x| x.abs() < 1e-6));
    }
}
