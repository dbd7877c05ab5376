//! The joints. Lengths are in pixels of the image, "along" means along the stripe, "deep" across it (downwards in a
//! horizontal stripe).

use serde::{Deserialize, Serialize};

use super::path::Ramp;

/// What lies under the stripe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Joint {
    /// Two plates edge to edge with a visible gap. Truth: midpoint of the two gap edges.
    Butt(Butt),
    /// One plate on another. Truth: midpoint between the end of the upper stripe and the start of the lower one.
    Lap(Lap),
    /// Two bevelled plates. Truth: intersection of the flank lines.
    Vgroove(Vgroove),
    /// Two plates at an angle. Truth: intersection of the leg lines.
    Fillet(Fillet),
    /// A butt joint too narrow to resolve, as in a robot's scan of a fitted joint. Truth: the joint line.
    Hairline(Hairline),
    /// A plate without a joint. There is no truth.
    Flat,
}

/// A butt joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Butt {
    /// Gap width \[px\], 0 to 1000, may change along the way. Default 13: scene A of the method's description.
    pub gap_px: Ramp,
    /// How far below the plates the gap's floor appears \[px\], 0 to 1000. Default 24: scene A.
    pub depth_px: f64,
    /// Height of the right plate above the left one \[px\], −100 to 100. Default 0.
    pub hi_lo_px: Ramp,
    /// How far both plates' edges droop \[px\], −50 to 50. Default 3.5: scene A.
    pub bent_edge_px: f64,
    /// Length along the stripe in which the droop falls to 1/e \[px\], 1 to 500. Default 11, chosen.
    pub bent_length_px: f64,
    /// Brightness of the gap's floor relative to the plates, 0 to 1. Default 0.5, chosen: a backing strip in the shade.
    pub floor_reflectance: f64,
}

impl Default for Butt {
    fn default() -> Self {
        Self {
            gap_px: Ramp::Constant(13.0),
            depth_px: 24.0,
            hi_lo_px: Ramp::Constant(0.0),
            bent_edge_px: 3.5,
            bent_length_px: 11.0,
            floor_reflectance: 0.5,
        }
    }
}

/// A lap joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lap {
    /// How far the lower plate's stripe lies below the upper one's \[px\], −1000 to 1000, may change along the way.
    /// Default 24: scene B of the method's description.
    pub step_px: Ramp,
    /// Unlit length between the two stripes \[px\], 0 to 100. Default 5: scene B.
    pub shadow_px: f64,
    /// Whether the upper plate is on the right. Default false; drawn for each seed when `variation` is not 0.
    pub upper_on_right: bool,
    /// Brightness of the glint on the upper plate's edge relative to the stripe, 0 to 3. Default 0.25, chosen.
    pub glint: f64,
}

impl Default for Lap {
    fn default() -> Self {
        Self { step_px: Ramp::Constant(24.0), shadow_px: 5.0, upper_on_right: false, glint: 0.25 }
    }
}

/// A V-groove.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Vgroove {
    /// From the root to each shoulder \[px\], 4 to 1000. Default 36: scene D of the method's description.
    pub half_width_px: f64,
    /// The same on the right \[px\], 0.5 to 1000, where it differs: a single bevel has one nearly upright flank. Default: as on the left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right_half_width_px: Option<f64>,
    /// From the plates to the root \[px\], 1 to 1000. Default 34: scene D.
    pub depth_px: f64,
    /// Opening at the root \[px\], 0 to 200. Default 3: scene D.
    pub root_gap_px: Ramp,
    /// Height of the right plate above the left one \[px\], −100 to 100. Default 0.
    pub hi_lo_px: Ramp,
    /// Brightness of the flanks relative to the plates, 0 to 3. Default 0.6: a real groove's flanks are dimmer and
    /// thinner than its plates.
    pub flank_reflectance: f64,
}

impl Vgroove {
    /// From the root to the left and the right shoulder \[px\].
    pub(in crate::synth) fn half_widths_px(&self) -> [f64; 2] {
        [self.half_width_px, self.right_half_width_px.unwrap_or(self.half_width_px)]
    }
}

