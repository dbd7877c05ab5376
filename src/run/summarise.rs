//! `summary.json` of a run.

use serde_json::{Map, Value, json};

use super::{RunError, RunOutcome};
use crate::calib::KnownSensor;
use crate::config::{Config, Preset};
use crate::eval::PlaneErrors;
use crate::report::summary::{Calibration, ErrorTable, Input, Joint, Limits, SCHEMA_VERSION, Summary};
use crate::tracker::{JointDecision, REFUSE_NIS};
use crate::units::StripeAxis;

/// The summary of a run over the recording `input` (a path as the user gave it, and the kind of recording), by a configuration
/// and a sensor. Of `limits` the user's are taken; those of the method are known here.
///
/// # Errors
/// When the configuration cannot be written as JSON.
pub fn summarise(
    outcome: &RunOutcome,
    (path, kind): (&str, &str),
    (config, known): (&Config, &KnownSensor),
    limits: Limits,
    (errors, plane_errors): (Option<ErrorTable>, Option<PlaneErrors>),
) -> Result<Summary, RunError> {
    let (width_px, height_px) = outcome.size_px;
    let mut more = Map::new();
    more.insert("kind".into(), json!(kind));
    if let Some(scale) = outcome.sixteen_bit_scale {
        more.insert("sixteen_bit_white".into(), json!(scale.white));
    }
    if let Some(frame) = outcome.confirmed_at {
        more.insert("seam_confirmed_at_frame".into(), json!(frame));
    }
    let config_json: Value = serde_json::to_value(config).map_err(|error| RunError::Config(error.into()))?;
    Ok(Summary {
        schema_version: SCHEMA_VERSION,
        program: format!("seamtrack {}", env!("CARGO_PKG_VERSION")),
        input: Input { path: path.into(), width_px, height_px, more },
        calibration: Calibration::of(
            known,
            outcome.axis.unwrap_or(StripeAxis::Horizontal),
            outcome.ruler.as_ref().map(|ruler| ruler.origin),
        ),
        limits: Limits {
            psr: (config.preset == Preset::Paper).then_some(config.paper.psr_threshold),
            nis: (config.preset == Preset::Robust).then_some(REFUSE_NIS),
            ..limits
        },
        config: config_json,
        frames: outcome.counts,
        joint: match outcome.joints.split_first() {
            Some((first, later)) => Joint { later: later.iter().map(joint).collect(), ..joint(first) },
            None => Joint {
                kind: "none".into(),
                decided_at_frame: None,
                reason: "no frame showed a joint that others confirmed".into(),
                doubt: None,
                contradicted_by: None,
                later: vec![],
            },
        },
        timing: outcome.timing,
        errors,
        plane_errors,
        tolerance: None,
    })
}

fn joint(decision: &JointDecision) -> Joint {
    Joint {
        kind: decision.kind.into(),
        decided_at_frame: Some(decision.frame),
        reason: decision.reason.clone(),
        doubt: decision.doubt.map(Into::into),
        contradicted_by: decision.contradicted_by.map(Into::into),
        later: vec![],
    }
}
