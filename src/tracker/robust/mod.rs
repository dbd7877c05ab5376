//! The robust method: stripe geometry as the main observation, the KCF as the fallback, interacting models as the
//! filter, and judgement between them. The search is centred on the prediction; a value is never reported as valid
//! because the tracker could not tell.

mod filter;
mod history;
mod noise;
mod seed;

use self::filter::{SeamFilter, VIBRATION_VARIANCE_PX2};
use self::history::{History, Measured};
use self::noise::NoiseScale;
use self::seed::Seed;
use super::estimate::{Estimate, KcfReading, Observation, SeamEstimate, Status};
use super::{Follow, TrackerError};
use crate::frame::GrayFrame;
use crate::imgproc::geometry::{HALF_WINDOW_PX, JointFit, JointKind, JointModel, Line, Refusal};
use crate::imgproc::{MedianKernel, median};
use crate::kcf::{Kcf, KcfSettings};
use crate::units::PixelPoint;

/// The numbers of the robust method.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustSettings {
    /// The joint to follow.
    pub joint: JointKind,
    /// The correlation filter.
    pub kcf: KcfSettings,
    /// Learning rate η of its template.
    pub learning_rate: f64,
    /// PSR over its ceiling at which the template may learn; T = 8 of Du 2022 is 0.57 of the ceiling.
    pub learn_psr_ratio: f64,
}

impl Default for RobustSettings {
    fn default() -> Self {
        Self {
            joint: JointKind::Butt,
            kcf: KcfSettings { window_width_px: 160, window_height_px: 96, label_sd_px: 3.5, ..KcfSettings::du_2022() },
            learning_rate: 0.03,
            learn_psr_ratio: 0.4,
        }
    }
}

/// R of an accepted geometry fit \[px²\]. Prototype.
const GEOMETRY_VARIANCE_PX2: f64 = 0.1;
/// R of a KCF peak at full PSR \[px²\]; it grows with the fourth power as the PSR falls. Prototype.
const KCF_VARIANCE_PX2: f64 = 4.5;
/// PSR ratio below which a KCF peak is not used at all.
const LEAST_PSR_RATIO: f64 = 0.35;
/// Frames in a row for which the KCF may stand in for the geometry: PSR stays high while a template slides.
const KCF_ALONE_FRAMES: u32 = 6;
/// NIS above which a measurement is refused, and above which it is used with an inflated R. Prototype.
const REFUSE_NIS: f64 = 16.0;
const INFLATE_NIS: f64 = 4.0;
/// Refused measurements that agree with each other and make the filter start anew. Prototype.
const AGREEING_REFUSALS: usize = 3;
/// As many are enough when each is clear by itself.
const AGREEING_CLEAR_REFUSALS: usize = 2;
/// How far they may lie from one straight line \[px\], and its steepest slope \[px/frame\].
const AGREEMENT_PX: f64 = 1.5;
const STEEPEST_SLOPE_PX: f64 = 8.0;
/// σ of the prediction above which the seam is lost \[px\]: 2.5 σ are 1 mm at 0.073 mm/px.
const LOST_STD_PX: f64 = 5.0;
/// Frames without geometry after which the seam is lost.
const LOST_FRAMES: u32 = 30;

/// A geometry fit refused for its NIS.
#[derive(Debug, Clone, Copy)]
struct Refused {
    frame: f64,
    u_px: f64,
    clear: bool,
}

/// A seam that is being followed.
struct Following {
    model: JointModel,
    filter: SeamFilter,
    /// Row of the seam when it was last seen \[px\].
    v_px: f64,
    /// Frames since the geometry was last accepted.
    unseen: u32,
    refused: Vec<Refused>,
    /// Mean difference of KCF peak and geometry \[px\].
    kcf_bias_px: f64,
    lost: bool,
}

/// The robust tracker, on frames of which the stripe is horizontal.
pub struct RobustTracker {
    settings: RobustSettings,
    kcf: Kcf,
    seed_at: Option<PixelPoint>,
    following: Option<Following>,
    pending: Vec<Seed>,
    clock: Clock,
    history: History,
    noise: NoiseScale,
    /// Sum and number of the noise scales in use, for the smoother.
    noise_used: (f64, f64),
    last: Option<Estimate>,
}

/// Time in frames: the recording's shortest step is one.
#[derive(Debug, Default)]
struct Clock {
    last_s: Option<f64>,
    period_s: Option<f64>,
    frames: f64,
}