impl Default for Vgroove {
    fn default() -> Self {
        Self {
            half_width_px: 36.0,
            right_half_width_px: None,
            depth_px: 34.0,
            root_gap_px: Ramp::Constant(3.0),
            hi_lo_px: Ramp::Constant(0.0),
            flank_reflectance: 0.6,
        }
    }
}

/// A fillet (legs meet below) or an outer corner (legs meet above).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Fillet {
    /// Slope of the left leg \[px/px\], −3 to 3. Default 0.42: scene E of the method's description.
    pub left_slope: f64,
    /// Slope of the right leg \[px/px\], −3 to 3. Default −0.36: scene E.
    pub right_slope: f64,
    /// Length over which the toe is rounded \[px\], 0 to 100. Default 6, chosen.
    pub toe_px: f64,
    /// Light reflected between the legs near the corner, relative to the stripe, 0 to 3. Default 0.3, chosen.
    pub inner_reflection: f64,
}

impl Default for Fillet {
    fn default() -> Self {
        Self { left_slope: 0.42, right_slope: -0.36, toe_px: 6.0, inner_reflection: 0.3 }
    }
}

/// A butt joint too narrow to resolve: a small break of the stripe whose look changes from a notch to a glint to a
/// step in brightness, and a faint line in ambient light beside the stripe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Hairline {
    /// Standard width of the break \[px\], 0.3 to 20. Default 1.3: read off real frames.
    pub width_px: f64,
    /// Depth of the break in powers of e, 0 to 10. Default 1.2; it comes and goes.
    pub dip: f64,
    /// Sideways displacement of the stripe at the break \[px\], −20 to 20. Default 1.2.
    pub bump_px: f64,
    /// Difference of brightness between the plates in powers of e, −3 to 3. Default 0.5.
    pub step: f64,
    /// Contrast of the joint in ambient light beside the stripe \[grey\], 0 to 100. Default 6.
    pub ambient_line_grey: f64,
    /// Travel between two camera frames \[px\], 0.1 to 100: the ambient line shows the joint before and after the
    /// stripe. Default 8.8: real scans.
    pub travel_px_per_frame: f64,
}

impl Default for Hairline {
    fn default() -> Self {
        Self { width_px: 1.3, dip: 1.2, bump_px: 1.2, step: 0.5, ambient_line_grey: 6.0, travel_px_per_frame: 8.8 }
    }
}

/// Raggedness of the plate edges: it moves what is seen, but is not part of the truth.
///
/// Butt and lap: each edge. V-groove: each flank. Fillet: none, for its legs are plate surfaces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Edges {
    /// Standard deviation of each edge along the stripe \[px\], 0 to 20. Default 0.6: scene A. The noise floor of one
    /// frame is this over √2.
    pub raggedness_px: f64,
    /// Correlation from frame to frame, 0 to below 1. Default 0.5: all scenes.
    pub correlation: f64,
}

impl Default for Edges {
    fn default() -> Self {
        Self { raggedness_px: 0.6, correlation: 0.5 }
    }
}

/// Where along the travel the joint exists; outside there is a flat plate and no truth.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Extent {
    /// First camera frame with the joint. Default: from the beginning.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_frame: Option<usize>,
    /// First camera frame without it again. Default: to the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to_frame: Option<usize>,
}

/// A tack weld that fills the joint over a stretch; the truth stays the joint line and is marked as covered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tack {
    /// First frame.
    pub from_frame: usize,
    /// First frame after it.
    pub to_frame: usize,
    /// Height of the bead above the plates \[px\], −100 to 100. Default 7, chosen.
    #[serde(default = "tack_height")]
    pub height_px: f64,
    /// From the joint line to the bead's toe \[px\], 1 to 500. Default 26, chosen.
    #[serde(default = "tack_half_width")]
    pub half_width_px: f64,
}

const fn tack_height() -> f64 {
    7.0
}

const fn tack_half_width() -> f64 {
    26.0
}

