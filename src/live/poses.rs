//! Where the robot was, by time.

use std::collections::VecDeque;

/// Poses that are remembered. Chosen: a second of RSI's 4 ms.
const REMEMBERED: usize = 256;
/// Furthest beyond the newest pose that one is foretold \[s\]. Chosen: a pose every 12 ms, three missing.
const FORETOLD_S: f64 = 0.05;
/// Time over which the speed is measured \[s\]. Chosen: jitter of the stamps averages out, and a robot hardly speeds up. Over
/// less than half of it none is: poses that come in a heap would make any speed.
const SPEED_OVER_S: f64 = 0.1;

/// The torch at one moment: along the travel, and across it with the corrections that have been executed \[mm\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Along the travel \[mm\].
    pub path_mm: f64,
    /// Across the travel \[mm\].
    pub lateral_mm: f64,
}

impl Pose {
    fn between(self, other: Self, share: f64) -> Self {
        let mean = |a: f64, b: f64| a + share * (b - a);
        Self { path_mm: mean(self.path_mm, other.path_mm), lateral_mm: mean(self.lateral_mm, other.lateral_mm) }
    }
}

/// The last poses. Memory is bounded.
#[derive(Debug, Clone, Default)]
pub struct Poses {
    last: VecDeque<(f64, Pose)>,
}

impl Poses {
    /// Takes the pose of the moment `now_s`. Those of later moments are forgotten: their times were wrong.
    pub fn push(&mut self, now_s: f64, pose: Pose) {
        while self.last.back().is_some_and(|(at_s, _)| *at_s >= now_s) {
            self.last.pop_back();
        }
        if self.last.len() == REMEMBERED {
            self.last.pop_front();
        }
        self.last.push_back((now_s, pose));
    }

    /// The pose at `time_s`: between two, or a moment beyond the newest, as an exposure is that was read at once. To wait
    /// for the next pose instead would pair the exposure with a pose of another time whenever it comes late.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<Pose> {
        let behind = self.last.partition_point(|(at_s, _)| *at_s <= time_s);
        let before = behind.checked_sub(1)?;
        let second = if behind < self.last.len() { behind } else { before };
        let first = second.checked_sub(1)?;
        let ((first_s, first), (second_s, second)) = (self.last[first], self.last[second]);
        if time_s - second_s > FORETOLD_S {
            return None;
        }
        Some(first.between(second, (time_s - first_s) / (second_s - first_s)))
    }

    /// Speed along the travel \[mm/s\]; 0 before it can be told.
    #[must_use]
    pub fn speed_mm_s(&self) -> f64 {
        let Some(&(now_s, now)) = self.last.back() else { return 0.0 };
        let from = self.last.partition_point(|(at_s, _)| *at_s < now_s - SPEED_OVER_S);
        let (from_s, from) = self.last[from];
        if now_s - from_s >= 0.5 * SPEED_OVER_S { (now.path_mm - from.path_mm) / (now_s - from_s) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moving() -> Poses {
        let mut poses = Poses::default();
        for i in 0..1000 {
            poses.push(0.004 * f64::from(i), Pose { path_mm: 0.12 * f64::from(i), lateral_mm: 0.0 });
        }
        poses
    }

    #[test]
    fn an_exposure_between_two_poses_or_a_moment_behind_the_last_is_placed_and_no_other() {
        let poses = moving();
        let path_mm = |time_s| poses.at(time_s).map(|pose| pose.path_mm);
        assert!((path_mm(3.99).unwrap() - 119.7).abs() < 1e-9 && (path_mm(4.01).unwrap() - 120.3).abs() < 1e-9);
        assert_eq!((path_mm(4.1), path_mm(1.0)), (None, None));
    }

    #[test]
    fn speed_is_that_of_the_last_moment() {
        assert!((moving().speed_mm_s() - 30.0).abs() < 1e-9);
        assert_eq!(Poses::default().speed_mm_s(), 0.0);
        let mut heap = Poses::default();
        (0..5).for_each(|i| heap.push(1e-5 * f64::from(i), Pose { path_mm: f64::from(i), lateral_mm: 0.0 }));
        assert_eq!(heap.speed_mm_s(), 0.0);
    }

    #[test]
    fn a_pose_whose_time_turns_out_wrong_is_forgotten() {
        let mut poses = Poses::default();
        for (at_s, path_mm) in [(1.0, 0.0), (1.030, 1.0), (1.008, 2.0), (1.012, 3.0)] {
            poses.push(at_s, Pose { path_mm, lateral_mm: 0.0 });
        }
        assert!((poses.at(1.010).unwrap().path_mm - 2.5).abs() < 1e-9);
    }
}
