//! How far a plate moved in the picture from frame to frame, by its texture beside the stripe.
//!
//! The stripe stands still in the picture while the sensor moves along the plate, and so does the laser's glare. What moves
//! is what ambient light shows. Pieces on both sides of the stripe are registered by normalised cross-correlation, first
//! at a quarter of the size and over all shifts, then at full size near the best one.

use nalgebra::Vector2;

use crate::frame::GrayFrame;
use crate::units::StripeAxis;

/// Pieces begin this far from the stripe \[px\] and are at most this wide; near the stripe the scale is the plate's at it.
const BESIDE_PX: usize = 30;
const PIECE_PX: usize = 150;
/// Half the window of the mean that is taken, against the camera's noise \[px\].
const SMOOTH_HALF_PX: usize = 2;
/// Half the window of the mean that is taken off, so that light which does not move has no say \[px\].
const MEAN_HALF_PX: usize = 16;
/// Reduction of the first pass, and its reach \[reduced px\]: moves of up to 96 px are found.
const REDUCTION: usize = 4;
const COARSE_REACH: isize = 24;
/// Reach of the second pass \[px\].
const FINE_REACH: isize = 5;
/// Frames are registered with one reference until it is this far away \[px\]: a small error of each registration then counts
/// once in several frames, and what is left of the still light is far from the peak.
const REFERENCE_PX: f64 = 64.0;
/// A piece is believed above this correlation, and beside a better one only when both moves agree \[px\].
const LEAST_CORRELATION: f64 = 0.3;
const AGREE_PX: f64 = 2.0;

/// A picture of contrasts: the mean of its surroundings is taken off.
struct Contrast {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

/// A rectangle: first and one past the last column and row.
#[derive(Clone, Copy)]
struct Piece {
    u: [usize; 2],
    v: [usize; 2],
}

/// Fewer different frames than this have no mean that is still light alone.
const LEAST_STILL: usize = 8;

/// The light that does not move: the mean of a recording's different frames. Stripe, glare, dirt on the glass and blocks
/// of a JPEG stand still while the plate moves, and would hold the registration at no motion.
#[derive(Default)]
pub struct StillLight {
    sums: Vec<f32>,
    count: usize,
    last: Option<GrayFrame>,
}

impl StillLight {
    /// Adds a frame; a repeated one does not count.
    pub fn add(&mut self, frame: &GrayFrame) {
        if self.sums.is_empty() {
            self.sums = vec![0.0; frame.pixels().len()];
        }
        if self.sums.len() == frame.pixels().len() && self.last.as_ref() != Some(frame) {
            self.sums.iter_mut().zip(frame.pixels()).for_each(|(sum, grey)| *sum += f32::from(*grey));
            self.count += 1;
            self.last = Some(frame.clone());
        }
    }

    /// What of a frame is not still.
    fn taken_off(&self, frame: &GrayFrame) -> Vec<f32> {
        let grey = frame.pixels().iter().map(|&grey| f32::from(grey));
        if self.count < LEAST_STILL || self.sums.len() != frame.pixels().len() {
            return grey.collect();
        }
        let share = 1.0 / self.count as f32;
        grey.zip(&self.sums).map(|(grey, sum)| grey - share * sum).collect()
    }
}

/// Registers frames one after another.
pub struct Travel {
    axis: StripeAxis,
    still: StillLight,
    previous: Option<GrayFrame>,
    reference: Option<(Contrast, Contrast)>,
    /// Of the last good frame from the reference \[px\].
    offset_px: Vector2<f64>,
    /// The pieces are those of the first frame.
    pieces: Vec<Piece>,
}

/// What one frame shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moved {
    /// The first frame.
    First,
    /// The same picture again: the camera was slower than the recorder.
    Repeated,
    /// Moved by this \[px\].
    By(Vector2<f64>),
    /// Nothing to hold on to.
    Unknown,
}

impl Travel {
    /// For recordings whose stripe runs along `axis`; `still` is the light of all of its frames that does not move.
    #[must_use]
    pub const fn new(axis: StripeAxis, still: StillLight) -> Self {
        Self { axis, still, previous: None, reference: None, offset_px: Vector2::new(0.0, 0.0), pieces: vec![] }
    }

    /// How far the plate moved since the last frame.
    pub fn step(&mut self, frame: &GrayFrame) -> Moved {
        if self.previous.as_ref() == Some(frame) {
            return Moved::Repeated;
        }
        self.previous = Some(frame.clone());
        if self.pieces.is_empty() {
            self.pieces = pieces(frame, self.axis);
        }
        let (width, height) = (frame.width_px(), frame.height_px());
        let moving = self.still.taken_off(frame);
        let coarse = reduced(width, height, &moving);
        let fine = contrast(width, height, moving, SMOOTH_HALF_PX, MEAN_HALF_PX);
        let Some((reference_fine, reference_coarse)) = &self.reference else {
            self.reference = Some((fine, coarse));
            return Moved::First;
        };
        // A frame that shows nothing is passed over: the next one is registered with the same reference.
        let Some(offset_px) = self.register((reference_fine, &fine), (reference_coarse, &coarse)) else {
            return Moved::Unknown;
        };
        let by_px = offset_px - self.offset_px;
        self.offset_px = offset_px;
        if offset_px.norm() > REFERENCE_PX {
            self.reference = Some((fine, coarse));
            self.offset_px = Vector2::zeros();
        }
        Moved::By(by_px)
    }

