//! The plates: their shape, their finish, and what lies on them.
//!
//! What belongs to the plates moves with them: it passes the stripe as they travel, and shakes with the vibration.

use serde::{Deserialize, Serialize};

/// The plates beside the joint. Everything defaults to flat, evenly bright and clean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plates {
    /// How far the plates travel between two camera frames, in pixels of the image, 0 to 100: what lies on them passes
    /// the stripe in its length over this. Default 3: the stains in ambient light always moved so. A hairline joint has
    /// its own.
    pub travel_px_per_frame: f64,
    /// What they are bent to.
    pub shape: Shape,
    /// How they reflect.
    pub finish: Finish,
    /// What lies on them or is scratched into them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<Marks>,
    /// Beads of earlier passes in a V-groove.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub beads: Vec<Bead>,
}

impl Default for Plates {
    fn default() -> Self {
        Self {
            travel_px_per_frame: 3.0,
            shape: Shape::default(),
            finish: Finish::default(),
            marks: Vec::new(),
            beads: Vec::new(),
        }
    }
}

/// What the plates are bent to, as the stripe shows it. The joint is drawn onto the bent plates; where its lines are
/// bent, the truth is where the bent lines meet.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Shape {
    /// Radius of a pipe on which the joint lies \[px\]: convex when positive (the stripe's ends lie deeper), concave when
    /// negative; at least 100 in size. Its axis stays in the image; the joint moves over it. Default: flat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_px: Option<f64>,
    /// Where its axis lies, from the middle of the image \[px\], −1000 to 1000. Default 0.
    pub axis_px: f64,
    /// Radius of the left plate \[px\], as above, but horizontal at the joint and moving with it. Default: flat.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_radius_px: Option<f64>,
    /// Radius of the right plate \[px\], likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right_radius_px: Option<f64>,
    /// Slope by which the plates' right part is bent down against the left \[px/px\], −1 to 1: no seam. Default 0.
    pub bend: f64,
    /// Step by which the right part is pressed down (a joggle) \[px\], −100 to 100: no seam. Default 0.
    pub joggle_px: f64,
    /// Length over which bend and joggle are rounded \[px\], 1 to 1000. Default 60, chosen: pressed, not broken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounding_px: Option<f64>,
    /// Half the depth of a corrugated sheet's waves \[px\], 0 to 100. Default 0.
    pub corrugation_px: f64,
    /// Length of its waves \[px\], 8 to 2000. Default 90, chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrugation_pitch_px: Option<f64>,
}

impl Shape {
    /// Length over which bend and joggle are rounded \[px\].
    pub(in crate::synth) fn rounding_px(&self) -> f64 {
        self.rounding_px.unwrap_or(60.0)
    }

    /// Length of the corrugation's waves \[px\].
    pub(in crate::synth) fn corrugation_pitch_px(&self) -> f64 {
        self.corrugation_pitch_px.unwrap_or(90.0)
    }
}

/// How the plates reflect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Finish {
    /// Brightness of the left plate relative to the stripe's, 0.02 to 5. Default 1.
    pub left_brightness: f64,
    /// Brightness of the right plate, likewise.
    pub right_brightness: f64,
    /// Contrast of patchy mill scale (standard deviation of the logarithm of the brightness), 0 to 2. Default 0.
    pub scale: f64,
    /// Size of its patches \[px\], 2 to 1000. Default 35, chosen.
    pub scale_patch_px: f64,
    /// Contrast of grinding marks (standard deviation of the logarithm of the brightness), 0 to 2. Default 0.
    pub grinding: f64,
    /// Distance between grinding marks \[px\], 0.5 to 100. Default 4, chosen.
    pub grinding_pitch_px: f64,
    /// Angle between grinding marks and the joint's direction \[degrees\], −90 to 90. Default 20, chosen.
    pub grinding_angle_deg: f64,
    /// Depth of the grinding marks (standard deviation) \[px\], 0 to 20. Default 0.
    pub grinding_relief_px: f64,
}

