//! Looking for a joint, frame by frame, until one is certain.

use std::collections::VecDeque;
use std::ops::Range;

use super::asked::{ASKED_FRAMES, Asked, MOTION_PX};
use super::candidate::{
    Candidate, DIP_DOUBT, FLAT_DOUBT, LEDGE_DOUBT, STEP_DOUBT, Shows, TWIN_DOUBT, are_alike, is_groove_between,
};
use super::classify;
use super::hairline::ROW_VARIANCE_PX2;
use super::outline::is_toe_of_hairline;
use super::part::{Part, Parts};
use super::seed::{self, Seed};
use super::sighting::Sighting;
use super::stripe::{STRAIGHT_SHARE, centreline, is_calm, straight_share};
use crate::frame::GrayFrame;
use crate::imgproc::geometry::{JointFit, JointKind};
use crate::imgproc::{Centreline, SeedSettings};
use crate::tracker::estimate::Evidence;
use crate::tracker::hairline::{HairlineEstimate, HairlineTracker, SeamPresence};
use crate::units::PixelPoint;

/// Seeds that must agree among those of the last frames: a spatter does not stay. One more where they are on the move:
/// chance has more ways to put four on a line than on one place.
const AGREEING_SEEDS: usize = 4;
const MOVING_SEEDS: usize = 5;
/// The same for what has no relief, since a dark place passes with the plate, and for a joint beside one that is known.
const FLAT_SEEDS: usize = 7;
const RECENT_FRAMES: usize = 8;
/// A better joint elsewhere is waited for when it has shown in so many of the last frames, so far away \[px\].
const RIVAL_SEEDS: usize = 3;
const RIVAL_PX: f64 = 12.0;
/// How close they must be at once \[px\].
const AGREEMENT_PX: f64 = 4.0;
/// What is fixed to the picture, dirt on the glass, a dead column of the sensor, a gap in the laser's line, stays within this
/// over the frames that are remembered \[px\], and is no seam: plates are ragged, and shake. Measured, in single frames: an SD
/// of .02 to .12 px against .3 px and more. Speckle moves the place of what shows no relief, and that of a hairline, so that
/// means of some frames are compared.
const FIXED_FLAT_PX: f64 = 0.5;
const FIXED_HAIRLINE_PX: f64 = 1.5;
const REMEMBERED_FRAMES: usize = 24;
const FRAMES_OF_A_MEAN: usize = 4;
/// A hairline is sought on from where its place is this sure.
const LEAST_PRESENCE: f64 = 0.9;
/// A hairline bends the stripe or takes from its flanks, an edge of mill scale or a shadow does not: least relief, as a mean over
/// the remembered frames, at least so many. Measured, means of ten frames: 1.7 to 3.4 at edges of brightness, 4.0 to 7.3 at
/// three real joints and six made-up ones when they were found.
const LEAST_RELIEF: f64 = 3.7;
const LEAST_RELIEF_FRAMES: usize = 5;
/// Fastest seam that is found by its seeds on one line \[px/frame\]. Chosen.
const FASTEST_PX: f64 = 10.0;
/// Memory of that share \[per frame\].
const STRAIGHT_RATE: f64 = 0.25;
/// A hairline is the toe of what lies on the plates when it looks like one in this share of the last frames. Chosen: a cap that
/// runs out little by little, and a spatter over it, hide it in half of them; beside a seam a spatter shows one for a frame.
const LARGEST_TOE_SHARE: f64 = 0.3;
/// What a frame brought.
pub enum Found {
    /// No joint that is certain.
    Nothing {
        /// There was a stripe.
        stripe_seen: bool,
        /// What speaks for a hairline.
        evidence: Evidence,
    },
    /// A joint with edges or a corner.
    Joint {
        /// Its cross-section and its place.
        seed: Box<Seed>,
        /// What it shows.
        shows: Shows,
        /// Why it is one of its kind.
        reason: String,
        /// What else it may be.
        doubt: Option<&'static str>,
        /// Where it was in the frames before, the newest first: how many frames ago, and its seed's fit.
        before: Vec<(usize, JointFit)>,
    },
    /// A hairline.
    Hairline {
        /// The tracker that found it.
        tracker: Box<HairlineTracker>,
        /// Its place.
        sighting: Box<Sighting>,
        /// Why it is one.
        reason: String,
    },
}

impl Found {
    /// Not even a stripe.
    pub const fn nothing() -> Self {
        Self::Nothing { stripe_seen: false, evidence: Evidence::NONE }
    }

