//! A seam that is followed: in each frame one outcome, which filter, noise memory, template and path are fed from.

use std::collections::VecDeque;

use super::RobustSettings;
use super::correlation::Correlation;
use super::geometry::GeometryEye;
use super::hairline::HairlineEye;
use super::height::Height;
use super::judge::{Judge, Restart, Verdict};
use super::lasting::Lasting;
use super::noise::{NoiseScale, expected_scale};
use super::part::{Part, Parts};
use super::seed::Seed;
use super::sighting::{Sighting, Unsighted};
use crate::calib::Sensor;
use crate::imgproc::Pixels;
use crate::imgproc::geometry::{JointFit, JointKind, PLAIN_REACH_PX, Refusal};
use crate::tracker::TrackerError;
use crate::tracker::estimate::{Estimate, Evidence, KcfReading, Observation, SeamEstimate, Status};
use crate::tracker::hairline::HairlineTracker;
use crate::tracker::lag::Links;
use crate::tracker::path::{Event, Measured, Memory, REMEMBERED};
use crate::tracker::session::unseen;
use crate::tracker::view::View;
use crate::units::PixelPoint;

/// R of a KCF peak at [`FULL_PSR_RATIO`] \[px²\]; it grows with the fourth power as the PSR falls. Prototype.
const KCF_VARIANCE_PX2: f64 = 4.5;
/// The PSR ratio that counts as full: T = 8 of Du 2022 over its ceiling of 14.1.
const FULL_PSR_RATIO: f64 = 0.57;
/// PSR ratio below which a KCF peak is not used at all.
pub const LEAST_PSR_RATIO: f64 = 0.35;
/// For how long the KCF may stand in for a sighting \[beats\]: PSR stays high while a template slides.
const KCF_ALONE_BEATS: f64 = 6.0;
/// Rate at which the KCF's bias against the sightings is learned, a frame.
const BIAS_RATE: f64 = 0.05;
/// How long a plain stripe lies in place of the joint before the joint has ended \[beats\]. Chosen: a tack weld is shorter.
const ENDED_AFTER_BEATS: f64 = 5.0;

/// σ of the prediction above which a seam is lost: 2.7 σ are 1 mm, beyond which a value is wrong \[mm\], and no more than
/// windows can hold, no less than a few noisy sightings leave \[px\].
const LOST_STD_MM: f64 = 0.365;
const LOST_STD_PX: std::ops::RangeInclusive<f64> = 1.2..=5.0;
/// The same for a hairline, whose sightings are sometimes off by more than they claim \[px\]. Tuned.
const HAIRLINE_LOST_STD_PX: f64 = 3.0;

/// The row of a butt joint is that of its plates, drawn on over edges that may be bent: so much of a droop may be hidden in it
/// \[px²\]. Measured: edges that droop by 3.5 px draw it .9 px down. It is the same in every frame, so no filter averages it
/// away, and it belongs to σ alone.
const BUTT_ROW_BIAS_PX2: f64 = 0.8;

/// How the seam is sighted.
enum Eye {
    Geometry(Box<GeometryEye>),
    Hairline(Box<HairlineEye>),
}

/// What is to be done in the next frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// Follow the seam.
    Follow,
    /// It is lost: search it in the whole frame.
    Search,
    /// It has ended, or been lost for too long: seek any joint.
    Seek,
}

/// What became of a frame.
enum Outcome {
    /// The sighting went into the filter, or the filter started anew from it and those before.
    Sighted { sighting: Sighting, measured: Measured, nis: f64, restart: Option<Restart> },
    /// The sighting was too far from the prediction.
    Refused { sighting: Sighting, measured: Measured, nis: f64 },
    /// The correlation filter's peak went into the filter.
    StoodIn { along: (f64, f64), nis: f64, evidence: Evidence },
    /// No sighting, for this reason.
    Unsighted { why: Observation, nis: Option<f64>, evidence: Evidence },
}

