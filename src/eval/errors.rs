//! The error figures of a path against its truth.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::units::{LengthUnit, MmPerPx};

/// A value further off than this is wrong \[mm\]: the method's description, section 5.
pub const WRONG_MM: f64 = 1.0;
/// The same where no scale is known \[px\]. Chosen: [`WRONG_MM`] on sensors of a tenth of a millimetre a pixel.
pub const WRONG_PX: f64 = 10.0;

/// A position along the stripe, as a tracker claims it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Position along the stripe \[px\].
    pub position_px: f64,
    /// One standard deviation of it \[px\], where the tracker states one.
    pub std_px: Option<f64>,
}

/// Errors along the stripe, estimate − truth, over the frames that have both. Lengths are in [`Errors::unit`]; in files their
/// keys end in it: `mae_mm`, or `mae_px` where no scale is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Map<String, Value>", into = "Map<String, Value>")]
pub struct Errors {
    /// The unit of the lengths.
    pub unit: LengthUnit,
    /// Frames with an estimate and a truth.
    pub frames: usize,
    /// Mean absolute error.
    pub mae: f64,
    /// Largest absolute error.
    pub max: f64,
    /// Standard deviation of the absolute error, as in the papers.
    pub std: f64,
    /// Root mean square error.
    pub rmse: f64,
    /// 95th percentile of the absolute error, interpolated linearly between the ranks.
    pub p95: f64,
    /// Mean signed error.
    pub bias: f64,
    /// Share of frames within ±2σ, 0 to 1; absent for an estimate without σ.
    pub coverage_2sigma: Option<f64>,
    /// Frames with a value that is off by over [`WRONG_MM`], or [`WRONG_PX`].
    pub wrong_frames: usize,
    /// Frames without a value after the seam was first confirmed.
    pub unavailable_frames: usize,
}

/// The errors of `estimates` against `truth_px`, frame by frame, by one scale; none when no frame has both.
///
/// # Panics
/// When the two differ in length.
#[must_use]
pub fn errors(estimates: &[Option<Estimate>], truth_px: &[Option<f64>], scale: MmPerPx) -> Option<Errors> {
    errors_by(estimates, truth_px, LengthUnit::Mm, |_| scale.get())
}