impl Default for Finish {
    fn default() -> Self {
        Self {
            left_brightness: 1.0,
            right_brightness: 1.0,
            scale: 0.0,
            scale_patch_px: 35.0,
            grinding: 0.0,
            grinding_pitch_px: 4.0,
            grinding_angle_deg: 20.0,
            grinding_relief_px: 0.0,
        }
    }
}

/// The form of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MarkForm {
    /// A flat patch with a ragged outline: slag, paint, rust, marker.
    #[default]
    Patch,
    /// A drop that stuck: round, raised like a ball, with a glint on its top.
    Drop,
    /// A straight scratch: `width_px` across, `length_px` along the travel, slanting by `slant`.
    Scratch,
    /// A bar along the joint's direction, at `beside_px` from it, for as long as the recording: paint, tape, a rolled-in line.
    Bar,
}

/// A scatter of marks of one kind over the plates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Marks {
    /// Their form.
    pub form: MarkForm,
    /// Mean number whose middle passes the stripe in 100 camera frames, 0 to 1000. A bar is always one. Default 5.
    pub per_100_frames: f64,
    /// Width along the stripe \[px\], 0.5 to 1000; each mark's own lies between 0.6 and 1.5 of it. Default 30, chosen.
    pub width_px: f64,
    /// Length along the travel \[px\], 0.5 to 100 000, likewise. Default 60, chosen.
    pub length_px: f64,
    /// Brightness of the plate inside relative to outside, 0 to 10. Default 0.15: slag, marker.
    pub reflectance: f64,
    /// Height above the plate \[px\], −50 to 50. Default 0.
    pub relief_px: f64,
    /// Light added at the top of a drop relative to the stripe, 0 to 10. Default 0.
    pub glint: f64,
    /// How soft the outline is \[px\], 0.3 to 200. Default 1.2, chosen.
    pub edge_px: f64,
    /// How far a scratch wanders along the stripe for each pixel of travel \[px/px\], −20 to 20; its sign is drawn for each scratch. Default 0.3,
    /// chosen.
    pub slant: f64,
    /// Marks lie within this distance of the joint's line \[px\], 1 to 5000. Default: anywhere on the stripe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_seam_px: Option<f64>,
    /// Distance of a bar's middle from the joint's line \[px\], −2000 to 2000. Default 0.
    pub beside_px: f64,
}

impl Default for Marks {
    fn default() -> Self {
        Self {
            form: MarkForm::Patch,
            per_100_frames: 5.0,
            width_px: 30.0,
            length_px: 60.0,
            reflectance: 0.15,
            relief_px: 0.0,
            glint: 0.0,
            edge_px: 1.2,
            slant: 0.3,
            near_seam_px: None,
            beside_px: 0.0,
        }
    }
}

/// A bead of an earlier pass in a V-groove. The truth stays the groove's: where the flanks' lines meet. The outermost
/// toes of the beads are written beside it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Bead {
    /// Middle of the bead, from the groove's line \[px\], −1000 to 1000, right positive. Default 0.
    pub beside_px: f64,
    /// Its top below the plates \[px\], −200 to 1000; negative above (a cap). Default 20, chosen.
    pub top_px: f64,
    /// From its middle to where it falls off, if no flank is met before \[px\], 2 to 1000. Default 30, chosen.
    pub half_width_px: f64,
    /// How much its top stands above its sides \[px\], −100 to 100; negative: hollow. Default 3, chosen.
    pub crown_px: f64,
    /// How much its height, side and middle wander along the travel (standard deviation) \[px\], 0 to 20. Default 0.8,
    /// read off real beads.
    pub wander_px: f64,
    /// Its brightness relative to the plates, 0 to 5. Default 0.8, read off real beads.
    pub brightness: f64,
}

