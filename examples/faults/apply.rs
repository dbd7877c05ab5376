//! A fault strikes a recording: the frames that come out, where the seam is in each, and when it can be seen.

use anyhow::Result;
use rand::Rng;
use rand_pcg::Pcg64Mcg;
use seamtrack::synth::Scene;
use seamtrack::units::PixelPoint;

use crate::kinds::Kind;
use crate::paint::{blurred, brightened, covered, cropped, filled, torn};
use crate::recording::{FRAMES, JOINTS, Look, Recording};
use crate::replay::Shot;

/// First frames that a fault may strike: the seam was followed for a while.
const FIRST: std::ops::RangeInclusive<usize> = 40..=60;
/// How fast the seam leaves \[px/frame\], and for how long it is away \[frames\].
const LEAVING_PX: f64 = 6.0;
const AWAY: usize = 15;

/// A recording with a fault.
pub struct Struck {
    pub shots: Vec<Shot>,
    /// The seam in each frame, in the picture or beside it; none where there is none.
    pub seams: Vec<Option<PixelPoint>>,
    /// First frame that is not as it should be.
    pub first: usize,
    /// First frame that does not show the seam where it is, where the fault hides it.
    pub hidden: Option<usize>,
    /// First frame from which on the seam is seen again, or still; none when it does not come back.
    pub returns: Option<usize>,
}

impl Struck {
    /// The whole recording as it is, `first` being the place that is to be struck.
    fn plain(recording: &Recording, first: usize) -> Result<Self> {
        let (mut shots, mut seams) = (vec![], vec![]);
        for frame in 0..FRAMES {
            let picture = Some(recording.picture(frame, Look::default())?);
            shots.push(Shot { time_s: recording.scene.timestamp_s(frame), picture });
            seams.push(recording.seam(&recording.scene, frame, Look::default()));
        }
        Ok(Self { shots, seams, first, hidden: None, returns: Some(first) })
    }

    /// Nothing of the seam in `count` frames.
    fn hides(&mut self, count: usize) -> std::ops::Range<usize> {
        (self.hidden, self.returns) = (Some(self.first), Some(self.first + count));
        self.first..self.first + count
    }

    /// The frames from `first` on are those of `scene`.
    fn take(&mut self, recording: &Recording, scene: &Scene, frames: std::ops::Range<usize>) -> Result<()> {
        for frame in frames {
            self.shots[frame].picture = Some(recording.picture_of(scene, frame, Look::default())?);
            self.seams[frame] = recording.seam(scene, frame, Look::default());
        }
        Ok(())
    }

    /// The frames are those that a camera sees that looks elsewhere.
    fn look(&mut self, recording: &Recording, frame: usize, look: Look) -> Result<()> {
        self.shots[frame].picture = Some(recording.picture(frame, look)?);
        self.seams[frame] = recording.seam(&recording.scene, frame, look);
        Ok(())
    }

    /// Changes the pictures of some frames.
    fn each(
        &mut self,
        frames: std::ops::Range<usize>,
        mut change: impl FnMut(usize, &seamtrack::GrayFrame) -> Result<seamtrack::GrayFrame>,
    ) -> Result<()> {
        for frame in frames {
            if let Some(picture) = &self.shots[frame].picture {
                self.shots[frame].picture = Some(change(frame, picture)?);
            }
        }
        Ok(())
    }
}