    fn register(&self, fine: (&Contrast, &Contrast), coarse: (&Contrast, &Contrast)) -> Option<Vector2<f64>> {
        let found = self.pieces.iter().filter_map(|piece| {
            let small = Piece { u: piece.u.map(|u| u / REDUCTION), v: piece.v.map(|v| v / REDUCTION) };
            let (rough, _) = best_shift(coarse, small, (0, 0), COARSE_REACH)?;
            let start = (rough.x.round() as isize * REDUCTION as isize, rough.y.round() as isize * REDUCTION as isize);
            best_shift(fine, *piece, start, FINE_REACH).filter(|(_, correlation)| *correlation > LEAST_CORRELATION)
        });
        let found: Vec<(Vector2<f64>, f64)> = found.collect();
        let (best, _) = found.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let (mut sum, mut weight) = (Vector2::zeros(), 0.0);
        for (shift, correlation) in found.into_iter().filter(|(shift, _)| (shift - best).norm() < AGREE_PX) {
            sum += shift * correlation;
            weight += correlation;
        }
        Some(sum / weight)
    }
}

/// A piece on either side of the stripe, as long as the picture; none beside a stripe at the rim.
fn pieces(frame: &GrayFrame, axis: StripeAxis) -> Vec<Piece> {
    let (width, height) = (frame.width_px(), frame.height_px());
    let across = if axis == StripeAxis::Vertical { width } else { height };
    // The stripe is where most light is, summed along it.
    let light = |i: usize| -> u64 {
        match axis {
            StripeAxis::Vertical => (0..height).map(|v| u64::from(frame.pixels()[v * width + i])).sum(),
            StripeAxis::Horizontal => frame.row(i).iter().map(|&g| u64::from(g)).sum(),
        }
    };
    let stripe = (0..across).max_by_key(|&i| light(i)).unwrap_or(0);
    let sides = [
        [stripe.saturating_sub(BESIDE_PX + PIECE_PX), stripe.saturating_sub(BESIDE_PX)],
        [(stripe + BESIDE_PX).min(across), (stripe + BESIDE_PX + PIECE_PX).min(across)],
    ];
    let piece = |side: [usize; 2]| match axis {
        StripeAxis::Vertical => Piece { u: side, v: [0, height] },
        StripeAxis::Horizontal => Piece { u: [0, width], v: side },
    };
    sides.into_iter().filter(|[a, b]| b - a >= BESIDE_PX).map(piece).collect()
}

fn reduced(full_width: usize, full_height: usize, moving: &[f32]) -> Contrast {
    let (width, height) = (full_width / REDUCTION, full_height / REDUCTION);
    let mut values = vec![0.0; width * height];
    for v in 0..height * REDUCTION {
        for u in 0..width * REDUCTION {
            values[v / REDUCTION * width + u / REDUCTION] += moving[v * full_width + u];
        }
    }
    contrast(width, height, values, 0, MEAN_HALF_PX / REDUCTION)
}

/// The mean over a square of `near` less the mean over one of `far`, by sums over rows and columns.
fn contrast(width: usize, height: usize, values: Vec<f32>, near: usize, far: usize) -> Contrast {
    let mut sums = vec![0.0f64; (width + 1) * (height + 1)];
    for v in 0..height {
        let mut row = 0.0;
        for u in 0..width {
            row += f64::from(values[v * width + u]);
            sums[(v + 1) * (width + 1) + u + 1] = sums[v * (width + 1) + u + 1] + row;
        }
    }
    let mean = |u: usize, v: usize, half: usize| {
        let (top, bottom) = (v.saturating_sub(half), (v + half + 1).min(height));
        let (left, right) = (u.saturating_sub(half), (u + half + 1).min(width));
        let at = |v: usize, u: usize| sums[v * (width + 1) + u];
        let sum = at(bottom, right) - at(top, right) - at(bottom, left) + at(top, left);
        sum / ((bottom - top) * (right - left)) as f64
    };
    let mut out = values;
    for (i, out) in out.iter_mut().enumerate() {
        *out = (mean(i % width, i / width, near) - mean(i % width, i / width, far)) as f32;
    }
    Contrast { width, height, values: out }
}