/// The same in any unit: `scale` is that of a pixel along the stripe in each frame.
///
/// # Panics
/// When the two differ in length.
#[must_use]
pub fn errors_by(
    estimates: &[Option<Estimate>],
    truth_px: &[Option<f64>],
    unit: LengthUnit,
    scale: impl Fn(usize) -> f64,
) -> Option<Errors> {
    assert_eq!(estimates.len(), truth_px.len(), "one estimate and one truth a frame");
    let first = estimates.iter().position(Option::is_some)?;
    let unavailable_frames =
        estimates.iter().zip(truth_px).skip(first).filter(|(e, t)| e.is_none() && t.is_some()).count();
    let both = || estimates.iter().zip(truth_px).enumerate().filter_map(|(i, (e, t))| Some((i, (*e)?, (*t)?)));
    let signed: Vec<f64> = both().map(|(i, e, t)| scale(i) * (e.position_px - t)).collect();
    if signed.is_empty() {
        return None;
    }
    let n = signed.len() as f64;
    let mut absolute: Vec<f64> = signed.iter().map(|e| e.abs()).collect();
    let mae = absolute.iter().sum::<f64>() / n;
    let std = (absolute.iter().map(|e| (e - mae).powi(2)).sum::<f64>() / n).sqrt();
    absolute.sort_by(f64::total_cmp);
    let claims: Vec<bool> =
        both().filter_map(|(_, e, t)| e.std_px.map(|std_px| (e.position_px - t).abs() <= 2.0 * std_px)).collect();
    Some(Errors {
        unit,
        frames: signed.len(),
        mae,
        max: absolute[absolute.len() - 1],
        std,
        rmse: (signed.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
        p95: percentile(&absolute, 0.95),
        bias: signed.iter().sum::<f64>() / n,
        coverage_2sigma: (!claims.is_empty())
            .then(|| claims.iter().filter(|&&within| within).count() as f64 / claims.len() as f64),
        wrong_frames: absolute.iter().filter(|&&e| e > wrong_from(unit)).count(),
        unavailable_frames,
    })
}

/// What a value must be off by to be wrong, with its unit.
#[must_use]
pub fn wrong_limit(unit: LengthUnit) -> String {
    format!("{} {unit}", wrong_from(unit))
}

const fn wrong_from(unit: LengthUnit) -> f64 {
    match unit {
        LengthUnit::Mm => WRONG_MM,
        LengthUnit::Px => WRONG_PX,
    }
}

impl From<Errors> for Map<String, Value> {
    fn from(e: Errors) -> Self {
        let lengths =
            [("mae", e.mae), ("max", e.max), ("std", e.std), ("rmse", e.rmse), ("p95", e.p95), ("bias", e.bias)];
        let lengths = lengths.map(|(name, value)| (format!("{name}_{}", e.unit), json!(value)));
        let others = [
            ("frames", json!(e.frames)),
            ("coverage_2sigma", json!(e.coverage_2sigma)),
            ("wrong_frames", json!(e.wrong_frames)),
            ("unavailable_frames", json!(e.unavailable_frames)),
        ];
        lengths.into_iter().chain(others.map(|(name, value)| (name.to_owned(), value))).collect()
    }
}

impl TryFrom<Map<String, Value>> for Errors {
    type Error = String;
    fn try_from(map: Map<String, Value>) -> Result<Self, String> {
        let unit = if map.contains_key("mae_px") { LengthUnit::Px } else { LengthUnit::Mm };
        let missing = |key: &str| format!("the errors have no {key}");
        let length = |name: &str| {
            let key = format!("{name}_{unit}");
            map.get(&key).and_then(Value::as_f64).ok_or_else(|| missing(&key))
        };
        let count = |key: &str| {
            let count = map.get(key).and_then(Value::as_u64).and_then(|count| usize::try_from(count).ok());
            count.ok_or_else(|| missing(key))
        };
        Ok(Self {
            unit,
            frames: count("frames")?,
            mae: length("mae")?,
            max: length("max")?,
            std: length("std")?,
            rmse: length("rmse")?,
            p95: length("p95")?,
            bias: length("bias")?,
            coverage_2sigma: map.get("coverage_2sigma").and_then(Value::as_f64),
            wrong_frames: count("wrong_frames")?,
            unavailable_frames: count("unavailable_frames")?,
        })
    }
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
        assert_relative_eq!(e.mae, 1.0);
        assert_relative_eq!(e.max, 1.5);
        assert_relative_eq!(e.std, (1.0_f64 / 6.0).sqrt());
        assert_relative_eq!(e.rmse, (3.5_f64 / 3.0).sqrt());
        assert_relative_eq!(e.p95, 1.45);
        assert_relative_eq!(e.bias, 0.0);
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
    fn the_unit_stands_in_the_keys_of_files() {
        for (unit, key) in [(LengthUnit::Mm, "mae_mm"), (LengthUnit::Px, "mae_px")] {
            let e = errors_by(&[at(11.0)], &[Some(9.0)], unit, |_| 1.0).unwrap();
            let text = serde_json::to_string(&e).unwrap();
            assert!(text.contains(key), "{text}");
            assert_eq!(serde_json::from_str::<Errors>(&text).unwrap(), e);
        }
        let far = errors_by(&[at(21.0)], &[Some(10.0)], LengthUnit::Px, |_| 1.0).unwrap();
        assert_eq!(far.wrong_frames, 1);
    }

    #[test]
    fn without_a_common_frame_there_are_no_figures() {
        assert_eq!(errors(&[None, at(1.0)], &[Some(1.0), None], MmPerPx::DU_2022), None);
    }
}
