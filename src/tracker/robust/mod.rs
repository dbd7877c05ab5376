//! The robust method: stripe geometry, or evidence of a hairline, as the main observation; the KCF as the fallback;
//! interacting models as the filter; and judgement between them. The search is centred on the prediction, and a value is
//! never reported as valid because the tracker could not tell.
//!
//! | file | what it does |
//! |---|---|
//! | `seek`, `seed`, `classify` | finds the joint and its kind in whole frames |
//! | `geometry`, `hairline`, `sighting` | one frame's own view of the seam |
//! | `judge`, `filter`, `noise`, `clock` | what a sighting is worth, and the estimate |
//! | `history` | all that was accepted, for the smoother |
//! | `part` | what an ablation takes away |

mod classify;
mod clock;
mod filter;
mod geometry;
mod hairline;
mod history;
mod judge;
mod noise;
mod part;
mod seed;
mod seek;
mod sighting;

use self::clock::Clock;
use self::geometry::GeometryEye;
use self::hairline::HairlineEye;
use self::history::History;
pub use self::judge::REFUSE_NIS;
use self::judge::{HAIRLINE_LOST_STD_PX, Judge, LOST_STD_PX, Measured, Verdict};
use self::noise::NoiseScale;
pub use self::part::{Part, Parts};
use self::seek::{Found, Seeker};
use self::sighting::{Sighting, Unsighted};
use super::estimate::{Estimate, JointDecision, KcfReading, Observation, SeamEstimate, Status};
use super::{Follow, TrackerError};
use crate::frame::GrayFrame;
use crate::imgproc::geometry::{JointKind, Refusal};
use crate::imgproc::{MedianKernel, median};
use crate::kcf::{Kcf, KcfSettings};
use crate::units::PixelPoint;

/// The numbers of the robust method.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustSettings {
    /// The joint to follow; found from the frames when it is not given.
    pub joint: Option<JointKind>,
    /// The correlation filter.
    pub kcf: KcfSettings,
    /// Learning rate η of its template.
    pub learning_rate: f64,
    /// PSR over its ceiling at which the template may learn.
    pub learn_psr_ratio: f64,
    /// Frames that the smoother may look ahead; the whole recording when it is not given.
    pub fixed_lag: Option<usize>,
    /// The parts of the method; all of them but for an ablation.
    pub parts: Parts,
}

impl Default for RobustSettings {
    fn default() -> Self {
        Self {
            joint: None,
            kcf: KcfSettings { window_width_px: 160, window_height_px: 96, label_sd_px: 3.5, ..KcfSettings::du_2022() },
            learning_rate: 0.03,
            learn_psr_ratio: 0.4,
            fixed_lag: None,
            parts: Parts::default(),
        }
    }
}

/// R of an accepted geometry fit \[px²\]. Prototype.
const GEOMETRY_VARIANCE_PX2: f64 = 0.1;
/// R of a KCF peak at [`FULL_PSR_RATIO`] \[px²\]; it grows with the fourth power as the PSR falls. Prototype.
const KCF_VARIANCE_PX2: f64 = 4.5;
/// The PSR ratio that counts as full: T = 8 of Du 2022 over its ceiling of 14.1.
const FULL_PSR_RATIO: f64 = 0.57;
/// PSR ratio below which a KCF peak is not used at all.
const LEAST_PSR_RATIO: f64 = 0.35;
/// Frames in a row for which the KCF may stand in for a sighting: PSR stays high while a template slides.
const KCF_ALONE_FRAMES: u32 = 6;
/// Rate at which the KCF's bias against the sightings is learned.
const BIAS_RATE: f64 = 0.05;

/// Frames with a plain stripe in place of the joint after which the joint has ended. Chosen: a tack weld is shorter.
const ENDED_AFTER: u32 = 5;

/// How the seam is sighted.
enum Eye {
    Geometry(GeometryEye),
    Hairline(Box<HairlineEye>),
}

impl Eye {
    fn look(&mut self, frame: &GrayFrame, judge: &Judge, kcf: &KcfReading) -> Result<Sighting, Unsighted> {
        match self {
            Self::Geometry(eye) => eye.look(frame, judge, kcf),
            Self::Hairline(eye) => eye.look(frame),
        }
    }
}

/// A seam that is being followed.
struct Following {
    eye: Eye,
    judge: Judge,
    /// Row of the seam when it was last sighted \[px\].
    v_px: f64,
    /// Mean difference of KCF peak and sighting \[px\].
    kcf_bias_px: f64,
    /// Frames since the last sighting in which the stripe went straight through.
    plain_frames: u32,
}

impl Following {
    /// Whether the stripe goes straight through where the joint should be; counts such frames.
    fn sees_plain_stripe(&mut self, frame: &GrayFrame) -> bool {
        let place = self.seam().centre;
        let plain = matches!(&self.eye, Eye::Geometry(eye) if eye.sees_plain_stripe(frame, place));
        self.plain_frames += u32::from(plain);
        plain
    }

