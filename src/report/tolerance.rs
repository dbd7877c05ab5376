//! `--tolerance`: on how many frames the path stays within ± so many millimetres, and where it does not.

use serde::{Deserialize, Serialize};

use super::results::Estimator;
use super::run::Run;
use crate::units::LengthUnit;

/// What the path is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reference {
    /// The truth that was given: the deviation is the error.
    Truth,
    /// x = 0, the `--origin`: the deviation is how far the seam lies from where the torch was set up.
    Origin,
}

/// A path within a tolerance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    /// Half the width of the band \[mm\].
    pub tolerance_mm: f64,
    /// What the path is held against.
    pub reference: Reference,
    /// Frames with a value and a reference.
    pub frames: usize,
    /// Of these, within the band \[%\].
    pub inside_pct: f64,
    /// The others, stretch by stretch.
    pub outside: Vec<Stretch>,
}

/// Frames in a row outside of the band; frames without a value do not end it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// First frame.
    pub first: usize,
    /// Last frame.
    pub last: usize,
    /// The frame farthest out.
    pub worst: usize,
    /// How far that is, with its sign \[mm\].
    pub worst_mm: f64,
}

impl Tolerance {
    /// The result in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Self { tolerance_mm, inside_pct, .. } = self;
        let of = match self.reference {
            Reference::Truth => "the truth",
            Reference::Origin => "x = 0",
        };
        let places = match self.outside.len() {
            0 => String::new(),
            1 => ", outside at 1 place".to_owned(),
            count => format!(", outside at {count} places"),
        };
        format!(
            "Within ±{tolerance_mm} mm of {of} on {inside_pct:.1} % of the {} frames with a value{places}.",
            self.frames
        )
    }
}

impl Run {
    /// The estimate that a tolerance judges: the smoothed path where there is one, else the filtered.
    #[must_use]
    pub fn best_estimator(&self) -> Estimator {
        let has_smoothed = self.rows.iter().any(|row| row.smooth_u_px.is_some());
        if has_smoothed { Estimator::Smoothed } else { Estimator::Filtered }
    }

    /// How far the path lies from what a tolerance holds it against, in the run's unit.
    #[must_use]
    pub fn deviation(&self) -> (Reference, Vec<Option<f64>>) {
        let estimator = self.best_estimator();
        match self.error(estimator) {
            Some(errors) => (Reference::Truth, errors),
            None => (Reference::Origin, self.position(estimator, &self.ruler())),
        }
    }

    /// The run within the tolerance that was asked for, if one was and lengths are in millimetres.
    #[must_use]
    pub fn tolerance(&self) -> Option<Tolerance> {
        let tolerance_mm = self.summary.limits.tolerance_mm.filter(|_| self.unit() == LengthUnit::Mm)?;
        let (reference, deviation_mm) = self.deviation();
        let known: Vec<f64> = deviation_mm.iter().flatten().copied().collect();
        let inside = known.iter().filter(|mm| mm.abs() <= tolerance_mm).count();
        Some(Tolerance {
            tolerance_mm,
            reference,
            frames: known.len(),
            inside_pct: 100.0 * inside as f64 / known.len().max(1) as f64,
            outside: stretches(&deviation_mm, tolerance_mm),
        })
    }
}

/// Where `deviation_mm` leaves ± `tolerance_mm`.
#[must_use]
pub fn stretches(deviation_mm: &[Option<f64>], tolerance_mm: f64) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = vec![];
    let mut open = false;
    for (frame, mm) in deviation_mm.iter().enumerate().filter_map(|(frame, mm)| Some((frame, (*mm)?))) {
        let is_outside = mm.abs() > tolerance_mm;
        match found.last_mut().filter(|_| open && is_outside) {
            Some(stretch) => {
                stretch.last = frame;
                if mm.abs() > stretch.worst_mm.abs() {
                    (stretch.worst, stretch.worst_mm) = (frame, mm);
                }
            }
            None if is_outside => found.push(Stretch { first: frame, last: frame, worst: frame, worst_mm: mm }),
            None => {}
        }
        open = is_outside;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_outside_are_told_as_stretches_with_their_farthest_frame() {
        let deviation = [Some(0.1), Some(0.4), None, Some(-0.6), Some(0.3), Some(0.31)];
        let found: Vec<_> = stretches(&deviation, 0.3).iter().map(|s| (s.first, s.last, s.worst, s.worst_mm)).collect();
        assert_eq!(found, [(1, 3, 3, -0.6), (5, 5, 5, 0.31)]);
    }
}
