//! The way of the stripe through a whole frame: the brightest narrow ridge from the left border to the right.
//!
//! A column's brightest pixel may belong to a spatter or to a reflection of the stripe. The stripe is what goes on from
//! column to column: a path of largest summed contrast on a coarse grid, found by dynamic programming. A bend costs
//! little and a jump, as at the edge of a plate, a fixed price whatever its height.

use std::ops::Range;

use crate::frame::GrayFrame;

/// Size of a cell \[px\], along and across the stripe: it averages the speckle and still resolves a thin stripe.
pub(super) const CELL_PX: (usize, usize) = (4, 2);
/// A ridge is brighter than both its neighbourhoods: from here to there across the stripe \[cells\], 8 px to 16 px.
const FLANK_CELLS: Range<usize> = 4..8;
/// Steepest stripe that is no jump \[cells per cell\]: a slope of 1.5.
const STEEPEST: usize = 3;
/// Price of one cell up or down, and of a jump, as shares of a well-lit cell. Chosen: a jump must pay off within 12 px,
/// so that the path passes over a gap, and a slope of 1 costs a tenth.
const BEND_PRICE: f32 = 0.05;
const JUMP_PRICE: f32 = 3.0;

/// What stands out is so many times the mean of all cells. Chosen: a stripe fills a hundredth of a picture.
const LEAST_OVER_MEAN: f32 = 6.0;

/// The row of the stripe \[px\] in each column, also where it passes over a gap. None for a frame without contrast.
#[must_use]
pub fn stripe_path(frame: &GrayFrame) -> Option<Vec<usize>> {
    let (columns, rows) = (frame.width_px() / CELL_PX.0, frame.height_px() / CELL_PX.1);
    if columns == 0 || rows < 2 * FLANK_CELLS.end + 1 {
        return None;
    }
    let contrast = contrast(frame, columns, rows);
    let lit = typical_ridge(&contrast, rows);
    if lit <= 0.0 {
        return None;
    }
    let reward: Vec<f32> = contrast.iter().map(|&c| (c / lit).min(1.0)).collect();
    let cells = best_path(&reward, rows);
    let row_of = |cell: usize| cell * CELL_PX.1 + CELL_PX.1 / 2;
    Some((0..frame.width_px()).map(|u| row_of(cells[(u / CELL_PX.0).min(columns - 1)])).collect())
}

/// By how much each cell exceeds the brighter of its two flanks \[grey\], column by column, not below 0.
pub(super) fn contrast(frame: &GrayFrame, columns: usize, rows: usize) -> Vec<f32> {
    // Row by row of cells, each between those above and below it.
    let mut sums = vec![0.0f32; columns * (rows + 1)];
    let mut mean = vec![0.0f32; columns * rows];
    let scale = 1.0 / (CELL_PX.0 * CELL_PX.1) as f32;
    for (j, mean) in mean.chunks_exact_mut(columns).enumerate() {
        let cells = |v: usize| frame.row(v)[..columns * CELL_PX.0].chunks_exact(CELL_PX.0);
        for v in j * CELL_PX.1..(j + 1) * CELL_PX.1 {
            for (sum, cell) in mean.iter_mut().zip(cells(v)) {
                *sum += f32::from(cell.iter().map(|&grey| u16::from(grey)).sum::<u16>());
            }
        }
        let (before, after) = sums[j * columns..].split_at_mut(columns);
        for ((mean, before), after) in mean.iter_mut().zip(before).zip(after) {
            *mean *= scale;
            *after = *before + *mean;
        }
    }
    let mut contrast = vec![0.0f32; columns * rows];
    let mut flank = vec![0.0f32; columns];
    for v in 0..rows {
        flank.fill(0.0);
        let above = (v + 1).saturating_sub(FLANK_CELLS.end)..(v + 1).saturating_sub(FLANK_CELLS.start);
        let below = (v + FLANK_CELLS.start).min(rows)..(v + FLANK_CELLS.end).min(rows);
        for range in [above, below].into_iter().filter(|range| !range.is_empty()) {
            let (start, end) = (&sums[range.start * columns..][..columns], &sums[range.end * columns..][..columns]);
            let count = range.len() as f32;
            for (flank, (start, end)) in flank.iter_mut().zip(start.iter().zip(end)) {
                let over = (end - start) / count;
                *flank = if over > *flank { over } else { *flank };
            }
        }
        for (u, (grey, flank)) in mean[v * columns..][..columns].iter().zip(&flank).enumerate() {
            let over = grey - flank;
            contrast[u * rows + v] = if over > 0.0 { over } else { 0.0 };
        }
    }
    contrast
}