impl Clock {
    /// Frames since the last call, at least one.
    fn tick(&mut self, time_s: f64) -> f64 {
        let step_s = self.last_s.map(|last_s| time_s - last_s).filter(|step| *step > 0.0);
        self.last_s = Some(time_s);
        let Some(step_s) = step_s else { return 1.0 };
        let period_s = self.period_s.map_or(step_s, |period| period.min(step_s));
        self.period_s = Some(period_s);
        let frames = (step_s / period_s).max(1.0);
        self.frames += frames;
        frames
    }
}

impl RobustTracker {
    /// A tracker that looks for its seed.
    ///
    /// # Errors
    /// When a KCF setting is out of range.
    pub fn new(settings: &RobustSettings) -> Result<Self, TrackerError> {
        Ok(Self {
            kcf: Kcf::new(settings.kcf)?,
            settings: settings.clone(),
            seed_at: None,
            following: None,
            pending: vec![],
            clock: Clock::default(),
            history: History::default(),
            noise: NoiseScale::default(),
            noise_used: (0.0, 0.0),
            last: None,
        })
    }

    fn seek(&mut self, frame: &GrayFrame) -> Result<Estimate, TrackerError> {
        let asked = self.seed_at;
        let (stripe_seen, seed) = seed::find(frame, self.settings.joint, asked);
        let Some(seed) = seed else {
            self.pending.clear();
            self.history.nothing();
            return Ok(Estimate::seeking(if stripe_seen { Observation::NoSeam } else { Observation::NoStripe }));
        };
        let confirmed = seed.clear || {
            let near = |other: &Seed| (other.fit.centre.u_px - seed.fit.centre.u_px).abs() < 8.0;
            self.pending.retain(near);
            self.pending.push(seed.clone());
            self.pending.len() >= 3
        };
        if !confirmed {
            self.history.nothing();
            return Ok(Estimate::seeking(Observation::NoSeam));
        }
        self.pending.clear();
        let centre = seed.fit.centre;
        self.kcf.train(frame, centre);
        self.history.measured(Measured { u_px: centre.u_px, variance_px2: GEOMETRY_VARIANCE_PX2 });
        let variance = filter::COLOUR_VARIANCE_PX2 + GEOMETRY_VARIANCE_PX2;
        let following = Following {
            model: seed.model,
            filter: SeamFilter::start(centre.u_px, 0.0, [variance, 1.0])?,
            v_px: centre.v_px,
            unseen: 0,
            refused: vec![],
            kcf_bias_px: 0.0,
            lost: false,
        };
        let seam = following.seam();
        self.following = Some(following);
        Ok(Estimate { status: Status::Tracked, seam: Some(seam), ..Estimate::seeking(Observation::Seed) })
    }
}

impl Following {
    fn seam(&self) -> SeamEstimate {
        let (u_px, variance) = self.filter.position();
        let std_px = (variance + VIBRATION_VARIANCE_PX2).sqrt();
        SeamEstimate { centre: PixelPoint::new(u_px, self.v_px), std_px }
    }

    /// The best geometry fit near the prediction, or near the KCF's peak where that is elsewhere.
    fn geometry(&self, frame: &GrayFrame, u_px: f64, variance_px2: f64, kcf: &KcfReading) -> Result<JointFit, Refusal> {
        let search_px = 12.0 + (2.5 * (variance_px2 - 1.0).max(0.0).sqrt()).min(18.0);
        let kcf_dv_px = {
            let dv = kcf.peak.v_px - self.model.seam_v_px();
            if dv.abs() > 25.0 { 0.0 } else { dv }
        };
        let mut places = vec![(u_px, 0.0)];
        if kcf.psr_ratio >= LEAST_PSR_RATIO && ((kcf.peak.u_px - u_px).abs() > 4.0 || self.unseen > 0) {
            places.push((kcf.peak.u_px, kcf_dv_px));
        }
        if self.unseen > 1 && kcf.psr_ratio >= LEAST_PSR_RATIO {
            places.push((u_px, kcf_dv_px));
        }
        let mut best: Result<(f64, JointFit), Refusal> = Err(Refusal::NoLine);
        for (place_u, dv) in places {
            let fit = self.model.fit(frame, place_u, dv, search_px).and_then(JointFit::judged);
            match fit {
                Err(refusal) => {
                    if best.is_err() {
                        best = Err(refusal);
                    }
                }
                Ok(fit) => {
                    let badness = fit.edges.map_or(fit.residual_px, |edges| edges.cost);
                    let away = if self.unseen < 5 { 0.002 * (fit.centre.u_px - u_px).abs() } else { 0.0 };
                    if best.as_ref().map_or(true, |(least, _)| badness + away < *least) {
                        best = Ok((badness + away, fit));
                    }
                }
            }
        }
        best.map(|(_, fit)| fit)
    }

