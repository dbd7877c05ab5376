//! Training, detection and update of the filter.

use rustfft::num_complex::Complex32;

use super::fft2::{Fft2, Spectrum};
use super::patch::{CosineWindow, Sampler};
use super::response::{Response, peak_shift, psr, psr_ceiling};
use crate::imgproc::Pixels;
use crate::lanes;
use crate::units::PixelPoint;

/// The filter's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KcfSettings {
    /// Window width \[px\]: the ROI's width times the padding, or the next size that the FFT likes.
    pub window_width_px: usize,
    /// Window height \[px\].
    pub window_height_px: usize,
    /// SD of the Gaussian training label \[px\].
    pub label_sd_px: f64,
    /// Bandwidth σ of the Gaussian kernel, on grey in \[0,1\].
    pub kernel_sigma: f64,
    /// Regularisation λ of the ridge regression (Du 2022, eq. 1).
    pub lambda: f64,
}

impl KcfSettings {
    /// Du 2022 on its ROI of 80 × 60 px; padding 2.5, label SD 0.1·√(80·60), σ = 0.2 and λ = 1e-4 are not printed
    /// there and follow Henriques 2015.
    #[must_use]
    pub fn du_2022() -> Self {
        Self {
            window_width_px: 200,
            window_height_px: 150,
            label_sd_px: 0.1 * 4800f64.sqrt(),
            kernel_sigma: 0.2,
            lambda: 1e-4,
        }
    }
}

/// Settings that no filter can be built from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KcfError {
    /// The window is too small, or larger than any frame.
    #[error("a KCF window of {0} x {1} pixels is not between 8 and 4096 pixels a side")]
    Window(usize, usize),
    /// A number that must be finite and positive is not.
    #[error("the KCF's {name} must be a positive number, not {value}")]
    NotPositive {
        /// Which number.
        name: &'static str,
        /// Its value.
        value: f64,
    },
}

/// A trained filter with its plan and buffers. [`Self::train`] comes first.
pub struct Kcf {
    settings: KcfSettings,
    fft: Fft2,
    window: CosineWindow,
    sampler: Sampler,
    label_spectrum: Spectrum,
    /// Learned features x̂ and dual coefficients α̂ (Du 2022, eq. 8).
    template_spectrum: Spectrum,
    alpha_spectrum: Spectrum,
    template_energy: f32,
    ceiling: f32,
    patch: Vec<f32>,
    kernel: Vec<f32>,
    patch_spectrum: Spectrum,
    product: Spectrum,
}