/// The median over the columns of their strongest contrast \[grey\], of those that stand out: a stripe may be short.
fn typical_ridge(contrast: &[f32], rows: usize) -> f32 {
    let mut strongest = strongest(contrast, rows);
    let least = standing_out(contrast);
    strongest.retain(|&strong| strong > least);
    if strongest.is_empty() {
        return 0.0;
    }
    let middle = strongest.len() / 2;
    *strongest.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// The strongest contrast of each column \[grey\].
pub(super) fn strongest(contrast: &[f32], rows: usize) -> Vec<f32> {
    contrast.chunks_exact(rows).map(|column| column.iter().copied().fold(0.0, f32::max)).collect()
}

/// What a cell must exceed to stand out \[grey\].
pub(super) fn standing_out(contrast: &[f32]) -> f32 {
    LEAST_OVER_MEAN * (contrast.iter().sum::<f32>() / contrast.len() as f32)
}

/// The row of the best path in each column of cells.
fn best_path(reward: &[f32], rows: usize) -> Vec<usize> {
    let columns = reward.len() / rows;
    let mut sum = reward[..rows].to_vec();
    let mut next = vec![0.0f32; rows];
    let mut from = vec![0u32; columns * rows];
    for (column, reward) in reward.chunks_exact(rows).enumerate().skip(1) {
        let best = largest(&sum);
        let origin = &mut from[column * rows..][..rows];
        origin.fill(best as u32);
        next.fill(sum[best] - JUMP_PRICE);
        // From each of the rows near by in turn, all rows side by side.
        for down in 0..=2 * STEEPEST {
            let price = BEND_PRICE * down.abs_diff(STEEPEST) as f32;
            let (first, skipped) = (STEEPEST.saturating_sub(down), down.saturating_sub(STEEPEST));
            let reached = next.iter_mut().zip(&mut *origin).enumerate().skip(first);
            for ((v, (value, origin)), before) in reached.zip(&sum[skipped..]) {
                let near = before - price;
                *origin = if near > *value { (v + down - STEEPEST) as u32 } else { *origin };
                *value = if near > *value { near } else { *value };
            }
        }
        next.iter_mut().zip(reward).for_each(|(value, reward)| *value += reward);
        std::mem::swap(&mut sum, &mut next);
    }
    let mut path = vec![largest(&sum); columns];
    for column in (1..columns).rev() {
        path[column - 1] = from[column * rows + path[column]] as usize;
    }
    path
}

fn largest(values: &[f32]) -> usize {
    (0..values.len()).fold(0, |best, i| if values[i] > values[best] { i } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Brightness and row of a stripe.
    type Stripe<'a> = (f64, &'a dyn Fn(f64) -> Option<f64>);

    fn frame(stripes: &[Stripe<'_>]) -> GrayFrame {
        let mut frame = GrayFrame::filled(320, 240, 0).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 320) as f64, (i / 320) as f64);
            let light = stripes
                .iter()
                .filter_map(|(grey, row)| row(u).map(|row| grey * (-0.5 * ((v - row) / 2.0).powi(2)).exp()));
            *pixel = (9.0 + light.sum::<f64>()).min(255.0) as u8;
        }
        frame
    }

    #[test]
    fn the_brighter_of_two_stripes_is_followed_over_its_step() {
        let lap = |u: f64| Some(if u < 160.0 { 150.0 } else { 174.0 });
        let reflection = |u: f64| Some(if u < 177.0 { 112.0 } else { 136.0 });
        let path = stripe_path(&frame(&[(150.0, &lap), (90.0, &reflection)])).unwrap();
        for (u, row) in path.iter().enumerate().filter(|(u, _)| !(152..168).contains(u)) {
            assert!((*row as f64 - lap(u as f64).unwrap()).abs() <= 2.0, "column {u}: {row}");
        }
    }

    #[test]
    fn spatter_brighter_than_the_stripe_does_not_draw_the_path_away() {
        let stripe = |u: f64| Some(120.0 + 0.3 * u);
        let spatter = |u: f64| (100.0..108.0).contains(&u).then_some(60.0);
        let path = stripe_path(&frame(&[(150.0, &stripe), (240.0, &spatter)])).unwrap();
        assert!(path.iter().enumerate().all(|(u, &row)| (row as f64 - 120.0 - 0.3 * u as f64).abs() <= 3.0));
    }

    #[test]
    fn a_frame_without_contrast_or_too_small_has_no_path() {
        assert_eq!(stripe_path(&GrayFrame::filled(320, 240, 80).unwrap()), None);
        assert_eq!(stripe_path(&GrayFrame::filled(1, 1, 80).unwrap()), None);
    }
}