impl Default for Bead {
    fn default() -> Self {
        Self { beside_px: 0.0, top_px: 20.0, half_width_px: 30.0, crown_px: 3.0, wander_px: 0.8, brightness: 0.8 }
    }
}

impl Plates {
    /// What is wrong with the plates, if anything.
    pub(super) fn problem(&self) -> Option<&'static str> {
        let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
        if !within(self.travel_px_per_frame, 0.0, 100.0) {
            return Some("plates: travel_px_per_frame lies in 0..100");
        }
        let s = &self.shape;
        let round = |radius: Option<f64>| radius.is_none_or(|r| within(r.abs(), 100.0, 1e6));
        if !(round(s.radius_px) && round(s.left_radius_px) && round(s.right_radius_px) && within(s.axis_px, -1e3, 1e3))
        {
            return Some("plates.shape: radii are at least 100 in size, axis_px lies in ±1000");
        }
        if !(within(s.bend, -1.0, 1.0)
            && within(s.joggle_px, -100.0, 100.0)
            && within(s.rounding_px(), 1.0, 1000.0)
            && within(s.corrugation_px, 0.0, 100.0)
            && within(s.corrugation_pitch_px(), 8.0, 2000.0))
        {
            return Some(
                "plates.shape: bend lies in ±1, joggle_px in ±100, rounding_px in 1..1000, corrugation_px in 0..100, corrugation_pitch_px in 8..2000",
            );
        }
        let f = &self.finish;
        if !(within(f.left_brightness, 0.02, 5.0)
            && within(f.right_brightness, 0.02, 5.0)
            && within(f.scale, 0.0, 2.0)
            && within(f.scale_patch_px, 2.0, 1000.0)
            && within(f.grinding, 0.0, 2.0)
            && within(f.grinding_pitch_px, 0.5, 100.0)
            && within(f.grinding_angle_deg, -90.0, 90.0)
            && within(f.grinding_relief_px, 0.0, 20.0))
        {
            return Some(
                "plates.finish: brightnesses lie in 0.02..5, scale and grinding in 0..2, scale_patch_px in 2..1000, grinding_pitch_px in 0.5..100, grinding_angle_deg in ±90, grinding_relief_px in 0..20",
            );
        }
        self.marks.iter().find_map(Marks::problem).or_else(|| self.beads.iter().find_map(Bead::problem))
    }
}

impl Marks {
    fn problem(&self) -> Option<&'static str> {
        let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
        (!(within(self.per_100_frames, 0.0, 1000.0)
            && within(self.width_px, 0.5, 1000.0)
            && within(self.length_px, 0.5, 1e5)
            && within(self.reflectance, 0.0, 10.0)
            && within(self.relief_px, -50.0, 50.0)
            && within(self.glint, 0.0, 10.0)
            && within(self.edge_px, 0.3, 200.0)
            && within(self.slant, -20.0, 20.0)
            && self.near_seam_px.is_none_or(|px| within(px, 1.0, 5000.0))
            && within(self.beside_px, -2000.0, 2000.0)))
        .then_some("plates.marks: per_100_frames lies in 0..1000, width_px in 0.5..1000, length_px in 0.5..100000, reflectance and glint in 0..10, relief_px in ±50, edge_px in 0.3..200, slant in ±20, near_seam_px in 1..5000, beside_px in ±2000")
    }
}

impl Bead {
    fn problem(&self) -> Option<&'static str> {
        let within = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
        (!(within(self.beside_px, -1000.0, 1000.0)
            && within(self.top_px, -200.0, 1000.0)
            && within(self.half_width_px, 2.0, 1000.0)
            && within(self.crown_px, -100.0, 100.0)
            && within(self.wander_px, 0.0, 20.0)
            && within(self.brightness, 0.0, 5.0)))
        .then_some("plates.beads: beside_px lies in ±1000, top_px in -200..1000, half_width_px in 2..1000, crown_px in ±100, wander_px in 0..20, brightness in 0..5")
    }
}
