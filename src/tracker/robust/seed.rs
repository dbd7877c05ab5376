//! Finding the joint in a whole frame, without a prediction.

use crate::frame::GrayFrame;
use crate::imgproc::geometry::{JointFit, JointKind, JointModel, learn};
use crate::imgproc::{Centreline, CentrelineSettings, SeedSettings, extract_centreline, seam_candidates};
use crate::units::PixelPoint;

/// Arm of the second difference that shows a corner \[px\]. Prototype.
const CORNER_ARM_PX: usize = 18;
/// Least second difference of a corner over the arms \[px\]: a bend of 0.2 in slope. Chosen.
const LEAST_CORNER_PX: f32 = 3.6;
/// Places of a frame that are looked at closely.
const MOST_CANDIDATES: usize = 6;
/// How far the refined centre may lie from the seed \[px\].
const SEARCH_PX: f64 = 12.0;
/// A joint found in a frame.
#[derive(Debug, Clone)]
pub struct Seed {
    /// Its cross-section.
    pub model: JointModel,
    /// The fit on the same frame.
    pub fit: JointFit,
    /// So clear that no second frame need confirm it.
    pub clear: bool,
}

/// Whether the frame shows a stripe at all, and the joint of `kind` in it. `asked` is where the user says it is.
pub fn find(frame: &GrayFrame, kind: JointKind, asked: Option<PixelPoint>) -> (bool, Option<Seed>) {
    let line = extract_centreline(frame, &CentrelineSettings::default());
    let settings = SeedSettings::default();
    let seen = line.extent(settings.widest_joint_px).is_some();
    let candidates = match asked {
        Some(point) => vec![point],
        None if kind.has_edges() => {
            seam_candidates(&line, &settings).iter().take(MOST_CANDIDATES).map(|(f, _)| f.centre()).collect()
        }
        None => corners(&line, kind),
    };
    let seeds = candidates.into_iter().filter_map(|candidate| refine(frame, kind, candidate));
    (seen, seeds.max_by(|a, b| score(&a.fit).total_cmp(&score(&b.fit))))
}

fn score(fit: &JointFit) -> f64 {
    fit.support - fit.residual_px / 4.0 - fit.edges.map_or(0.0, |edges| edges.cost)
}

/// Learns the cross-section round `candidate` and fits it there.
fn refine(frame: &GrayFrame, kind: JointKind, candidate: PixelPoint) -> Option<Seed> {
    let mut model = learn(frame, candidate, kind)?;
    let fit = model.fit(frame, candidate.u_px, 0.0, SEARCH_PX).ok()?.judged().ok()?;
    model.learn(&fit);
    Some(Seed { clear: fit.is_clear(), model, fit })
}

/// The strongest bends of the centreline, of the sign that the kind has: a V-groove's root lies lower than its flanks
/// (v grows downwards), a fillet may bend either way.
fn corners(line: &Centreline, kind: JointKind) -> Vec<PixelPoint> {
    let mean = |range: std::ops::Range<usize>| {
        let values: Vec<f32> = range.filter_map(|u| line.at(u)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f32>() / values.len() as f32)
    };
    let arm = CORNER_ARM_PX;
    let width = line.v_px.len();
    let mut bends: Vec<(f32, usize)> = (arm + 2..width.saturating_sub(arm + 2))
        .filter_map(|u| {
            let at = |u: usize| mean(u - 2..u + 3);
            let bend = 2.0 * at(u)? - at(u - arm)? - at(u + arm)?;
            let strength = if kind == JointKind::VGroove { bend } else { bend.abs() };
            (strength > LEAST_CORNER_PX).then_some((strength, u))
        })
        .collect();
    bends.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut peaks: Vec<usize> = vec![];
    for (_, u) in bends {
        if peaks.iter().all(|&other| other.abs_diff(u) > arm) {
            peaks.push(u);
        }
        if peaks.len() == 4 {
            break;
        }
    }
    peaks.into_iter().filter_map(|u| Some(PixelPoint::new(u as f64, f64::from(mean(u - 2..u + 3)?)))).collect()
}
