//! The robust method: stripe geometry, or evidence of a hairline, as the main observation; the KCF as the fallback;
//! interacting models as the filter; and judgement between them. The search is centred on the prediction, and a value is
//! never reported as valid because the tracker could not tell.
//!
//! | file | what it does |
//! |---|---|
//! | `places`, `levels`, `finer`, `seek`, `asked`, `candidate`, `seed`, `outline`, `classify`, `stripe` | finds the joint and its kind in whole frames, on the stripe that carries it, in the raster that fits it |
//! | `doubt` | whether the joint asked for is the joint seen |
//! | `correlation` | the correlation filters, in a small window and in a wide one |
//! | `geometry`, `hairline`, `sighting` | one frame's own view of the seam |
//! | `rival` | whether a joint seen beside one that is unseen is that one |
//! | `following`, `judge` | a seam that is followed, and what a sighting of it is worth |
//! | `filter`, `height` | the estimate along the stripe and across it |
//! | `noise`, `roughness` | R, all of it |
//! | `fixed` | where the picture shows what is no seam |
//! | `lasting` | what belongs to σ and to no R |
//! | `part` | what an ablation takes away |

mod asked;
mod candidate;
mod classify;
mod correlation;
mod doubt;
pub(super) mod filter;
mod finer;
mod fixed;
mod following;
mod geometry;
mod hairline;
pub(super) mod height;
mod judge;
mod lasting;
mod levels;
pub(super) mod noise;
mod outline;
mod part;
mod places;
mod rival;
mod roughness;
mod seed;
mod seek;
mod sighting;
mod stripe;

use self::asked::ASKED_FRAMES;
use self::candidate::{SECOND_LINE_DOUBT, WIDE_DOUBT};
use self::correlation::Correlation;
use self::doubt::Doubter;
use self::fixed::FixedPlaces;
use self::following::{Following, Next};
pub use self::judge::REFUSE_NIS;
use self::levels::Levels;
pub use self::part::Part;
use self::part::Parts;
use self::places::Places;
use self::rival::{Known, RIVAL_AFTER_BEATS, Seen};
use self::seek::Found;
use super::TrackerError;
use super::clock::Tick;
use super::estimate::{Estimate, JointDecision, Observation, Status};
use super::lag::Links;
use super::path::{Event, Memory, REMEMBERED};
use super::picture::{Darkroom, Developed, Picture};
use super::session::Follow;
use super::view::View;
use crate::calib::Sensor;
use crate::imgproc::geometry::JointKind;
use crate::imgproc::{MedianKernel, Pixels, Raster};
use crate::kcf::KcfSettings;
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
    /// The parts of the method; all of them but for an ablation.
    pub(crate) parts: Parts,
}

impl Default for RobustSettings {
    fn default() -> Self {
        Self {
            joint: None,
            kcf: KcfSettings { window_width_px: 80, window_height_px: 48, label_sd_px: 2.5, ..KcfSettings::du_2022() },
            learning_rate: 0.03,
            learn_psr_ratio: 0.4,
            parts: Parts::default(),
        }
    }
}

#[cfg(feature = "ablation")]
impl RobustSettings {
    /// The method without a part of it, or whole.
    #[must_use]
    pub fn without(part: Option<Part>) -> Self {
        Self { parts: Parts { without: part }, ..Self::default() }
    }
}

/// A wider gap than this between two plates is doubted. Chosen: root gaps are up to 4 mm, with a backing up to 8 (ISO 9692-1).
const WIDEST_GAP_MM: f64 = 8.0;

/// What the tracker is doing.
enum Phase {
    /// No joint is known: any that the settings allow is sought in whole frames.
    Seeking(Places),
    /// A joint is followed near its prediction.
    Following(Box<Following>),
    /// It was lost, and is sought in the whole frame as it was known.
    Searching(Box<Following>),
}

/// The robust tracker, on frames of which the stripe is horizontal.
pub struct RobustTracker {
    settings: RobustSettings,
    sensor: Sensor,
    darkroom: Option<Darkroom>,
    kcf: Correlation,
    phase: Phase,
    joint: Option<JointDecision>,
    doubter: Option<Doubter>,
    /// The kind that the frames show by themselves, where one was asked for.
    seen: Option<JointKind>,
    /// Seeks any joint while the one that is followed is not seen: its preparation may have changed.
    rival: Option<Levels>,
    fixed: FixedPlaces,
    frame_number: usize,
}

