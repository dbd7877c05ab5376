//! The laser's stripe on a board: its pixels, and the straight line that they are.
//!
//! A flat board and a flat sheet of light meet in a straight line, so a view tells no more about the plane than two
//! points of it, however many rows it has. Neighbouring rows share their speckle (correlation .4 to .9 on real steel),
//! so the number of independent rows is far below that of rows.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::adjust::StripeSupport;
use super::board::BoardSize;
use super::intrinsics::Intrinsics;
use super::pose::homography;
use crate::frame::GrayFrame;
use crate::imgproc::{CentrelineSettings, extract_along, stripe_path};
use crate::units::{PixelPoint, StripeAxis};

/// The stripe is sought this many squares beyond the outer corners: the board goes on for one.
const MARGIN_SQUARES: f64 = 0.9;
/// Least contrast of the stripe \[grey\]; black squares give back a quarter of the light.
const LEAST_CONTRAST_GREY: f32 = 10.0;
const LEAST_CONTRAST_RATIO: f32 = 0.08;
/// The centroid reaches down to this share of the peak. Chosen: speckle tears the peak, so the flanks must have their say; a
/// board and a plate have no plume that would pull them.
pub const BAND_RATIO: f32 = 0.15;
/// Shares of a picture's pixels darker than a white square, and than the stripe: 100 rows of 4 px in two megapixels are
/// .02 %.
const WHITE_SHARE: f64 = 0.95;
const STRIPE_SHARE: f64 = 0.9999;
/// The bright pixels between these ranks bound the stripe, with a margin \[px\].
const LIT_RANKS: (f64, f64) = (0.02, 0.98);
const LIT_MARGIN_PX: usize = 40;
/// Pairs of points tried for the first line, and how near a point must be to count \[px\].
const PAIRS: usize = 400;
const FIRST_REACH_PX: f64 = 3.0;
/// Tukey's constant in robust σ, its least value \[px\], and rounds.
const TUKEY: f64 = 4.685;
const LEAST_TUKEY_PX: f64 = 1.0;
const ROUNDS: usize = 8;
/// A line needs this many rows, and this share of the rows in which something was seen.
const LEAST_ROWS: usize = 30;
const LEAST_SHARE: f64 = 0.4;
/// A line whose rows scatter by more \[px\] is no stripe.
const MOST_SCATTER_PX: f64 = 3.0;
/// A line has at least this many independent rows.
const LEAST_INDEPENDENT: f64 = 4.0;

/// The stripe in one view.
#[derive(Debug, Clone)]
pub struct StripeLineSeen {
    /// Its pixels on the line.
    pub pixels: Vec<PixelPoint>,
    /// σ of a pixel across the stripe \[px\].
    pub scatter_px: f64,
    /// Rows that count as independent.
    pub independent_rows: f64,
    /// The two places that hold all that the line says; their errors are independent.
    pub supports: [StripeSupport; 2],
}

/// The stripe within a board. `dark` is the same view with the laser off, its corners moved by `shift_px` to this one.
#[must_use]
pub fn find_stripe(
    camera: &Intrinsics,
    board: BoardSize,
    corners: &[Vector2<f64>],
    lit: &GrayFrame,
    dark: Option<(&GrayFrame, Vector2<f64>)>,
) -> Option<StripeLineSeen> {
    let (only_board, corner) = lit_part(&board_only(board, corners, lit, dark)?)?;
    let [across, down] = [StripeAxis::Horizontal, StripeAxis::Vertical].map(|axis| {
        let pixels = match axis {
            StripeAxis::Horizontal => centreline(&only_board),
            StripeAxis::Vertical => centreline(&only_board.transposed()),
        };
        let in_full = |p: PixelPoint| PixelPoint::new(p.u_px + corner.0 as f64, p.v_px + corner.1 as f64);
        let pixels: Vec<PixelPoint> = pixels.into_iter().map(|p| in_full(axis.image_from_stripe(p))).collect();
        fit(camera, axis, &pixels)
    });
    [across, down].into_iter().flatten().max_by_key(|line| line.pixels.len())
}

/// What the laser adds, on the board alone.
fn board_only(
    board: BoardSize,
    corners: &[Vector2<f64>],
    lit: &GrayFrame,
    dark: Option<(&GrayFrame, Vector2<f64>)>,
) -> Option<GrayFrame> {
    let board_from_image = homography(&board.points_mm(1.0), corners)?.try_inverse()?;
    let inside = |u: usize, v: usize| is_on_board(&board_from_image, board, u as f64, v as f64);
    let (width, height) = (lit.width_px(), lit.height_px());
    let mut only = GrayFrame::filled(width, height, 0).ok()?;
    let mut greys: Vec<u8> = vec![];
    for v in 0..height {
        for u in 0..width {
            if inside(u, v) {
                let i = v * width + u;
                let light = match dark {
                    None => lit.pixels()[i],
                    Some((dark, shift_px)) => {
                        let without = sample(dark, u as f64 - shift_px.x, v as f64 - shift_px.y);
                        (f64::from(lit.pixels()[i]) - without).clamp(0.0, 255.0) as u8
                    }
                };
                only.pixels_mut()[i] = light;
                greys.push(light);
            }
        }
    }
    if greys.is_empty() {
        return None;
    }
    // Around the board lies its own typical grey, so that its rim is no stripe.
    let middle = greys.len() / 2;
    let typical = *greys.select_nth_unstable(middle).1;
    for v in 0..height {
        for u in 0..width {
            if !inside(u, v) {
                only.pixels_mut()[v * width + u] = typical;
            }
        }
    }
    Some(only)
}

