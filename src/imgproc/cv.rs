//! The only file of this folder that knows OpenCV: its median is 50 to 100 times faster than the alternatives.
#![expect(clippy::disallowed_types, reason = "the folder's one door to OpenCV")]

use opencv::core::{Mat, MatTraitConst};

use crate::frame::GrayFrame;

/// The side of a median's square neighbourhood \[px\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MedianKernel {
    /// No filter.
    Off,
    /// 3 × 3.
    Three,
    /// 5 × 5. Larger ones are ten times slower, and no better on a stripe of a few pixels.
    Five,
}

/// OpenCV refused a median.
#[derive(Debug, thiserror::Error)]
#[error("the median filter failed on a frame of {width_px} x {height_px} pixels")]
pub struct MedianError {
    width_px: usize,
    height_px: usize,
    source: opencv::Error,
}

/// The median of `frame` over `kernel`; the border is continued outwards.
///
/// # Errors
/// When OpenCV refuses the frame, for example for want of memory.
pub fn median(frame: &GrayFrame, kernel: MedianKernel) -> Result<GrayFrame, MedianError> {
    let side_px = match kernel {
        MedianKernel::Off => return Ok(frame.clone()),
        MedianKernel::Three => 3,
        MedianKernel::Five => 5,
    };
    let mut filtered = frame.clone();
    filter_into(frame, side_px, &mut filtered).map_err(|source| MedianError {
        width_px: frame.width_px(),
        height_px: frame.height_px(),
        source,
    })?;
    Ok(filtered)
}

fn filter_into(frame: &GrayFrame, side_px: i32, filtered: &mut GrayFrame) -> opencv::Result<()> {
    let (rows, cols) = (frame.height_px() as i32, frame.width_px() as i32);
    let source = Mat::new_rows_cols_with_data(rows, cols, frame.pixels())?;
    let buffer = filtered.pixels_mut().as_ptr();
    let mut target = Mat::new_rows_cols_with_data_mut(rows, cols, filtered.pixels_mut())?;
    opencv::imgproc::median_blur(&source, &mut target, side_px)?;
    // OpenCV silently reallocates a destination that it does not like, and leaves our buffer untouched.
    if target.data() != buffer {
        return Err(opencv::Error::new(opencv::core::StsUnmatchedSizes, "the median was written elsewhere"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn naive(frame: &GrayFrame, radius_px: isize) -> Vec<u8> {
        let mut out = vec![];
        for v in 0..frame.height_px() as isize {
            for u in 0..frame.width_px() as isize {
                let mut values: Vec<u8> = (-radius_px..=radius_px)
                    .flat_map(|dv| (-radius_px..=radius_px).map(move |du| (du, dv)))
                    .map(|(du, dv)| frame.at_clamped(u + du, v + dv))
                    .collect();
                values.sort_unstable();
                out.push(values[values.len() / 2]);
            }
        }
        out
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
        #[test]
        fn the_median_is_the_middle_of_the_sorted_neighbourhood(
            (width, height, pixels) in (1usize..24, 1usize..24)
                .prop_flat_map(|(w, h)| (Just(w), Just(h), proptest::collection::vec(any::<u8>(), w * h)))
        ) {
            let frame = GrayFrame::new(width, height, pixels).unwrap();
            let three = median(&frame, MedianKernel::Three).unwrap();
            prop_assert_eq!(three.pixels(), naive(&frame, 1));
            let five = median(&frame, MedianKernel::Five).unwrap();
            prop_assert_eq!(five.pixels(), naive(&frame, 2));
        }
    }
}
