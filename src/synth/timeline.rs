//! Everything that is correlated from frame to frame, simulated once for the whole recording: a few numbers a frame.

use rand::Rng;
use rand_pcg::Pcg64Mcg;

use super::draw::Drawn;
use super::noise::{Ar1, Component, generator, normal};
use super::scenario::{PathTerm, Recorder};

/// What is so in one recorded frame.
#[derive(Debug, Clone)]
pub(super) struct Moment {
    /// The camera's frame number: missing frames run on, repeated frames stand still.
    pub(super) tick: usize,
    /// The camera frame whose plates are seen: `tick`, until they stand still.
    pub(super) plates_tick: usize,
    /// Time stamp \[s\].
    pub(super) timestamp_s: f64,
    /// Where the joint is along the stripe \[px\].
    pub(super) along_px: f64,
    /// How far the plates are displaced across the stripe \[px\].
    pub(super) across_px: f64,
    /// Displacement of the left and right edge by raggedness \[px\].
    pub(super) raggedness_px: [f64; 2],
    /// Arc glare relative to its mean; 0 before arc-on.
    pub(super) flicker: f64,
    /// Exposure relative to its mean.
    pub(super) exposure: f64,
    /// Smoke's mean opacity in this frame.
    pub(super) opacity: f64,
    /// Whether a burst of spatter is on.
    pub(super) burst: bool,
    /// The cover over the seam: its number, which decides its look.
    pub(super) cover: Option<u64>,
}

/// The path of the joint in this seed's own numbers.
#[derive(Debug, Clone)]
pub(super) struct Course {
    terms: Vec<PathTerm>,
    span_frames: f64,
    offset_px: f64,
}

impl Course {
    /// A sum of terms over a recording of `span_frames`, its range centred on `centre_px`.
    fn centred(terms: &[PathTerm], span_frames: f64, centre_px: f64) -> Self {
        let mut course = Self { terms: terms.to_vec(), span_frames, offset_px: 0.0 };
        let (low, high) = course.range_px();
        course.offset_px = centre_px - 0.5 * (low + high);
        course
    }

    /// The position at a time \[px\].
    pub(super) fn at(&self, tick: f64) -> f64 {
        self.offset_px + self.terms.iter().map(|term| term.at(tick, self.span_frames)).sum::<f64>()
    }

    /// Lowest and highest position \[px\].
    pub(super) fn range_px(&self) -> (f64, f64) {
        (0..self.span_frames as usize)
            .map(|tick| self.at(tick as f64))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), position| (low.min(position), high.max(position)))
    }
}

/// The moments of a recording.
#[derive(Debug, Clone)]
pub(super) struct Timeline {
    /// One a recorded frame.
    pub(super) moments: Vec<Moment>,
    /// The joint along the stripe, without vibration.
    pub(super) along: Course,
    /// Number of the camera's frames.
    pub(super) ticks: usize,
}

/// Correlation of the smoke's opacity and of the exposure from frame to frame (chosen: smoke drifts off in seconds).
const SMOKE_CORRELATION: f64 = 0.85;
/// Standard deviation of the logarithm of the smoke's opacity (chosen).
const SMOKE_VARIATION: f64 = 0.35;
/// Mean length of a puff of smoke and of a burst of spatter \[frames\] (chosen: 0.6 s).
const EPISODE_FRAMES: f64 = 3.0;

/// Simulates a recording whose path is centred on `centre_px` along the stripe.
pub(super) fn simulate(drawn: &Drawn, seed: u64, centre_px: f64) -> Timeline {
    let scenario = &drawn.scenario;
    let mut rng = generator(seed, 0, Component::Timeline);
    let clock = camera_clock(&scenario.recorder, scenario.frames, &mut rng);
    let ticks = clock.last().map_or(1, |&(tick, _)| tick + 1);
    let along = Course::centred(&scenario.path, ticks as f64, centre_px);
    let height = Course::centred(&scenario.height, ticks as f64, 0.0);
    let mut camera = camera_moments(drawn, ticks, &along, &height, &mut rng);
    if let Some(from) = scenario.view.standstill_from_frame {
        stand_still(&mut camera, from);
    }
    if scenario.view.exposure_follows_arc > 0.0 {
        follow_arc(&mut camera, scenario.view.exposure_follows_arc * drawn.disturbances.arc.glare_grey);
    }
    let moments = clock
        .iter()
        .map(|&(tick, periods)| {
            let jitter_s = scenario.recorder.jitter_s * f64::from(normal(&mut rng)).clamp(-1.4, 1.4);
            Moment { timestamp_s: periods as f64 * scenario.period_s + jitter_s, ..camera[tick].clone() }
        })
        .collect();
    Timeline { moments, along, ticks }
}

