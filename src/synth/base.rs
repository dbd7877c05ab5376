//! The plates' surface without the joint, as rows of the stripe: tilt, sag, and what the plates are bent to.

use super::scenario::Shape;

/// Share of a pipe's radius up to which its surface is lit; beyond, the stripe runs off the pipe's side (chosen: a
/// surface seen at 16°).
const LIT_SHARE: f64 = 0.96;

/// The base line of the stripe on the plates and the joint's place on it.
#[derive(Debug, Clone)]
pub(super) struct Base<'a> {
    /// Columns of the image.
    pub(super) columns: usize,
    /// Row of the stripe in the middle of the image \[px\].
    pub(super) row_px: f64,
    /// \[px/px\].
    pub(super) tilt: f64,
    /// \[px\] at the image's ends.
    pub(super) sag_px: f64,
    /// What the plates are bent to.
    pub(super) shape: &'a Shape,
    /// Where the joint is along the stripe \[px\].
    pub(super) seam_px: f64,
}

impl Base<'_> {
    /// Row of the plates without the joint at a column \[px\].
    pub(super) fn at(&self, x: f64) -> f64 {
        let half = 0.5 * self.columns as f64;
        let from_centre = x - half;
        self.row_px + self.tilt * from_centre + self.sag_px * (from_centre / half).powi(2) + self.bent(x).0
    }

    /// Brightness of the bent plates at a column, relative to flat ones: Lambert's cosine, and nothing beyond a pipe's
    /// side.
    pub(super) fn light(&self, x: f64) -> f64 {
        let (_, slope, lit) = self.bent(x);
        lit / slope.hypot(1.0)
    }

    /// How far the bent plates lie below flat ones \[px\], their slope \[px/px\], and whether they are lit.
    fn bent(&self, x: f64) -> (f64, f64, f64) {
        let shape = self.shape;
        let from_seam = x - self.seam_px;
        let side = if from_seam < 0.0 { shape.left_radius_px } else { shape.right_radius_px };
        let pipe = shape.radius_px.map(|radius| arc(x - 0.5 * self.columns as f64 - shape.axis_px, radius));
        let (mut drop, mut slope, mut lit) = (0.0, 0.0, 1.0);
        for (arc_drop, arc_slope, arc_lit) in pipe.into_iter().chain(side.map(|radius| arc(from_seam, radius))) {
            (drop, slope, lit) = (drop + arc_drop, slope + arc_slope, lit * arc_lit);
        }
        if shape.bend != 0.0 || shape.joggle_px != 0.0 {
            let round = shape.rounding_px() / 4.0;
            let t = from_seam / round;
            drop += shape.bend * (round * (-t.abs()).exp().ln_1p() + from_seam.max(0.0));
            drop += shape.joggle_px / (1.0 + (-t).exp());
        }
        if shape.corrugation_px > 0.0 {
            let wave = std::f64::consts::TAU / shape.corrugation_pitch_px();
            drop += shape.corrugation_px * (wave * from_seam).sin();
            slope += shape.corrugation_px * wave * (wave * from_seam).cos();
        }
        (drop, slope, lit)
    }
}

/// How far a circle has fallen at a distance from its top \[px\], its slope there, and whether it is lit; straight on where it is not.
/// A negative radius rises.
fn arc(distance_px: f64, radius_px: f64) -> (f64, f64, f64) {
    let radius = radius_px.abs();
    let limit = LIT_SHARE * radius;
    let within = distance_px.clamp(-limit, limit);
    let height = (radius * radius - within * within).sqrt();
    let slope = within / height;
    let lit = 1.0 / (1.0 + (distance_px.abs() - limit).exp());
    (radius_px.signum() * (radius - height + slope * (distance_px - within)), radius_px.signum() * slope, lit)
}
