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

mod classify;
mod clock;
mod filter;
mod geometry;
mod hairline;
mod history;
mod judge;
mod noise;
mod seed;
mod seek;
mod sighting;

use self::clock::Clock;
use self::geometry::GeometryEye;
use self::hairline::HairlineEye;
use self::history::History;
pub use self::judge::REFUSE_NIS;
use self::judge::{Judge, Measured, Verdict};
use self::noise::NoiseScale;
use self::seek::{Found, Seeker};
use self::sighting::Sighting;
use super::estimate::{Estimate, JointDecision, KcfReading, Observation, SeamEstimate, Status};
use super::{Follow, TrackerError};
use crate::frame::GrayFrame;
use crate::imgproc::geometry::{JointFit, JointKind, Refusal};
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
}

impl Default for RobustSettings {
    fn default() -> Self {
        Self {
            joint: None,
            kcf: KcfSettings { window_width_px: 160, window_height_px: 96, label_sd_px: 3.5, ..KcfSettings::du_2022() },
            learning_rate: 0.03,
            learn_psr_ratio: 0.4,
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

/// How the seam is sighted.
enum Eye {
    Geometry(GeometryEye),
    Hairline(Box<HairlineEye>),
}

impl Eye {
    fn look(
        &mut self,
        frame: &GrayFrame,
        judge: &Judge,
        kcf: &KcfReading,
    ) -> Result<(Sighting, Option<JointFit>), Refusal> {
        match self {
            Self::Geometry(eye) => eye.look(frame, judge, kcf).map(|(sighting, fit)| (sighting, Some(fit))),
            Self::Hairline(eye) => eye.look(frame).map(|sighting| (sighting, None)),
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
}

impl Following {
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
    joint: Option<JointDecision>,
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
            seeker: Seeker::new(settings.joint),
            settings: settings.clone(),
            following: None,
            joint: None,
            clock: Clock::default(),
            history: History::default(),
            noise: NoiseScale::default(),
            last: None,
            frame_number: 0,
        })
    }

    fn seek(&mut self, frame: &GrayFrame) -> Result<Estimate, TrackerError> {
        let status = if self.joint.is_some() { Status::Lost } else { Status::Seeking };
        let (eye, centre, variance_px2, kind, reason) = match self.seeker.look(frame) {
            Found::Nothing { stripe_seen } => {
                self.history.nothing();
                let observation = if stripe_seen { Observation::NoSeam } else { Observation::NoStripe };
                return Ok(Estimate { status, ..Estimate::seeking(observation) });
            }
            Found::Joint { seed, reason } => {
                let (centre, kind) = (seed.fit.centre, seed.model.kind);
                (Eye::Geometry(GeometryEye::new(seed.model)), centre, GEOMETRY_VARIANCE_PX2, kind, reason)
            }
            Found::Hairline { tracker, centre, variance_px2, reason } => {
                (Eye::Hairline(Box::new(HairlineEye::new(*tracker))), centre, variance_px2, JointKind::Butt, reason)
            }
        };
        self.kcf.train(frame, centre);
        self.history.measured(Measured { u_px: centre.u_px, variance_px2 });
        self.noise = NoiseScale::default();
        let judge = Judge::start(centre.u_px, variance_px2)?;
        let following = Following { eye, judge, v_px: centre.v_px, kcf_bias_px: 0.0 };
        let seam = following.seam();
        self.following = Some(following);
        if self.joint.is_none() {
            self.joint = Some(JointDecision { kind: kind.name(), frame: self.frame_number - 1, reason });
        }
        Ok(Estimate { status: Status::Tracked, seam: Some(seam), ..Estimate::seeking(Observation::Seed) })
    }

    fn follow(&mut self, frame: &GrayFrame, frames: f64) -> Result<Estimate, TrackerError> {
        let Some(following) = &mut self.following else { return self.seek(frame) };
        let noise = self.noise.scale();
        following.judge.predict(frames, noise)?;
        let (predicted_u, _) = following.judge.position();
        let mut kcf = ask_kcf(&mut self.kcf, frame, PixelPoint::new(predicted_u, following.v_px));
        let mut estimate = Estimate::seeking(Observation::NoSeam);
        let measured = match following.eye.look(frame, &following.judge, &kcf) {
            Ok((sighting, fit)) => {
                let u_px = sighting.centre.u_px;
                self.noise.push(fit.map(|_| u_px));
                let variance_px2 = noise * sighting.variance_px2;
                let (nis, verdict) = following.judge.sighted(self.clock.now(), u_px, variance_px2, sighting.clear)?;
                estimate.nis = Some(nis);
                let (observation, measured) = match verdict {
                    Verdict::Taken(measured) => (Observation::Geometry, Some(measured)),
                    Verdict::Restarted(measured) => (Observation::Reacquired, Some(measured)),
                    Verdict::Refused => (Observation::Refused, None),
                };
                estimate.observation = observation;
                if measured.is_some() {
                    following.v_px = sighting.centre.v_px;
                    estimate.sides = sighting.sides;
                    if let (Eye::Geometry(eye), Some(fit)) = (&mut following.eye, &fit) {
                        eye.learn(fit);
                    }
                    if kcf.psr_ratio >= self.settings.learn_psr_ratio {
                        let (learned_u, _) = following.judge.position();
                        following.kcf_bias_px += BIAS_RATE * (kcf.peak.u_px - u_px - following.kcf_bias_px);
                        let centre = PixelPoint::new(learned_u, following.v_px);
                        self.kcf.update(frame, centre, self.settings.learning_rate);
                        kcf.template_updated = true;
                    }
                }
                measured
            }
            Err(refusal) => {
                self.noise.push(None);
                estimate.observation = Observation::SightingRefused(refusal);
                following.judge.missed();
                let may_stand_in = matches!(following.eye, Eye::Geometry(_))
                    && kcf.psr_ratio >= LEAST_PSR_RATIO
                    && following.judge.unseen() <= KCF_ALONE_FRAMES
                    && !following.judge.is_lost();
                let mut measured = None;
                if may_stand_in {
                    let weakness = (FULL_PSR_RATIO / kcf.psr_ratio.min(FULL_PSR_RATIO)).powi(4);
                    let u_px = kcf.peak.u_px - following.kcf_bias_px;
                    let (nis, taken) = following.judge.stand_in(u_px, KCF_VARIANCE_PX2 * weakness)?;
                    estimate.nis = Some(nis);
                    if taken.is_some() {
                        estimate.observation = Observation::Kcf;
                    }
                    measured = taken;
                }
                measured
            }
        };
        estimate.kcf = Some(kcf);
        if following.judge.is_lost() {
            estimate.status = Status::Lost;
            if following.judge.should_give_up() {
                self.following = None;
                self.seeker = Seeker::new(self.settings.joint);
            }
        } else {
            estimate.status = if measured.is_some() { Status::Tracked } else { Status::Coasting };
            estimate.seam = Some(following.seam());
        }
        self.history.frame(measured, noise);
        Ok(estimate)
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
        let frame = &median(frame, MedianKernel::Three)?;
        let estimate = self.follow(frame, frames)?;
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
        Ok(self.history.smoothed()?)
    }

    fn joint(&self) -> Option<&JointDecision> {
        self.joint.as_ref()
    }
}