impl RobustTracker {
    /// A tracker that looks for its seam.
    ///
    /// # Errors
    /// When a KCF setting is out of range.
    pub fn new(settings: &RobustSettings, sensor: Sensor) -> Result<Self, TrackerError> {
        Ok(Self {
            darkroom: None,
            kcf: Correlation::new(settings.kcf)?,
            settings: settings.clone(),
            sensor,
            phase: Phase::Seeking(Places::new(settings, true)),
            joint: None,
            doubter: settings.joint.map(|_| Doubter::new(settings)),
            seen: None,
            rival: None,
            fixed: FixedPlaces::default(),
            frame_number: 0,
        })
    }

    fn seek(&mut self, field: &mut Developed<'_>, beats: f64) -> Result<Estimate, TrackerError> {
        let Phase::Seeking(places) = &mut self.phase else { return Ok(self.unseen(Observation::NoSeam, beats)) };
        let origin = field.origin();
        let (part, raster, found) = places.look(field.whole());
        let found = found.unless(|seed| self.fixed.hold(seed, &View::of_part(origin, part, raster)));
        if let (Found::Nothing { .. }, Some((place, elsewhere))) = (&found, places.asked_in_vain()) {
            let view = View::new(origin, Raster::PICTURE);
            return Err(TrackerError::NothingAtSeed {
                seed: view.picture_from_view(place),
                frames: ASKED_FRAMES,
                elsewhere: elsewhere.map(|(kind, centre)| (kind.name(), view.picture_from_view(centre))),
            });
        }
        self.begin(field, View::of_part(origin, part, raster), found, beats)
    }

    /// The gap of what is followed, where millimetres are known.
    fn gap_mm(&self, following: &Following) -> Option<f64> {
        let view = following.view();
        let centre = following.seam().in_picture(&view).centre;
        let mm_per_px = self.sensor.scale_along(centre, view.axis()).filter(|_| self.sensor.has_millimetres())?;
        Some(following.gap_px()? * mm_per_px.abs())
    }

    /// Begins to follow what was found.
    fn begin(
        &mut self,
        field: &mut Developed<'_>,
        view: View,
        found: Found,
        beats: f64,
    ) -> Result<Estimate, TrackerError> {
        let mut before = [None; REMEMBERED];
        let (following, sighting, (kind, reason, doubt)) = match found {
            Found::Nothing { stripe_seen, evidence } => {
                let why = if stripe_seen { Observation::NoSeam } else { Observation::NoStripe };
                return Ok(Estimate { evidence, ..self.unseen(why, beats) }.in_picture(&view));
            }
            Found::Joint { seed, reason, doubt, before: fits, .. } => {
                let kind = seed.model.kind;
                let (following, sighting) = Following::by_geometry(*seed, view, &self.sensor, self.settings.parts)?;
                for (age, fit) in fits {
                    if let Some(place) = before.get_mut(age - 1) {
                        *place = following.sighting(fit).map(|sighting| sighting.measured(1.0));
                    }
                }
                let asked = self.settings.joint.is_some();
                let is_too_wide = !asked && kind == JointKind::Butt && self.gap_mm(&following) > Some(WIDEST_GAP_MM);
                let doubt = doubt.or(is_too_wide.then_some(WIDE_DOUBT));
                (following, sighting, (kind, reason, doubt))
            }
            Found::Hairline { tracker, sighting, reason } => {
                let following = Following::by_evidence(*tracker, &sighting, view, &self.sensor, self.settings.parts)?;
                (following, *sighting, (JointKind::Butt, reason, None))
            }
        };
        if let Some(mut frame) = field.in_view(view) {
            self.kcf.train(&mut frame, sighting.centre);
        }
        let estimate = Estimate {
            status: Status::Tracked,
            seam: Some(following.seam()),
            evidence: sighting.evidence,
            section: sighting.section,
            memory: Memory {
                beats,
                event: Event::Found {
                    view,
                    measured: sighting.measured(1.0),
                    before,
                    row_bias_px2: following.row_bias_px2(),
                },
            },
            ..Estimate::seeking(Observation::Seed)
        };
        let frame = self.frame_number - 1;
        let contradicted_by = self.contradiction(kind.name());
        self.joint = Some(JointDecision { kind: kind.name(), frame, reason, doubt, contradicted_by });
        self.phase = Phase::Following(Box::new(following));
        self.rival = None;
        Ok(estimate.in_picture(&view))
    }