impl Kcf {
    /// Plans a filter. Nothing is learned yet: every response is zero.
    ///
    /// # Errors
    /// When a setting is out of its range.
    pub fn new(settings: KcfSettings) -> Result<Self, KcfError> {
        let (width, height) = (settings.window_width_px, settings.window_height_px);
        if !(8..=4096).contains(&width) || !(8..=4096).contains(&height) {
            return Err(KcfError::Window(width, height));
        }
        for (name, value) in [
            ("label SD", settings.label_sd_px),
            ("kernel bandwidth", settings.kernel_sigma),
            ("regularisation", settings.lambda),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(KcfError::NotPositive { name, value });
            }
        }
        let mut fft = Fft2::new(width, height);
        let mut label_spectrum = fft.new_spectrum();
        fft.forward(&gaussian_label(width, height, settings.label_sd_px), &mut label_spectrum);
        Ok(Self {
            window: CosineWindow::new(width, height),
            sampler: Sampler::new(width),
            label_spectrum,
            template_spectrum: fft.new_spectrum(),
            alpha_spectrum: fft.new_spectrum(),
            template_energy: 0.0,
            ceiling: psr_ceiling(settings.label_sd_px, width * height) as f32,
            patch: vec![0.0; width * height],
            kernel: vec![0.0; width * height],
            patch_spectrum: fft.new_spectrum(),
            product: fft.new_spectrum(),
            fft,
            settings,
        })
    }

    /// Learns the patch round `centre`, forgetting all before.
    pub fn train(&mut self, pixels: impl Pixels, centre: PixelPoint) {
        self.update(pixels, centre, 1.0);
    }

    /// Blends the patch round `centre` into template and coefficients at `learning_rate` (Du 2022, eq. 8).
    pub fn update(&mut self, pixels: impl Pixels, centre: PixelPoint, learning_rate: f64) {
        self.read_patch(pixels, centre);
        let energy = lanes::sum_of_squares(&self.patch);
        for (product, x) in self.product.iter_mut().zip(&self.patch_spectrum) {
            *product = Complex32::new(x.norm_sqr(), 0.0);
        }
        self.kernel_from_product(energy, energy);
        let (rate, lambda) = (learning_rate as f32, self.settings.lambda as f32);
        // α̂ = ŷ / (k̂_xx + λ), eq. 4.
        let asked = self.label_spectrum.iter().zip(&self.product);
        for (learned, (label, kernel)) in self.alpha_spectrum.iter_mut().zip(asked) {
            let denominator = kernel + lambda;
            let alpha = label * denominator.conj() * denominator.norm_sqr().recip();
            *learned = *learned * (1.0 - rate) + alpha * rate;
        }
        for (learned, seen) in self.template_spectrum.iter_mut().zip(&self.patch_spectrum) {
            *learned = *learned * (1.0 - rate) + seen * rate;
        }
        self.template_energy = self.fft.energy(&self.template_spectrum);
    }

    /// Searches the window round `centre`: response F⁻¹(k̂_xz ⊙ α̂) (Du 2022, eq. 6), its peak and PSR.
    pub fn detect(&mut self, pixels: impl Pixels, centre: PixelPoint) -> Response {
        self.read_patch(pixels, centre);
        self.respond(centre)
    }

    fn respond(&mut self, centre: PixelPoint) -> Response {
        let energy = lanes::sum_of_squares(&self.patch);
        for ((product, x), z) in self.product.iter_mut().zip(&self.template_spectrum).zip(&self.patch_spectrum) {
            *product = x.conj() * z;
        }
        self.kernel_from_product(self.template_energy, energy);
        for (product, alpha) in self.product.iter_mut().zip(&self.alpha_spectrum) {
            *product *= alpha;
        }
        self.fft.inverse(&mut self.product, &mut self.kernel);
        let (du_px, dv_px, value) =
            peak_shift(&self.kernel, self.settings.window_width_px, self.settings.window_height_px);
        Response {
            peak: PixelPoint::new(centre.u_px + du_px, centre.v_px + dv_px),
            value,
            psr: psr(&self.kernel, value),
            psr_ceiling: self.ceiling,
        }
    }

    /// The last [`Self::detect`]'s response map, row by row, shift zero first and wrapped.
    #[must_use]
    pub fn response_map(&self) -> &[f32] {
        &self.kernel
    }

    fn read_patch(&mut self, pixels: impl Pixels, centre: PixelPoint) {
        self.sampler.sample(pixels, centre, &mut self.patch);
        self.window.apply(&mut self.patch);
        self.fft.forward(&self.patch, &mut self.patch_spectrum);
    }

    /// `product` holds conj(x̂) ⊙ ẑ; leaves in it the spectrum of the Gaussian kernel
    /// k = exp(−max(0, |x|² + |z|² − 2 F⁻¹(conj(x̂) ⊙ ẑ)) / (σ² N)).
    fn kernel_from_product(&mut self, energy_x: f32, energy_z: f32) {
        self.fft.inverse(&mut self.product, &mut self.kernel);
        let scale = -1.0 / (self.settings.kernel_sigma.powi(2) * self.kernel.len() as f64) as f32;
        for k in &mut self.kernel {
            *k = lanes::exp_of_negative((energy_x + energy_z - 2.0 * *k).max(0.0) * scale);
        }
        self.fft.forward(&self.kernel, &mut self.product);
    }
}

