//! What a sighting is worth: taken into the filter, refused, or a reason to start the filter anew; and when the seam
//! is lost.

use super::filter::{COLOUR_VARIANCE_PX2, START_VELOCITY_VARIANCE, SeamFilter, VIBRATION_VARIANCE_PX2};
use super::part::{Part, Parts};
use crate::tracker::TrackerError;

/// NIS above which a sighting is refused, and above which it is used with an inflated R. Prototype.
pub const REFUSE_NIS: f64 = 16.0;
const INFLATE_NIS: f64 = 4.0;
/// The refusals that are looked at, and how long they count \[frames\]. Three that agree with each other make the filter
/// start anew (prototype), two when each is clear by itself and the seam is not lost, or they lie where it is expected
/// (tuned).
const RECENT_REFUSALS: usize = 5;
/// How far they may lie from one straight line \[px\], more where the edges are torn, and its steepest slope
/// \[px/frame\]: of any, and of three or more clear ones. Prototype; the last chosen: large pictures move fast.
const AGREEMENT_PX: f64 = 1.5;
const STEEPEST_SLOPE_PX: f64 = 8.0;
const STEEPEST_CLEAR_SLOPE_PX: f64 = 20.0;
/// Variances of position and velocity when the filter starts anew from them \[px², px²/frame²\].
const RESTART_VARIANCES: [f64; 2] = [1.5, 0.5];
/// σ of the prediction above which the seam is lost \[px\]: 2.7 σ are 1 mm at 0.073 mm/px.
pub const LOST_STD_PX: f64 = 5.0;
/// The same for a hairline, whose sightings are sometimes off by more than they claim. Tuned.
pub const HAIRLINE_LOST_STD_PX: f64 = 3.0;
/// Frames without a sighting after which the seam is lost, however sure the prediction is: as many as there were
/// sightings, within these bounds. A young track has not earned a long absence.
const LOST_FRAMES: std::ops::RangeInclusive<u32> = 3..=30;
/// How much longer a lost seam is sought as it was, in multiples of the same.
const GIVE_UP_FACTOR: u32 = 3;

/// A measurement as the filter took it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Position along the stripe \[px\].
    pub u_px: f64,
    /// R as used \[px²\].
    pub variance_px2: f64,
}

/// What became of a sighting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// It went into the filter.
    Taken(Measured),
    /// It was refused like those before it, but they agree: the filter started anew from them.
    Restarted(Measured),
    /// It is too far from the prediction.
    Refused,
}

#[derive(Debug, Clone, Copy)]
struct Refused {
    frame: f64,
    u_px: f64,
    clear: bool,
    /// Near the prediction: refused only because the seam was lost.
    expected: bool,
}

/// The filter and its guard.
#[derive(Debug, Clone)]
pub struct Judge {
    filter: SeamFilter,
    refused: Vec<Refused>,
    unseen: u32,
    sightings: u32,
    lost: bool,
    lost_std_px: f64,
    parts: Parts,
}