    fn seam(&self) -> SeamEstimate {
        let (u_px, _) = self.judge.position();
        SeamEstimate { centre: PixelPoint::new(u_px, self.v_px), std_px: self.judge.std_px() }
    }
}

/// The robust tracker, on frames of which the stripe is horizontal.
pub struct RobustTracker {
    settings: RobustSettings,
    kcf: Kcf,
    seeker: Seeker,
    following: Option<Following>,
    joints: Vec<JointDecision>,
    clock: Clock,
    history: History,
    noise: NoiseScale,
    last: Option<Estimate>,
    frame_number: usize,
}

impl RobustTracker {
    /// A tracker that looks for its seam.
    ///
    /// # Errors
    /// When a KCF setting is out of range.
    pub fn new(settings: &RobustSettings) -> Result<Self, TrackerError> {
        Ok(Self {
            kcf: Kcf::new(settings.kcf)?,
            seeker: Seeker::new(settings.joint, settings.parts),
            settings: settings.clone(),
            following: None,
            joints: vec![],
            clock: Clock::default(),
            history: History::new(settings.parts),
            noise: NoiseScale::default(),
            last: None,
            frame_number: 0,
        })
    }

    fn seek(&mut self, frame: &GrayFrame) -> Result<Estimate, TrackerError> {
        let status = if self.joints.is_empty() { Status::Seeking } else { Status::Lost };
        let (eye, sighting, kind, reason) = match self.seeker.look(frame) {
            Found::Nothing { stripe_seen, evidence } => {
                self.history.nothing();
                let observation = if stripe_seen { Observation::NoSeam } else { Observation::NoStripe };
                return Ok(Estimate { status, evidence, ..Estimate::seeking(observation) });
            }
            Found::Joint { seed, reason } => {
                let (kind, eye) = (seed.model.kind, GeometryEye::new(seed.model, self.settings.parts));
                let sighting = eye.sighting(seed.fit);
                (Eye::Geometry(eye), sighting, kind, reason)
            }
            Found::Hairline { tracker, sighting, reason } => {
                (Eye::Hairline(Box::new(HairlineEye::new(*tracker))), *sighting, JointKind::Butt, reason)
            }
        };
        let Sighting { centre, variance_px2, evidence, section, .. } = sighting;
        self.kcf.train(frame, centre);
        self.history.found(Measured { u_px: centre.u_px, variance_px2 });
        self.noise = NoiseScale::default();
        let lost_std_px = match &eye {
            Eye::Geometry(_) => LOST_STD_PX,
            Eye::Hairline(_) => HAIRLINE_LOST_STD_PX,
        };
        let judge = Judge::start(centre.u_px, variance_px2, lost_std_px, self.settings.parts)?;
        let following = Following { eye, judge, v_px: centre.v_px, kcf_bias_px: 0.0, plain_frames: 0 };
        let seam = Some(following.seam());
        self.following = Some(following);
        self.joints.push(JointDecision { kind: kind.name(), frame: self.frame_number - 1, reason });
        let seeking = Estimate::seeking(Observation::Seed);
        Ok(Estimate { status: Status::Tracked, seam, evidence, section, ..seeking })
    }

    fn follow(&mut self, frame: &GrayFrame, frames: f64) -> Result<Estimate, TrackerError> {
        let Some(mut following) = self.following.take() else { return self.seek(frame) };
        let noise = if self.settings.parts.has(Part::NoiseScale) { self.noise.scale() } else { 1.0 };
        following.judge.predict(frames, noise)?;
        let (predicted_u, _) = following.judge.position();
        let mut kcf = ask_kcf(&mut self.kcf, frame, PixelPoint::new(predicted_u, following.v_px));
        let mut estimate = Estimate::seeking(Observation::NoSeam);
        let measured = match following.eye.look(frame, &following.judge, &kcf) {
            Ok(sighting) => self.judge_sighting(&mut following, &sighting, noise, &mut estimate)?,
            Err(unsighted) if following.sees_plain_stripe(frame) => {
                self.noise.push(None);
                following.judge.missed();
                estimate.observation = Observation::SightingRefused(Refusal::Plain);
                estimate.evidence = unsighted.evidence;
                None
            }
            Err(unsighted) => self.do_without(&mut following, unsighted, &kcf, &mut estimate)?,
        };
        let sighted = measured.is_some() && estimate.observation != Observation::Kcf;
        if kcf.psr_ratio >= self.settings.learn_psr_ratio && (sighted || !self.settings.parts.has(Part::LearningGate)) {
            let centre = following.seam().centre;
            self.kcf.update(frame, centre, self.settings.learning_rate);
            kcf.template_updated = true;
        }
        if let (true, true, Some(measured)) = (sighted, kcf.template_updated, measured) {
            following.kcf_bias_px += BIAS_RATE * (kcf.peak.u_px - measured.u_px - following.kcf_bias_px);
        }
        estimate.kcf = Some(kcf);
        self.history.frame(measured, noise);
        let has_ended = following.plain_frames >= ENDED_AFTER;
        if has_ended || following.judge.is_lost() {
            estimate.status = Status::Lost;
            if has_ended { self.history.ended() } else { self.history.lost() }
        } else {
            estimate.status = if measured.is_some() { Status::Tracked } else { Status::Coasting };
            estimate.seam = Some(following.seam());
        }
        if has_ended || following.judge.should_give_up() {
            self.seeker = Seeker::new(self.settings.joint, self.settings.parts);
        } else {
            self.following = Some(following);
        }
        Ok(estimate)
    }

