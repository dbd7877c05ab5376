//! What a sighting is worth: taken into the filter, refused, or a reason to start the filter anew; and when the seam
//! is lost.
#![expect(non_snake_case, reason = "covariances carry the literature's letters")]

use std::collections::VecDeque;

use arrayvec::ArrayVec;

use super::filter::{START_VELOCITY_VARIANCE, SeamFilter, VIBRATION_VARIANCE_PX2};
use super::noise::{self, INFLATE_NIS};
use super::part::{Part, Parts};
use crate::kalman::Link;
use crate::tracker::TrackerError;

/// NIS above which a sighting is refused. Prototype.
pub const REFUSE_NIS: f64 = 16.0;
/// The correlation filter vouches for a sighting that it sees this near \[px\]: then a NIS up to the second counts, and R is
/// not inflated. Replayed: of 166 sightings refused by their NIS, 97 of the 107 near its peak were right, 7 of the 59 others.
const WITNESS_PX: f64 = 3.0;
const VOUCHED_NIS: f64 = 60.0;
/// A clear sighting that was refused, or the prediction, is wrong: so much of their distance goes into σ. Chosen: each with a
/// chance of a quarter.
const DOUBT_SHARE: f64 = 0.5;
/// The refusals that are looked at, and how long they count \[beats\]. Three that agree with each other make the filter
/// start anew (prototype), two when each is clear by itself and the seam is not lost, or they lie where it is expected
/// (tuned).
const RECENT_REFUSALS: usize = 5;
/// How far they may lie from one straight line \[px\], more where the edges are torn, and its steepest slope
/// \[px/beat\]: of any, and of three or more clear ones. Prototype; the last chosen: large pictures move fast.
const AGREEMENT_PX: f64 = 1.5;
const STEEPEST_SLOPE_PX: f64 = 8.0;
const STEEPEST_CLEAR_SLOPE_PX: f64 = 20.0;
/// A line through the sightings that starts the filter anew and passes the place where the seam was last seen by more than so
/// many of the distances above is no corner but a jump: the camera was knocked. Chosen: 4.5 px on sharp edges.
const JUMP_DISTANCES: f64 = 3.0;
/// R of the position and variance of the velocity when the filter starts anew from them \[px², px²/beat²\].
const RESTART_VARIANCES: (f64, f64) = (1.3, 0.5);
/// Time without a sighting after which the seam is lost, however sure the prediction is \[beats\]: as many as there were
/// sightings, within these bounds. A young track has not earned a long absence.
const LOST_BEATS: std::ops::RangeInclusive<f64> = 3.0..=30.0;
/// How much longer a lost seam is sought as it was, in multiples of the same.
const GIVE_UP_FACTOR: f64 = 3.0;

/// What became of a sighting; a measured one comes with the R that was used \[px²\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// It went into the filter.
    Taken(f64),
    /// It was refused like those before it, but they agree: the filter started anew from them.
    Restarted(f64, Restart),
    /// It is too far from the prediction.
    Refused,
}

/// The straight path from which the filter started anew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restart {
    /// Where the seam is now \[px\], and how fast it moves \[px/beat\].
    u_px: f64,
    slope_px: f64,
    tolerance_px: f64,
    /// It cannot have come here from where it was seen before.
    pub is_jump: bool,
}

impl Restart {
    /// Whether a sighting of `beats` ago lies on the path.
    pub fn holds(&self, u_px: f64, beats: f64) -> bool {
        (self.u_px - self.slope_px * beats - u_px).abs() < self.tolerance_px
    }
}

#[derive(Debug, Clone, Copy)]
struct Refused {
    /// When \[beats\].
    at: f64,
    u_px: f64,
    clear: bool,
    /// Near the prediction: refused only because the seam was lost.
    expected: bool,
}

/// The filter and its guard.
#[derive(Debug, Clone)]
pub struct Judge {
    filter: SeamFilter,
    refused: VecDeque<Refused>,
    /// Since the start \[beats\], and the step it last took.
    now: f64,
    step: f64,
    unseen_beats: f64,
    /// Where the seam was when it was last seen \[px\].
    seen_px: f64,
    /// Farthest from the prediction that a clear sighting was refused since the last one that was taken \[px\].
    doubt_px: f64,
    sightings: f64,
    lost_std_px: f64,
    /// A clear sighting elsewhere speaks against the prediction.
    has_doubts: bool,
    parts: Parts,
}