/// Nothing of the plates moves any more from a camera frame on.
fn stand_still(camera: &mut [Moment], from: usize) {
    let Some(last) = camera.get(from).cloned() else { return };
    for moment in &mut camera[from..] {
        moment.plates_tick = last.plates_tick;
        (moment.along_px, moment.across_px) = (last.along_px, last.across_px);
        moment.raggedness_px = last.raggedness_px;
    }
}

/// Glare that halves the exposure of a camera that follows the arc \[grey\] (chosen: a target of about 100 grey).
const HALVING_GLARE_GREY: f64 = 100.0;
/// Share of the way to its aim that an automatic exposure goes in a frame (chosen: it settles within some five frames).
const EXPOSURE_STEP: f64 = 0.35;

/// Lets the exposure follow the arc's glare, `glare_grey` at its mean.
fn follow_arc(camera: &mut [Moment], glare_grey: f64) {
    let mut exposure = 1.0;
    for moment in camera {
        moment.exposure *= exposure;
        let aim = 1.0 / (1.0 + glare_grey * moment.flicker / HALVING_GLARE_GREY);
        exposure += EXPOSURE_STEP * (aim - exposure);
    }
}

/// For each recorded frame the camera's frame number and the time in periods.
fn camera_clock(recorder: &Recorder, frames: usize, rng: &mut Pcg64Mcg) -> Vec<(usize, usize)> {
    let mut clock = vec![(0, 0)];
    while clock.len() < frames {
        let &(tick, periods) = clock.last().unwrap_or(&(0, 0));
        let (repeat, drop) = (rng.random::<f64>(), rng.random::<f64>());
        clock.push(if repeat < recorder.repeated {
            (tick, periods + 1)
        } else if drop < recorder.dropped {
            let missing = rng.random_range(1..=4);
            (tick + 1 + missing, periods + 1 + missing)
        } else {
            (tick + 1, periods + 1)
        });
    }
    clock.truncate(frames);
    clock
}

/// One moment a camera frame.
fn camera_moments(drawn: &Drawn, ticks: usize, along: &Course, height: &Course, rng: &mut Pcg64Mcg) -> Vec<Moment> {
    let (s, d) = (&drawn.scenario, &drawn.disturbances);
    let mut vibration = [s.vibration.along_px, s.vibration.across_px].map(|sd| Ar1::new(sd, s.vibration.correlation));
    let mut edges = [Ar1::new(s.edges.raggedness_px, s.edges.correlation); 2];
    let mut flicker = Ar1::new(d.arc.flicker, d.arc.flicker_correlation);
    let mut exposure = Ar1::new(s.sensor.exposure, SMOKE_CORRELATION);
    let mut smoke = Ar1::new(SMOKE_VARIATION, SMOKE_CORRELATION);
    let (mut burst, mut smoky) = (false, false);
    let (mut cover_left, mut covers) = (0_usize, 0_u64);
    (0..ticks)
        .map(|tick| {
            let arc_on = tick >= s.arc_on_frame;
            let [burst_roll, cover_roll, smoke_roll] = [(); 3].map(|()| rng.random::<f64>());
            let cover_frames = rng.random_range(d.covers.frames[0]..=d.covers.frames[1]);
            burst = arc_on && goes_on(burst, d.spatter.burst_share, burst_roll);
            smoky = arc_on && goes_on(smoky, d.smoke.share, smoke_roll);
            cover_left = cover_left.saturating_sub(1);
            if arc_on && cover_left == 0 && cover_roll < d.covers.per_100_frames / 100.0 {
                cover_left = cover_frames;
                covers += 1;
            }
            let log_normal = |x: f64, sd: f64| (x - 0.5 * sd * sd).exp();
            let flicker = log_normal(flicker.step(rng), d.arc.flicker) * if burst { BURST_FLASH } else { 1.0 };
            let opacity = (d.smoke.opacity * log_normal(smoke.step(rng), SMOKE_VARIATION)).min(0.8);
            Moment {
                tick,
                plates_tick: tick,
                timestamp_s: 0.0,
                along_px: along.at(tick as f64) + vibration[0].step(rng),
                across_px: height.at(tick as f64) + vibration[1].step(rng),
                raggedness_px: [edges[0].step(rng), edges[1].step(rng)],
                flicker: if arc_on { flicker } else { 0.0 },
                exposure: 1.0 + exposure.step(rng),
                opacity: if smoky { opacity } else { 0.0 },
                burst,
                cover: (cover_left > 0).then_some(covers),
            }
        })
        .collect()
}

/// The next state of a two-state chain whose episodes last [`EPISODE_FRAMES`] and take the stated share of the time.
fn goes_on(now: bool, share: f64, roll: f64) -> bool {
    roll < if now { 1.0 - 1.0 / EPISODE_FRAMES } else { share / (1.0 - share) / EPISODE_FRAMES }
}

/// How much brighter the arc is in a burst (chosen).
const BURST_FLASH: f64 = 1.25;