/// The shift of largest correlation within `reach` of `start`, with a parabola through it, and the correlation.
fn best_shift(
    (from, to): (&Contrast, &Contrast),
    piece: Piece,
    start: (isize, isize),
    reach: isize,
) -> Option<(Vector2<f64>, f64)> {
    let side = 2 * reach + 1;
    let mut all = vec![f64::NEG_INFINITY; (side * side) as usize];
    for dv in -reach..=reach {
        for du in -reach..=reach {
            let shift = (start.0 + du, start.1 + dv);
            all[((dv + reach) * side + du + reach) as usize] =
                correlation(from, to, piece, shift).unwrap_or(f64::NEG_INFINITY);
        }
    }
    let best = (0..all.len()).max_by(|a, b| all[*a].total_cmp(&all[*b]))?;
    let (du, dv) = (best as isize % side, best as isize / side);
    let at = |du: isize, dv: isize| {
        let inside = (0..side).contains(&du) && (0..side).contains(&dv);
        if inside { all[(dv * side + du) as usize] } else { f64::NEG_INFINITY }
    };
    let peak = all[best];
    let vertex = |before: f64, behind: f64| {
        let bend = before - 2.0 * peak + behind;
        if bend.is_finite() && bend < 0.0 { (0.5 * (before - behind) / bend).clamp(-0.5, 0.5) } else { 0.0 }
    };
    let sub = Vector2::new(vertex(at(du - 1, dv), at(du + 1, dv)), vertex(at(du, dv - 1), at(du, dv + 1)));
    let whole = Vector2::new((start.0 + du - reach) as f64, (start.1 + dv - reach) as f64);
    peak.is_finite().then_some((whole + sub, peak))
}

/// Normalised correlation of the piece with the one shifted by (du, dv); none when less than half of it stays inside.
fn correlation(from: &Contrast, to: &Contrast, piece: Piece, (du, dv): (isize, isize)) -> Option<f64> {
    let overlap = |[a, b]: [usize; 2], shift: isize, side: usize| {
        let first = (a as isize).max(-shift) as usize;
        let end = (b as isize).min(side as isize - shift).max(0) as usize;
        (2 * end.saturating_sub(first) >= b - a && end > first).then_some(first..end)
    };
    let columns = overlap(piece.u, du, to.width)?;
    let rows = overlap(piece.v, dv, to.height)?;
    let (mut product, mut one, mut other) = (0.0f32, 0.0f32, 0.0f32);
    for v in rows {
        let a = &from.values[v * from.width..][columns.clone()];
        let shifted = (columns.start as isize + du) as usize;
        let b = &to.values[(v as isize + dv) as usize * to.width + shifted..][..columns.len()];
        for (x, y) in a.iter().zip(b) {
            product += x * y;
            one += x * x;
            other += y * y;
        }
    }
    let norm = f64::from(one).sqrt() * f64::from(other).sqrt();
    (norm > 0.0).then(|| f64::from(product) / norm)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth noise that repeats nowhere: random values on a lattice, −1 to 1, and between them.
    fn grain(x: f64, y: f64) -> f64 {
        let at = |i: f64, j: f64| {
            let mut hash = (i as i64 as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
                ^ (j as i64 as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
            hash = (hash ^ (hash >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            ((hash >> 40) as f64) / f64::from(1 << 23) - 1.0
        };
        let (i, j) = (x.floor(), y.floor());
        let ease = |t: f64| t * t * (3.0 - 2.0 * t);
        let (a, b) = (ease(x - i), ease(y - j));
        let row = |j: f64| (1.0 - a) * at(i, j) + a * at(i + 1.0, j);
        (1.0 - b) * row(j) + b * row(j + 1.0)
    }

    /// A plate's texture under a stripe that stands still, seen from `at_px`.
    fn plate(at_px: f64) -> GrayFrame {
        let mut frame = GrayFrame::filled(300, 200, 0).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 300) as f64, (i / 300) as f64);
            let x = u - at_px;
            let texture = 2.0 * grain(x / 5.0, v / 5.0);
            let stripe = 150.0 * (-0.5 * ((u - 150.0) / 3.0).powi(2)).exp();
            *pixel = (60.0 + 12.0 * texture + stripe).round() as u8;
        }
        frame
    }

    #[test]
    fn the_plates_texture_is_followed_to_a_tenth_of_a_pixel_past_a_stripe_that_stands_still() {
        // As the command does: what stands still is known from all frames.
        let mut still = StillLight::default();
        (0..24).for_each(|i| still.add(&plate(8.8 * f64::from(i))));
        let mut travel = Travel::new(StripeAxis::Vertical, still);
        assert_eq!(travel.step(&plate(0.0)), Moved::First);
        for (to, by) in [(8.8, 8.8), (17.6, 8.8), (14.0, -3.6)] {
            let Moved::By(moved) = travel.step(&plate(to)) else { panic!("nothing to hold on to") };
            assert!((moved.x - by).abs() < 0.1 && moved.y.abs() < 0.1, "{moved} for {by}");
        }
        assert_eq!(travel.step(&plate(14.0)), Moved::Repeated);
        assert_eq!(travel.step(&GrayFrame::filled(300, 200, 9).unwrap()), Moved::Unknown);
    }
}