    /// The same, but no joint that is known to be none.
    pub fn unless(self, is_none: impl Fn(&Seed) -> bool) -> Self {
        match &self {
            Self::Joint { seed, .. } if is_none(seed) => Self::Nothing { stripe_seen: true, evidence: Evidence::NONE },
            _ => self,
        }
    }
}

/// Looks for joints of one kind, or of all.
pub struct Seeker {
    kind: Option<JointKind>,
    parts: Parts,
    asked: Option<Asked>,
    /// The seeds of the last frames, each with what it shows, the newest last.
    recent: VecDeque<Vec<Candidate>>,
    /// No stripe was seen yet: the next frame with one may be from before the arc (Du 2022, section 3.1).
    untouched: bool,
    hairline: HairlineTracker,
    /// Hairlines are sought too.
    seeks_hairlines: bool,
    /// Another joint is known, and not seen.
    is_rival: bool,
    straight_share: f64,
    /// Share of the last frames in which something lies beside the hairline.
    toe_share: f64,
    /// The middle of the field: cameras are aimed at the seam \[px\].
    middle_px: f64,
    /// Where the last frames have the hairline \[px\], and its relief, the newest last.
    hairlines: VecDeque<(f64, f64)>,
}

impl Seeker {
    /// Looks for `kind`, or for any; `untouched` when no weld can have been begun, `seeks_hairlines` when a joint may have
    /// neither edges nor a corner.
    pub fn new(kind: Option<JointKind>, parts: Parts, untouched: bool, seeks_hairlines: bool) -> Self {
        Self {
            kind,
            parts,
            asked: None,
            recent: VecDeque::new(),
            untouched,
            hairline: HairlineTracker::default(),
            seeks_hairlines: seeks_hairlines && kind.is_none_or(|kind| kind == JointKind::Butt),
            is_rival: false,
            straight_share: 0.0,
            toe_share: 0.0,
            middle_px: 0.0,
            hairlines: VecDeque::new(),
        }
    }

    /// The same beside a joint that is known: what is found must be the surer, since what hides that looks like others.
    pub fn rival(kind: Option<JointKind>, parts: Parts) -> Self {
        Self { is_rival: true, ..Self::new(kind, parts, false, false) }
    }

    /// What may be a joint in the last frame looked at.
    pub fn candidates(&self) -> impl Iterator<Item = &Candidate> + Clone {
        self.recent.back().into_iter().flatten()
    }

    /// The user knows where the seam is in the next frame, which has so many pixels a pixel of the picture.
    pub fn seed_at(&mut self, centre: PixelPoint, raster_px_a_px: f64) {
        self.asked = Some(Asked::new(centre, raster_px_a_px));
    }

    /// The place the user gave, if there was nothing there for [`ASKED_FRAMES`], with what showed elsewhere.
    pub fn asked_in_vain(&self) -> Option<Option<(JointKind, PixelPoint)>> {
        let asked = self.asked.as_ref().filter(|asked| asked.frames >= ASKED_FRAMES)?;
        Some(asked.elsewhere)
    }

    /// A frame passes that cannot be looked at.
    pub fn miss(&mut self) {
        self.remember(vec![]);
    }

    fn remember(&mut self, candidates: Vec<Candidate>) {
        self.recent.push_back(candidates);
        if self.recent.len() > REMEMBERED_FRAMES {
            self.recent.pop_front();
        }
    }

