//! The joint's cross-section as lines, each with how surely it is known: what widths, heights and angles are measured on.

use nalgebra::{Matrix2, matrix};

use super::view::View;
use crate::imgproc::geometry::{FrameLine, JointFit, JointKind};
use crate::units::PixelPoint;

/// A straight piece of the stripe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenLine {
    /// Two points of it, the one nearer to the seam first.
    pub ends: [PixelPoint; 2],
    /// Covariance of their coordinates across the stripe \[px²\].
    pub covariance_px2: Matrix2<f64>,
}

/// The joint's lines in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    /// Its kind.
    pub kind: JointKind,
    /// Where the seam was seen in this frame.
    pub seam: PixelPoint,
    /// What meets at the seam: the plates of a butt or lap joint, the flanks of a groove, the legs of a fillet.
    pub sides: [SeenLine; 2],
    /// The plates beside a groove's shoulders, each where it was seen.
    pub plates: [Option<SeenLine>; 2],
    /// Distance of the two edges along the stripe \[px\] (butt, lap).
    pub gap_px: Option<f64>,
    /// Its variance \[px²\], ragged edges included.
    pub gap_variance_px2: f64,
    /// Variance of an edge's or a flank's place along the stripe \[px²\]: ragged edges.
    pub ragged_px2: f64,
}

/// A stripe counts as present from a sixth of its brightness on; half of it, where the plate ends, lies this much further
/// from the gap's middle on either side \[px\], give or take. Measured on rendered stripes, whose lens blurs by .7 px: gaps of 5 to
/// 16 px came out .9 to 1.4 px too narrow.
const HALF_LIGHT_PX: f64 = 0.55;
const HALF_LIGHT_SD_PX: f64 = 0.15;

/// How far a line's second point is from its first \[px\]. Chosen: about what a side shows of itself.
const REACH_PX: f64 = 40.0;

impl Profile {
    /// The lines of a fit; the middle of its edges scatters by `along_px2` round what the gap is known to
    /// be, of which `ragged_px2` is the edges' raggedness.
    pub(super) fn of(fit: &JointFit, kind: JointKind, along_px2: f64, ragged_px2: f64) -> Self {
        let signs = [-1.0, 1.0];
        let side = |i: usize| seen(fit, fit.in_frame[i], (0.0, signs[i] * REACH_PX));
        let plate = |i: usize| {
            let plate = fit.plates_in_frame[i]?;
            let (shoulder_du, _) = fit.in_frame[i].line.meets(plate.line)?;
            Some(seen(fit, plate, (shoulder_du, shoulder_du + signs[i] * REACH_PX)))
        };
        Self {
            kind,
            seam: fit.centre,
            sides: [side(0), side(1)],
            plates: [plate(0), plate(1)],
            gap_px: fit.edges.map(|edges| edges.gap_px + 2.0 * HALF_LIGHT_PX),
            // The middle of two edges has a quarter of the variance of their distance.
            gap_variance_px2: 4.0 * along_px2 + (2.0 * HALF_LIGHT_SD_PX).powi(2),
            // And half that of one.
            ragged_px2: 2.0 * ragged_px2,
        }
    }

    /// The same under noise of which the variance is `scale` times the nominal one.
    pub(super) fn with_noise(self, scale: f64) -> Self {
        Self { gap_variance_px2: scale * self.gap_variance_px2, ragged_px2: scale * self.ragged_px2, ..self }
    }

    pub(super) fn in_picture(self, view: &View) -> Self {
        let (px, px2) = (view.picture_px(), view.picture_px().powi(2));
        let line = |line: SeenLine| SeenLine {
            ends: line.ends.map(|end| view.picture_from_view(end)),
            covariance_px2: px2 * line.covariance_px2,
        };
        Self {
            seam: view.picture_from_view(self.seam),
            sides: self.sides.map(line),
            plates: self.plates.map(|plate| plate.map(line)),
            gap_px: self.gap_px.map(|gap_px| px * gap_px),
            gap_variance_px2: px2 * self.gap_variance_px2,
            ragged_px2: px2 * self.ragged_px2,
            ..self
        }
    }
}

/// Two points of a line at the distances `near` and `far` from the centre's column.
fn seen(fit: &JointFit, FrameLine { line, covariance }: FrameLine, (near, far): (f64, f64)) -> SeenLine {
    let straight = line.moved(near);
    let ends =
        [near, far].map(|du| PixelPoint::new(fit.centre.u_px + du, straight.v_px + straight.slope * (du - near)));
    let by_line = matrix![1.0, near; 1.0, far];
    SeenLine { ends, covariance_px2: by_line * covariance * by_line.transpose() }
}
