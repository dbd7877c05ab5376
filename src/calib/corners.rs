//! A board's corners in one picture, in an order that does not depend on how the board lay.

use nalgebra::Vector2;

use super::board::{BoardSize, LEAST_CORNERS};
use super::cv::{Grid, Search, find_grid, refine};
use crate::frame::GrayFrame;

/// Half the window of the refinement as a share of the distance to the next corner, and its bounds \[px\]. Chosen: the
/// window must not reach the next corner's edges; beyond 11 px nothing is gained.
const WINDOW_SHARE: f64 = 0.3;
const WINDOW_PX: (f64, f64) = (2.0, 11.0);
/// A refined corner farther than this share of a square from the found one was drawn away: the found one stays.
const REFINED_WITHIN: f64 = 0.1;

/// The corners of a board in one picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Corners {
    /// Number of inner corners.
    pub size: BoardSize,
    /// Row by row, in the order of [`BoardSize::points_mm`] \[px\].
    pub pixels: Vec<Vector2<f64>>,
}

/// Share of the pixels that are darker than white and darker than black, and the headroom above white: dark pictures, in
/// which a board spans twenty grey levels, are stretched before the detector sees them. Chosen: a board's white squares
/// fill more than 2 % of a picture, glare less; with the headroom hardly a square is clipped.
const WHITE_SHARE: f64 = 0.98;
const BLACK_SHARE: f64 = 0.01;
const HEADROOM: f64 = 1.25;

/// The frame with the board's black and white spread over the grey levels.
fn stretched(frame: &GrayFrame) -> GrayFrame {
    let mut histogram = [0usize; 256];
    frame.pixels().iter().for_each(|&grey| histogram[grey as usize] += 1);
    let level = |share: f64| {
        let rank = (share * frame.pixels().len() as f64) as usize;
        let mut seen = 0;
        histogram
            .iter()
            .position(|n| {
                seen += n;
                seen > rank
            })
            .unwrap_or(255) as f64
    };
    let black = level(BLACK_SHARE);
    let gain = 255.0 / (HEADROOM * (level(WHITE_SHARE) - black)).clamp(16.0, 255.0);
    let table: [u8; 256] = std::array::from_fn(|grey| ((grey as f64 - black) * gain).clamp(0.0, 255.0) as u8);
    let mut stretched = frame.clone();
    stretched.pixels_mut().iter_mut().for_each(|grey| *grey = table[*grey as usize]);
    stretched
}

/// The largest board of at least `LEAST_CORNERS` corners a side, with the size that the detector sees.
#[must_use]
pub fn find_any(frame: &GrayFrame) -> Option<Corners> {
    in_order(frame, grid(frame, (LEAST_CORNERS, LEAST_CORNERS), true)?)
}

/// The board of `size`; none where it is not seen as a whole.
#[must_use]
pub fn find_sized(frame: &GrayFrame, size: BoardSize) -> Option<Corners> {
    in_order(frame, grid(frame, (size.columns, size.rows), false)?)
}

/// Corners of a board that has hardly moved since they were found in another picture; none when one of them went astray.
#[must_use]
pub fn find_near(frame: &GrayFrame, near: &Corners) -> Option<Corners> {
    let spacing_px = spacing_px(&near.pixels, near.size);
    let pixels = refine(frame, &near.pixels, half_window_px(spacing_px)).ok()?;
    let stayed = |(a, b): (&Vector2<f64>, &Vector2<f64>)| (a - b).norm() < 2.0 * REFINED_WITHIN * spacing_px;
    pixels.iter().zip(&near.pixels).all(stayed).then_some(Corners { size: near.size, pixels })
}

fn half_window_px(spacing_px: f64) -> i32 {
    (WINDOW_SHARE * spacing_px).clamp(WINDOW_PX.0, WINDOW_PX.1) as i32
}

/// The detector's grid in the picture as it is, else in the stretched one. An error of OpenCV means a picture too small to
/// hold a board.
fn grid(frame: &GrayFrame, corners: (usize, usize), or_larger: bool) -> Option<Grid> {
    let found = |frame: &GrayFrame, thorough| {
        let search = Search { or_larger, thorough };
        find_grid(frame, corners, search).ok().flatten()
    };
    // Only the thorough search is sure to find the largest board.
    let quick = if or_larger { None } else { found(frame, false) };
    quick.or_else(|| found(frame, true)).or_else(|| found(&stretched(frame), true))
}

/// The corners refined and turned: as many columns as rows or fewer, right-handed, and the board's half turn told by the
/// colour of its squares. The detector turns some boards by 180°.
fn in_order(frame: &GrayFrame, grid: Grid) -> Option<Corners> {
    let size = BoardSize::new(grid.columns, grid.rows).ok()?;
    let mut pixels = grid.corners;
    if grid.columns > grid.rows {
        let turned = |i: usize| pixels[(grid.rows - 1 - i % grid.rows) * grid.columns + i / grid.rows];
        pixels = (0..pixels.len()).map(turned).collect();
    }
    let (along, down) = (pixels[1] - pixels[0], pixels[size.columns] - pixels[0]);
    if along.x * down.y - along.y * down.x < 0.0 {
        pixels = pixels.chunks_exact(size.columns).rev().flatten().copied().collect();
    }
    if size.shows_half_turn() && first_square_is_brighter(frame, &pixels, size) {
        pixels.reverse();
    }
    let spacing_px = spacing_px(&pixels, size);
    let refined = refine(frame, &pixels, half_window_px(spacing_px)).unwrap_or_else(|_| pixels.clone());
    let keep = |(found, refined): (Vector2<f64>, Vector2<f64>)| {
        if (refined - found).norm() < REFINED_WITHIN * spacing_px { refined } else { found }
    };
    let pixels: Vec<Vector2<f64>> = pixels.into_iter().zip(refined).map(keep).collect();
    pixels.iter().all(|p| p.iter().all(|x| x.is_finite())).then_some(Corners { size, pixels })
}

/// The least distance between neighbours along the rows and down the columns \[px\].
fn spacing_px(pixels: &[Vector2<f64>], size: BoardSize) -> f64 {
    let along = pixels.chunks_exact(size.columns).flat_map(|row| row.windows(2)).map(|pair| (pair[1] - pair[0]).norm());
    let down = (size.columns..pixels.len()).map(|i| (pixels[i] - pixels[i - size.columns]).norm());
    along.chain(down).fold(f64::INFINITY, f64::min)
}

/// Whether the squares of the first one's colour are the bright ones.
fn first_square_is_brighter(frame: &GrayFrame, pixels: &[Vector2<f64>], size: BoardSize) -> bool {
    let mut difference = 0.0;
    for row in 0..size.rows - 1 {
        for column in 0..size.columns - 1 {
            let i = row * size.columns + column;
            let middle = (pixels[i] + pixels[i + 1] + pixels[i + size.columns] + pixels[i + size.columns + 1]) / 4.0;
            let grey = f64::from(frame.at_clamped(middle.x.round() as isize, middle.y.round() as isize));
            difference += if (row + column) % 2 == 0 { grey } else { -grey };
        }
    }
    difference > 0.0
}