    /// The frame shows the seam: it goes into the filter, or is refused.
    fn judge_sighting(
        &mut self,
        following: &mut Following,
        sighting: &Sighting,
        noise: f64,
        estimate: &mut Estimate,
    ) -> Result<Option<Measured>, TrackerError> {
        let u_px = sighting.centre.u_px;
        self.noise.push(sighting.fit.map(|_| u_px));
        let variance_px2 = noise * sighting.variance_px2;
        let (nis, verdict) = following.judge.sighted(self.clock.now(), u_px, variance_px2, sighting.clear)?;
        estimate.nis = Some(nis);
        estimate.evidence = sighting.evidence;
        let (observation, measured) = match verdict {
            Verdict::Taken(measured) => (Observation::Geometry, Some(measured)),
            Verdict::Restarted(measured) => (Observation::Reacquired, Some(measured)),
            Verdict::Refused => (Observation::Refused, None),
        };
        estimate.observation = observation;
        if measured.is_some() {
            following.v_px = sighting.centre.v_px;
            following.plain_frames = 0;
            estimate.section = sighting.section;
            if let (Eye::Geometry(eye), Some(fit)) = (&mut following.eye, &sighting.fit) {
                eye.learn(fit);
            }
        }
        Ok(measured)
    }

    /// The frame shows no seam to be trusted: the correlation filter may stand in for a while.
    fn do_without(
        &mut self,
        following: &mut Following,
        unsighted: Unsighted,
        kcf: &KcfReading,
        estimate: &mut Estimate,
    ) -> Result<Option<Measured>, TrackerError> {
        self.noise.push(None);
        estimate.observation = Observation::SightingRefused(unsighted.refusal);
        estimate.evidence = unsighted.evidence;
        following.judge.missed();
        let may_stand_in = matches!(following.eye, Eye::Geometry(_))
            && self.settings.parts.has(Part::KcfStandIn)
            && kcf.psr_ratio >= LEAST_PSR_RATIO
            && following.judge.unseen() <= KCF_ALONE_FRAMES
            && !following.judge.is_lost();
        if !may_stand_in {
            return Ok(None);
        }
        let weakness = (FULL_PSR_RATIO / kcf.psr_ratio.min(FULL_PSR_RATIO)).powi(4);
        let u_px = kcf.peak.u_px - following.kcf_bias_px;
        let (nis, taken) = following.judge.stand_in(u_px, KCF_VARIANCE_PX2 * weakness)?;
        estimate.nis = Some(nis);
        if taken.is_some() {
            estimate.observation = Observation::Kcf;
        }
        Ok(taken)
    }
}

fn ask_kcf(kcf: &mut Kcf, frame: &GrayFrame, around: PixelPoint) -> KcfReading {
    let response = kcf.detect(frame, around);
    KcfReading {
        peak: response.peak,
        psr: response.psr.into(),
        psr_ratio: response.psr_ratio().into(),
        template_updated: false,
    }
}

impl Follow for RobustTracker {
    fn seed_at(&mut self, centre: PixelPoint) {
        self.seeker.seed_at(centre);
    }

    fn step(&mut self, frame: &GrayFrame, time_s: f64, repeated: bool) -> Result<Estimate, TrackerError> {
        self.frame_number += 1;
        if repeated && let Some(last) = self.last {
            self.clock.skip(time_s);
            self.history.repeated();
            let kcf = last.kcf.map(|kcf| KcfReading { template_updated: false, ..kcf });
            return Ok(Estimate { kcf, ..last });
        }
        let frames = self.clock.tick(time_s);
        self.history.step(frames);
        let kernel = if self.settings.parts.has(Part::Median) { MedianKernel::Three } else { MedianKernel::Off };
        let estimate = self.follow(&median(frame, kernel)?, frames)?;
        self.last = Some(estimate);
        Ok(estimate)
    }

    fn miss(&mut self, time_s: f64) -> Result<(), TrackerError> {
        self.frame_number += 1;
        let frames = self.clock.tick(time_s);
        self.history.step(frames);
        self.history.nothing();
        self.noise.push(None);
        if let Some(following) = &mut self.following {
            following.judge.predict(frames, self.noise.scale())?;
            following.judge.missed();
        }
        Ok(())
    }

    fn smoothed(&self) -> Result<Vec<Option<(f64, f64)>>, TrackerError> {
        Ok(self.history.smoothed(self.settings.fixed_lag)?)
    }

    fn joints(&self) -> &[JointDecision] {
        &self.joints
    }
}