/// The part of the picture that holds the bright pixels, and its first column and row. A stripe of 100 rows in a picture
/// of 1200 would else be lost among the rows without any.
fn lit_part(frame: &GrayFrame) -> Option<(GrayFrame, (usize, usize))> {
    let mut greys = frame.pixels().to_vec();
    let mut level = |share: f64| {
        let rank = (share * (greys.len() - 1) as f64) as usize;
        f64::from(*greys.select_nth_unstable(rank).1)
    };
    let bright = 0.5 * (level(WHITE_SHARE) + level(STRIPE_SHARE));
    let width = frame.width_px();
    let lit = frame.pixels().iter().enumerate().filter(|(_, grey)| f64::from(**grey) > bright);
    let (mut columns, mut rows): (Vec<usize>, Vec<usize>) = lit.map(|(i, _)| (i % width, i / width)).unzip();
    if columns.is_empty() {
        return None;
    }
    // A few glints must not stretch it.
    let extent = |all: &mut Vec<usize>, side: usize| {
        all.sort_unstable();
        let rank = |share: f64| all[(share * (all.len() - 1) as f64) as usize];
        (rank(LIT_RANKS.0).saturating_sub(LIT_MARGIN_PX), (rank(LIT_RANKS.1) + LIT_MARGIN_PX + 1).min(side))
    };
    let (left, right) = extent(&mut columns, width);
    let (top, bottom) = extent(&mut rows, frame.height_px());
    let pixels = (top..bottom).flat_map(|v| frame.row(v)[left..right].iter().copied()).collect();
    Some((GrayFrame::new(right - left, bottom - top, pixels).ok()?, (left, top)))
}

fn is_on_board(board_from_image: &Matrix3<f64>, board: BoardSize, u_px: f64, v_px: f64) -> bool {
    let at = board_from_image * Vector3::new(u_px, v_px, 1.0);
    let half = |corners: usize| 0.5 * (corners as f64 - 1.0) + MARGIN_SQUARES;
    (at.x / at.z).abs() <= half(board.columns) && (at.y / at.z).abs() <= half(board.rows)
}

/// The grey between four pixels.
fn sample(frame: &GrayFrame, u_px: f64, v_px: f64) -> f64 {
    let (u, v) = (u_px.floor(), v_px.floor());
    let (a, b) = (u_px - u, v_px - v);
    let at = |du: isize, dv: isize| f64::from(frame.at_clamped(u as isize + du, v as isize + dv));
    (1.0 - b) * ((1.0 - a) * at(0, 0) + a * at(1, 0)) + b * ((1.0 - a) * at(0, 1) + a * at(1, 1))
}

fn centreline(frame: &GrayFrame) -> Vec<PixelPoint> {
    let settings = CentrelineSettings {
        least_contrast_grey: LEAST_CONTRAST_GREY,
        least_contrast_ratio: LEAST_CONTRAST_RATIO,
        band_ratio: BAND_RATIO,
        ..CentrelineSettings::default()
    };
    let Some(path) = stripe_path(frame) else { return vec![] };
    let line = extract_along(frame, &settings, &path);
    let rows = line.v_px.iter().enumerate().filter_map(|(u, v)| Some(PixelPoint::new(u as f64, f64::from((*v)?))));
    rows.collect()
}

/// A point's coordinate along the stripe and across it.
fn along_across(axis: StripeAxis, p: Vector2<f64>) -> (f64, f64) {
    match axis {
        StripeAxis::Horizontal => (p.x, p.y),
        StripeAxis::Vertical => (p.y, p.x),
    }
}

#[derive(Clone, Copy)]
struct Line {
    at_zero: f64,
    slope: f64,
}

impl Line {
    fn off(self, (along, across): (f64, f64)) -> f64 {
        across - self.at_zero - self.slope * along
    }
}