/// A seam that is being followed, in its own view of the picture.
pub struct Following {
    view: View,
    eye: Eye,
    judge: Judge,
    height: Height,
    noise: NoiseScale,
    lasting: Lasting,
    parts: Parts,
    /// What no filter can average out of the row \[px²\].
    row_bias_px2: f64,
    /// Mean difference of KCF peak and sighting \[px\].
    kcf_bias_px: f64,
    /// Since the last sighting, how long the stripe has gone straight through \[beats\].
    plain_beats: f64,
    /// What was refused in the last frames and when \[beats\], the newest last: where the seam may have jumped.
    refused: VecDeque<Option<(f64, Measured)>>,
}

impl Following {
    /// Follows a joint with edges or a corner; its first sighting comes with it.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn by_geometry(
        seed: Seed,
        view: View,
        sensor: &Sensor,
        parts: Parts,
    ) -> Result<(Self, Sighting), TrackerError> {
        let row_bias_px2 = if seed.model.kind == JointKind::Butt { BUTT_ROW_BIAS_PX2 } else { 0.0 };
        let kind = seed.model.kind;
        let eye = GeometryEye::new(seed.model, parts);
        let sighting = eye.sighting(seed.fit);
        let scale = mm_per_px(sensor, &view, sighting.centre);
        let lasting = Lasting::new(Some(kind), expected_scale(scale), Some(&seed.fit));
        let eye = Eye::Geometry(Box::new(eye));
        let following = Self::start(eye, &sighting, (scale, *LOST_STD_PX.end()), view, parts)?;
        Ok((Self { row_bias_px2, lasting, ..following }, sighting))
    }

    /// Follows a hairline.
    ///
    /// # Errors
    /// When a number is not finite.
    pub fn by_evidence(
        tracker: HairlineTracker,
        sighting: &Sighting,
        view: View,
        sensor: &Sensor,
        parts: Parts,
    ) -> Result<Self, TrackerError> {
        let eye = Eye::Hairline(Box::new(HairlineEye::new(tracker)));
        let scale = mm_per_px(sensor, &view, sighting.centre);
        let mut following = Self::start(eye, sighting, (scale, HAIRLINE_LOST_STD_PX), view, parts)?;
        following.judge = following.judge.without_doubts();
        Ok(following)
    }

    fn start(
        eye: Eye,
        sighting: &Sighting,
        (mm_per_px, most_std_px): (Option<f64>, f64),
        view: View,
        parts: Parts,
    ) -> Result<Self, TrackerError> {
        let within = |std_px: f64| std_px.clamp(*LOST_STD_PX.start(), most_std_px);
        let lost_std_px = mm_per_px.map_or(most_std_px, |mm_per_px| within(LOST_STD_MM / mm_per_px));
        Ok(Self {
            view,
            eye,
            judge: Judge::start(sighting.centre.u_px, sighting.variance_px2, lost_std_px, parts)?,
            height: Height::start((sighting.centre.v_px, sighting.across_variance_px2))?,
            noise: NoiseScale::new(expected_scale(mm_per_px)),
            lasting: Lasting::new(None, 1.0, None),
            parts,
            row_bias_px2: 0.0,
            kcf_bias_px: 0.0,
            plain_beats: 0.0,
            refused: VecDeque::with_capacity(REMEMBERED + 1),
        })
    }

    /// Goes on with another cross-section: the preparation has changed, the seam has not.
    pub fn change_joint(&mut self, seed: Seed) {
        self.lasting.becomes(seed.model.kind);
        self.eye = Eye::Geometry(Box::new(GeometryEye::new(seed.model, self.parts)));
    }

    /// What no filter can average out of the row \[px²\].
    pub const fn row_bias_px2(&self) -> f64 {
        self.row_bias_px2
    }

    /// The view in which it is followed.
    pub const fn view(&self) -> View {
        self.view
    }

    /// What a fit of another frame shows.
    pub fn sighting(&self, fit: JointFit) -> Option<Sighting> {
        match &self.eye {
            Eye::Geometry(eye) => Some(eye.sighting(fit)),
            Eye::Hairline(_) => None,
        }
    }

    /// From edge to edge as it is known \[px of the picture\]; none of joints without edges.
    pub fn gap_px(&self) -> Option<f64> {
        match &self.eye {
            Eye::Geometry(eye) => Some(eye.gap_px()? * self.view.picture_px()),
            Eye::Hairline(_) => None,
        }
    }

    /// Whether a picture of `beats` ago still tells where the seam is.
    pub fn outlasts(&self, beats: f64) -> bool {
        self.judge.outlasts(beats)
    }

    /// Time since the seam was last sighted \[beats\].
    pub const fn unseen_beats(&self) -> f64 {
        self.judge.unseen_beats()
    }

    /// The seam as it is known, in the view.
    pub fn seam(&self) -> SeamEstimate {
        let ((u_px, _), (v_px, across_px2)) = (self.judge.position(), self.height.reading());
        SeamEstimate {
            centre: PixelPoint::new(u_px, v_px),
            std_px: (self.judge.std_px().powi(2) + self.lasting_px2()).sqrt(),
            std_across_px: (across_px2 + self.row_bias_px2).sqrt(),
        }
    }

    /// The filters' last step.
    pub fn links(&self) -> Links {
        Links {
            view: self.view,
            along: self.judge.link(),
            across: self.height.link(),
            doubt_px2: self.judge.doubt_px2(),
            row_bias_px2: self.row_bias_px2,
            lasting_px2: self.lasting_px2(),
        }
    }

    /// What no filter averages out of the place along the stripe \[px²\].
    fn lasting_px2(&self) -> f64 {
        self.lasting.variance_px2(self.height.shaking_px2())
    }

    /// Whether beside a leg a second line runs that may be the leg itself.
    pub fn has_rival_line(&self) -> bool {
        self.lasting.has_rival()
    }

    /// Whether what is sighted is fixed to the picture, and no seam.
    pub fn is_fixed(&self) -> bool {
        self.lasting.is_fixed(self.height.shaking_px2())
    }

    /// One frame further by `beats`; `is_lost` when the seam is to be searched in the whole frame.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn step(
        &mut self,
        frame: &mut impl Pixels,
        beats: f64,
        is_lost: bool,
        kcf: &mut Correlation,
        settings: &RobustSettings,
    ) -> Result<(Estimate, Next), TrackerError> {
        let noise = self.predict(beats)?;
        let around = self.seam().centre;
        let mut reading = kcf.near(frame, around);
        let seen = match &mut self.eye {
            Eye::Geometry(eye) if is_lost => eye.search(frame, &self.judge),
            Eye::Geometry(eye) => eye.look(frame, &self.judge, &reading).or_else(|unsighted| {
                // It may have gone out of the small window.
                let wide = kcf.wide(frame, around);
                let sighting = eye.look_at_peak(frame, &self.judge, &wide).map_err(|_| unsighted)?;
                reading = wide;
                Ok(sighting)
            }),
            Eye::Hairline(eye) if is_lost => eye.search(frame.whole()),
            Eye::Hairline(eye) => eye.look(frame.whole()),
        };
        let outcome = match seen {
            Ok(sighting) => self.judge_sighting(sighting, &reading, noise, is_lost)?,
            Err(unsighted) => self.do_without(frame, unsighted, beats, is_lost, &reading)?,
        };
        self.take_over(&outcome)?;
        let sighted = match &outcome {
            Outcome::Sighted { measured, .. } => Some(measured.along.0),
            _ => None,
        };
        let may_learn = sighted.is_some() || !self.parts.has(Part::LearningGate);
        if reading.psr_ratio >= settings.learn_psr_ratio && may_learn {
            kcf.update(frame, self.seam().centre, settings.learning_rate);
            reading.template_updated = true;
            if let Some(u_px) = sighted {
                self.kcf_bias_px += BIAS_RATE * (reading.peak.u_px - u_px - self.kcf_bias_px);
            }
        }
        Ok(self.conclude(outcome, Some(reading), noise, beats, is_lost))
    }

    /// A frame that shows nothing, for the reason `why`.
    ///
    /// # Errors
    /// When a covariance breaks down.
    pub fn miss(&mut self, why: Observation, beats: f64, is_lost: bool) -> Result<(Estimate, Next), TrackerError> {
        let noise = self.predict(beats)?;
        self.judge.missed();
        let outcome = Outcome::Unsighted { why, nis: None, evidence: Evidence::NONE };
        self.take_over(&outcome)?;
        Ok(self.conclude(outcome, None, noise, beats, is_lost))
    }

    fn predict(&mut self, beats: f64) -> Result<f64, TrackerError> {
        let noise = if self.parts.has(Part::NoiseScale) { self.noise.scale() } else { 1.0 };
        self.judge.predict(beats, noise)?;
        self.height.predict(beats)?;
        Ok(noise)
    }

    /// The frame shows the seam: it goes into the filter, or is refused.
    fn judge_sighting(
        &mut self,
        sighting: Sighting,
        kcf: &KcfReading,
        noise: f64,
        is_lost: bool,
    ) -> Result<Outcome, TrackerError> {
        let measured = sighting.measured(noise);
        let (u_px, variance_px2) = measured.along;
        let away_px = (kcf.peak.u_px - self.kcf_bias_px - u_px).abs();
        let witness = (kcf.psr_ratio >= LEAST_PSR_RATIO).then_some(away_px);
        let (nis, verdict) = self.judge.sighted(u_px, variance_px2, witness, sighting.clear, is_lost)?;
        let (used_px2, restart) = match verdict {
            Verdict::Taken(used_px2) => (used_px2, None),
            Verdict::Restarted(used_px2, restart) => (used_px2, Some(restart)),
            Verdict::Refused => return Ok(Outcome::Refused { sighting, measured, nis }),
        };
        let measured = Measured { along: (u_px, used_px2), ..measured };
        Ok(Outcome::Sighted { sighting, measured, nis, restart })
    }

    /// The frame shows no seam to be trusted: the correlation filter may stand in for a while.
    fn do_without(
        &mut self,
        frame: &mut impl Pixels,
        unsighted: Unsighted,
        beats: f64,
        is_lost: bool,
        kcf: &KcfReading,
    ) -> Result<Outcome, TrackerError> {
        self.judge.missed();
        let evidence = unsighted.evidence;
        let Eye::Geometry(eye) = &self.eye else {
            return Ok(Outcome::Unsighted {
                why: Observation::SightingRefused(unsighted.refusal),
                nis: None,
                evidence,
            });
        };
        // Only where the seam must be does a plain stripe say that it has ended.
        let is_sure = 2.0 * self.judge.position().1.sqrt() <= PLAIN_REACH_PX;
        if is_sure && eye.sees_plain_stripe(frame, self.seam().centre) {
            self.plain_beats += beats;
            return Ok(Outcome::Unsighted { why: Observation::SightingRefused(Refusal::Plain), nis: None, evidence });
        }
        let why = Observation::SightingRefused(unsighted.refusal);
        let may_stand_in = self.parts.has(Part::KcfStandIn)
            && kcf.psr_ratio >= LEAST_PSR_RATIO
            && self.judge.unseen_beats() <= KCF_ALONE_BEATS
            && !is_lost
            && !self.judge.is_exhausted();
        if !may_stand_in {
            return Ok(Outcome::Unsighted { why, nis: None, evidence });
        }
        let weakness = (FULL_PSR_RATIO / kcf.psr_ratio.min(FULL_PSR_RATIO)).powi(4);
        let u_px = kcf.peak.u_px - self.kcf_bias_px;
        let (nis, taken) = self.judge.stand_in(u_px, KCF_VARIANCE_PX2 * weakness)?;
        Ok(match taken {
            Some(used_px2) => Outcome::StoodIn { along: (u_px, used_px2), nis, evidence },
            None => Outcome::Unsighted { why, nis: Some(nis), evidence },
        })
    }

    /// What the outcome teaches height, noise and eye.
    fn take_over(&mut self, outcome: &Outcome) -> Result<(), TrackerError> {
        let fit = match outcome {
            Outcome::Sighted { sighting, .. } | Outcome::Refused { sighting, .. } => sighting.fit.as_ref(),
            Outcome::StoodIn { .. } | Outcome::Unsighted { .. } => None,
        };
        self.noise.push(fit.map(|fit| fit.centre.u_px));
        self.lasting.push(fit);
        let Outcome::Sighted { sighting, measured, .. } = outcome else { return self.height.update(None) };
        self.plain_beats = 0.0;
        if let (Eye::Geometry(eye), Some(fit)) = (&mut self.eye, &sighting.fit) {
            eye.learn(fit);
        }
        self.height.update(measured.across)
    }

    /// Where the seam was in the frames before this one, if it has jumped on to `restart`; forgets what was refused unless
    /// this frame was too.
    fn before(&mut self, outcome: &Outcome) -> Option<[Option<Measured>; REMEMBERED]> {
        let now = self.judge.now_beats();
        let before = match outcome {
            Outcome::Sighted { restart, .. } => restart.filter(|restart| restart.is_jump).map(|restart| {
                let held = |&(at, measured): &(f64, Measured)| restart.holds(measured.along.0, now - at);
                let mut newest = self.refused.iter().rev().map(|refused| refused.filter(held).map(|(_, m)| m));
                std::array::from_fn(|_| newest.next().flatten())
            }),
            Outcome::Refused { .. } | Outcome::StoodIn { .. } | Outcome::Unsighted { .. } => None,
        };
        self.refused.push_back(match outcome {
            Outcome::Refused { measured, .. } => Some((now, *measured)),
            _ => None,
        });
        if self.refused.len() > REMEMBERED {
            self.refused.pop_front();
        }
        before
    }

    /// The estimate, and what comes next.
    fn conclude(
        &mut self,
        outcome: Outcome,
        kcf: Option<KcfReading>,
        noise: f64,
        beats: f64,
        was_lost: bool,
    ) -> (Estimate, Next) {
        let found = matches!(outcome, Outcome::Sighted { .. });
        let jumped_from = self.before(&outcome);
        let has_ended = self.plain_beats >= ENDED_AFTER_BEATS || self.is_fixed();
        let is_lost = !found && (was_lost || self.judge.is_exhausted());
        let next = match (has_ended || (is_lost && self.judge.should_give_up()), is_lost) {
            (true, _) => Next::Seek,
            (false, true) => Next::Search,
            (false, false) => Next::Follow,
        };
        let (observation, nis, evidence, section, measured) = match outcome {
            Outcome::Sighted { sighting, measured, nis, restart } => {
                let observation = if restart.is_some() { Observation::Reacquired } else { Observation::Geometry };
                let section = sighting.section.map(|section| section.with_noise(self.noise.scale()));
                (observation, Some(nis), sighting.evidence, section, Some(measured))
            }
            Outcome::Refused { sighting, nis, .. } => (Observation::Refused, Some(nis), sighting.evidence, None, None),
            Outcome::StoodIn { along, nis, evidence } => {
                let measured = Measured { along, across: None };
                (Observation::Kcf, Some(nis), evidence, None, Some(measured))
            }
            Outcome::Unsighted { why, nis, evidence } => (why, nis, evidence, None, None),
        };
        let jump = jumped_from.zip(measured);
        let event = match next {
            Next::Seek if has_ended => Event::Ended,
            Next::Seek | Next::Search => Event::Lost,
            Next::Follow => match jump {
                Some((before, measured)) => {
                    Event::Found { view: self.view, measured, before, row_bias_px2: self.row_bias_px2 }
                }
                None => {
                    let (shaking_px2, lasting_px2) = (self.height.shaking_px2(), self.lasting_px2());
                    Event::Followed { measured, noise, shaking_px2, lasting_px2 }
                }
            },
        };
        let has_value = next == Next::Follow && !self.judge.is_doubtful();
        let estimate = Estimate {
            status: if has_value && measured.is_some() { Status::Tracked } else { unseen(!has_value) },
            seam: has_value.then(|| self.seam()),
            kcf,
            nis,
            evidence,
            section,
            memory: Memory { beats, event },
            ..Estimate::seeking(observation)
        };
        (estimate, next)
    }
}

/// Millimetres along the stripe of a pixel of the view at `place`, where they are known.
fn mm_per_px(sensor: &Sensor, view: &View, place: PixelPoint) -> Option<f64> {
    let mm_per_px = sensor.scale_along(view.picture_from_view(place), view.axis())?.abs() * view.picture_px();
    sensor.has_millimetres().then_some(mm_per_px)
}
