//! The clock of a camera or a robot, and ours.

use std::collections::VecDeque;

/// Time that one part of the minimum covers \[s\], and how many are remembered. Chosen: crystals drift 50 µs in a second at
/// most, so that over a minute the map is never more than 3 ms off, and the quickest picture of a minute is a quick one.
const PART_S: f64 = 6.0;
const PARTS: usize = 10;

/// Maps the stamps of a camera or a robot, which count from its power-on and drift, to the time of arrival's clock: by the minimum of
/// arrival − stamp over the last minute, which is that of the picture that came quickest.
#[derive(Debug, Clone, Default)]
pub struct StampMap {
    /// The beginning of each part, by our clock, and its minimum \[s\].
    parts: VecDeque<(f64, f64)>,
}

impl StampMap {
    /// When what is stamped `stamp_s`, and came at `arrived_s`, was so, by our clock \[s\]: never later than it came.
    pub fn map(&mut self, stamp_s: f64, arrived_s: f64) -> f64 {
        let lag_s = arrived_s - stamp_s;
        match self.parts.back_mut() {
            Some((began_s, least_s)) if arrived_s - *began_s < PART_S => *least_s = least_s.min(lag_s),
            _ => {
                if self.parts.len() == PARTS {
                    self.parts.pop_front();
                }
                self.parts.push_back((arrived_s, lag_s));
            }
        }
        stamp_s + self.parts.iter().map(|(_, least_s)| *least_s).fold(f64::INFINITY, f64::min)
    }

    /// The camera or robot was started anew: its clock may count from another moment.
    pub fn clear(&mut self) {
        self.parts.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_pictures_keep_their_time_and_a_drifting_clock_is_followed() {
        let mut map = StampMap::default();
        let mut worst_s: f64 = 0.0;
        for i in 0..36_000 {
            let taken_s = f64::from(i) / 60.0;
            let late_s = if i % 7 == 0 { 0.0003 } else { 0.004 };
            // 50 ppm fast, powered on 1000 s ago.
            let mapped_s = map.map(1000.0 + 1.00005 * taken_s, taken_s + late_s);
            assert!(mapped_s <= taken_s + late_s + 1e-9);
            worst_s = worst_s.max((mapped_s - taken_s).abs());
        }
        assert!(worst_s < 0.0035, "{worst_s}");
    }
}