impl Judge {
    /// Starts at a sighting of variance `variance_px2`; the seam is lost when σ exceeds `lost_std_px`.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn start(u_px: f64, variance_px2: f64, lost_std_px: f64, parts: Parts) -> Result<Self, TrackerError> {
        let filter =
            SeamFilter::start(u_px, 0.0, [COLOUR_VARIANCE_PX2 + variance_px2, START_VELOCITY_VARIANCE], parts)?;
        Ok(Self { filter, refused: vec![], unseen: 0, sightings: 1, lost: false, lost_std_px, parts })
    }

    /// Goes `frames` on, with the measurements' noise scaled by `noise`.
    ///
    /// # Errors
    /// When `frames` is not positive.
    pub fn predict(&mut self, frames: f64, noise: f64) -> Result<(), TrackerError> {
        self.filter.set_noise(noise);
        Ok(self.filter.predict(frames)?)
    }

    /// Mean and variance of the position \[px, px²\].
    pub fn position(&self) -> (f64, f64) {
        self.filter.position()
    }

    /// One σ of the seam's position \[px\], its vibration included.
    pub fn std_px(&self) -> f64 {
        (self.position().1 + VIBRATION_VARIANCE_PX2).sqrt()
    }

    /// Frames since the seam was last sighted.
    pub const fn unseen(&self) -> u32 {
        self.unseen
    }

    /// Whether the seam is lost: no value may be given.
    pub const fn is_lost(&self) -> bool {
        self.lost
    }

    /// Whether the seam has been lost for so long that any joint should be sought.
    pub fn should_give_up(&self) -> bool {
        self.lost && self.unseen > GIVE_UP_FACTOR * self.patience()
    }

    fn patience(&self) -> u32 {
        self.sightings.clamp(*LOST_FRAMES.start(), *LOST_FRAMES.end())
    }

    /// Judges a sighting in frame `now`; `clear` when it needs no second one beside it. The NIS comes with the verdict.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn sighted(
        &mut self,
        now: f64,
        u_px: f64,
        variance_px2: f64,
        clear: bool,
    ) -> Result<(f64, Verdict), TrackerError> {
        let nis = self.filter.nis(u_px, variance_px2)?;
        let believable = nis <= REFUSE_NIS || !self.parts.has(Part::InnovationGate);
        if believable && !self.lost {
            self.unseen = 0;
            self.sightings += 1;
            return Ok((nis, Verdict::Taken(self.take(nis, u_px, variance_px2)?)));
        }
        self.refused.push(Refused { frame: now, u_px, clear, expected: nis <= INFLATE_NIS });
        let may_restart = self.lost || self.parts.has(Part::Reacquisition);
        if let Some((start_px, slope)) = self.agreement(now).filter(|_| may_restart) {
            self.filter = SeamFilter::start(start_px, slope, RESTART_VARIANCES, self.parts)?;
            self.refused.clear();
            self.lost = false;
            self.unseen = 0;
            return Ok((nis, Verdict::Restarted(Measured { u_px, variance_px2 })));
        }
        self.missed();
        Ok((nis, Verdict::Refused))
    }

    /// The seam was not sighted in this frame.
    pub fn missed(&mut self) {
        self.unseen += 1;
        let (_, variance) = self.position();
        self.lost |= variance.sqrt() > self.lost_std_px || self.unseen > self.patience();
    }

    /// Offers a stand-in for the sighting that was missed; it never restarts the filter.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn stand_in(&mut self, u_px: f64, variance_px2: f64) -> Result<(f64, Option<Measured>), TrackerError> {
        let nis = self.filter.nis(u_px, variance_px2)?;
        let measured = if nis <= REFUSE_NIS { Some(self.take(nis, u_px, variance_px2)?) } else { None };
        Ok((nis, measured))
    }

    fn take(&mut self, nis: f64, u_px: f64, variance_px2: f64) -> Result<Measured, TrackerError> {
        let inflation = if self.parts.has(Part::InnovationGate) { (nis / INFLATE_NIS).max(1.0) } else { 1.0 };
        let variance_px2 = variance_px2 * inflation;
        self.filter.update(u_px, variance_px2)?;
        Ok(Measured { u_px, variance_px2 })
    }

    /// Whether the newest refused sighting and enough of those just before it lie on a straight path: its position and
    /// slope now. A stray one among them does not matter.
    fn agreement(&self, now: f64) -> Option<(f64, f64)> {
        let fresh = |r: &&Refused| r.frame >= now - RECENT_REFUSALS as f64;
        let recent: Vec<Refused> = self.refused.iter().rev().take(RECENT_REFUSALS).filter(fresh).copied().collect();
        let [newest, others @ ..] = &recent[..] else { return None };
        let mut threes = others.iter().enumerate().flat_map(|(i, b)| others[i + 1..].iter().map(|c| [*newest, *b, *c]));
        let enough = |r: &Refused| r.clear && (r.expected || !self.lost);
        let two = others.first().map(|b| [*newest, *b]).filter(|two| two.iter().all(enough));
        let two = two.and_then(|two| self.straight_path(now, &two, STEEPEST_SLOPE_PX));
        let steepest_px = |three: &[Refused; 3]| {
            if three.iter().all(|r| r.clear) { STEEPEST_CLEAR_SLOPE_PX } else { STEEPEST_SLOPE_PX }
        };
        two.or_else(|| threes.find_map(|three| self.straight_path(now, &three, steepest_px(&three))))
    }

    /// Position and slope now of the straight line through `refused`, if they lie on one.
    fn straight_path(&self, now: f64, refused: &[Refused], steepest_px: f64) -> Option<(f64, f64)> {
        let n = refused.len() as f64;
        let mean_t = refused.iter().map(|r| r.frame - now).sum::<f64>() / n;
        let mean_u = refused.iter().map(|r| r.u_px).sum::<f64>() / n;
        let spread: f64 = refused.iter().map(|r| (r.frame - now - mean_t).powi(2)).sum();
        let slope = refused.iter().map(|r| (r.frame - now - mean_t) * (r.u_px - mean_u)).sum::<f64>() / spread;
        let off_line_px = |r: &Refused| (r.u_px - mean_u - slope * (r.frame - now - mean_t)).abs();
        let tolerance_px = AGREEMENT_PX * self.filter.noise().sqrt().max(1.0);
        let straight = refused.iter().all(|r| off_line_px(r) < tolerance_px) && slope.abs() < steepest_px;
        straight.then_some((mean_u - slope * mean_t, slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const R_PX2: f64 = 0.1;

    fn settled() -> Judge {
        let mut judge = Judge::start(100.0, R_PX2, LOST_STD_PX, Parts::default()).unwrap();
        for t in 1..40 {
            judge.predict(1.0, 1.0).unwrap();
            judge.sighted(f64::from(t), 100.0 + 0.5 * f64::from(t), R_PX2, true).unwrap();
        }
        judge
    }

    #[test]
    fn a_single_wild_sighting_is_refused_and_the_prediction_stands() {
        let mut judge = settled();
        judge.predict(1.0, 1.0).unwrap();
        let (_, verdict) = judge.sighted(40.0, 150.0, R_PX2, true).unwrap();
        assert_eq!(verdict, Verdict::Refused);
        assert!((judge.position().0 - 120.0).abs() < 0.3);
    }

    #[test]
    fn refused_sightings_that_agree_start_the_filter_anew() {
        let mut judge = settled();
        let mut verdicts = vec![];
        for t in 40..43 {
            judge.predict(1.0, 1.0).unwrap();
            verdicts.push(judge.sighted(f64::from(t), 150.0, R_PX2, false).unwrap().1);
        }
        assert!(matches!(verdicts[..], [Verdict::Refused, Verdict::Refused, Verdict::Restarted(_)]));
        assert!((judge.position().0 - 150.0).abs() < 0.5);
    }

    #[test]
    fn a_seam_that_is_long_unseen_is_lost_and_never_found_again_by_one_sighting() {
        let mut judge = settled();
        for _ in 0..=*LOST_FRAMES.end() {
            judge.predict(1.0, 1.0).unwrap();
            judge.missed();
        }
        assert!(judge.is_lost());
        judge.predict(1.0, 1.0).unwrap();
        let (_, verdict) = judge.sighted(90.0, judge.position().0, R_PX2, true).unwrap();
        assert_eq!(verdict, Verdict::Refused);
        assert!(judge.is_lost());
    }

    #[test]
    fn sigma_grows_while_the_seam_is_unseen() {
        let mut judge = settled();
        let first = judge.std_px();
        let mut last = first;
        for _ in 0..12 {
            judge.predict(1.0, 1.0).unwrap();
            judge.missed();
            assert!(judge.std_px() > last);
            last = judge.std_px();
        }
        assert!(last > 1.5 * first, "{first} to {last}");
    }
}