/// A change of the joint's preparation: another gap, another width, or a butt joint's edges bevelled to a V-groove.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// First camera frame of the change.
    pub from_frame: usize,
    /// Frames it takes, 1 to 100 000. Default 20, chosen: a plate's bevel runs out over some centimetres.
    #[serde(default = "twenty")]
    pub over_frames: usize,
    /// The joint behind it: of the same kind, or a V-groove behind a butt joint, or a butt joint behind a V-groove.
    pub joint: Joint,
}

const fn twenty() -> usize {
    20
}

impl Change {
    /// What is wrong with the change from `first`, if anything.
    pub(super) fn problem(&self, first: &Joint) -> Option<&'static str> {
        use Joint::{Butt, Fillet, Lap, Vgroove};
        if !(1..=100_000).contains(&self.over_frames) {
            return Some("change: over_frames lie in 1..100000");
        }
        match (first, &self.joint) {
            (Butt(_) | Vgroove(_), Butt(_) | Vgroove(_)) | (Lap(_), Lap(_)) | (Fillet(_), Fillet(_)) => {
                self.joint.problem()
            }
            _ => Some("change: the joint is of the same kind, or one is a butt joint and one a V-groove"),
        }
    }
}

impl Joint {
    /// What is wrong with the joint, if anything.
    pub(super) fn problem(&self) -> Option<&'static str> {
        let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
        match self {
            Self::Butt(j) => (!(j.gap_px.within(0.0..=1000.0)
                && within(j.depth_px, 0.0, 1000.0)
                && j.hi_lo_px.within(-100.0..=100.0)
                && within(j.bent_edge_px, -50.0, 50.0)
                && within(j.bent_length_px, 1.0, 500.0)
                && within(j.floor_reflectance, 0.0, 1.0)))
            .then_some("gap_px and depth_px lie in 0..1000, hi_lo_px in ±100, bent_edge_px in ±50, bent_length_px in 1..500, floor_reflectance in 0..1"),
            Self::Lap(j) => (!(j.step_px.within(-1000.0..=1000.0)
                && within(j.shadow_px, 0.0, 100.0)
                && within(j.glint, 0.0, 3.0)))
            .then_some("step_px lies in ±1000, shadow_px in 0..100, glint in 0..3"),
            Self::Vgroove(j) => (!(within(j.half_width_px, 4.0, 1000.0)
                && j.right_half_width_px.is_none_or(|px| within(px, 0.5, 1000.0))
                && within(j.depth_px, 1.0, 1000.0)
                && j.root_gap_px.within(0.0..=200.0)
                && j.hi_lo_px.within(-100.0..=100.0)
                && within(j.flank_reflectance, 0.0, 3.0)))
            .then_some("half_width_px lies in 4..1000, right_half_width_px in 0.5..1000, depth_px in 1..1000, root_gap_px in 0..200, hi_lo_px in ±100, flank_reflectance in 0..3"),
            Self::Fillet(j) => (!(within(j.left_slope, -3.0, 3.0)
                && within(j.right_slope, -3.0, 3.0)
                && (j.left_slope - j.right_slope).abs() >= 0.05
                && within(j.toe_px, 0.0, 100.0)
                && within(j.inner_reflection, 0.0, 3.0)))
            .then_some("slopes lie in ±3 and differ by at least 0.05, toe_px lies in 0..100, inner_reflection in 0..3"),
            Self::Hairline(j) => (!(within(j.width_px, 0.3, 20.0)
                && within(j.dip, 0.0, 10.0)
                && within(j.bump_px, -20.0, 20.0)
                && within(j.step, -3.0, 3.0)
                && within(j.ambient_line_grey, 0.0, 100.0)
                && within(j.travel_px_per_frame, 0.1, 100.0)))
            .then_some("width_px lies in 0.3..20, dip in 0..10, bump_px in ±20, step in ±3, ambient_line_grey in 0..100, travel_px_per_frame in 0.1..100"),
            Self::Flat => None,
        }
    }
}
