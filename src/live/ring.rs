//! Where the seam was seen, by the path of the torch.

use std::collections::VecDeque;

/// Nearest that two targets lie \[mm\]: of more only the newest is kept. Chosen: far below what a torch can follow.
const SPACING_MM: f64 = 0.05;
/// Most targets. Chosen: 200 mm of the closest ones.
const MOST: usize = 4096;

/// Where the seam runs at one place of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The place \[mm\].
    pub path_mm: f64,
    /// The seam, across the travel, in the robot's frame \[mm\].
    pub lateral_mm: f64,
    /// When it was exposed \[s\].
    pub exposed_s: f64,
}

/// What the ring knows of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// Targets before and behind it, no further apart than an unbroken seam's.
    Seen(f64),
    /// Targets before and behind it, further apart, but not beyond the stretch that may be bridged.
    Bridged(f64),
    /// It lies before the first target.
    Before,
    /// No target behind it yet, or too far; or too old a one.
    Unknown,
    /// No picture shows it yet.
    Unlooked,
}

/// Targets in the order of the path. Memory is bounded.
#[derive(Debug, Clone, Default)]
pub struct PathRing {
    targets: VecDeque<Target>,
    /// Where the newest picture looked, with or without a seam in it \[mm\].
    looked_mm: Option<f64>,
}

impl PathRing {
    /// A picture looked at `path_mm`, whatever it showed.
    pub const fn look(&mut self, path_mm: f64) {
        self.looked_mm = Some(path_mm);
    }

    /// Takes a target. Those further along the path are forgotten: the robot went back, and looks again.
    pub fn push(&mut self, target: Target) {
        while self.targets.back().is_some_and(|last| last.path_mm >= target.path_mm) {
            self.targets.pop_back();
        }
        // Compared with the last but one, so that a slow robot's targets do not carry the last one along for ever.
        if let Some(i) = self.targets.len().checked_sub(2)
            && target.path_mm - self.targets[i].path_mm < SPACING_MM
        {
            self.targets.pop_back();
        }
        if self.targets.len() == MOST {
            self.targets.pop_front();
        }
        self.targets.push_back(target);
    }

    /// Forgets what lies behind `path_mm`, but for the last target there.
    pub fn forget_before(&mut self, path_mm: f64) {
        while self.targets.get(1).is_some_and(|second| second.path_mm <= path_mm) {
            self.targets.pop_front();
        }
    }

    /// The seam at `path_mm`, from targets exposed at `oldest_s` or later.
    #[must_use]
    pub fn at(&self, path_mm: f64, oldest_s: f64, unbroken_mm: f64, tack_mm: f64) -> Reach {
        let behind = self.targets.partition_point(|target| target.path_mm <= path_mm);
        let Some(before) = behind.checked_sub(1).map(|i| self.targets[i]) else {
            return if self.targets.is_empty() { Reach::Unknown } else { Reach::Before };
        };
        let Some(behind) = self.targets.get(behind) else {
            return if self.looked_mm.is_some_and(|looked_mm| path_mm <= looked_mm) {
                Reach::Unknown
            } else {
                Reach::Unlooked
            };
        };
        let apart_mm = behind.path_mm - before.path_mm;
        if before.exposed_s.min(behind.exposed_s) < oldest_s || apart_mm > tack_mm {
            return Reach::Unknown;
        }
        let share = (path_mm - before.path_mm) / apart_mm;
        let lateral_mm = before.lateral_mm + share * (behind.lateral_mm - before.lateral_mm);
        if apart_mm <= unbroken_mm { Reach::Seen(lateral_mm) } else { Reach::Bridged(lateral_mm) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(places: &[(f64, f64)]) -> PathRing {
        let mut ring = PathRing::default();
        for &(path_mm, lateral_mm) in places {
            ring.look(path_mm);
            ring.push(Target { path_mm, lateral_mm, exposed_s: path_mm });
        }
        ring
    }

    #[test]
    fn between_two_targets_the_seam_is_straight_and_beyond_the_last_it_is_not_known() {
        let ring = ring(&[(0.0, 0.0), (1.0, 2.0)]);
        assert_eq!(ring.at(0.5, 0.0, 2.0, 10.0), Reach::Seen(1.0));
        assert_eq!(ring.at(1.5, 0.0, 2.0, 10.0), Reach::Unlooked);
        assert_eq!(ring.at(-0.5, 0.0, 2.0, 10.0), Reach::Before);
    }

    #[test]
    fn a_tack_is_bridged_and_a_longer_stretch_is_not() {
        let ring = ring(&[(0.0, 0.0), (10.0, 1.0), (30.0, 2.0)]);
        assert_eq!(ring.at(5.0, 0.0, 2.0, 10.0), Reach::Bridged(0.5));
        assert_eq!(ring.at(20.0, 0.0, 2.0, 10.0), Reach::Unknown);
    }

    #[test]
    fn a_target_past_its_age_is_not_known_any_more() {
        let ring = ring(&[(0.0, 0.0), (1.0, 2.0)]);
        assert_eq!(ring.at(0.5, 0.1, 2.0, 10.0), Reach::Unknown);
    }

    #[test]
    fn a_place_that_a_picture_without_a_seam_showed_is_unknown_and_one_that_none_showed_is_unlooked() {
        let mut ring = ring(&[(0.0, 0.0), (1.0, 2.0)]);
        ring.look(3.0);
        assert_eq!(ring.at(2.5, 0.0, 2.0, 10.0), Reach::Unknown);
        assert_eq!(ring.at(3.5, 0.0, 2.0, 10.0), Reach::Unlooked);
    }

    #[test]
    fn a_robot_that_goes_back_looks_again() {
        let mut ring = ring(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
        ring.look(0.5);
        ring.push(Target { path_mm: 0.5, lateral_mm: 3.0, exposed_s: 9.0 });
        assert_eq!((ring.targets.len(), ring.at(1.0, 0.0, 2.0, 10.0)), (2, Reach::Unlooked));
    }

    #[test]
    fn a_robot_that_stands_or_creeps_fills_no_memory_and_leaves_no_hole() {
        let mut ring = PathRing::default();
        for i in 0..100_000 {
            ring.push(Target { path_mm: 0.001 * f64::from(i), lateral_mm: 0.0, exposed_s: 0.0 });
        }
        assert!(
            ring.targets.len() <= 2100 && matches!(ring.at(50.0, 0.0, 0.2, 0.2), Reach::Seen(_)),
            "{}",
            ring.targets.len()
        );
        (0..100_000).for_each(|_| ring.push(Target { path_mm: 100.0, lateral_mm: 0.0, exposed_s: 0.0 }));
        assert!(ring.targets.len() <= 2101);
    }
}