/// A robust straight line through the rays of `pixels`; none where they make no line.
fn fit(camera: &Intrinsics, axis: StripeAxis, pixels: &[PixelPoint]) -> Option<StripeLineSeen> {
    let rays: Vec<(PixelPoint, (f64, f64))> =
        pixels.iter().filter_map(|&p| Some((p, along_across(axis, camera.ray(p)?)))).collect();
    if rays.len() < LEAST_ROWS {
        return None;
    }
    let focal_px = 0.5 * (camera.fx_px + camera.fy_px);
    let mut line = first_line(&rays, FIRST_REACH_PX / focal_px)?;
    let mut limit = 2.0 * FIRST_REACH_PX / focal_px;
    for _ in 0..ROUNDS {
        let weights = rays.iter().map(|(_, ray)| (1.0 - (line.off(*ray) / limit).powi(2)).max(0.0).powi(2));
        let mut sums = [0.0; 5];
        for ((_, (x, y)), w) in rays.iter().zip(weights) {
            for (sum, value) in sums.iter_mut().zip([1.0, *x, *y, x * x, x * y]) {
                *sum += w * value;
            }
        }
        let [w, wx, wy, wxx, wxy] = sums;
        let spread = wxx - wx * wx / w;
        if spread.is_nan() || spread <= 0.0 {
            return None;
        }
        let slope = (wxy - wx * wy / w) / spread;
        line = Line { at_zero: (wy - slope * wx) / w, slope };
        let mut off: Vec<f64> = rays.iter().map(|(_, ray)| line.off(*ray).abs()).filter(|off| *off < limit).collect();
        off.sort_by(f64::total_cmp);
        let sigma = 1.4826 * off.get(off.len() / 2)?;
        limit = (TUKEY * sigma).max(LEAST_TUKEY_PX / focal_px);
    }
    let on_line: Vec<&(PixelPoint, (f64, f64))> = rays.iter().filter(|(_, ray)| line.off(*ray).abs() < limit).collect();
    let count = on_line.len() as f64;
    let scatter = (on_line.iter().map(|(_, ray)| line.off(*ray).powi(2)).sum::<f64>() / (count - 2.0).max(1.0)).sqrt();
    let scatter_px = scatter * focal_px;
    if on_line.len() < LEAST_ROWS || count < LEAST_SHARE * rays.len() as f64 || scatter_px > MOST_SCATTER_PX {
        return None;
    }
    let independent_rows = independent(&on_line, line);
    let mean = on_line.iter().map(|(_, (along, _))| along).sum::<f64>() / count;
    let reach = (on_line.iter().map(|(_, (along, _))| (along - mean).powi(2)).sum::<f64>() / count).sqrt();
    // At the mean ± one SD of the rows the errors of a fitted line are independent, each of variance 2 σ²/n.
    let sigma_px = scatter_px * (2.0 / independent_rows).sqrt();
    let support = |along: f64| {
        let pixel = |along: f64| {
            let (a, b) = along_across(axis, Vector2::new(along, line.at_zero + line.slope * along));
            camera.project(&Vector3::new(a, b, 1.0))
        };
        let (before, at, behind) = (pixel(along - 0.001)?, pixel(along)?, pixel(along + 0.001)?);
        let direction = Vector2::new(behind.u_px - before.u_px, behind.v_px - before.v_px).normalize();
        Some(StripeSupport { pixel: at, across: Vector2::new(-direction.y, direction.x), sigma_px })
    };
    let supports = [support(mean - reach)?, support(mean + reach)?];
    Some(StripeLineSeen {
        pixels: on_line.into_iter().map(|(p, _)| *p).collect(),
        scatter_px,
        independent_rows,
        supports,
    })
}

/// The line with the most points near it, of pairs at fixed places of the list.
fn first_line(rays: &[(PixelPoint, (f64, f64))], reach: f64) -> Option<Line> {
    let mut best: Option<(usize, Line)> = None;
    for pair in 0..PAIRS {
        // Two quasi-random places (the golden ratio's and the plastic number's sequence).
        let place = |ratio: f64| ((pair as f64 + 1.0) * ratio).fract() * rays.len() as f64;
        let (a, b) = (rays[place(0.754_877_666) as usize].1, rays[place(0.569_840_291) as usize].1);
        let slope = (b.1 - a.1) / (b.0 - a.0);
        if !slope.is_finite() || slope.abs() > 1.2 {
            continue;
        }
        let line = Line { at_zero: a.1 - slope * a.0, slope };
        let near = rays.iter().filter(|(_, ray)| line.off(*ray).abs() < reach).count();
        if best.is_none_or(|(most, _)| near > most) {
            best = Some((near, line));
        }
    }
    best.map(|(_, line)| line)
}

/// n (1 − ρ)/(1 + ρ), ρ being the correlation of neighbouring rows (Bayley & Hammersley 1946, for an AR(1) series).
fn independent(on_line: &[&(PixelPoint, (f64, f64))], line: Line) -> f64 {
    let off: Vec<f64> = on_line.iter().map(|(_, ray)| line.off(*ray)).collect();
    let variance = off.iter().map(|o| o * o).sum::<f64>() / off.len() as f64;
    let neighbours = off.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / (off.len() as f64 - 1.0);
    let correlation = (neighbours / variance).clamp(0.0, 0.98);
    (off.len() as f64 * (1.0 - correlation) / (1.0 + correlation)).max(LEAST_INDEPENDENT)
}
