//! Time in frames.

/// Counts time in frames: the recording's shortest step is one.
#[derive(Debug, Default)]
pub struct Clock {
    last_s: Option<f64>,
    period_s: Option<f64>,
    frames: f64,
}

impl Clock {
    /// Frames since the last call, at least one.
    pub fn tick(&mut self, time_s: f64) -> f64 {
        let step_s = self.last_s.map(|last_s| time_s - last_s).filter(|step| *step > 0.0);
        self.last_s = Some(time_s);
        let Some(step_s) = step_s else { return 1.0 };
        let period_s = self.period_s.map_or(step_s, |period| period.min(step_s));
        self.period_s = Some(period_s);
        // Jitter of the stamps is not motion: steps are whole frames unless the stamps say clearly otherwise.
        let frames = step_s / period_s;
        let frames = if (frames - frames.round()).abs() < 0.1 { frames.round() } else { frames }.max(1.0);
        self.frames += frames;
        frames
    }

    /// A frame that repeats the last one takes no time: the seam has not moved.
    pub const fn skip(&mut self, time_s: f64) {
        self.last_s = Some(time_s);
    }

    /// Frames since the beginning.
    pub const fn now(&self) -> f64 {
        self.frames
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dropped_frame_counts_twice_and_a_repeated_one_not_at_all() {
        let mut clock = Clock::default();
        assert_eq!(clock.tick(0.0), 1.0);
        assert_eq!(clock.tick(0.2), 1.0);
        assert_eq!(clock.tick(0.6), 2.0);
        clock.skip(0.8);
        assert_eq!(clock.tick(1.0), 1.0);
    }
}
