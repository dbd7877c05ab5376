//! Time from the stamps of the frames: how long after the frame before, in seconds and in beats.
//!
//! A *beat* is the recording's own period \[s\]: the median of its last steps. What the models call a frame is a beat, so a
//! dropped frame is two of them and a hurried one a half. One stamp out of place does not change it.

use std::collections::VecDeque;

use arrayvec::ArrayVec;

/// Steps that the beat is the median of. Chosen: a few seconds, so that a camera may change its rate.
const REMEMBERED_STEPS: usize = 31;
/// The beat before two stamps are known \[s\]: Du 2022.
const FIRST_BEAT_S: f64 = 0.2;
/// A step this near to whole beats is whole beats: jitter of the stamps is not motion. Chosen.
const JITTER_BEATS: f64 = 0.1;
/// A stamp further ahead than this is out of place until the next one goes on from it \[beats\]. Chosen: dropped frames come
/// by the dozen, not by the hundred.
const LEAP_BEATS: f64 = 100.0;
/// Shortest and longest step \[beats\]. Chosen: no seam stands still for no time, and beyond the last all is forgotten.
const STEP_BEATS: std::ops::RangeInclusive<f64> = 0.05..=1e4;

/// One step of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// Since the frame before \[beats\], positive.
    pub beats: f64,
    /// The same \[s\].
    pub seconds: f64,
    /// The stamp says when the frame was taken: it is a number, and later than the one before. Otherwise one beat is
    /// taken to have passed.
    pub stamp_is_good: bool,
}

/// The recording's clock.
#[derive(Debug, Default)]
pub struct Clock {
    /// The last good stamp, and where the clock stands \[s\]: they differ after a bad stamp.
    last: Option<(f64, f64)>,
    /// A stamp that was out of place: if the next one goes on from it, the camera paused or its clock was set.
    stray_s: Option<f64>,
    steps_s: VecDeque<f64>,
}

impl Clock {
    /// The frame stamped `stamp_s` is the next one.
    pub fn tick(&mut self, stamp_s: f64) -> Tick {
        let Some((last_stamp_s, now_s)) = self.last else {
            self.last = stamp_s.is_finite().then_some((stamp_s, stamp_s));
            return self.one_beat(stamp_s.is_finite());
        };
        // A leap is believed when the next stamp goes on from it: the camera paused, or its clock was set.
        let follows =
            |from_s: f64| (0.0..=LEAP_BEATS * self.beat_s()).contains(&(stamp_s - from_s)) && stamp_s > from_s;
        let step_s = if follows(last_stamp_s) {
            Some(stamp_s - now_s)
        } else if self.stray_s.is_some_and(follows) {
            let paused_s = self.stray_s.map_or(0.0, |stray_s| stray_s - last_stamp_s).max(0.0);
            self.stray_s.map(|stray_s| stamp_s - stray_s + paused_s)
        } else {
            None
        };
        let Some(step_s) = step_s else {
            self.stray_s = stamp_s.is_finite().then_some(stamp_s);
            self.last = Some((last_stamp_s, now_s + self.beat_s()));
            return self.one_beat(false);
        };
        self.last = Some((stamp_s, stamp_s));
        self.stray_s = None;
        if step_s > 0.0 {
            self.steps_s.push_back(step_s);
            if self.steps_s.len() > REMEMBERED_STEPS {
                self.steps_s.pop_front();
            }
        }
        let beats = step_s / self.beat_s();
        let beats = if (beats - beats.round()).abs() < JITTER_BEATS { beats.round() } else { beats };
        let beats = beats.clamp(*STEP_BEATS.start(), *STEP_BEATS.end());
        Tick { beats, seconds: beats * self.beat_s(), stamp_is_good: true }
    }

    fn one_beat(&self, stamp_is_good: bool) -> Tick {
        Tick { beats: 1.0, seconds: self.beat_s(), stamp_is_good }
    }

    /// The recording's period \[s\].
    pub fn beat_s(&self) -> f64 {
        let mut sorted: ArrayVec<f64, REMEMBERED_STEPS> = self.steps_s.iter().copied().take(REMEMBERED_STEPS).collect();
        if sorted.is_empty() {
            return FIRST_BEAT_S;
        }
        let middle = sorted.len() / 2;
        *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beats(stamps_s: &[f64]) -> Vec<f64> {
        let mut clock = Clock::default();
        stamps_s.iter().map(|stamp_s| clock.tick(*stamp_s).beats).collect()
    }

    #[test]
    fn a_dropped_frame_counts_twice() {
        assert_eq!(beats(&[0.0, 0.2, 0.4, 0.8, 1.0]), [1.0, 1.0, 1.0, 2.0, 1.0]);
    }

    #[test]
    fn one_stamp_out_of_place_does_not_change_the_unit_of_later_frames() {
        let mut stamps_s: Vec<f64> = (0..40).map(|i| 0.2 * f64::from(i)).collect();
        stamps_s[20] = stamps_s[21] - 0.03;
        let beats = beats(&stamps_s);
        assert!((beats[20] - 1.85).abs() < 1e-9 && (beats[21] - 0.15).abs() < 1e-9, "{beats:?}");
        assert!(beats[22..].iter().all(|beats| *beats == 1.0), "{beats:?}");
    }

    #[test]
    fn a_stamp_that_is_no_number_or_does_not_rise_is_bad_once_and_the_next_ones_are_good() {
        for bad_s in [f64::NAN, f64::INFINITY, 0.8, 0.3] {
            let mut clock = Clock::default();
            for i in 0..5 {
                assert!(clock.tick(0.2 * f64::from(i)).stamp_is_good);
            }
            assert!(!clock.tick(bad_s).stamp_is_good);
            for i in 6..9 {
                let tick = clock.tick(0.2 * f64::from(i));
                assert!(tick.stamp_is_good && tick.beats == 1.0, "after {bad_s}: {tick:?}");
            }
        }
    }

    #[test]
    fn a_stamp_an_hour_ahead_is_bad_once_and_a_pause_of_an_hour_is_believed_from_its_second_stamp_on() {
        let mut clock = Clock::default();
        for i in 0..5 {
            clock.tick(0.2 * f64::from(i));
        }
        assert!(!clock.tick(3600.0).stamp_is_good);
        let back = clock.tick(1.2);
        assert!(back.stamp_is_good && back.beats == 1.0, "{back:?}");
        assert!(!clock.tick(3600.0).stamp_is_good);
        let paused = clock.tick(3600.2);
        assert!(paused.stamp_is_good && paused.beats > 9e3, "{paused:?}");
        let next = clock.tick(3600.4);
        assert!(next.stamp_is_good && next.beats == 1.0, "{next:?}");
    }

    #[test]
    fn a_clock_that_was_set_back_is_followed_from_its_second_stamp_on() {
        let mut clock = Clock::default();
        for i in 0..5 {
            clock.tick(100.0 + 0.2 * f64::from(i));
        }
        assert!(!clock.tick(3.0).stamp_is_good);
        for i in 1..5 {
            let tick = clock.tick(3.0 + 0.2 * f64::from(i));
            assert!(tick.stamp_is_good && tick.beats == 1.0, "{tick:?}");
        }
    }

    #[test]
    fn stamps_that_stand_still_are_all_bad() {
        let mut clock = Clock::default();
        clock.tick(1.0);
        assert!((0..5).all(|_| !clock.tick(1.0).stamp_is_good));
    }
}
