//! Places of the picture where something was followed that turned out to be fixed to it: a dead block of the sensor, a gap in the
//! laser's line. What is found there again is the same, whatever it looks like.

use arrayvec::ArrayVec;

use super::seed::Seed;
use crate::tracker::view::View;

/// Places that are remembered, the newest. Chosen: a picture with more is not one to weld by.
const MOST_PLACES: usize = 4;
/// Least half width of a place \[px of the picture\]. Chosen: what seeks looks at joints that are so far apart as one.
const LEAST_HALF_PX: f64 = 6.0;

/// Stretches along the stripe \[px of the picture\].
#[derive(Debug, Default)]
pub struct FixedPlaces {
    places: ArrayVec<(f64, f64), MOST_PLACES>,
}

impl FixedPlaces {
    /// Remembers what lies round `along_px`, `wide_px` from edge to edge.
    pub fn push(&mut self, along_px: f64, wide_px: f64) {
        if self.places.is_full() {
            self.places.remove(0);
        }
        self.places.push((along_px, (0.5 * wide_px).max(LEAST_HALF_PX)));
    }

    /// Whether a joint with edges that is found in `view` is one of them.
    pub fn hold(&self, seed: &Seed, view: &View) -> bool {
        seed.model.kind.has_edges() && self.are_at(view.axis().along_px(view.picture_from_view(seed.fit.centre)))
    }

    fn are_at(&self, along_px: f64) -> bool {
        self.places.iter().any(|(place_px, half_px)| (along_px - place_px).abs() <= *half_px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_found_again_where_something_was_fixed_is_it_and_beside_it_is_not() {
        let mut fixed = FixedPlaces::default();
        assert!(!fixed.are_at(350.0));
        fixed.push(350.0, 46.0);
        assert!(fixed.are_at(330.0) && fixed.are_at(372.0) && !fixed.are_at(376.0));
        (0..MOST_PLACES).for_each(|i| fixed.push(30.0 * i as f64, 3.0));
        assert!(!fixed.are_at(350.0), "the oldest is forgotten");
        assert!(fixed.are_at(90.0) && !fixed.are_at(100.0));
    }
}
