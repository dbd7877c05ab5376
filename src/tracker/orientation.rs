//! Which way the stripe runs.

use crate::frame::GrayFrame;
use crate::imgproc::{CentrelineSettings, extract_centreline, stripes};
use crate::units::StripeAxis;

/// Least number of columns that a stripe covers smoothly.
const LEAST_SMOOTH_COLUMNS: usize = 40;

/// Largest step between neighbouring columns of one smooth stripe \[px\]. Chosen: slopes stay below 1, plus noise.
const LARGEST_STEP_PX: f32 = 2.0;

/// By how much one direction must win.
const LEAST_DOMINANCE: f64 = 1.5;

/// While no joint is found the direction is looked for again after so many frames, and another one counts when it was seen so often
/// in a row. Chosen: the first frames may show the arc or a lamp only, and a single one a spatter's track.
const LOOK_AGAIN_FRAMES: u32 = 4;
const LOOKS_TO_TURN: u32 = 3;

/// The direction of the stripe: told, or found and doubted until a joint is found along it.
#[derive(Debug)]
pub struct Orientation {
    axis: Option<StripeAxis>,
    is_told: bool,
    frames: u32,
    others: u32,
}

impl Orientation {
    /// What the user told, if anything.
    pub const fn told(axis: Option<StripeAxis>) -> Self {
        Self { axis, is_told: axis.is_some(), frames: 0, others: 0 }
    }

    /// The direction, where it is known.
    pub const fn axis(&self) -> Option<StripeAxis> {
        self.axis
    }

    /// Whether it is to be looked for in the next frame.
    pub const fn is_due(&mut self, has_joint: bool) -> bool {
        if self.axis.is_none() {
            return true;
        }
        if self.is_told || has_joint {
            return false;
        }
        self.frames += 1;
        self.frames.is_multiple_of(LOOK_AGAIN_FRAMES)
    }

    /// What a frame shows.
    pub fn see(&mut self, seen: Option<StripeAxis>) {
        let is_other = seen.is_some() && seen != self.axis;
        self.others = if is_other { self.others + 1 } else { 0 };
        if self.axis.is_none() || self.others == LOOKS_TO_TURN {
            self.axis = seen;
            self.others = 0;
        }
    }
}

/// The direction in which the frame shows a smooth stripe; none when it shows none or both alike.
#[must_use]
pub fn find_axis(frame: &GrayFrame) -> Option<StripeAxis> {
    let turned = frame.transposed();
    let (horizontal, vertical) = (smooth_columns(frame), smooth_columns(&turned));
    let (axis, more, less) = if horizontal >= vertical {
        (StripeAxis::Horizontal, horizontal, vertical)
    } else {
        (StripeAxis::Vertical, vertical, horizontal)
    };
    let is_clear = more >= LEAST_SMOOTH_COLUMNS && more as f64 >= LEAST_DOMINANCE * less as f64;
    if is_clear { Some(axis) } else { axis_of_stripes(frame, &turned) }
}

/// The direction of short stripes in a large picture, which most columns and rows do not cross.
fn axis_of_stripes(frame: &GrayFrame, turned: &GrayFrame) -> Option<StripeAxis> {
    let lit_px = |frame: &GrayFrame| stripes(frame).iter().map(|stripe| stripe.lit_px).sum::<f64>();
    let (horizontal, vertical) = (lit_px(frame), lit_px(turned));
    let clear = |more: f64, less: f64| more > LEAST_DOMINANCE * less;
    match (clear(horizontal, vertical), clear(vertical, horizontal)) {
        (true, _) => Some(StripeAxis::Horizontal),
        (_, true) => Some(StripeAxis::Vertical),
        _ => None,
    }
}

fn smooth_columns(frame: &GrayFrame) -> usize {
    let line = extract_centreline(frame, &CentrelineSettings::default());
    line.v_px.windows(2).filter(|pair| matches!(pair, [Some(a), Some(b)] if (a - b).abs() < LARGEST_STEP_PX)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_is_turned_when_frame_after_frame_shows_the_other_one_and_no_joint_was_found() {
        let (along, across) = (Some(StripeAxis::Horizontal), Some(StripeAxis::Vertical));
        let mut orientation = Orientation::told(None);
        let axis_after = |orientation: &mut Orientation, seen: &[Option<StripeAxis>]| {
            seen.iter().for_each(|&seen| orientation.see(seen));
            orientation.axis()
        };
        assert!(
            orientation.is_due(false) && axis_after(&mut orientation, &[None]).is_none() && orientation.is_due(false)
        );
        assert_eq!(axis_after(&mut orientation, &[along]), along);
        let due = (0..12).filter(|_| orientation.is_due(false)).count();
        assert_eq!(due, 3);
        assert!((0..20).all(|_| !orientation.is_due(true)), "along it there is a joint");
        assert_eq!(axis_after(&mut orientation, &[across, across, along]), along);
        assert_eq!(axis_after(&mut orientation, &[across, across]), along);
        assert_eq!(axis_after(&mut orientation, &[across]), across);
        let mut told = Orientation::told(along);
        assert!((0..20).all(|_| !told.is_due(false)));
    }

    #[test]
    fn the_direction_of_a_drawn_stripe_is_found_and_nothing_is_found_in_the_dark() {
        let mut frame = GrayFrame::filled(160, 120, 10).unwrap();
        for u in 10..150 {
            for dv in 0..5 {
                frame.pixels_mut()[(60 + u / 20 + dv) * 160 + u] = 200;
            }
        }
        assert_eq!(find_axis(&frame), Some(StripeAxis::Horizontal));
        assert_eq!(find_axis(&frame.transposed()), Some(StripeAxis::Vertical));
        assert_eq!(find_axis(&GrayFrame::filled(160, 120, 10).unwrap()), None);
        assert_eq!(find_axis(&GrayFrame::filled(1, 1, 255).unwrap()), None);
    }
}
