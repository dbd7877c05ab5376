//! What a guide may do: geometry of the sensor, limits of corrections, distances and ages.

use std::ops::RangeInclusive;

/// Limits and geometry of a [`Guide`](super::Guide). Every number has a default, said with its source.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields, default))]
pub struct GuideSettings {
    /// How far the stripe lies ahead of the torch, along the travel \[mm\]. 20: sensors of the trade have 20 to 40.
    pub ahead_mm: f64,
    /// From a correction's sending until the robot stands where it says \[s\]. 0.012: three RSI cycles of 4 ms.
    pub delay_s: f64,
    /// Share of the remaining error that one cycle corrects. At most 0.3: more swings, since the delay is known only roughly.
    pub gain: f64,
    /// Largest correction of one cycle \[mm\].
    pub step_mm: f64,
    /// Fastest correction \[mm/s\].
    pub speed_mm_s: f64,
    /// Largest sum of corrections \[mm\]. 5: the limit ABB's seam tracking has.
    pub total_mm: f64,
    /// Targets no further apart than this are one unbroken seam \[mm\].
    pub unbroken_mm: f64,
    /// Longest stretch without seam that is bridged, as a tack weld has it \[mm\]; both its ends must have been seen. 18: a
    /// little less than the look-ahead, so that half a second without pictures is bridged at 30 mm/s.
    pub tack_mm: f64,
    /// So far without a value is still [`State::Coast`](super::State::Coast), then [`State::Lost`](super::State::Lost) \[mm\].
    pub coast_mm: f64,
    /// So far without a value stops \[mm\].
    pub stop_mm: f64,
    /// A newest picture older than this is [`State::Coast`](super::State::Coast) \[s\].
    pub fresh_s: f64,
    /// Older than this it is [`State::Lost`](super::State::Lost) \[s\].
    pub coast_s: f64,
    /// Older than this it stops \[s\].
    pub stop_s: f64,
    /// Oldest target that is steered to \[s\]; must be longer than the way from stripe to torch takes.
    pub target_age_s: f64,
    /// A robot silent for longer than this stops \[s\].
    pub robot_silent_s: f64,
    /// The seam must be seen within this way after the start, the look-ahead not counted \[mm\].
    pub start_mm: f64,
    /// Length of the seam \[mm\]: behind it nothing is missed. Unknown when it is not given.
    #[cfg_attr(feature = "cli", serde(skip_serializing_if = "Option::is_none"))]
    pub seam_mm: Option<f64>,
    /// Largest σ of a sighting that becomes a target \[mm\].
    pub worst_std_mm: f64,
}

impl Default for GuideSettings {
    fn default() -> Self {
        Self {
            ahead_mm: 20.0,
            delay_s: 0.012,
            gain: 0.3,
            step_mm: 0.1,
            speed_mm_s: 15.0,
            total_mm: 5.0,
            unbroken_mm: 2.0,
            tack_mm: 18.0,
            coast_mm: 5.0,
            stop_mm: 15.0,
            fresh_s: 0.1,
            coast_s: 0.75,
            stop_s: 2.0,
            target_age_s: 10.0,
            robot_silent_s: 0.3,
            start_mm: 10.0,
            seam_mm: None,
            worst_std_mm: 0.5,
        }
    }
}

/// A setting that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the guide's {key} must be {range}, not {value}")]
pub struct BadGuideSetting {
    /// Its name.
    pub key: &'static str,
    /// What is allowed.
    pub range: String,
    /// What it is.
    pub value: f64,
}

impl GuideSettings {
    /// The same, once every number is in its range.
    ///
    /// # Errors
    /// Names the first number that is not.
    pub fn checked(self) -> Result<Self, BadGuideSetting> {
        let within = |key, value: f64, range: RangeInclusive<f64>| {
            if range.contains(&value) {
                return Ok(());
            }
            Err(BadGuideSetting { key, range: format!("from {} to {}", range.start(), range.end()), value })
        };
        within("ahead_mm", self.ahead_mm, 0.0..=200.0)?;
        within("delay_s", self.delay_s, 0.0..=1.0)?;
        within("gain", self.gain, 0.01..=0.3)?;
        within("step_mm", self.step_mm, 0.001..=5.0)?;
        within("speed_mm_s", self.speed_mm_s, 0.1..=500.0)?;
        within("total_mm", self.total_mm, 0.01..=100.0)?;
        within("unbroken_mm", self.unbroken_mm, 0.01..=20.0)?;
        // A stretch as long as the look-ahead would reach the torch before its far end is seen.
        within("tack_mm", self.tack_mm, self.unbroken_mm..=self.ahead_mm.max(self.unbroken_mm))?;
        within("coast_mm", self.coast_mm, 0.0..=200.0)?;
        within("stop_mm", self.stop_mm, self.coast_mm..=500.0)?;
        within("fresh_s", self.fresh_s, 0.005..=10.0)?;
        within("coast_s", self.coast_s, self.fresh_s..=10.0)?;
        within("stop_s", self.stop_s, self.coast_s..=60.0)?;
        within("target_age_s", self.target_age_s, 0.01..=600.0)?;
        within("robot_silent_s", self.robot_silent_s, 0.02..=10.0)?;
        within("start_mm", self.start_mm, 0.0..=1000.0)?;
        within("seam_mm", self.seam_mm.unwrap_or(1.0), 0.1..=1e6)?;
        within("worst_std_mm", self.worst_std_mm, 0.001..=10.0)?;
        Ok(self)
    }
}