    /// Whether another joint shows where the one that is followed should be, or anywhere once that is lost.
    fn rival(&mut self, field: &mut Developed<'_>) -> Option<(View, Found)> {
        let (following, is_lost) = match &self.phase {
            Phase::Following(following) => (following, false),
            Phase::Searching(following) => (following, true),
            Phase::Seeking(_) => return None,
        };
        if following.unseen_beats() < RIVAL_AFTER_BEATS {
            self.rival = None;
            return None;
        }
        let rival = self.rival.get_or_insert_with(|| Levels::rival(&self.settings));
        let part = following.view().part_of(field.whole())?;
        let (raster, found) = rival.look(&part);
        let view = following.view().in_raster(raster);
        let found = found.unless(|seed| self.fixed.hold(seed, &view));
        let Found::Joint { seed, .. } = &found else { return None };
        let predicted = following.seam().in_picture(&following.view());
        let axis = view.axis();
        let away_px = axis.along_px(view.picture_from_view(seed.fit.centre)) - axis.along_px(predicted.centre);
        let known = Known { kind: self.joint.as_ref()?.kind, gap_px: following.gap_px(), is_lost };
        let seen = Seen {
            kind: seed.model.kind.name(),
            gap_px: view.picture_px() * seed.gap_px(),
            is_certain: seed.certain,
            away_px,
            std_px: predicted.std_px,
        };
        known.may_be(seen).then_some((view, found))
    }

    /// Asks what the frames show by themselves, where a joint was asked for.
    fn doubt(&mut self, field: &mut Developed<'_>) {
        let Some(doubter) = &mut self.doubter else { return };
        doubter.look(field.whole());
        self.seen = doubter.seen();
        if doubter.is_done() {
            self.doubter = None;
        }
        let contradiction = self.joint.as_ref().and_then(|joint| self.contradiction(joint.kind));
        if let Some(joint) = &mut self.joint {
            joint.contradicted_by = contradiction;
        }
    }

    /// Says once that a leg has a rival.
    fn doubt_lines(&mut self) {
        if let (Phase::Following(following), Some(joint)) = (&self.phase, &mut self.joint)
            && following.has_rival_line()
        {
            joint.doubt.get_or_insert(SECOND_LINE_DOUBT);
        }
    }

