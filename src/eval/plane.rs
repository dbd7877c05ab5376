//! Errors in the plane of a calibrated laser, and whether both of its uncertainties hold.

use serde::{Deserialize, Serialize};

/// A coordinate in one frame with its two σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneValue {
    /// Estimate − truth \[mm\].
    pub error_mm: f64,
    /// σ by the picture's noise \[mm\].
    pub noise_std_mm: f64,
    /// σ by the calibration \[mm\], where it is known.
    pub calib_std_mm: Option<f64>,
}

/// Errors of one coordinate over the frames that have an estimate and a truth. The calibration's error is nearly the same in
/// all frames, so it shows in the mean; what scatters about the mean is the picture's noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AxisErrors {
    /// Frames with both.
    pub frames: usize,
    /// Mean absolute error \[mm\].
    pub mae_mm: f64,
    /// Root mean square error \[mm\].
    pub rmse_mm: f64,
    /// Largest absolute error \[mm\].
    pub max_mm: f64,
    /// Mean error \[mm\].
    pub bias_mm: f64,
    /// Root mean square of what is left of the errors without their mean \[mm\].
    pub scatter_mm: f64,
    /// Root mean square of the stated σ of the noise \[mm\].
    pub noise_std_mm: f64,
    /// Share of the frames whose error without the mean lies within ±2σ of the noise, 0 to 1.
    pub scatter_in_2sigma: f64,
    /// Root mean square of the stated σ of the calibration \[mm\].
    pub calib_std_mm: Option<f64>,
    /// The mean error in σ of the calibration: beyond ±2 in one calibration of twenty.
    pub bias_in_calib_std: Option<f64>,
}

/// Errors along the stripe and towards the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlaneErrors {
    /// Of `lateral_mm`.
    pub lateral: AxisErrors,
    /// Of `height_mm`.
    pub height: AxisErrors,
}

/// The errors of one coordinate; none without a frame.
#[must_use]
pub fn axis_errors(values: &[PlaneValue]) -> Option<AxisErrors> {
    let n = values.len() as f64;
    let mean = |of: &dyn Fn(&PlaneValue) -> f64| values.iter().map(of).sum::<f64>() / n;
    let bias_mm = mean(&|v| v.error_mm);
    let calib = values.iter().map(|v| v.calib_std_mm.map(|std| std * std)).sum::<Option<f64>>();
    let calib_std_mm = calib.map(|sum| (sum / n).sqrt());
    let within = values.iter().filter(|v| (v.error_mm - bias_mm).abs() <= 2.0 * v.noise_std_mm).count();
    (!values.is_empty()).then(|| AxisErrors {
        frames: values.len(),
        mae_mm: mean(&|v| v.error_mm.abs()),
        rmse_mm: mean(&|v| v.error_mm.powi(2)).sqrt(),
        max_mm: values.iter().map(|v| v.error_mm.abs()).fold(0.0, f64::max),
        bias_mm,
        scatter_mm: mean(&|v| (v.error_mm - bias_mm).powi(2)).sqrt(),
        noise_std_mm: mean(&|v| v.noise_std_mm.powi(2)).sqrt(),
        scatter_in_2sigma: within as f64 / n,
        calib_std_mm,
        bias_in_calib_std: calib_std_mm.filter(|std| *std > 0.0).map(|std| bias_mm / std),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_the_calibrations_and_the_rest_the_noises() {
        let value = |error_mm| PlaneValue { error_mm, noise_std_mm: 0.1, calib_std_mm: Some(0.2) };
        let e = axis_errors(&[value(0.4), value(0.2), value(0.4), value(0.6)]).unwrap();
        approx::assert_relative_eq!(e.bias_mm, 0.4, epsilon = 1e-12);
        approx::assert_relative_eq!(e.bias_in_calib_std.unwrap(), 2.0, epsilon = 1e-12);
        approx::assert_relative_eq!(e.scatter_mm, 0.02f64.sqrt(), epsilon = 1e-12);
        assert_eq!((e.frames, e.max_mm), (4, 0.6));
        assert_eq!(axis_errors(&[]), None);
    }
}
