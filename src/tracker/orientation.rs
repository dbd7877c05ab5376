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