    /// Looks at the next frame.
    pub fn look(&mut self, frame: &GrayFrame) -> Found {
        self.middle_px = 0.5 * frame.width_px() as f64;
        let line = centreline(frame, self.parts.has(Part::StripePath));
        let stripe_seen = line.extent(SeedSettings::default().widest_joint_px).is_some();
        let at_place = self.asked.as_ref().and_then(|asked| asked.seed(frame, self.kind));
        let seeds = match at_place {
            Some(seed) if seed.certain => vec![seed],
            unsure => unsure.into_iter().chain(seed::find(frame, &line, self.kind)).collect(),
        };
        let candidates = seeds.into_iter().filter_map(|seed| Candidate::of(frame, seed, self.kind)).collect();
        let before_arc = self.untouched && is_calm(frame, &line);
        self.untouched &= !stripe_seen;
        if let Some(Candidate { seed, shows }) = self.confirmed(candidates, before_arc) {
            let reason = classify::reason(&seed, self.kind.is_some());
            let doubt = match shows {
                Shows::Dark if seed.model.kind == JointKind::Lap => Some(STEP_DOUBT),
                Shows::Dark => Some(FLAT_DOUBT),
                Shows::Dip => Some(DIP_DOUBT),
                Shows::Ledge => Some(LEDGE_DOUBT),
                Shows::Step | Shows::Relief | Shows::Whole => self.has_twin(&seed).then_some(TWIN_DOUBT),
            };
            return Found::Joint { reason, doubt, before: self.before(&seed), seed: Box::new(seed), shows };
        }
        let hairline = if self.seeks_hairlines { self.hairline.step(frame) } else { None };
        let presence = hairline.map(|estimate| estimate.grid.presence);
        let evidence = Evidence { along_px: hairline.map(|estimate| estimate.seam.u_px), presence, ..Evidence::NONE };
        if let Some(estimate) = hairline
            && self.hairline_is_certain(&line, &estimate)
            && self.is_where_asked(JointKind::Butt, estimate.seam)
        {
            return Found::Hairline {
                tracker: Box::new(std::mem::take(&mut self.hairline)),
                sighting: Box::new(Sighting {
                    centre: estimate.seam,
                    variance_px2: estimate.grid.sd_px.powi(2),
                    across_variance_px2: ROW_VARIANCE_PX2,
                    clear: true,
                    evidence,
                    section: None,
                    fit: None,
                }),
                reason: "one straight stripe with a hairline break that moves as a seam does".into(),
            };
        }
        if let Some(asked) = self.asked.as_mut().filter(|_| stripe_seen) {
            asked.frames += 1;
        }
        Found::Nothing { stripe_seen, evidence }
    }

    /// Whether a joint may be the one that the user knows; if not, that it was seen is remembered.
    fn is_where_asked(&mut self, kind: JointKind, centre: PixelPoint) -> bool {
        let Some(asked) = &mut self.asked else { return true };
        let is_there = asked.is_near(centre);
        if !is_there {
            asked.elsewhere = Some((kind, centre));
        }
        is_there
    }

    /// The first seed that is clear by itself in a frame from before the arc, or that enough of the last frames confirm.
    fn confirmed(&mut self, candidates: Vec<Candidate>, before_arc: bool) -> Option<Candidate> {
        self.remember(candidates.clone());
        let certain = |candidate: &Candidate| {
            let Candidate { seed, shows } = candidate;
            let is_dark = *shows == Shows::Dark;
            let is_easy = !is_dark && !self.is_rival;
            let (agreeing, moving) = if is_easy { (AGREEING_SEEDS, MOVING_SEEDS) } else { (FLAT_SEEDS, FLAT_SEEDS) };
            let sure = (seed.certain && !self.is_rival)
                || (seed.clear && before_arc && *shows >= Shows::Step && !classify::is_open_lap(seed))
                || (self.agreeing(seed, 0.0, MOTION_PX) >= agreeing && (!is_dark || self.moves(seed)))
                || self.on_the_move(seed) >= moving;
            // What hides a joint that is known is a dark stretch of the stripe, too.
            let may_be_cover = self.is_rival && is_dark;
            sure && !may_be_cover && !self.latest().flatten().any(|other| is_groove_between(seed, &other.seed))
        };
        let typical =
            candidates.into_iter().map(|candidate| Candidate { shows: self.typically(&candidate), ..candidate });
        let mut certain: Vec<Candidate> = typical.filter(certain).collect();
        certain.retain(|candidate| self.is_where_asked(candidate.seed.model.kind, candidate.seed.fit.centre));
        // Of equals the first, as they come.
        certain.sort_by_key(|candidate| std::cmp::Reverse(candidate.shows.rank()));
        certain.into_iter().find(|candidate| !self.has_better(candidate))
    }

    /// What most of the last frames that have a candidate show, as far as one frame does not tell all.
    fn typically(&self, candidate: &Candidate) -> Shows {
        if candidate.shows == Shows::Whole {
            return Shows::Whole;
        }
        let near = |other: &&Candidate| {
            are_alike(&candidate.seed, &other.seed) && candidate.seed.away_px(&other.seed) < RIVAL_PX
        };
        let mut shown: Vec<Shows> = self.latest().flatten().filter(near).map(|other| other.shows).collect();
        shown.sort();
        shown.get(shown.len() / 2).copied().unwrap_or(candidate.shows)
    }

    /// The seeds of the frames that may confirm one, the newest frame first.
    fn latest(&self) -> impl Iterator<Item = &Vec<Candidate>> {
        self.recent.iter().rev().take(RECENT_FRAMES)
    }

    /// Whether another joint like `seed` shows at another place, and stays there.
    fn has_twin(&self, seed: &Seed) -> bool {
        let is_twin = |other: &Seed| are_alike(seed, other) && seed.away_px(other) > RIVAL_PX;
        self.stay(self.candidates().filter(|other| is_twin(&other.seed)))
    }

