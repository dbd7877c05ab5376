//! The error figures of a path against its truth.

use serde::{Deserialize, Serialize};

use crate::units::MmPerPx;

/// A value further off than this is wrong \[mm\]: the method's description, section 5.
pub const WRONG_MM: f64 = 1.0;

/// A position along the stripe, as a tracker claims it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Position along the stripe \[px\].
    pub position_px: f64,
    /// One standard deviation of it \[px\], where the tracker states one.
    pub std_px: Option<f64>,
}

/// Errors along the stripe, estimate − truth, over the frames that have both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Frames with an estimate and a truth.
    pub frames: usize,
    /// Mean absolute error \[mm\].
    pub mae_mm: f64,
    /// Largest absolute error \[mm\].
    pub max_mm: f64,
    /// Standard deviation of the absolute error \[mm\], as in the papers.
    pub std_mm: f64,
    /// Root mean square error \[mm\].
    pub rmse_mm: f64,
    /// 95th percentile of the absolute error \[mm\], interpolated linearly between the ranks.
    pub p95_mm: f64,
    /// Mean signed error \[mm\].
    pub bias_mm: f64,
    /// Share of frames within ±2σ, 0 to 1; absent for an estimate without σ.
    pub coverage_2sigma: Option<f64>,
    /// Frames with a value that is off by over 1 mm.
    pub wrong_frames: usize,
    /// Frames without a value after the seam was first confirmed.
    pub unavailable_frames: usize,
}

/// The errors of `estimates` against `truth_px`, frame by frame; none when no frame has both.
///
/// # Panics
/// When the two differ in length.
#[must_use]
pub fn errors(estimates: &[Option<Estimate>], truth_px: &[Option<f64>], scale: MmPerPx) -> Option<Errors> {
    assert_eq!(estimates.len(), truth_px.len(), "one estimate and one truth a frame");
    let first = estimates.iter().position(Option::is_some)?;
    let unavailable_frames =
        estimates.iter().zip(truth_px).skip(first).filter(|(e, t)| e.is_none() && t.is_some()).count();
    let both = || estimates.iter().zip(truth_px).filter_map(|(e, t)| Some(((*e)?, (*t)?)));
    let signed_mm: Vec<f64> = both().map(|(e, t)| scale.get() * (e.position_px - t)).collect();
    if signed_mm.is_empty() {
        return None;
    }
    let n = signed_mm.len() as f64;
    let mut absolute_mm: Vec<f64> = signed_mm.iter().map(|e| e.abs()).collect();
    let mae_mm = absolute_mm.iter().sum::<f64>() / n;
    let std_mm = (absolute_mm.iter().map(|e| (e - mae_mm).powi(2)).sum::<f64>() / n).sqrt();
    absolute_mm.sort_by(f64::total_cmp);
    let claims: Vec<bool> =
        both().filter_map(|(e, t)| e.std_px.map(|std_px| (e.position_px - t).abs() <= 2.0 * std_px)).collect();
    Some(Errors {
        frames: signed_mm.len(),
        mae_mm,
        max_mm: absolute_mm[absolute_mm.len() - 1],
        std_mm,
        rmse_mm: (signed_mm.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
        p95_mm: percentile(&absolute_mm, 0.95),
        bias_mm: signed_mm.iter().sum::<f64>() / n,
        coverage_2sigma: (!claims.is_empty())
            .then(|| claims.iter().filter(|&&within| within).count() as f64 / claims.len() as f64),
        wrong_frames: absolute_mm.iter().filter(|&&e| e > WRONG_MM).count(),
        unavailable_frames,
    })
}

/// A quantile of sorted values, interpolated linearly.
fn percentile(sorted: &[f64], quantile: f64) -> f64 {
    let rank = quantile * (sorted.len() - 1) as f64;
    let below = rank.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (sorted[above] - sorted[below]) * (rank - below as f64)
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    fn at(position_px: f64) -> Option<Estimate> {
        Some(Estimate { position_px, std_px: Some(1.0) })
    }

    #[test]
    fn the_figures_are_those_computed_by_hand() {
        // Errors in px: +1, -3, (no value), +2, (no truth); scale 0.5 mm/px.
        let estimates = [at(11.0), at(17.0), None, at(42.0), at(9.0)];
        let truth = [Some(10.0), Some(20.0), Some(30.0), Some(40.0), None];
        let e = errors(&estimates, &truth, MmPerPx::new(0.5).unwrap()).unwrap();
        assert_eq!((e.frames, e.wrong_frames, e.unavailable_frames), (3, 1, 1));
        assert_relative_eq!(e.mae_mm, 1.0);
        assert_relative_eq!(e.max_mm, 1.5);
        assert_relative_eq!(e.std_mm, (1.0_f64 / 6.0).sqrt());
        assert_relative_eq!(e.rmse_mm, (3.5_f64 / 3.0).sqrt());
        assert_relative_eq!(e.p95_mm, 1.45);
        assert_relative_eq!(e.bias_mm, 0.0);
        assert_relative_eq!(e.coverage_2sigma.unwrap(), 2.0 / 3.0);
    }

    #[test]
    fn frames_before_the_seam_was_found_are_not_unavailable_but_later_gaps_are() {
        let truth = vec![Some(1.0); 6];
        let e = errors(&[None, None, at(1.0), None, at(1.0), None], &truth, MmPerPx::DU_2022).unwrap();
        assert_eq!((e.frames, e.unavailable_frames), (2, 2));
    }

    #[test]
    fn exactly_one_millimetre_is_not_yet_wrong_and_a_missing_sigma_claims_nothing() {
        let plain = |position_px| Some(Estimate { position_px, std_px: None });
        let e = errors(&[plain(2.0), plain(2.5)], &[Some(1.0), Some(1.0)], MmPerPx::new(1.0).unwrap()).unwrap();
        assert_eq!((e.wrong_frames, e.coverage_2sigma), (1, None));
    }

    #[test]
    fn without_a_common_frame_there_are_no_figures() {
        assert_eq!(errors(&[None, at(1.0)], &[Some(1.0), None], MmPerPx::DU_2022), None);
    }
}
