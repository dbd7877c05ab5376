//! A gap that a coarse raster shows, looked into in a finer one.
//!
//! In a coarse raster a groove's flank beside an upright wall, or a bead between them, is a few pixels wide: it looks like the bottom
//! of a gap. What lies in it is seen in the finest raster that still holds the gap.

use super::seed::Seed;
use crate::frame::GrayFrame;
use crate::imgproc::Raster;
use crate::imgproc::geometry::{EdgeQuality, GapShows, JointFit, JointKind, Line, gap_shows};
use crate::units::PixelPoint;

/// Widest gap that is looked into \[px of the finer raster\]. Chosen: as deep as it is looked into.
const WIDEST_PX: f64 = 64.0;

/// Whether the gap that `raster` shows of the picture is none in a finer one: the stripe goes on through it, or down into it.
pub fn is_no_gap(picture: &GrayFrame, raster: Raster, finer: impl Iterator<Item = Raster>, seed: &Seed) -> bool {
    let Some(edges) = seed.fit.edges.filter(|_| seed.model.kind == JointKind::Butt) else { return false };
    let holds = |finer: &Raster| edges.gap_px * finer.scale() / raster.scale() <= WIDEST_PX;
    let finer = finer.filter(|finer| finer.scale() > raster.scale()).filter(holds);
    let Some(finest) = finer.max_by(|a, b| a.scale().total_cmp(&b.scale())) else { return false };
    let Some(frame) = finest.resample(picture) else { return false };
    let scale = finest.scale() / raster.scale();
    let fit = in_raster(&seed.fit, raster, finest);
    let shows = gap_shows(&frame, &fit, scale * seed.model.stripe_sd_px);
    matches!(shows, GapShows::Plate | GapShows::Bump | GapShows::Groove | GapShows::Flank)
}

/// The same fit in another raster, as far as what looks into its gap needs it.
fn in_raster(fit: &JointFit, from: Raster, to: Raster) -> JointFit {
    let scale = to.scale() / from.scale();
    let turned = |point: PixelPoint| to.raster_from_picture(from.picture_from_raster(point));
    let line = |line: Line| Line {
        v_px: turned(PixelPoint::new(fit.centre.u_px, line.v_px)).v_px,
        slope: line.slope,
        curvature_per_px: line.curvature_per_px / scale,
    };
    let edges = fit.edges.map(|edges| EdgeQuality { gap_px: scale * edges.gap_px, ..edges });
    JointFit { centre: turned(fit.centre), left: line(fit.left), right: line(fit.right), edges, ..*fit }
}
