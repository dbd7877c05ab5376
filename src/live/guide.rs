//! From sightings ahead of the torch to corrections at the torch.

use super::corrections::Corrections;
use super::guard::{Guard, State, Why};
use super::poses::{Pose, Poses};
use super::ring::{PathRing, Reach, Target};
use super::settings::{BadGuideSetting, GuideSettings};

/// A stamp this far in the future is no stamp \[s\]. Chosen: more than clocks of one machine differ.
const FUTURE_S: f64 = 0.02;
/// Cycle before two are known \[s\]: RSI's.
const FIRST_CYCLE_S: f64 = 0.004;
/// Share of a new cycle's length in their mean. Chosen: some ten cycles.
const CYCLE_SHARE: f64 = 0.1;
/// How far the ring reaches back behind the torch \[mm\]. Chosen: a robot that twitches back finds its targets.
const BACK_MM: f64 = 5.0;

/// Where the seam lies beside the torch's line, in one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// Across the travel; positive where the robot's lateral coordinate grows \[mm\].
    pub lateral_mm: f64,
    /// One σ of it \[mm\].
    pub std_mm: f64,
}

/// What one picture told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// The middle of its exposure, by the clock of the cycles \[s\].
    pub exposed_s: f64,
    /// Whether it is a picture of that moment: a frozen one, or one with a bad stamp, is none.
    pub is_live: bool,
    /// The seam, if it was seen: predictions are none.
    pub seam: Option<Offset>,
}

/// What the robot is to do. That nothing is known is never a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Correction {
    /// Move so far across the travel in this cycle \[mm\].
    Step(f64),
    /// Keep the line.
    Hold,
}

/// The answer to one cycle of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// What the guide does.
    pub state: State,
    /// Why it does so.
    pub why: Why,
    /// What the robot is to do.
    pub correction: Correction,
    /// Where the torch is.
    pub pose: Pose,
    /// Sum of the corrections sent \[mm\].
    pub total_mm: f64,
    /// From where the torch will be once what was sent is executed to the seam there \[mm\].
    pub remaining_mm: Option<f64>,
    /// Age of the newest picture \[s\]; none before the first.
    pub age_s: Option<f64>,
}

/// Sightings in, corrections out. Neither clock nor input nor output; all times are the caller's, memory is bounded.
///
/// The sensor sees the seam [`GuideSettings::ahead_mm`] ahead of the torch. A sighting is paired with the pose of the robot at
/// its exposure and becomes a target at a place of the path. In each cycle the target is read where the torch will be when
/// the correction is executed, what is under way is taken off, and a share of the rest is sent.
///
/// A loop that corrects the share `gain` in each cycle of length `T` follows a sloping seam `(1/gain − 1)·T` late; the target is
/// read that much further ahead.
#[derive(Debug, Clone)]
pub struct Guide {
    settings: GuideSettings,
    poses: Poses,
    ring: PathRing,
    corrections: Corrections,
    guard: Guard,
    newest_s: Option<f64>,
    cycled_s: Option<f64>,
    started_s: Option<f64>,
    cycle_s: f64,
    unpaired: u64,
    /// Of a robot that does not tell its pose: how far it went by its speed \[mm\].
    driven_mm: f64,
}

impl Guide {
    /// A guide before its seam.
    ///
    /// # Errors
    /// When a setting is out of its range.
    pub fn new(settings: GuideSettings) -> Result<Self, BadGuideSetting> {
        Ok(Self::fresh(settings.checked()?))
    }

    fn fresh(settings: GuideSettings) -> Self {
        Self {
            settings,
            poses: Poses::default(),
            ring: PathRing::default(),
            corrections: Corrections::default(),
            guard: Guard::default(),
            newest_s: None,
            cycled_s: None,
            started_s: None,
            cycle_s: FIRST_CYCLE_S,
            unpaired: 0,
            driven_mm: 0.0,
        }
    }

    /// Before the next seam: all is forgotten, a stop too.
    pub fn reset(&mut self) {
        *self = Self::fresh(self.settings);
    }

    /// Gives up until [`Self::reset`].
    pub fn stop(&mut self, why: Why) {
        self.guard.stop(why);
    }

    /// Sightings without a pose of the robot at their exposure: they were not used.
    #[must_use]
    pub const fn unpaired(&self) -> u64 {
        self.unpaired
    }