/// The recording with the fault, drawn by `random`; none where it cannot strike.
pub fn struck(recording: &Recording, kind: Kind, random: &mut Pcg64Mcg) -> Result<Option<Struck>> {
    let first = random.random_range(FIRST);
    let mut struck = Struck::plain(recording, first)?;
    match kind {
        Kind::Nothing => {}
        Kind::Dropped => {
            let missing = first..first + random.random_range(1..=12);
            struck.shots.drain(missing.clone());
            struck.seams.drain(missing);
        }
        Kind::Repeated => {
            for frame in first..first + random.random_range(1..=3) {
                struck.shots[frame].picture = struck.shots[first - 1].picture.clone();
                struck.seams[frame] = struck.seams[first - 1];
            }
        }
        Kind::Truncated => {
            for frame in struck.hides(random.random_range(1..=12)) {
                struck.shots[frame].picture = None;
            }
        }
        Kind::Torn => {
            let cut = random.random_range(0.2..0.9);
            let rest = random.random_range(0..3);
            let mut before = recording.picture(first - 1, Look::default())?;
            struck.each(first..first + random.random_range(1..=10), |_, picture| {
                let old = std::mem::replace(&mut before, picture.clone());
                let rest = if rest == 2 { old } else { filled(picture, 128 * rest)? };
                Ok(torn(picture, (cut * picture.height_px() as f64) as usize, &rest))
            })?;
        }
        Kind::OtherSize => {
            let frames = struck.hides(random.random_range(1..=10));
            let columns = random.random_range(1..100);
            struck.each(frames, |_, picture| cropped(picture, columns))?;
        }
        Kind::Swapped => {
            for frame in (first..first + random.random_range(2..=10)).step_by(2) {
                struck.seams.swap(frame, frame + 1);
                let (earlier, later) = struck.shots.split_at_mut(frame + 1);
                std::mem::swap(&mut earlier[frame].picture, &mut later[0].picture);
            }
        }
        Kind::Black | Kind::White => {
            let frames = struck.hides(random.random_range(1..=20));
            struck.each(frames, |_, picture| filled(picture, if kind == Kind::Black { 0 } else { 255 }))?;
        }
        Kind::Defocused => {
            let sd_px = random.random_range(3.0..8.0);
            let frames = first..first + random.random_range(5..=30);
            struck.returns = Some(frames.end);
            struck.each(frames, |_, picture| blurred(picture, sd_px))?;
        }
        Kind::Exposure => {
            let gain = 10_f64.powf(random.random_range(-0.82..0.78));
            let frames = first..first + random.random_range(10..=60);
            struck.returns = Some(frames.end);
            struck.each(frames, |_, picture| Ok(brightened(picture, gain)))?;
        }
        Kind::Knocked => {
            let sign = if random.random() { 1 } else { -1 };
            let look = Look { along_px: sign * random.random_range(5..=40), across_px: random.random_range(-20..=20) };
            (first..FRAMES).try_for_each(|frame| struck.look(recording, frame, look))?;
        }
        Kind::Leaving => {
            if !leave(recording, random.random(), &mut struck)? {
                return Ok(None);
            }
        }
        Kind::Covered => {
            let (half_px, beside_px) = (random.random_range(50.0..90.0), random.random_range(-30.0..30.0));
            let grey = if random.random() { 3 } else { 150 };
            let (frames, axis) = (struck.hides(60), recording.scene.axis());
            // The thing hangs at the torch, which follows the seam.
            let seams = struck.seams.clone();
            struck.each(frames, |frame, picture| {
                let Some(seam) = seams[frame] else { return Ok(picture.clone()) };
                let middle = PixelPoint::new(seam.u_px + beside_px, seam.v_px + beside_px);
                Ok(covered(picture, axis, middle, half_px, grey))
            })?;
        }
        Kind::StripeOff => {
            let frames = struck.hides(random.random_range(10..=60));
            let seams = struck.seams.clone();
            struck.take(recording, &recording.without_stripe()?, frames)?;
            struck.seams = seams;
        }
        Kind::SecondEdge => {
            let sign = if random.random() { 1.0 } else { -1.0 };
            let Some(scene) = recording.with_second_seam(sign * random.random_range(40.0..90.0))? else {
                return Ok(None);
            };
            struck.returns = Some(first + 30);
            struck.take(recording, &scene, first..first + 30)?;
        }
        Kind::Ending => {
            (struck.hidden, struck.returns) = (Some(first), None);
            struck.take(recording, &recording.without_joint()?, first..FRAMES)?;
        }
        Kind::Another => {
            if recording.joint == "hairline" {
                return Ok(None);
            }
            let between = struck.hides(random.random_range(15..=30));
            let others: Vec<&str> = JOINTS[..4].iter().copied().filter(|joint| *joint != recording.joint).collect();
            let another = recording.another_joint(others[random.random_range(0..others.len())])?;
            struck.take(recording, &another, between.end..FRAMES)?;
            struck.take(recording, &recording.without_joint()?, between)?;
        }
        Kind::Frozen => {
            for frame in struck.hides(random.random_range(15..=60)) {
                struck.shots[frame].picture = struck.shots[first - 1].picture.clone();
            }
        }
        Kind::Stamps => {
            let (wrong, frames) = (random.random_range(0..4), first..first + random.random_range(1..=10));
            struck.returns = Some(frames.end);
            let before_s = struck.shots[first - 1].time_s;
            for frame in frames {
                let time_s = &mut struck.shots[frame].time_s;
                *time_s = match wrong {
                    0 => f64::NAN,
                    1 => before_s,
                    2 => before_s - *time_s + before_s,
                    _ => *time_s + 3600.0,
                };
            }
        }
    }
    Ok(Some(struck))
}

/// The camera is led away until the seam is out of its picture, and back; false where it cannot go so far.
fn leave(recording: &Recording, to_the_left: bool, struck: &mut Struck) -> Result<bool> {
    let sign = if to_the_left { -1.0 } else { 1.0 };
    let mut way_px = 0.0;
    let (mut away, mut returns) = (0, None);
    for frame in struck.first..FRAMES {
        if struck.hidden.is_none() || away < AWAY {
            way_px += LEAVING_PX;
        } else {
            way_px = f64::max(way_px - LEAVING_PX, 0.0);
        }
        // Out of the picture it waits.
        if struck.hidden.is_some() && away < AWAY {
            (way_px, away) = (way_px - LEAVING_PX, away + 1);
        }
        if way_px > recording.reach_px() as f64 {
            return Ok(false);
        }
        struck.look(recording, frame, Look { along_px: (sign * way_px) as i32, across_px: 0 })?;
        match struck.seams[frame].is_some_and(|seam| recording.shows(seam)) {
            false if struck.hidden.is_none() => struck.hidden = Some(frame),
            true if away == AWAY && returns.is_none() => returns = Some(frame),
            _ => {}
        }
    }
    struck.returns = returns;
    Ok(struck.hidden.is_some() && returns.is_some())
}
