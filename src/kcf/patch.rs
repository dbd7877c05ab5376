//! The windowed feature patch: grey in \[0,1\], mean removed, times a cosine window.

use crate::frame::GrayFrame;
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
        let mean = (patch.iter().map(|&x| f64::from(x)).sum::<f64>() / patch.len() as f64) as f32;
        for (row, wv) in patch.chunks_exact_mut(width).zip(&self.along_v) {
            for (value, wu) in row.iter_mut().zip(&self.along_u) {
                *value = (*value - mean) * wu * wv;
            }
        }
    }
}

/// Samples `width` × `height` pixels round `centre` bilinearly into `patch`, as grey in \[0,1\]; the frame's border
/// continues outwards. Pixel (width/2, height/2) of the patch lies on `centre`.
pub fn sample(frame: &GrayFrame, centre: PixelPoint, width: usize, height: usize, patch: &mut [f32]) {
    let (u0, v0) = (centre.u_px.floor(), centre.v_px.floor());
    let (fu, fv) = ((centre.u_px - u0) as f32, (centre.v_px - v0) as f32);
    let (left, top) = (u0 as isize - (width / 2) as isize, v0 as isize - (height / 2) as isize);
    let inside = left >= 0
        && top >= 0
        && left + (width as isize) < frame.width_px() as isize
        && top + (height as isize) < frame.height_px() as isize;
    // The four bilinear weights, with the scale from grey to [0,1] in them.
    let scale = 1.0 / 255.0;
    let (a, b) = ((1.0 - fu) * (1.0 - fv) * scale, fu * (1.0 - fv) * scale);
    let (c, d) = ((1.0 - fu) * fv * scale, fu * fv * scale);
    for (j, row) in patch.chunks_exact_mut(width).enumerate() {
        let v = top + j as isize;
        if inside {
            let left = left as usize;
            let upper = &frame.row(v as usize)[left..=left + width];
            let lower = &frame.row(v as usize + 1)[left..=left + width];
            for (i, value) in row.iter_mut().enumerate() {
                *value = a * f32::from(upper[i])
                    + b * f32::from(upper[i + 1])
                    + c * f32::from(lower[i])
                    + d * f32::from(lower[i + 1]);
            }
        } else {
            for (i, value) in row.iter_mut().enumerate() {
                let u = left + i as isize;
                *value = a * f32::from(frame.at_clamped(u, v))
                    + b * f32::from(frame.at_clamped(u + 1, v))
                    + c * f32::from(frame.at_clamped(u, v + 1))
                    + d * f32::from(frame.at_clamped(u + 1, v + 1));
            }
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
            sample(&frame, centre, 8, 6, &mut patch);
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