    /// Takes what a picture told.
    pub fn see(&mut self, sighting: &Sighting) {
        let now_s = self.cycled_s.unwrap_or(f64::INFINITY);
        if !sighting.is_live || !sighting.exposed_s.is_finite() || sighting.exposed_s > now_s + FUTURE_S {
            return;
        }
        if self.newest_s.is_some_and(|newest_s| sighting.exposed_s <= newest_s) {
            return;
        }
        self.newest_s = Some(sighting.exposed_s);
        let is_sure = |seam: &Offset| seam.lateral_mm.is_finite() && seam.std_mm <= self.settings.worst_std_mm;
        let seam = sighting.seam.filter(is_sure);
        let Some(pose) = self.poses.at(sighting.exposed_s) else {
            self.unpaired += u64::from(seam.is_some());
            return;
        };
        let path_mm = pose.path_mm + self.settings.ahead_mm;
        self.ring.look(path_mm);
        let Some(seam) = seam else { return };
        self.ring.push(Target {
            path_mm,
            lateral_mm: pose.lateral_mm + seam.lateral_mm,
            exposed_s: sighting.exposed_s,
        });
    }

    /// One cycle of a robot that does not tell where it is: along the travel it is where `speed_mm_s` brought it, across it where
    /// the corrections did.
    pub fn cycle_at_speed(&mut self, now_s: f64, speed_mm_s: f64) -> Answer {
        let since_s = self.cycled_s.map_or(0.0, |before_s| now_s - before_s);
        self.driven_mm += speed_mm_s * since_s.max(0.0);
        let under_way_mm = self.corrections.under_way_mm(now_s, self.settings.delay_s);
        let pose = Pose { path_mm: self.driven_mm, lateral_mm: self.corrections.total_mm() - under_way_mm };
        self.cycle(now_s, pose)
    }

    /// One cycle of a robot that stands at `pose` at `now_s`.
    pub fn cycle(&mut self, now_s: f64, pose: Pose) -> Answer {
        self.cycle_posed(now_s, now_s, pose)
    }

    /// One cycle at `now_s` of a robot that stood at `pose` at `posed_s`: its message may have been on the way for long.
    pub fn cycle_posed(&mut self, now_s: f64, posed_s: f64, pose: Pose) -> Answer {
        let since_s = self.cycled_s.map_or(FIRST_CYCLE_S, |before_s| now_s - before_s);
        let is_good =
            [now_s, posed_s, pose.path_mm, pose.lateral_mm].iter().all(|number| number.is_finite()) && since_s > 0.0;
        if !is_good {
            self.guard.stop(Why::BadPose);
            return self.answer(Why::BadPose, pose, now_s);
        }
        if since_s > self.settings.robot_silent_s {
            self.guard.stop(Why::RobotSilent);
        }
        self.cycled_s = Some(now_s);
        let started_s = *self.started_s.get_or_insert(now_s);
        self.cycle_s += CYCLE_SHARE * (since_s.min(self.settings.robot_silent_s) - self.cycle_s);
        self.poses.push(posed_s, pose);
        if let Some(why) = self.guard.stopped() {
            return self.answer(why, pose, now_s);
        }

        let settings = self.settings;
        let lead_s = settings.delay_s + (1.0 / settings.gain - 1.0) * self.cycle_s;
        let aim_mm = pose.path_mm + self.poses.speed_mm_s() * lead_s;
        self.ring.forget_before(pose.path_mm - BACK_MM);
        let oldest_s = now_s - settings.target_age_s;
        let reach = self.ring.at(aim_mm, oldest_s, settings.unbroken_mm, settings.tack_mm);
        let age_s = now_s - self.newest_s.unwrap_or(started_s);
        let (state, why) = self.guard.judge(aim_mm, reach, age_s, &settings);
        let under_way_mm = self.corrections.under_way_mm(now_s, settings.delay_s);
        let remaining_mm = match reach {
            Reach::Seen(lateral_mm) | Reach::Bridged(lateral_mm) => Some(lateral_mm - pose.lateral_mm - under_way_mm),
            Reach::Before | Reach::Unknown | Reach::Unlooked => None,
        };
        let mut answer = Answer { state, why, remaining_mm, ..self.answer(why, pose, now_s) };
        let (State::Ok | State::Coast, Some(remaining_mm)) = (state, remaining_mm) else { return answer };
        if (self.corrections.total_mm() + remaining_mm).abs() > settings.total_mm {
            self.guard.stop(Why::OutOfReach);
            return Answer { remaining_mm: Some(remaining_mm), ..self.answer(Why::OutOfReach, pose, now_s) };
        }
        let step_mm = self.corrections.send(settings.gain * remaining_mm, (now_s, since_s), &settings);
        answer.correction = Correction::Step(step_mm);
        answer.total_mm = self.corrections.total_mm();
        answer
    }

    /// The answer that nothing is sent in.
    fn answer(&self, why: Why, pose: Pose, now_s: f64) -> Answer {
        Answer {
            state: State::Stop,
            why,
            correction: Correction::Hold,
            pose,
            total_mm: self.corrections.total_mm(),
            remaining_mm: None,
            age_s: self.newest_s.map(|newest_s| now_s - newest_s),
        }
    }
}
