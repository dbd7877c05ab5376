//! Looking for a joint on several rasters at once: small joints in the picture's own, large ones in coarser ones.
//!
//! What looks at a joint looks through windows of some 160 × 140 px. A gap of 250 px does not fit into them; in a raster
//! four times as coarse it does, and its edges are as sharp in millimetres as they need be. So each raster has its range of
//! joints, and a joint belongs to the finest one that holds it.

use std::ops::Range;

use rayon::prelude::*;

use super::RobustSettings;
use super::candidate::{OTHER_DOUBT, Shows};
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
const LEAST_GAP_PX: f64 = 28.0;
const LEAST_HALF_WIDTH_PX: f64 = 40.0;
/// A coarser raster is also for a stripe that has at least this SD there \[px\]: in the next finer one it would be twice as
/// thick, and what looks at it is made for stripes of SD 1.2 to 3.8 px.
const LEAST_STRIPE_SD_PX: f64 = 1.9;

/// Least half length of a joint along the stripe \[px\].
const LEAST_HALF_SPAN_PX: f64 = 5.0;

/// What lies within so many half lengths of a joint belongs to it. Chosen.
const SPAN_REACH: f64 = 1.5;

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
        let (raster, mut found) = self.find(frame);
        if let Found::Joint { seed, shows, doubt: doubt @ None, .. } = &mut found
            && self.any(&Span::of(seed, raster), |seeker, span_px| seeker.shows_other(*shows, span_px))
        {
            *doubt = Some(OTHER_DOUBT);
        }
        (raster, found)
    }

    fn find(&mut self, frame: &GrayFrame) -> (Raster, Found) {
        // The rasters do not need one another until each has been looked at.
        let look = |(raster, seeker): &mut (Raster, Seeker)| {
            let level = raster.resample(frame)?;
            let is_large = level.width_px() >= LEAST_RASTER_PX.0 && level.height_px() >= LEAST_RASTER_PX.1;
            (*raster == Raster::PICTURE || is_large).then(|| seeker.look(&level))
        };
        let found: Vec<Option<Found>> = self.levels.par_iter_mut().map(look).collect();
        let mut larger: Vec<(Span, Shows)> = vec![];
        let (mut nothing, mut smaller) = (None, None);
        for ((raster, seeker), found) in self.levels.iter().zip(found).rev() {
            let Some(found) = found else { continue };
            let is_finest = *raster == Raster::PICTURE;
            match found {
                Found::Joint { ref seed, shows, .. } if !is_finest && !is_large(seed) => {
                    let may_be_deep = shows.is_more_than_step() && seed.model.kind == JointKind::Butt;
                    smaller = may_be_deep.then_some((*raster, found)).or(smaller);
                }
                Found::Joint { ref seed, .. } if !is_finest && is_none_in_finer(frame, *raster, seed) => {}
                // A plate's end is a step, too: beside it a gap may be too deep to be looked into in its own raster.
                Found::Joint { ref seed, shows: shows @ (Shows::Step | Shows::Ledge), .. }
                    if self.any(&Span::of(seed, *raster), |seeker, span_px| seeker.shows_more(shows, span_px)) =>
                {
                    let deep = smaller.take().filter(|(raster, found)| match found {
                        Found::Joint { seed, .. } => is_finest && !is_none_in_finer(frame, *raster, seed),
                        _ => false,
                    });
                    if let Some((raster, found)) = deep {
                        return (raster, found);
                    }
                }
                // The edge of a wide gap looks like a lap joint to a narrow window; a groove is not hidden by what may be a gap.
                Found::Joint { ref seed, shows, .. }
                    if larger.iter().any(|(span, as_much)| {
                        span.holds(&Span::of(seed, *raster)) && (shows == Shows::Step || *as_much >= shows)
                    }) => {}
                found @ Found::Nothing { .. } => nothing = Some((*raster, found)),
                found => return (*raster, found),
            }
            let large = seeker.candidates().filter(|other| !is_finest && is_large(&other.seed));
            larger.extend(large.map(|other| (Span::of(&other.seed, *raster), other.shows)));
        }
        nothing.unwrap_or((Raster::PICTURE, Found::nothing()))
    }

    /// Whether in any raster `is` holds, of its seeker and of the columns of a joint there.
    fn any(&self, span: &Span, is: impl Fn(&Seeker, &Range<f64>) -> bool) -> bool {
        let reach_px = SPAN_REACH * span.half_px;
        self.levels.iter().any(|(raster, seeker)| {
            let at = |off_px: f64| (span.centre_px + off_px) * raster.scale();
            is(seeker, &(at(-reach_px)..at(reach_px)))
        })
    }
}

/// Whether what `raster` shows of the picture is no joint in a finer one.
fn is_none_in_finer(picture: &GrayFrame, raster: Raster, seed: &Seed) -> bool {
    is_no_gap(picture, raster, COARSENESS.into_iter().map(Raster::coarser), seed)
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
mod tests;