    /// Takes a measurement into the filter if its NIS allows it.
    fn take(&mut self, u_px: f64, variance_px2: f64, always: bool) -> Result<(f64, Option<Measured>), TrackerError> {
        let nis = self.filter.nis(u_px, variance_px2)?;
        if nis > REFUSE_NIS && !always {
            return Ok((nis, None));
        }
        let variance_px2 = variance_px2 * (nis / INFLATE_NIS).max(1.0);
        self.filter.update(u_px, variance_px2)?;
        Ok((nis, Some(Measured { u_px, variance_px2 })))
    }

    /// Whether the last refused fits agree on a straight path: its position and slope now.
    fn agreement(&self, now: f64) -> Option<(f64, f64)> {
        let recent: Vec<&Refused> = self.refused.iter().rev().take(4).filter(|r| r.frame >= now - 4.0).collect();
        let clear = recent.iter().filter(|r| r.clear).count() == recent.len();
        let needed = if clear && !self.lost { AGREEING_CLEAR_REFUSALS } else { AGREEING_REFUSALS };
        if recent.len() < needed {
            return None;
        }
        let n = recent.len() as f64;
        let (mt, mu) =
            (recent.iter().map(|r| r.frame - now).sum::<f64>() / n, recent.iter().map(|r| r.u_px).sum::<f64>() / n);
        let spread: f64 = recent.iter().map(|r| (r.frame - now - mt).powi(2)).sum();
        let slope = recent.iter().map(|r| (r.frame - now - mt) * (r.u_px - mu)).sum::<f64>() / spread;
        let at = |r: &Refused| mu + slope * (r.frame - now - mt);
        let close = recent.iter().all(|r| (r.u_px - at(r)).abs() < AGREEMENT_PX);
        (close && slope.abs() < STEEPEST_SLOPE_PX).then_some((mu - slope * mt, slope))
    }
}

impl RobustTracker {
    fn follow(&mut self, frame: &GrayFrame, frames: f64) -> Result<Estimate, TrackerError> {
        let now = self.clock.frames;
        let Some(following) = &mut self.following else { return self.seek(frame) };
        let noise = self.noise.scale();
        self.noise_used = (self.noise_used.0 + noise, self.noise_used.1 + 1.0);
        following.filter.set_noise(noise);
        following.filter.predict(frames)?;
        let (predicted_u, variance) = following.filter.position();
        let response = self.kcf.detect(frame, PixelPoint::new(predicted_u, following.v_px));
        let mut kcf = KcfReading {
            peak: response.peak,
            psr: response.psr.into(),
            psr_ratio: response.psr_ratio().into(),
            template_updated: false,
        };
        let fit = if following.lost {
            following.search(frame)
        } else {
            following.geometry(frame, predicted_u, variance, &kcf)
        };
        let mut estimate = Estimate::seeking(Observation::NoSeam);
        let mut taken = None;
        match fit {
            Ok(fit) => {
                let always = following.unseen >= 8 && !following.lost;
                let geometry_variance = noise * GEOMETRY_VARIANCE_PX2;
                self.noise.push(Some(fit.centre.u_px));
                let (nis, measured) = following.take(fit.centre.u_px, geometry_variance, always)?;
                estimate.nis = Some(nis);
                estimate.observation = Observation::Geometry;
                taken = measured;
                if taken.is_none() || following.lost {
                    estimate.observation = Observation::Refused;
                    following.refused.push(Refused { frame: now, u_px: fit.centre.u_px, clear: fit.is_clear() });
                    taken = None;
                    if let Some((u_px, slope)) = following.agreement(now) {
                        following.filter = SeamFilter::start(u_px, slope, [1.5, 0.5])?;
                        following.refused.clear();
                        following.lost = false;
                        estimate.observation = Observation::Reacquired;
                        taken = Some(Measured { u_px: fit.centre.u_px, variance_px2: geometry_variance });
                    }
                }
                if taken.is_some() {
                    following.model.learn(&fit);
                    following.v_px = fit.centre.v_px;
                    following.unseen = 0;
                    estimate.sides = Some(sides(&fit));
                    let (u_px, _) = following.filter.position();
                    if kcf.psr_ratio >= self.settings.learn_psr_ratio {
                        let centre = PixelPoint::new(u_px, following.v_px);
                        following.kcf_bias_px += 0.05 * (kcf.peak.u_px - fit.centre.u_px - following.kcf_bias_px);
                        self.kcf.update(frame, centre, self.settings.learning_rate);
                        kcf.template_updated = true;
                    }
                } else {
                    following.unseen += 1;
                }
            }
            Err(refusal) => {
                self.noise.push(None);
                estimate.observation = Observation::GeometryRefused(refusal);
                following.unseen += 1;
                if kcf.psr_ratio >= LEAST_PSR_RATIO && following.unseen <= KCF_ALONE_FRAMES && !following.lost {
                    let weakness = (0.57 / kcf.psr_ratio.clamp(0.14, 0.57)).powi(4);
                    let u_px = kcf.peak.u_px - following.kcf_bias_px;
                    let (nis, measured) = following.take(u_px, KCF_VARIANCE_PX2 * weakness, false)?;
                    estimate.nis = Some(nis);
                    taken = measured;
                    if taken.is_some() {
                        estimate.observation = Observation::Kcf;
                    }
                }
            }
        }
        let (_, variance) = following.filter.position();
        following.lost |= variance.sqrt() > LOST_STD_PX || following.unseen > LOST_FRAMES;
        estimate.kcf = Some(kcf);
        if following.lost {
            estimate.status = Status::Lost;
        } else {
            estimate.status = if taken.is_some() { Status::Tracked } else { Status::Coasting };
            estimate.seam = Some(following.seam());
        }
        match taken {
            Some(measured) => self.history.measured(measured),
            None => self.history.nothing(),
        }
        Ok(estimate)
    }
}