    /// The kind that the frames show, if it is not `kind`.
    fn contradiction(&self, kind: &str) -> Option<&'static str> {
        self.seen.map(JointKind::name).filter(|seen| *seen != kind)
    }

    /// Nothing is followed, and nothing was found.
    fn unseen(&self, why: Observation, beats: f64) -> Estimate {
        let status = if self.joint.is_some() { Status::Lost } else { Status::Seeking };
        Estimate { status, memory: Memory { beats, event: Event::Nothing }, ..Estimate::seeking(why) }
    }

    /// Follows or searches through a frame, or through one that shows nothing.
    fn follow(&mut self, field: Result<&mut Developed<'_>, Observation>, tick: Tick) -> Result<Estimate, TrackerError> {
        let (following, is_lost) = match &mut self.phase {
            Phase::Following(following) => (following, false),
            Phase::Searching(following) => (following, true),
            Phase::Seeking(_) => return Ok(self.unseen(Observation::NoSeam, tick.beats)),
        };
        let view = following.view();
        let (estimate, next) = match field.map(|field| field.in_view(view)) {
            Ok(Some(mut frame)) => following.step(&mut frame, tick.beats, is_lost, &mut self.kcf, &self.settings)?,
            Ok(None) => following.miss(Observation::NoStripe, tick.beats, is_lost)?,
            Err(why) => following.miss(why, tick.beats, is_lost)?,
        };
        self.go_on(next);
        Ok(estimate.in_picture(&view))
    }

    /// One frame further, in what is made of its picture.
    fn look(&mut self, field: &mut Developed<'_>, tick: Tick) -> Result<Estimate, TrackerError> {
        self.doubt(field);
        match self.phase {
            Phase::Seeking(_) => self.seek(field, tick.beats),
            Phase::Following(_) | Phase::Searching(_) => {
                let estimate = self.follow(Ok(field), tick)?;
                self.doubt_lines();
                match (self.rival(field), &mut self.phase) {
                    (None, _) => Ok(estimate),
                    (Some((view, Found::Joint { seed, reason, doubt, .. })), Phase::Following(following))
                        if view == following.view() =>
                    {
                        let (kind, frame) = (seed.model.kind.name(), self.frame_number - 1);
                        following.change_joint(*seed);
                        if self.joint.as_ref().is_none_or(|joint| joint.kind != kind) {
                            self.joint = Some(JointDecision { kind, frame, reason, doubt, contradicted_by: None });
                        }
                        Ok(estimate)
                    }
                    (Some((view, found)), _) => self.begin(field, view, found, tick.beats),
                }
            }
        }
    }

    fn go_on(&mut self, next: Next) {
        if next == Next::Seek {
            if let Phase::Following(following) = &self.phase
                && following.is_fixed()
            {
                let (view, gap_px) = (following.view(), following.gap_px().unwrap_or(0.0));
                self.fixed.push(view.axis().along_px(following.seam().in_picture(&view).centre), gap_px);
            }
            self.phase = Phase::Seeking(Places::new(&self.settings, false));
            return;
        }
        let is_so = match &self.phase {
            Phase::Following(_) => next == Next::Follow,
            Phase::Searching(_) => next == Next::Search,
            Phase::Seeking(_) => true,
        };
        if is_so {
            return;
        }
        let phase = std::mem::replace(&mut self.phase, Phase::Seeking(Places::new(&self.settings, false)));
        self.phase = match phase {
            Phase::Following(following) => Phase::Searching(following),
            Phase::Searching(following) => Phase::Following(following),
            seeking @ Phase::Seeking(_) => seeking,
        };
    }
}

impl Follow for RobustTracker {
    fn seed_at(&mut self, centre: PixelPoint) {
        if let Phase::Seeking(places) = &mut self.phase {
            places.seed_at(centre);
        }
    }

    fn step(&mut self, picture: Picture<'_>, tick: Tick) -> Result<Estimate, TrackerError> {
        self.frame_number += 1;
        let kernel = if self.settings.parts.has(Part::Median) { MedianKernel::Three } else { MedianKernel::Off };
        let mut darkroom = self.darkroom.take().unwrap_or_else(|| Darkroom::new(kernel));
        let estimate = self.look(&mut darkroom.begin(picture), tick);
        self.darkroom = Some(darkroom);
        estimate
    }

    fn miss(&mut self, tick: Tick, why: Observation) -> Result<Estimate, TrackerError> {
        self.frame_number += 1;
        match &mut self.phase {
            Phase::Seeking(places) => {
                places.miss();
                Ok(self.unseen(why, tick.beats))
            }
            Phase::Following(_) | Phase::Searching(_) => self.follow(Err(why), tick),
        }
    }

    fn looks_at_repeats(&self) -> bool {
        false
    }

    fn outlasts(&self, beats: f64) -> bool {
        match &self.phase {
            Phase::Following(following) => following.outlasts(beats),
            Phase::Seeking(_) | Phase::Searching(_) => true,
        }
    }

    fn pass_over(&mut self) {
        self.frame_number += 1;
    }

    fn start_anew(&mut self) {
        self.phase = Phase::Seeking(Places::new(&self.settings, true));
        self.doubter = self.settings.joint.map(|_| Doubter::new(&self.settings));
        self.seen = None;
    }

    fn links(&self) -> Option<Links> {
        match &self.phase {
            Phase::Following(following) => Some(following.links()),
            Phase::Seeking(_) | Phase::Searching(_) => None,
        }
    }

    fn joint(&self) -> Option<&JointDecision> {
        self.joint.as_ref()
    }
}
