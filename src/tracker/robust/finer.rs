//! A gap that a coarse raster shows, looked into in a finer one.
//!
//! In a coarse raster a groove's flank beside an upright wall, or a bead between them, is a few pixels wide: it looks like the bottom
//! of a gap. What lies in it is seen in the finest raster that still holds the gap.

use super::levels::LEAST_GAP_PX;
use super::seed::Seed;
use crate::frame::GrayFrame;
use crate::imgproc::Raster;
use crate::imgproc::geometry::{EdgeQuality, GapShows, JointFit, JointKind, Line, gap_shows, learn};
use crate::units::PixelPoint;

/// Widest gap that is looked into \[px of the finer raster\]. Chosen: as deep as it is looked into.
const WIDEST_PX: f64 = 64.0;

/// A stripe that is less than this share as thick in the finer raster only looked thick in the coarse one: a small gap there is none
/// of that raster's. Chosen: glare and flanks draw out a coarse cross-section, to four times what it is.
const THIN_SHARE: f64 = 0.5;

/// Whether the gap that `raster` shows of the picture is none in a finer one: the stripe goes on through it, or down into it, or is
/// so thin that the gap would be the finer raster's to show.
pub fn is_no_gap(picture: &GrayFrame, raster: Raster, finer: impl Iterator<Item = Raster>, seed: &Seed) -> bool {
    let Some(edges) = seed.fit.edges.filter(|_| seed.model.kind == JointKind::Butt) else { return false };
    let holds = |finer: &Raster| edges.gap_px * finer.scale() / raster.scale() <= WIDEST_PX;
    let finer = finer.filter(|finer| finer.scale() > raster.scale()).filter(holds);
    let Some(finest) = finer.max_by(|a, b| a.scale().total_cmp(&b.scale())) else { return false };
    let Some(frame) = finest.resample(picture) else { return false };
    let scale = finest.scale() / raster.scale();
    let fit = in_raster(&seed.fit, raster, finest);
    let coarse_sd_px = scale * seed.model.stripe_sd_px;
    let measured = learn(&frame, fit.centre, JointKind::Butt).map(|learned| learned.model.stripe_sd_px);
    let stripe_sd_px = measured.map_or(coarse_sd_px, |measured_px| measured_px.min(coarse_sd_px));
    if edges.gap_px < LEAST_GAP_PX && stripe_sd_px < THIN_SHARE * coarse_sd_px {
        return true;
    }
    let shows = gap_shows(&frame, &fit, stripe_sd_px);
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

#[cfg(test)]
mod tests {
    use super::super::seed::find;
    use super::super::stripe::centreline;
    use super::*;

    /// A picture with a gap of 60 px in a stripe of SD 2.4 px.
    fn with_gap() -> GrayFrame {
        let mut frame = GrayFrame::filled(1280, 480, 12).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 1280) as f64, (i / 1280) as f64);
            if (u - 640.0).abs() > 30.0 {
                *pixel += (180.0 * (-0.5 * ((v - 240.0) / 2.4).powi(2)).exp()).round() as u8;
            }
        }
        frame
    }

    #[test]
    fn a_small_gap_in_a_stripe_that_only_looks_thick_is_none_of_a_coarse_raster() {
        let (picture, coarse) = (with_gap(), Raster::coarser(4));
        let level = coarse.resample(&picture).unwrap();
        let seeds = find(&level, &centreline(&level, true), Some(JointKind::Butt));
        let mut seed = seeds.into_iter().find(|seed| (seed.gap_px() - 15.0).abs() < 2.0).unwrap();
        let finer = || [1, 2].into_iter().map(Raster::coarser);
        assert!(!is_no_gap(&picture, coarse, finer(), &seed), "{:?}", seed.model.stripe_sd_px);
        seed.model.stripe_sd_px = 2.8;
        assert!(is_no_gap(&picture, coarse, finer(), &seed));
    }
}