impl Following {
    /// The best fit anywhere in the frame.
    fn search(&self, frame: &GrayFrame) -> Result<JointFit, Refusal> {
        let mut best: Result<JointFit, Refusal> = Err(Refusal::NoLine);
        let badness = |fit: &JointFit| fit.edges.map_or(fit.residual_px, |edges| edges.cost) - 0.2 * fit.support;
        for place in (10..frame.width_px().saturating_sub(10)).step_by(12) {
            for dv in [-8.0, 0.0, 8.0] {
                let fit = self.model.fit(frame, place as f64, dv, 12.0).and_then(JointFit::judged);
                if let Ok(fit) = fit
                    && best.as_ref().map_or(true, |other| badness(&fit) < badness(other))
                {
                    best = Ok(fit);
                }
            }
        }
        best
    }
}

/// The sides' lines as far as they were fitted.
fn sides(fit: &JointFit) -> [[PixelPoint; 2]; 2] {
    let half_gap_px = fit.edges.map_or(0.0, |edges| 0.5 * edges.gap_px);
    let point = |line: Line, du: f64| PixelPoint::new(fit.centre.u_px + du, line.at(du));
    [
        [point(fit.left, -HALF_WINDOW_PX), point(fit.left, -half_gap_px)],
        [point(fit.right, half_gap_px), point(fit.right, HALF_WINDOW_PX)],
    ]
}

impl Follow for RobustTracker {
    fn seed_at(&mut self, centre: PixelPoint) {
        self.seed_at = Some(centre);
    }

    fn step(&mut self, frame: &GrayFrame, time_s: f64, repeated: bool) -> Result<Estimate, TrackerError> {
        if repeated && let Some(last) = self.last {
            self.clock.last_s = Some(time_s);
            self.history.repeated();
            return Ok(last);
        }
        let frames = self.clock.tick(time_s);
        self.history.step(frames);
        let frame = &median(frame, MedianKernel::Three)?;
        let estimate = self.follow(frame, frames)?;
        self.last = Some(estimate);
        Ok(estimate)
    }

    fn miss(&mut self, time_s: f64) -> Result<(), TrackerError> {
        let frames = self.clock.tick(time_s);
        self.history.step(frames);
        self.history.nothing();
        if let Some(following) = &mut self.following {
            following.filter.predict(frames)?;
            following.unseen += 1;
        }
        Ok(())
    }

    fn smoothed(&self) -> Result<Vec<Option<(f64, f64)>>, TrackerError> {
        let (sum, count) = self.noise_used;
        Ok(self.history.smoothed(if count > 0.0 { sum / count } else { 1.0 })?)
    }
}
