//! What there is to know of a run besides its verdict: errors, tolerance, consistency, calibration.

use super::results::Estimator;
use super::run::Run;

/// 95 % quantile of χ² with one degree of freedom: a consistent filter's NIS is below it on 95 % of the frames.
pub const NIS_95: f64 = 3.841;

/// Each a short sentence.
pub(super) fn facts(run: &Run) -> Vec<String> {
    let summary = &run.summary;
    let mut facts = Vec::new();
    if let Some(errors) = &summary.errors {
        for estimator in [Estimator::Filtered, Estimator::Smoothed] {
            if let Some(e) = errors.of(estimator) {
                let name = estimator.name();
                facts.push(format!(
                    "Error {name}: mean {:.3} {unit}, maximum {:.3} {unit}.",
                    e.mae,
                    e.max,
                    unit = e.unit
                ));
            }
        }
    }
    if let Some(plane) = &summary.plane_errors {
        for (name, e) in [("Lateral", &plane.lateral), ("Height", &plane.height)] {
            facts.push(format!(
                "{name} error in the laser's plane: mean {:+.3} mm (σ of the calibration {}), scatter {:.3} mm (σ of the noise {:.3}).",
                e.bias_mm,
                e.calib_std_mm.map_or_else(|| "unknown".to_owned(), |std| format!("{std:.3}")),
                e.scatter_mm,
                e.noise_std_mm
            ));
        }
    }
    facts.extend(run.tolerance().map(|tolerance| tolerance.sentence()));
    if let Some(consistency) = consistency(run) {
        let Consistency { mean, below_95_pct } = consistency;
        facts.push(format!(
            "NIS {mean:.2} on average (1 expected), {below_95_pct:.0} % below {NIS_95} (95 % expected)."
        ));
    }
    for (count, what) in
        [(summary.frames.repeated, "repeat their predecessor"), (summary.frames.saturated, "are saturated")]
    {
        if count > 0 {
            facts.push(format!("{count} frames {what}."));
        }
    }
    facts.push(format!("{}, {} stripe.", summary.calibration.words(), summary.calibration.stripe));
    facts.push(format!("Joint: {}; {}.", summary.joint.kind, summary.joint.reason.trim_end_matches('.')));
    facts
}

/// How well the filter's innovations fit its σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Consistency {
    /// Mean NIS; 1 for a consistent filter of one observation.
    pub mean: f64,
    /// Share of NIS below [`NIS_95`] \[%\].
    pub below_95_pct: f64,
}

/// The consistency of a run, if it has any NIS.
#[must_use]
pub fn consistency(run: &Run) -> Option<Consistency> {
    let nis: Vec<f64> = run.rows.iter().filter_map(|row| row.nis).collect();
    let count = nis.len() as f64;
    let below = nis.iter().filter(|&&nis| nis < NIS_95).count() as f64;
    (!nis.is_empty())
        .then(|| Consistency { mean: nis.iter().sum::<f64>() / count, below_95_pct: 100.0 * below / count })
}