/// The training label: a Gaussian with its peak at shift zero, wrapped.
fn gaussian_label(width: usize, height: usize, sd_px: f64) -> Vec<f32> {
    let wrapped = |i: usize, n: usize| i.min(n - i) as f64;
    let weight = |i: usize, n: usize| (-wrapped(i, n).powi(2) / (2.0 * sd_px * sd_px)).exp();
    (0..width * height).map(|i| (weight(i % width, width) * weight(i / width, height)) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::GrayFrame;

    fn settings(width: usize, height: usize) -> KcfSettings {
        KcfSettings { window_width_px: width, window_height_px: height, label_sd_px: 2.0, ..KcfSettings::du_2022() }
    }

    /// A butt-like picture whose break lies at (u, v), drawn without any FFT.
    fn picture(width: usize, height: usize, u0: f64, v0: f64) -> GrayFrame {
        let mut pixels = vec![0; width * height];
        for v in 0..height {
            for u in 0..width {
                let edge = |e: f64| 1.0 / (1.0 + (-(u as f64 - u0 - e) / 0.8).exp());
                let inside = edge(-6.0) * (1.0 - edge(6.0));
                let row = |c: f64| (-0.5 * ((v as f64 - c) / 2.4).powi(2)).exp();
                let light = (1.0 - inside) * row(v0 - 6.0) + 0.8 * inside * row(v0 + 6.0);
                pixels[v * width + u] = (9.0 + 190.0 * light) as u8;
            }
        }
        GrayFrame::new(width, height, pixels).unwrap()
    }

    /// The response by its definition, shift by shift, with naive circular sums in f64.
    fn naive_response(x: &[f32], z: &[f32], width: usize, height: usize, settings: &KcfSettings) -> Vec<f64> {
        let n = width * height;
        let shifted = |a: &[f32], b: &[f32], s: usize| -> f64 {
            let (su, sv) = (s % width, s / width);
            (0..n)
                .map(|i| {
                    let j = ((i / width + sv) % height) * width + (i % width + su) % width;
                    f64::from(a[i]) * f64::from(b[j])
                })
                .sum()
        };
        let energy = |a: &[f32]| a.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>();
        let kernel = |a: &[f32], b: &[f32]| -> Vec<f64> {
            (0..n)
                .map(|s| {
                    let d = (energy(a) + energy(b) - 2.0 * shifted(a, b, s)).max(0.0);
                    (-d / (settings.kernel_sigma.powi(2) * n as f64)).exp()
                })
                .collect()
        };
        // Ridge regression (K + λI) α = y over all cyclic shifts, solved densely.
        let kxx = kernel(x, x);
        let label = gaussian_label(width, height, settings.label_sd_px);
        let circulant = |i: usize, j: usize| {
            let du = (i % width + width - j % width) % width;
            let dv = (i / width + height - j / width) % height;
            kxx[dv * width + du]
        };
        let matrix =
            nalgebra::DMatrix::from_fn(n, n, |i, j| circulant(i, j) + if i == j { settings.lambda } else { 0.0 });
        let y = nalgebra::DVector::from_iterator(n, label.iter().map(|&v| f64::from(v)));
        let alpha = matrix.lu().solve(&y).unwrap();
        let kxz = kernel(x, z);
        (0..n)
            .map(|s| {
                (0..n)
                    .map(|i| {
                        let du = (s % width + width - i % width) % width;
                        let dv = (s / width + height - i / width) % height;
                        alpha[i] * kxz[dv * width + du]
                    })
                    .sum()
            })
            .collect()
    }

    #[test]
    fn the_fast_correlation_is_the_dense_ridge_regression_over_all_shifts() {
        let (width, height) = (24, 16);
        let settings = settings(width, height);
        let mut kcf = Kcf::new(settings).unwrap();
        let here = picture(80, 60, 40.0, 30.0);
        let there = picture(80, 60, 43.0, 28.0);
        let centre = PixelPoint::new(40.0, 30.0);
        kcf.train(&here, centre);
        let x = kcf.patch.clone();
        kcf.detect(&there, centre);
        let expected = naive_response(&x, &kcf.patch.clone(), width, height, &settings);
        for (fast, slow) in kcf.response_map().iter().zip(&expected) {
            assert!((f64::from(*fast) - slow).abs() < 2e-3, "{fast} against {slow}");
        }
    }

    #[test]
    fn a_cyclic_shift_that_goes_in_comes_out_as_the_peak() {
        let (width, height) = (40, 30);
        let mut kcf = Kcf::new(settings(width, height)).unwrap();
        kcf.train(&picture(80, 60, 40.0, 30.0), PixelPoint::new(40.0, 30.0));
        let patch = kcf.patch.clone();
        for (du, dv) in [(0, 0), (7, 0), (-11, 4), (19, -14)] {
            let from = |i: usize, shift: isize, n: usize| (i as isize - shift).rem_euclid(n as isize) as usize;
            for i in 0..patch.len() {
                kcf.patch[i] = patch[from(i / width, dv, height) * width + from(i % width, du, width)];
            }
            kcf.fft.forward(&kcf.patch, &mut kcf.patch_spectrum);
            let peak = kcf.respond(PixelPoint::new(0.0, 0.0)).peak;
            let (eu, ev) = (peak.u_px - du as f64, peak.v_px - dv as f64);
            assert!(eu.abs() < 0.01 && ev.abs() < 0.01, "shift {du},{dv}: peak {peak:?}");
        }
    }

    #[test]
    fn a_small_shift_of_the_picture_is_found_below_the_pixel() {
        let mut kcf = Kcf::new(KcfSettings::du_2022()).unwrap();
        let centre = PixelPoint::new(200.0, 120.0);
        kcf.train(&picture(420, 260, 200.0, 120.0), centre);
        let mut error_px = |du: f64, dv: f64| {
            let response = kcf.detect(&picture(420, 260, 200.0 + du, 120.0 + dv), centre);
            (response.peak.u_px - 200.0 - du).abs().max((response.peak.v_px - 120.0 - dv).abs())
        };
        // Far shifts are pulled to the middle by the cosine window; near ones are exact below the pixel.
        for (du, dv) in [(0.5, 0.0), (-1.3, 0.7), (0.2, -0.4)] {
            assert!(error_px(du, dv) < 0.1, "shift {du},{dv}: error {}", error_px(du, dv));
        }
    }

    #[test]
    fn the_trained_patch_itself_answers_with_the_ideal_response() {
        let mut kcf = Kcf::new(KcfSettings::du_2022()).unwrap();
        let frame = picture(420, 260, 200.0, 120.0);
        kcf.train(&frame, PixelPoint::new(200.0, 120.0));
        let response = kcf.detect(&frame, PixelPoint::new(200.0, 120.0));
        assert!((response.value - 1.0).abs() < 0.02, "{}", response.value);
        assert!((response.psr_ratio() - 1.0).abs() < 0.05, "{}", response.psr_ratio());
    }

    #[test]
    fn an_empty_frame_answers_without_a_number_gone_wrong() {
        let mut kcf = Kcf::new(settings(24, 16)).unwrap();
        let frame = GrayFrame::filled(30, 20, 0).unwrap();
        kcf.train(&frame, PixelPoint::new(15.0, 10.0));
        let response = kcf.detect(&frame, PixelPoint::new(-40.0, 500.0));
        assert!(response.peak.u_px.is_finite() && response.psr.is_finite());
    }

    #[test]
    fn settings_that_cannot_work_are_refused() {
        assert_eq!(Kcf::new(settings(4, 16)).err(), Some(KcfError::Window(4, 16)));
        let nan = KcfSettings { lambda: f64::NAN, ..settings(24, 16) };
        assert!(matches!(Kcf::new(nan), Err(KcfError::NotPositive { name: "regularisation", .. })));
    }
}
