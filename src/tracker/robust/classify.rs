//! The kind of a joint from its fitted cross-section.

use super::seed::Seed;
use crate::imgproc::geometry::{JointKind, Line};

/// A step this high between the plates makes a lap joint \[px\]. Chosen: plates of a butt joint are set level to within
/// a fraction of their thickness; a lap joint's step is the thickness.
pub const LAP_STEP_PX: f64 = 10.0;
/// A lower step, of at least so many SDs of the stripe, makes one too where the plates' ends are no farther apart than this share of
/// it: level plates that are set so close do not differ in height by twice their gap. Chosen.
const LEAST_STEP_SDS: f64 = 1.5;
const LARGEST_OPENING: f64 = 0.5;
/// Least bend of a corner that passes for one without being asked for. Chosen: plates tilted against each other by a
/// bad fit-up stay below it.
const LEAST_BEND: f64 = 0.3;

/// Least depth of a groove from its shoulders to its root, in SDs of the stripe. Chosen: bent edges of a narrow gap
/// look like flanks, but are hardly deeper than the stripe is wide.
const LEAST_GROOVE_SDS: f64 = 4.0;

/// How much the plates beside a groove may bend against one another, in shares of its flanks' bend. Chosen: those of a pipe of
/// R = 320 px by a third.
const LEVEL_SHARE: f64 = 0.5;

/// The height of the right plate over the left one at the seam \[px\]; v grows downwards.
pub fn step_px(seed: &Seed) -> f64 {
    seed.fit.right.v_px - seed.fit.left.v_px
}

/// The difference of the two sides' slopes.
pub fn bend(seed: &Seed) -> f64 {
    seed.fit.left.slope - seed.fit.right.slope
}

/// Whether the ends of a step's plates are farther apart along the stripe than the step is high: more than a shadow hides.
pub fn is_open_lap(seed: &Seed) -> bool {
    seed.model.kind == JointKind::Lap && seed.gap_px() > step_px(seed).abs()
}

/// Whether the step alone makes a lap joint.
pub fn is_high(seed: &Seed) -> bool {
    step_px(seed).abs() >= LAP_STEP_PX
}

/// The kind that a fit with edges stands for.
pub fn kind_with_edges(seed: &Seed) -> JointKind {
    let height_px = step_px(seed).abs();
    let is_low_lap =
        height_px >= LEAST_STEP_SDS * seed.model.stripe_sd_px && seed.gap_px() <= LARGEST_OPENING * height_px;
    if is_high(seed) || is_low_lap { JointKind::Lap } else { JointKind::Butt }
}

/// Whether a fit with a corner is one beyond doubt.
pub fn is_corner(seed: &Seed) -> bool {
    bend(seed).abs() >= LEAST_BEND
}

/// Whether a corner lies between shoulders, and deep enough for a groove. Beyond the shoulders the stripe goes on nearly as it
/// would without the groove; where the plates bend as much as the flanks, the "groove" is a stretch of an arc, or what lies between
/// two grooves.
pub fn is_groove(seed: &Seed) -> bool {
    let depth_px = seed.model.half_width_px.map(|half_px| 0.5 * bend(seed).abs() * half_px);
    let are_level = |[left, right]: [Line; 2]| (left.slope - right.slope).abs() < LEVEL_SHARE * bend(seed).abs();
    is_corner(seed)
        && depth_px.is_some_and(|depth_px| depth_px >= LEAST_GROOVE_SDS * seed.model.stripe_sd_px)
        && seed.model.plates.is_none_or(are_level)
}

/// Why it is of this kind, in one sentence.
pub fn reason(seed: &Seed, asked_for: bool) -> String {
    let gap_px = seed.gap_px();
    let seen = match seed.model.kind {
        JointKind::Butt => format!("two level plates end {gap_px:.0} px apart"),
        JointKind::Lap => format!("the stripe steps by {:.0} px", step_px(seed).abs()),
        JointKind::VGroove => {
            let half_px = seed.model.half_width_px.unwrap_or(0.0);
            format!("two flanks meet at a root and end in shoulders {half_px:.0} px away")
        }
        JointKind::Fillet => format!("two legs meet with a bend of {:.2} in slope", bend(seed).abs()),
    };
    if asked_for { format!("asked for; {seen}") } else { seen }
}
