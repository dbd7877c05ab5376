//! Seam-free controls: the seam of a real frame painted over with what is beside it.

use seamtrack::frame::GrayFrame;
use seamtrack::imgproc::StripeLineFinder;

/// How the stripe goes on across the place of the seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paint {
    /// The stretches on both sides, moved there, faded from one into the other.
    Moved,
    /// The same, mirrored at the paint's edges.
    Mirrored,
    /// Each row's mean of both sides, faded from one into the other.
    Smooth,
}

/// Columns painted on each side of the seam, and rows on each side of the stripe that belong to it \[px\].
const HALF_PX: isize = 10;
const STRIPE_HALF_PX: f64 = 14.0;
/// The ambient line is painted over within this distance of the seam, by the plate so far away \[px\].
const AMBIENT_HALF_PX: isize = 45;
const AMBIENT_AWAY_PX: isize = 100;

/// `frame` without its seam at `seam_px`.
pub fn without_seam(frame: &GrayFrame, seam_px: f64, paint: Paint) -> GrayFrame {
    let line = StripeLineFinder::default().find(frame).unwrap();
    let width = frame.width_px();
    let seam = seam_px.round() as isize;
    let mut painted = frame.clone();
    for v in 0..frame.height_px() {
        let near = (v as f64 - line.v_px(seam_px)).abs() <= STRIPE_HALF_PX;
        let half = if near { HALF_PX } else { AMBIENT_HALF_PX };
        for u in (seam - half).max(0)..=(seam + half).min(width as isize - 1) {
            let grey = |u: isize, tilt: isize| {
                let dv = (line.slope * (u - tilt) as f64).round() as isize;
                f64::from(frame.at_clamped(u, v as isize + dv))
            };
            let value = if near {
                let size = 2 * HALF_PX + 1;
                let (left_rim, right_rim) = (seam - HALF_PX, seam + HALF_PX);
                let (left, right) = match paint {
                    Paint::Moved => (grey(u - size, u), grey(u + size, u)),
                    Paint::Mirrored => (grey(2 * left_rim - 1 - u, u), grey(2 * right_rim + 1 - u, u)),
                    Paint::Smooth => {
                        let mean = |first: isize| (first..first + 12).map(|c| grey(c, u)).sum::<f64>() / 12.0;
                        (mean(left_rim - 12), mean(right_rim + 1))
                    }
                };
                let share = (u - left_rim) as f64 / (size - 1) as f64;
                left + share * (right - left)
            } else {
                let away = if seam < width as isize / 2 { AMBIENT_AWAY_PX } else { -AMBIENT_AWAY_PX };
                grey(u + away, u + away)
            };
            painted.pixels_mut()[v * width + u as usize] = value.round() as u8;
        }
    }
    painted
}
