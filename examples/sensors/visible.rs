//! Which draws are no fair question: rules of geometry, written down before anything is tracked.

use seamtrack::synth::Scene;
use seamtrack::synth::scenario::Joint;
use seamtrack::units::{PixelPoint, StripeAxis};

use crate::draw::{FASTEST_PX, peak_speed_px};

/// Least gap that is called a gap \[px\]; what is narrower is a hairline.
const LEAST_GAP_PX: f64 = 2.5;
/// Least length of plate beside the joint in the picture \[px\], and in standard widths of the stripe.
const LEAST_PLATE_PX: f64 = 40.0;
const LEAST_PLATE_STRIPES: f64 = 10.0;
/// Widths of the stripe at which two lines of light, one above the other, are two.
const APART_STRIPES: f64 = 3.0;
/// The least length of a groove's flank \[px\], and in widths of the stripe.
const LEAST_FLANK_PX: f64 = 10.0;
const LEAST_FLANK_STRIPES: f64 = 4.0;
/// Brightness of a gap's floor up to which it is dark beside the plates.
const DARK_FLOOR: f64 = 0.3;
/// Largest slope of a leg \[px/px\]: steeper ones have no ridge in a column.
const STEEPEST_LEG: f64 = 1.2;

/// Why a draw was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Unseen {
    /// The path does not fit into the picture.
    PathTooLong,
    /// Varied beyond the fastest seam.
    TooFast,
    /// The joint with its plates does not fit into the picture in each frame.
    JointDoesNotFit,
    /// A gap below 2.5 px, or narrower than the stripe's standard width.
    GapTooNarrow,
    /// A gap whose bright floor lies less than 3 standard widths below the plates.
    FloorHidesGap,
    /// A lap whose plates are less than 3 standard widths of the stripe apart.
    StepTooSmall,
    /// A groove whose flanks, or whose depth, are below 10 px or 4 standard widths of the stripe.
    GrooveTooSmall,
    /// A leg steeper than 50 degrees.
    LegTooSteep,
}

impl Unseen {
    /// Each reason, in words.
    pub const ALL: [(Self, &str); 8] = [
        (Self::PathTooLong, "the path does not fit into the picture"),
        (Self::TooFast, "faster than 6 px a frame"),
        (Self::JointDoesNotFit, "the joint with 40 px and 10 σ of plate on each side does not fit into the picture"),
        (Self::GapTooNarrow, "gap below 2.5 px or 1 σ of the stripe"),
        (Self::FloorHidesGap, "a bright floor within 3 σ of the plates"),
        (Self::StepTooSmall, "step below 3 σ of the stripe"),
        (Self::GrooveTooSmall, "flank or depth of a groove below 10 px or 4 σ"),
        (Self::LegTooSteep, "a leg steeper than 50 degrees"),
    ];
}

/// Why the joint of a scene cannot be seen as what it is, if it cannot.
pub fn unseen(scene: &Scene) -> Option<Unseen> {
    let s = scene.drawn_scenario();
    let sigma_px = s.stripe.sigma_px;
    if peak_speed_px(s) > FASTEST_PX {
        return Some(Unseen::TooFast);
    }
    match &s.joint {
        Joint::Butt(j) if j.gap_px.at(0.0) < LEAST_GAP_PX.max(sigma_px) => return Some(Unseen::GapTooNarrow),
        Joint::Butt(j) if j.depth_px < APART_STRIPES * sigma_px && j.floor_reflectance > DARK_FLOOR => {
            return Some(Unseen::FloorHidesGap);
        }
        Joint::Lap(j) if j.step_px.at(0.0) < APART_STRIPES * sigma_px => return Some(Unseen::StepTooSmall),
        Joint::Vgroove(j) => {
            let flank_px = j.half_width_px - 0.5 * j.root_gap_px.at(0.0);
            if flank_px.min(j.depth_px) < LEAST_FLANK_PX.max(LEAST_FLANK_STRIPES * sigma_px) {
                return Some(Unseen::GrooveTooSmall);
            }
        }
        Joint::Fillet(j) if j.left_slope.abs().max(j.right_slope.abs()) > STEEPEST_LEG => {
            return Some(Unseen::LegTooSteep);
        }
        _ => {}
    }
    (!fits(scene)).then_some(Unseen::JointDoesNotFit)
}

/// Whether the joint with plates beside it lies in the picture in each frame.
fn fits(scene: &Scene) -> bool {
    let s = scene.drawn_scenario();
    let (width_px, height_px) = (s.image.width_px as f64, s.image.height_px as f64);
    let (along_px, across_px) = match scene.axis() {
        StripeAxis::Horizontal => (width_px, height_px),
        StripeAxis::Vertical => (height_px, width_px),
    };
    let margin_px = APART_STRIPES * s.stripe.sigma_px;
    let outline = outline(&s.joint, s.stripe.tilt, LEAST_PLATE_PX.max(LEAST_PLATE_STRIPES * s.stripe.sigma_px));
    (0..scene.frame_count()).filter_map(|i| scene.truth(i).seam).all(|seam| {
        let seam = scene.axis().image_from_stripe(seam);
        outline.iter().all(|point| {
            let (u, v) = (seam.u_px + point.u_px, seam.v_px + point.v_px);
            (0.0..along_px).contains(&u) && (margin_px..across_px - margin_px).contains(&v)
        })
    })
}

/// The extreme points of a joint and of `plate_px` of plate on each side, from the seam, in the stripe's frame.
fn outline(joint: &Joint, tilt: f64, plate_px: f64) -> Vec<PixelPoint> {
    // A point left and one right of the seam, each `reach` away, at its height besides the tilt's.
    let pair = |reach: f64, left: f64, right: f64| {
        [PixelPoint::new(-reach, left - tilt * reach), PixelPoint::new(reach, right + tilt * reach)]
    };
    match joint {
        Joint::Butt(j) => {
            let half_px = 0.5 * j.gap_px.at(0.0);
            [pair(half_px + plate_px, 0.0, 0.0), pair(half_px, j.depth_px, j.depth_px)].concat()
        }
        Joint::Lap(j) => {
            let half_px = 0.5 * j.step_px.at(0.0) * if j.upper_on_right { -1.0 } else { 1.0 };
            pair(0.5 * j.shadow_px + plate_px, -half_px, half_px).to_vec()
        }
        Joint::Vgroove(j) => {
            let plates = pair(j.half_width_px + plate_px, -j.depth_px, -j.depth_px);
            [&plates[..], &[PixelPoint::new(0.0, 0.0)]].concat()
        }
        Joint::Fillet(j) => {
            let leg_px = plate_px + j.toe_px;
            let legs = pair(leg_px, -j.left_slope * leg_px, j.right_slope * leg_px);
            [&legs[..], &[PixelPoint::new(0.0, 0.0)]].concat()
        }
        Joint::Hairline(_) | Joint::Flat => pair(plate_px, 0.0, 0.0).to_vec(),
    }
}
