//! Sighting a hairline butt joint: evidence along the straightened stripe and a grid filter over it.

use super::sighting::{Sighting, Unsighted};
use super::stripe;
use crate::frame::GrayFrame;
use crate::imgproc::geometry::Refusal;
use crate::tracker::estimate::Evidence;
use crate::tracker::hairline::{HairlineTracker, SeamPresence};
use crate::units::PixelPoint;

/// Least variance of a sighting \[px²\]. Chosen: as a geometry fit's.
const LEAST_VARIANCE_PX2: f64 = 0.1;
/// Variance of the stripe's row where a hairline is \[px²\]: that of the stripe's line. Chosen.
pub const ROW_VARIANCE_PX2: f64 = 0.1;

/// The hairline tracker as an eye of the robust tracker.
#[derive(Debug, Clone)]
pub struct HairlineEye {
    tracker: HairlineTracker,
}

impl HairlineEye {
    /// Goes on from a tracker that has confirmed its seam.
    pub const fn new(tracker: HairlineTracker) -> Self {
        Self { tracker }
    }

    /// The same for a hairline that was lost, anywhere along the stripe: what is found must lie in one straight stripe, as when
    /// any is sought. The end of the stripe at a cover does not.
    pub fn search(&mut self, frame: &GrayFrame) -> Result<Sighting, Unsighted> {
        let sighting = self.look(frame)?;
        let line = stripe::centreline(frame, true);
        let share = stripe::straight_share(&line, sighting.centre.u_px, |u| self.tracker.stripe_v_px(u));
        if share >= stripe::STRAIGHT_SHARE {
            return Ok(sighting);
        }
        Err(Unsighted { refusal: Refusal::Support, evidence: sighting.evidence })
    }

    /// What the frame shows, where the grid is sure that there is a seam and where.
    pub fn look(&mut self, frame: &GrayFrame) -> Result<Sighting, Unsighted> {
        let estimate = self.tracker.step(frame).ok_or(Refusal::NoLine)?;
        let evidence = Evidence { presence: Some(estimate.grid.presence), ..Evidence::NONE };
        let unsighted = |refusal| Unsighted { refusal, evidence };
        if estimate.presence != SeamPresence::Present {
            return Err(unsighted(Refusal::Presence));
        }
        let observation = estimate.observation.ok_or(unsighted(Refusal::Support))?;
        let evidence = Evidence { along_px: Some(observation.u_px), ..evidence };
        Ok(Sighting {
            centre: PixelPoint::new(observation.u_px, estimate.seam.v_px),
            variance_px2: observation.sd_px.powi(2).max(LEAST_VARIANCE_PX2),
            across_variance_px2: ROW_VARIANCE_PX2,
            clear: true,
            evidence,
            section: None,
            fit: None,
        })
    }
}
