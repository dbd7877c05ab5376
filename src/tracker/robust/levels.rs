//! Looking for a joint on several rasters at once: small joints in the picture's own, large ones in coarser ones.
//!
//! What looks at a joint looks through windows of some 160 × 140 px. A gap of 250 px does not fit into them; in a raster
//! four times as coarse it does, and its edges are as sharp in millimetres as they need be. So each raster has its range of
//! joints, and a joint belongs to the finest one that holds it.

use rayon::prelude::*;

use super::RobustSettings;
use super::classify;
use super::finer::is_no_gap;
use super::seed::Seed;
use super::seek::{Found, Seeker};
use crate::frame::GrayFrame;
use crate::imgproc::Raster;
use crate::imgproc::geometry::JointKind;
use crate::units::PixelPoint;

/// Picture pixels a raster pixel, along each side.
const COARSENESS: [usize; 4] = [1, 2, 4, 8];
/// Columns and rows that a raster must have to be looked at. Chosen: twice a window.
const LEAST_RASTER_PX: (usize, usize) = (160, 120);
/// A joint belongs to a coarser raster when its gap or step there is at least this wide, its groove this wide from root to
/// shoulder \[px\]. Chosen: half of what the next finer one can hold.
pub const LEAST_GAP_PX: f64 = 28.0;
const LEAST_HALF_WIDTH_PX: f64 = 40.0;
/// A coarser raster is also for a stripe that has at least this SD there \[px\]: in the next finer one it would be twice as
/// thick, and what looks at it is made for stripes of SD 1.2 to 3.8 px.
const LEAST_STRIPE_SD_PX: f64 = 1.9;

/// Least half length of a joint along the stripe \[px\].
const LEAST_HALF_SPAN_PX: f64 = 5.0;

/// A seeker for each raster, the finest first.
pub struct Levels {
    levels: Vec<(Raster, Seeker)>,
}

impl Levels {
    /// Looks for the joint of the settings, or for any; `untouched` when no weld can have been begun.
    pub fn new(settings: &RobustSettings, untouched: bool) -> Self {
        Self::of(|coarseness| Seeker::new(settings.joint, settings.parts, untouched, coarseness == 1))
    }

    /// The same but for hairlines.
    pub fn without_hairlines(settings: &RobustSettings, untouched: bool) -> Self {
        Self::of(|_| Seeker::new(settings.joint, settings.parts, untouched, false))
    }

    /// Looks for the joint of the settings, or for any, beside one that is known and not seen.
    pub fn rival(settings: &RobustSettings) -> Self {
        Self::of(|_| Seeker::rival(settings.joint, settings.parts))
    }

    fn of(seeker: impl Fn(usize) -> Seeker) -> Self {
        Self { levels: COARSENESS.map(|coarseness| (Raster::coarser(coarseness), seeker(coarseness))).into() }
    }

    /// The user knows where the seam is in the next frame.
    pub fn seed_at(&mut self, centre: PixelPoint) {
        for (raster, seeker) in &mut self.levels {
            seeker.seed_at(raster.raster_from_picture(centre), raster.scale());
        }
    }

    /// Whether nothing was found at the place the user gave, as [`Seeker::asked_in_vain`] has it.
    pub fn asked_in_vain(&self) -> Option<Option<(JointKind, PixelPoint)>> {
        self.levels.first()?.1.asked_in_vain()?;
        let seen = self.levels.iter().find_map(|(raster, seeker)| Some((raster, seeker.asked_in_vain()??)));
        Some(seen.map(|(raster, (kind, centre))| (kind, raster.picture_from_raster(centre))))
    }

    /// A frame passes that cannot be looked at.
    pub fn miss(&mut self) {
        self.levels.iter_mut().for_each(|(_, seeker)| seeker.miss());
    }

