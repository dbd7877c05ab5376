//! Pictures as another camera would have taken them.

use seamtrack::frame::GrayFrame;
use seamtrack::units::StripeAxis;

/// The picture with the stripe's two ends exchanged.
pub fn mirrored(frame: &GrayFrame, axis: StripeAxis) -> GrayFrame {
    match axis {
        StripeAxis::Horizontal => with_rows_reversed(frame),
        StripeAxis::Vertical => with_rows_reversed(&frame.transposed()).transposed(),
    }
}

/// The picture with what is above the stripe and what is below it exchanged.
pub fn upside_down(frame: &GrayFrame, axis: StripeAxis) -> GrayFrame {
    mirrored(
        frame,
        match axis {
            StripeAxis::Horizontal => StripeAxis::Vertical,
            StripeAxis::Vertical => StripeAxis::Horizontal,
        },
    )
}

/// Half of every grey value, rounded.
pub fn dimmed(frame: &GrayFrame) -> GrayFrame {
    let pixels = frame.pixels().iter().map(|grey| grey.div_ceil(2)).collect();
    GrayFrame::new(frame.width_px(), frame.height_px(), pixels).unwrap()
}

/// The mean of every 2 × 2 pixels, rounded.
pub fn binned(frame: &GrayFrame) -> GrayFrame {
    let (width, height) = (frame.width_px() / 2, frame.height_px() / 2);
    let pixel = |i: usize| {
        let (u, v) = (2 * (i % width), 2 * (i / width));
        let sum: u16 =
            [(u, v), (u + 1, v), (u, v + 1), (u + 1, v + 1)].map(|(u, v)| u16::from(frame.row(v)[u])).into_iter().sum();
        ((sum + 2) / 4) as u8
    };
    GrayFrame::new(width, height, (0..width * height).map(pixel).collect()).unwrap()
}

/// Each row read backwards.
fn with_rows_reversed(frame: &GrayFrame) -> GrayFrame {
    let pixels = (0..frame.height_px()).flat_map(|v| frame.row(v).iter().rev().copied()).collect();
    GrayFrame::new(frame.width_px(), frame.height_px(), pixels).unwrap()
}