impl Judge {
    /// Starts at a sighting `u_px` of R `white_px2`; the seam is lost when σ exceeds `lost_std_px`.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn start(u_px: f64, white_px2: f64, lost_std_px: f64, parts: Parts) -> Result<Self, TrackerError> {
        Ok(Self {
            filter: SeamFilter::start((u_px, white_px2), (0.0, START_VELOCITY_VARIANCE), 1.0, parts)?,
            refused: VecDeque::with_capacity(RECENT_REFUSALS + 1),
            now: 0.0,
            step: 1.0,
            unseen_beats: 0.0,
            seen_px: u_px,
            doubt_px: 0.0,
            sightings: 1.0,
            lost_std_px,
            has_doubts: true,
            parts,
        })
    }

    /// For sightings that are all called clear, and some of which are wild: they raise no doubts.
    #[must_use]
    pub fn without_doubts(self) -> Self {
        Self { has_doubts: false, ..self }
    }

    /// Goes `beats` on, with the measurements' noise scaled by `noise`.
    ///
    /// # Errors
    /// When `beats` is not positive.
    pub fn predict(&mut self, beats: f64, noise: f64) -> Result<(), TrackerError> {
        self.now += beats;
        self.step = beats;
        self.filter.set_noise(noise);
        Ok(self.filter.predict(beats)?)
    }

    /// Mean and variance of the position \[px, px²\].
    pub fn position(&self) -> (f64, f64) {
        self.filter.position()
    }

    /// The filter's last step.
    pub fn link(&self) -> Link<4> {
        self.filter.link()
    }

    /// What a clear sighting elsewhere leaves of σ² \[px²\].
    pub fn doubt_px2(&self) -> f64 {
        (DOUBT_SHARE * self.doubt_px).powi(2)
    }

    /// One σ of the seam's position \[px\], its vibration included, and what a clear sighting elsewhere leaves of it.
    pub fn std_px(&self) -> f64 {
        (self.position().1 + VIBRATION_VARIANCE_PX2 + self.doubt_px2()).sqrt()
    }

    /// Whether σ is too large for a value to be given.
    pub fn is_doubtful(&self) -> bool {
        self.doubt_px > 0.0 && self.std_px() > self.lost_std_px
    }

    /// Whether a picture of `beats` ago still tells where the seam is: at its speed it has not gone as far as the prediction may
    /// be unsure.
    pub fn outlasts(&self, beats: f64) -> bool {
        self.filter.velocity_px().abs() * beats <= self.lost_std_px
    }

    /// Time since the start \[beats\].
    pub const fn now_beats(&self) -> f64 {
        self.now
    }

    /// Time since the seam was last sighted \[beats\], 0 in the frame after a sighting.
    pub const fn unseen_beats(&self) -> f64 {
        self.unseen_beats
    }

    /// Whether the prediction is worth nothing any more: too long unseen, or too unsure.
    pub fn is_exhausted(&self) -> bool {
        self.unseen_beats > 0.0
            && (self.position().1.sqrt() > self.lost_std_px || self.unseen_beats > self.patience_beats())
    }

    /// Whether a lost seam has been sought for so long that any joint should be.
    pub fn should_give_up(&self) -> bool {
        self.unseen_beats > GIVE_UP_FACTOR * self.patience_beats()
    }

    /// Where the sightings refused last were \[px\], the newest first.
    pub fn refused_px(&self) -> impl Iterator<Item = f64> {
        self.refused.iter().rev().map(|refused| refused.u_px)
    }

    fn patience_beats(&self) -> f64 {
        self.sightings.clamp(*LOST_BEATS.start(), *LOST_BEATS.end())
    }

    /// Judges a sighting, which the correlation filter sees `witness` \[px\] away, where it is to be believed; `clear` when it needs no second one beside it, `is_lost` when the prediction is exhausted. The
    /// NIS comes with the verdict.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn sighted(
        &mut self,
        u_px: f64,
        R_px2: f64,
        witness: Option<f64>,
        clear: bool,
        is_lost: bool,
    ) -> Result<(f64, Verdict), TrackerError> {
        let nis = self.filter.nis(u_px, R_px2)?;
        let witness = witness.filter(|_| self.parts.has(Part::Witness));
        let vouched = witness.is_some_and(|away_px| away_px <= WITNESS_PX);
        let believable = nis <= if vouched { VOUCHED_NIS } else { REFUSE_NIS } || !self.parts.has(Part::InnovationGate);
        if believable && !is_lost {
            self.unseen_beats = 0.0;
            self.doubt_px = 0.0;
            self.sightings += 1.0;
            let doubt = if vouched { 0.0 } else { nis };
            return Ok((nis, Verdict::Taken(self.take(doubt, u_px, R_px2)?)));
        }
        if clear && self.has_doubts {
            self.doubt_px = self.doubt_px.max((u_px - self.position().0).abs());
        }
        self.refused.push_back(Refused { at: self.now, u_px, clear, expected: nis <= INFLATE_NIS });
        if self.refused.len() > RECENT_REFUSALS {
            self.refused.pop_front();
        }
        let may_restart = is_lost || self.parts.has(Part::Reacquisition);
        if let Some((start_px, slope)) = self.agreement(is_lost).filter(|_| may_restart) {
            let restart = self.restart(start_px, slope, nis);
            let (white_px2, velocity_variance) = RESTART_VARIANCES;
            let noise = self.filter.noise();
            let position = (start_px, noise.max(1.0) * white_px2);
            self.filter = SeamFilter::start(position, (slope, velocity_variance), noise, self.parts)?;
            self.refused.clear();
            self.unseen_beats = 0.0;
            self.seen_px = start_px;
            self.doubt_px = 0.0;
            return Ok((nis, Verdict::Restarted(R_px2, restart)));
        }
        self.missed();
        Ok((nis, Verdict::Refused))
    }

    /// The seam was not sighted in this frame.
    pub fn missed(&mut self) {
        self.unseen_beats += self.step;
    }

    /// Offers a stand-in for the sighting that was missed; it never restarts the filter. Its NIS, and R if it was taken.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn stand_in(&mut self, u_px: f64, R_px2: f64) -> Result<(f64, Option<f64>), TrackerError> {
        let nis = self.filter.nis(u_px, R_px2)?;
        let taken = if nis <= REFUSE_NIS { Some(self.take(nis, u_px, R_px2)?) } else { None };
        Ok((nis, taken))
    }

    fn take(&mut self, nis: f64, u_px: f64, R_px2: f64) -> Result<f64, TrackerError> {
        let inflation = if self.parts.has(Part::InnovationGate) { noise::inflation(nis) } else { 1.0 };
        self.filter.update(u_px, R_px2 * inflation)?;
        self.seen_px = self.position().0;
        Ok(R_px2 * inflation)
    }

    fn restart(&self, u_px: f64, slope_px: f64, nis: f64) -> Restart {
        let tolerance_px = self.tolerance_px();
        let since_seen = self.unseen_beats + self.step;
        let off_px = (u_px - slope_px * since_seen - self.seen_px).abs();
        Restart { u_px, slope_px, tolerance_px, is_jump: nis > REFUSE_NIS && off_px > JUMP_DISTANCES * tolerance_px }
    }

    /// How far sightings may lie from one straight line \[px\].
    fn tolerance_px(&self) -> f64 {
        AGREEMENT_PX * self.filter.noise().sqrt().max(1.0)
    }

    /// Whether the newest refused sighting and enough of those just before it lie on a straight path: its position and
    /// slope now. A stray one among them does not matter.
    fn agreement(&self, is_lost: bool) -> Option<(f64, f64)> {
        let fresh = |r: &&Refused| r.at >= self.now - RECENT_REFUSALS as f64;
        let recent = self.refused.iter().rev().filter(fresh).copied().take(RECENT_REFUSALS);
        let recent: ArrayVec<Refused, RECENT_REFUSALS> = recent.collect();
        let [newest, others @ ..] = &recent[..] else { return None };
        let mut threes = others.iter().enumerate().flat_map(|(i, b)| others[i + 1..].iter().map(|c| [*newest, *b, *c]));
        let enough = |r: &Refused| r.clear && (r.expected || !is_lost);
        let two = others.first().map(|b| [*newest, *b]).filter(|two| two.iter().all(enough));
        let two = two.and_then(|two| self.straight_path(&two, STEEPEST_SLOPE_PX));
        let steepest_px = |three: &[Refused; 3]| {
            if three.iter().all(|r| r.clear) { STEEPEST_CLEAR_SLOPE_PX } else { STEEPEST_SLOPE_PX }
        };
        two.or_else(|| threes.find_map(|three| self.straight_path(&three, steepest_px(&three))))
    }

    /// Position and slope now of the straight line through `refused`, if they lie on one.
    fn straight_path(&self, refused: &[Refused], steepest_px: f64) -> Option<(f64, f64)> {
        let (n, now) = (refused.len() as f64, self.now);
        let mean_t = refused.iter().map(|r| r.at - now).sum::<f64>() / n;
        let mean_u = refused.iter().map(|r| r.u_px).sum::<f64>() / n;
        let spread: f64 = refused.iter().map(|r| (r.at - now - mean_t).powi(2)).sum();
        let slope = refused.iter().map(|r| (r.at - now - mean_t) * (r.u_px - mean_u)).sum::<f64>() / spread;
        let off_line_px = |r: &Refused| (r.u_px - mean_u - slope * (r.at - now - mean_t)).abs();
        let straight = refused.iter().all(|r| off_line_px(r) < self.tolerance_px()) && slope.abs() < steepest_px;
        straight.then_some((mean_u - slope * mean_t, slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const R_PX2: f64 = 0.1;

    fn settled() -> Judge {
        let mut judge = Judge::start(100.0, R_PX2, 5.0, Parts::default()).unwrap();
        for t in 1..40 {
            judge.predict(1.0, 1.0).unwrap();
            judge.sighted(100.0 + 0.5 * f64::from(t), R_PX2, None, true, false).unwrap();
        }
        judge
    }

    #[test]
    fn a_single_wild_sighting_is_refused_and_the_prediction_stands() {
        let mut judge = settled();
        judge.predict(1.0, 1.0).unwrap();
        let (_, verdict) = judge.sighted(150.0, R_PX2, None, true, false).unwrap();
        assert_eq!(verdict, Verdict::Refused);
        assert!((judge.position().0 - 120.0).abs() < 0.3);
    }

    #[test]
    fn refused_sightings_that_agree_start_the_filter_anew() {
        let mut judge = settled();
        let mut verdicts = vec![];
        for _ in 40..43 {
            judge.predict(1.0, 1.0).unwrap();
            verdicts.push(judge.sighted(150.0, R_PX2, None, false, false).unwrap().1);
        }
        assert!(matches!(
            verdicts[..],
            [Verdict::Refused, Verdict::Refused, Verdict::Restarted(_, Restart { is_jump: true, .. })]
        ));
        assert!((judge.position().0 - 150.0).abs() < 0.5);
    }

    #[test]
    fn a_corner_that_starts_the_filter_anew_is_no_jump() {
        let mut judge = settled();
        let turned = (1..12).find_map(|t| {
            judge.predict(1.0, 1.0).unwrap();
            let (_, verdict) = judge.sighted(119.5 - 6.0 * f64::from(t), R_PX2, None, false, false).unwrap();
            if let Verdict::Restarted(_, restart) = verdict { Some(restart.is_jump) } else { None }
        });
        assert_eq!(turned, Some(false));
    }

    #[test]
    fn a_picture_tells_the_longer_where_the_seam_is_the_slower_that_moves() {
        // Half a pixel a beat, and 5 px that the prediction may be unsure.
        let judge = settled();
        assert!(judge.outlasts(5.0) && !judge.outlasts(20.0));
    }

    #[test]
    fn a_seam_that_is_long_unseen_is_lost_and_never_found_again_by_one_sighting() {
        let mut judge = settled();
        for _ in 0..=30 {
            judge.predict(1.0, 1.0).unwrap();
            judge.missed();
        }
        assert!(judge.is_exhausted());
        judge.predict(1.0, 1.0).unwrap();
        let (_, verdict) = judge.sighted(judge.position().0, R_PX2, None, true, true).unwrap();
        assert_eq!(verdict, Verdict::Refused);
        assert!(judge.is_exhausted());
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