    /// Whether one of these has been there in several frames, or in all there were.
    fn stay<'a>(&self, mut others: impl Iterator<Item = &'a Candidate>) -> bool {
        let frames = RIVAL_SEEDS.min(self.recent.len());
        others.any(|other| self.agreeing(&other.seed, 0.0, MOTION_PX) >= frames)
    }

    /// Whether something that stays shows beside what is found in these columns, and may be the joint as well.
    pub fn shows_other(&self, shows: Shows, span_px: &Range<f64>) -> bool {
        let off_px = self.off_middle_px(0.5 * (span_px.start + span_px.end));
        self.stays_beside(span_px, |other| match shows {
            // A gap that shows no relief may be a mark beside other gaps; beside a step it is as good.
            Shows::Step => true,
            _ => other.shows >= Shows::Step || self.off_middle_px(other.seed.fit.centre.u_px) < off_px,
        })
    }

    /// Whether something that stays beside what is found in these columns goes before it.
    pub fn shows_more(&self, shows: Shows, span_px: &Range<f64>) -> bool {
        let off_px = self.off_middle_px(0.5 * (span_px.start + span_px.end));
        self.stays_beside(span_px, |other| self.goes_before(other, shows, off_px))
    }

    fn stays_beside(&self, span_px: &Range<f64>, is: impl Fn(&Candidate) -> bool) -> bool {
        let beside = |other: &&Candidate| !span_px.contains(&other.seed.fit.centre.u_px) && is(other);
        self.kind.is_none() && self.stay(self.candidates().filter(beside))
    }

    /// How far from the middle of the field a column lies \[px\].
    fn off_middle_px(&self, u_px: f64) -> f64 {
        (u_px - self.middle_px).abs()
    }

    /// Whether `one` is more likely the joint than a step or a ledge so far from the middle of the field: any plate's end is a step, and
    /// what lies on a plate a ledge.
    fn goes_before(&self, one: &Candidate, shows: Shows, off_middle_px: f64) -> bool {
        let is_nearer = self.off_middle_px(one.seed.fit.centre.u_px) < off_middle_px;
        let has_two_sides = matches!(one.seed.model.kind, JointKind::Butt | JointKind::VGroove);
        match shows {
            Shows::Ledge => one.shows >= Shows::Step || (one.shows != Shows::Ledge && is_nearer),
            Shows::Step => one.shows.is_more_than_step() && has_two_sides && is_nearer,
            Shows::Dark | Shows::Dip | Shows::Relief | Shows::Whole => false,
        }
    }

    /// Whether another place of the last frames, that shows more, may be the joint: it has not been seen often enough yet.
    fn has_better(&self, candidate: &Candidate) -> bool {
        let away = |other: &&Candidate| candidate.seed.away_px(&other.seed) > RIVAL_PX;
        let better = self.latest().flatten().filter(|other| other.shows.rank() > candidate.shows.rank()).filter(away);
        // Of two dark places in one frame neither is the better one.
        let is_dark = |shows: Shows| shows == Shows::Dark;
        let beside = self.candidates().filter(away);
        let as_good = beside.clone().filter(|other| is_dark(candidate.shows) && is_dark(other.shows));
        let mut others = better.chain(as_good);
        others.any(|other| self.agreeing(&other.seed, 0.0, MOTION_PX) >= RIVAL_SEEDS)
            || self.stay(beside.filter(|other| self.is_rather_meant(other, candidate)))
    }

    /// Whether `one` is more likely the joint than `other`: it goes before it, or of two steps, or two corners, as the upper edge of a plate
    /// that stands is one, it lies nearer to the middle of the field and has the longer legs.
    fn is_rather_meant(&self, one: &Candidate, other: &Candidate) -> bool {
        let off_px = |of: &Candidate| self.off_middle_px(of.seed.fit.centre.u_px);
        let worth_px = |of: &Candidate| of.seed.leg_px - off_px(of);
        let kind = one.seed.model.kind;
        let are_alike = one.shows == other.shows && one.shows >= Shows::Step && kind == other.seed.model.kind;
        let ends_a_plate = matches!(kind, JointKind::Lap | JointKind::Fillet);
        (are_alike && ends_a_plate && worth_px(one) > worth_px(other))
            || self.goes_before(one, other.shows, off_px(other))
    }

    /// Where `seed` was in the frames before this one, as far as its seeds follow on one another.
    fn before(&self, seed: &Seed) -> Vec<(usize, JointFit)> {
        let mut path: Vec<(usize, JointFit)> = vec![];
        for (age, candidates) in self.latest().enumerate().skip(1) {
            let (last_age, last) = path.last().copied().unwrap_or((0, seed.fit));
            let reach_px = AGREEMENT_PX + FASTEST_PX * (age - last_age) as f64;
            let away_px = |other: &Seed| (other.fit.centre.u_px - last.centre.u_px).abs();
            let alike = candidates.iter().map(|candidate| &candidate.seed).filter(|other| are_alike(seed, other));
            let near = alike.filter(|other| away_px(other) < reach_px);
            path.extend(near.min_by(|a, b| away_px(a).total_cmp(&away_px(b))).map(|other| (age, other.fit)));
        }
        path
    }

    /// Frames, this one included, with a seed like `seed` where it was when it moves by `velocity_px` a frame, give or take
    /// `motion_px`.
    fn agreeing(&self, seed: &Seed, velocity_px: f64, motion_px: f64) -> usize {
        let is_like = |other: &Seed, age: usize| {
            let away_px = seed.fit.centre.u_px - velocity_px * age as f64 - other.fit.centre.u_px;
            away_px.abs() < AGREEMENT_PX + motion_px * age as f64 && are_alike(seed, other)
        };
        let frames = self.latest().enumerate();
        frames.filter(|(age, others)| others.iter().any(|other| is_like(&other.seed, *age))).count()
    }

    /// Whether the seeds that are like `seed` are not all in one and the same place.
    fn moves(&self, seed: &Seed) -> bool {
        let near = |other: &&Seed| are_alike(seed, other) && seed.away_px(other) < AGREEMENT_PX;
        let seeds = self.recent.iter().flatten().map(|other| &other.seed);
        let places: Vec<f64> = seeds.filter(near).map(|other| other.fit.centre.u_px).collect();
        range(means(&places)) > FIXED_FLAT_PX
    }

    /// The most frames whose seeds lie on one line in time with `seed`.
    fn on_the_move(&self, seed: &Seed) -> usize {
        let frames = self.latest().enumerate().skip(1);
        let others = frames.flat_map(|(age, seeds)| seeds.iter().map(move |other| (age, &other.seed)));
        let velocities = others
            .filter(|(_, other)| are_alike(seed, other))
            .map(|(age, other)| (seed.fit.centre.u_px - other.fit.centre.u_px) / age as f64);
        let velocities = velocities.filter(|velocity_px| (MOTION_PX..=FASTEST_PX).contains(&velocity_px.abs()));
        velocities.map(|velocity_px| self.agreeing(seed, velocity_px, 0.0)).max().unwrap_or(0)
    }

    fn hairline_is_certain(&mut self, line: &Centreline, estimate: &HairlineEstimate) -> bool {
        let share = straight_share(line, estimate.seam.u_px, |u| self.hairline.stripe_v_px(u));
        self.straight_share += STRAIGHT_RATE * (share - self.straight_share);
        let is_toe = is_toe_of_hairline(line, estimate.seam.u_px, |u| self.hairline.stripe_v_px(u));
        self.toe_share += STRAIGHT_RATE * (f64::from(u8::from(is_toe)) - self.toe_share);
        if estimate.grid.presence < LEAST_PRESENCE {
            self.hairlines.clear();
            return false;
        }
        self.hairlines.push_back((estimate.seam.u_px, estimate.relief));
        if self.hairlines.len() > REMEMBERED_FRAMES {
            self.hairlines.pop_front();
        }
        let places: Vec<f64> = self.hairlines.iter().map(|(u_px, _)| *u_px).collect();
        let relief = self.hairlines.iter().map(|(_, relief)| relief).sum::<f64>() / places.len() as f64;
        // Who asks for a butt joint knows that there is one.
        let has_relief = places.len() >= LEAST_RELIEF_FRAMES && (relief >= LEAST_RELIEF || self.kind.is_some());
        estimate.presence == SeamPresence::Present
            && self.straight_share >= STRAIGHT_SHARE
            && has_relief
            && self.toe_share < LARGEST_TOE_SHARE
            && range(means(&places)) > FIXED_HAIRLINE_PX
    }
}

/// Means of so many neighbours each, the last ones first; what is left over counts not.
fn means(values: &[f64]) -> impl Iterator<Item = f64> {
    values.rchunks_exact(FRAMES_OF_A_MEAN).map(|few| few.iter().sum::<f64>() / few.len() as f64)
}

/// Largest less least; 0 of none.
fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    (most - least).max(0.0)
}

#[cfg(test)]
mod tests;