    /// Looks at the next frame: what was found, and in which raster.
    pub fn look(&mut self, frame: &GrayFrame) -> (Raster, Found) {
        // The rasters do not need one another until each has been looked at.
        let look = |(raster, seeker): &mut (Raster, Seeker)| {
            let level = raster.resample(frame)?;
            let is_large = level.width_px() >= LEAST_RASTER_PX.0 && level.height_px() >= LEAST_RASTER_PX.1;
            (*raster == Raster::PICTURE || is_large).then(|| seeker.look(&level))
        };
        let found: Vec<Option<Found>> = self.levels.par_iter_mut().map(look).collect();
        let mut larger: Vec<Span> = vec![];
        let mut nothing = None;
        for ((raster, seeker), found) in self.levels.iter().zip(found).rev() {
            let Some(found) = found else { continue };
            let is_finest = *raster == Raster::PICTURE;
            match found {
                Found::Joint { seed, .. } if !is_finest && !is_large(&seed) => {}
                Found::Joint { seed, .. }
                    if !is_finest && is_no_gap(frame, *raster, COARSENESS.into_iter().map(Raster::coarser), &seed) => {}
                // The edge of a wide gap looks like a lap joint to a narrow window.
                Found::Joint { seed, .. } if larger.iter().any(|span| span.holds(&Span::of(&seed, *raster))) => {}
                found @ Found::Nothing { .. } => nothing = Some((*raster, found)),
                found => return (*raster, found),
            }
            larger.extend(
                seeker.candidates().filter(|seed| !is_finest && is_large(seed)).map(|seed| Span::of(seed, *raster)),
            );
        }
        nothing.unwrap_or((Raster::PICTURE, Found::nothing()))
    }
}

/// Where a joint lies along the stripe \[px of the picture\].
struct Span {
    centre_px: f64,
    half_px: f64,
}

impl Span {
    fn of(seed: &Seed, raster: Raster) -> Self {
        let half_px = seed.half_px().max(LEAST_HALF_SPAN_PX);
        let centre_px = raster.picture_from_raster(seed.fit.centre).u_px;
        Self { centre_px, half_px: half_px / raster.scale() }
    }

    /// Whether the other one is a part of this one.
    fn holds(&self, other: &Self) -> bool {
        (self.centre_px - other.centre_px).abs() < 1.2 * self.half_px && other.half_px < self.half_px
    }
}

/// Whether a joint is too large for the next finer raster, or its stripe too thick.
fn is_large(seed: &Seed) -> bool {
    let joint_is_large = match seed.model.kind {
        JointKind::Butt => seed.fit.edges.is_some_and(|edges| edges.gap_px >= LEAST_GAP_PX),
        JointKind::Lap => classify::step_px(seed).abs() >= LEAST_GAP_PX,
        JointKind::VGroove => seed.model.half_width_px.is_some_and(|half_px| half_px >= LEAST_HALF_WIDTH_PX),
        JointKind::Fillet => false,
    };
    joint_is_large || seed.model.stripe_sd_px >= LEAST_STRIPE_SD_PX
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level stripe of SD 2 px with a gap round column `middle_px`.
    fn with_gap(middle_px: f64, gap_px: f64) -> GrayFrame {
        let (width_px, height_px) = (1280, 960);
        let mut frame = GrayFrame::filled(width_px, height_px, 12).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % width_px) as f64, (i / width_px) as f64);
            if (u - middle_px).abs() > 0.5 * gap_px {
                *pixel += (180.0 * (-0.5 * ((v - 480.0) / 2.0).powi(2)).exp()).round() as u8;
            }
        }
        frame
    }

    /// The raster in which a gap that moves by 2 px a frame is found, and its middle in the picture's last column.
    fn found(gap_px: f64) -> (Raster, f64) {
        let settings = RobustSettings { joint: Some(JointKind::Butt), ..RobustSettings::default() };
        let mut levels = Levels::new(&settings, false);
        for frame in 0..10 {
            let middle_px = 600.0 + 2.0 * f64::from(frame);
            let (raster, found) = levels.look(&with_gap(middle_px, gap_px));
            if let Found::Joint { seed, .. } = found {
                return (raster, raster.picture_from_raster(seed.fit.centre).u_px - middle_px);
            }
        }
        panic!("a gap of {gap_px} px was not found");
    }

    #[test]
    fn a_gap_belongs_to_the_finest_raster_that_holds_it() {
        let (raster, off_px) = found(12.0);
        assert!(raster == Raster::PICTURE && off_px.abs() < 1.0, "{off_px}");
        let (raster, off_px) = found(150.0);
        assert!(raster != Raster::PICTURE && off_px.abs() < 4.0, "{off_px}");
    }

    #[test]
    fn a_frame_too_small_for_the_coarse_rasters_is_looked_at_in_its_own() {
        let mut levels = Levels::new(&RobustSettings::default(), false);
        let (raster, found) = levels.look(&GrayFrame::filled(200, 130, 12).unwrap());
        assert!(raster == Raster::PICTURE && matches!(found, Found::Nothing { stripe_seen: false, .. }));
    }
}
