//! Looking for a joint, frame by frame, until one is certain.

use super::classify;
use super::seed::{self, Seed};
use crate::frame::GrayFrame;
use crate::imgproc::geometry::JointKind;
use crate::imgproc::{Centreline, CentrelineSettings, SeedSettings, extract_centreline};
use crate::tracker::hairline::{HairlineEstimate, HairlineTracker, SeamPresence};
use crate::units::PixelPoint;

/// Seeds in successive frames that must agree where one is not clear by itself.
const AGREEING_SEEDS: usize = 3;
/// How close they must be \[px\]: the seam moves between frames.
const AGREEMENT_PX: f64 = 8.0;
/// A hairline lies in one straight stripe: this share of the columns near it must lie on the stripe's line.
const STRAIGHT_SHARE: f64 = 0.75;
const STRAIGHT_REACH_PX: usize = 40;
const STRAIGHT_TOLERANCE_PX: f64 = 3.5;
/// Memory of that share \[per frame\].
const STRAIGHT_RATE: f64 = 0.25;
/// Frames for which the hairline's place must have been straight.
const HAIRLINE_FRAMES: u32 = 3;

/// What a frame brought.
pub enum Found {
    /// No joint that is certain.
    Nothing {
        /// There was a stripe.
        stripe_seen: bool,
    },
    /// A joint with edges or a corner.
    Joint {
        /// Its cross-section and its place.
        seed: Box<Seed>,
        /// Why it is one of its kind.
        reason: String,
    },
    /// A hairline.
    Hairline {
        /// The tracker that found it.
        tracker: Box<HairlineTracker>,
        /// Its place.
        centre: PixelPoint,
        /// Variance of the place along the stripe \[px²\].
        variance_px2: f64,
        /// Why it is one.
        reason: String,
    },
}

/// Looks for joints of one kind, or of all.
pub struct Seeker {
    kind: Option<JointKind>,
    asked: Option<PixelPoint>,
    pending: Vec<Seed>,
    hairline: HairlineTracker,
    straight_share: f64,
    hairline_frames: u32,
}

impl Seeker {
    /// Looks for `kind`, or for any.
    pub fn new(kind: Option<JointKind>) -> Self {
        Self {
            kind,
            asked: None,
            pending: vec![],
            hairline: HairlineTracker::default(),
            straight_share: 0.0,
            hairline_frames: 0,
        }
    }

    /// The user knows where the seam is in the next frame.
    pub fn seed_at(&mut self, centre: PixelPoint) {
        self.asked = Some(centre);
    }

    /// Looks at the next frame.
    pub fn look(&mut self, frame: &GrayFrame) -> Found {
        let line = extract_centreline(frame, &CentrelineSettings::default());
        let stripe_seen = line.extent(SeedSettings::default().widest_joint_px).is_some();
        let seed = match self.asked.take() {
            Some(point) => seed::at(frame, self.kind, point),
            None => seed::find(frame, &line, self.kind),
        };
        if let Some(seed) = self.confirmed(seed) {
            let reason = classify::reason(&seed, self.kind.is_some());
            return Found::Joint { seed: Box::new(seed), reason };
        }
        if self.kind.is_none_or(|kind| kind == JointKind::Butt)
            && let Some(estimate) = self.hairline.step(frame)
            && self.hairline_is_certain(&line, &estimate)
        {
            return Found::Hairline {
                tracker: Box::new(std::mem::take(&mut self.hairline)),
                centre: estimate.seam,
                variance_px2: estimate.grid.sd_px.powi(2),
                reason: "one straight stripe with a hairline break that moves as a seam does".into(),
            };
        }
        Found::Nothing { stripe_seen }
    }

    /// The seed if it is clear by itself, or if those of the frames before agree with it.
    fn confirmed(&mut self, seed: Option<Seed>) -> Option<Seed> {
        let Some(seed) = seed else {
            self.pending.clear();
            return None;
        };
        let agrees = |other: &Seed| {
            other.model.kind == seed.model.kind && (other.fit.centre.u_px - seed.fit.centre.u_px).abs() < AGREEMENT_PX
        };
        self.pending.retain(agrees);
        self.pending.push(seed.clone());
        if !seed.clear && self.pending.len() < AGREEING_SEEDS {
            return None;
        }
        self.pending.clear();
        Some(seed)
    }

    fn hairline_is_certain(&mut self, line: &Centreline, estimate: &HairlineEstimate) -> bool {
        let share = straight_share(line, estimate.seam.u_px, |u| self.hairline.stripe_v_px(u));
        self.straight_share += STRAIGHT_RATE * (share - self.straight_share);
        let present = estimate.presence == SeamPresence::Present;
        let straight = self.straight_share >= STRAIGHT_SHARE;
        self.hairline_frames = if present && straight { self.hairline_frames + 1 } else { 0 };
        self.hairline_frames >= HAIRLINE_FRAMES
    }
}

/// Share of the columns near `u_px` whose centre lies on the stripe's line.
fn straight_share(line: &Centreline, u_px: f64, stripe_v_px: impl Fn(f64) -> Option<f64>) -> f64 {
    let centre = u_px.round().max(0.0) as usize;
    let near = centre.saturating_sub(STRAIGHT_REACH_PX)..centre + STRAIGHT_REACH_PX + 1;
    let on_line = |u: usize| {
        let (Some(v), Some(expected)) = (line.at(u), stripe_v_px(u as f64)) else { return false };
        (f64::from(v) - expected).abs() < STRAIGHT_TOLERANCE_PX
    };
    let count = near.len() as f64;
    near.filter(|&u| on_line(u)).count() as f64 / count
}
