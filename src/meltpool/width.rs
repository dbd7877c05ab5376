//! The pool's width: its longest cut across the travel.
//!
//! In each row the pool is cut between its two edges. Near its widest place the square of the cut is a parabola, exactly
//! so for every ellipse however it lies; its top is the width. So all rows there share in it, and ragged or spattered
//! ones do not move it.

use super::edge::edge;
use super::pool::Pool;
use super::refusal::{Border, Refusal};
use super::robust::Parabola;
use super::travel::Turned;

/// The wide part: rows whose cut is at least this part of the reference cut, which one row in four exceeds. Chosen: six
/// tenths of an ellipse's length, where its outline is still steep across; streaks of spatter cross fewer rows.
const WIDE_PART: f64 = 0.82;
const REFERENCE_RANK: f64 = 0.75;
/// Fewest rows for a fit; chosen: a parabola takes three.
const FEWEST_ROWS: usize = 4;
/// Least part of the wide rows that must show both edges; chosen.
const LEAST_ROWS_SHARE: f64 = 0.5;
/// Where the picture's border cuts the wide part, its widest place must lie this far from the cut, in half its length
/// from its middle; chosen: the cuts must be seen to fall again.
const SURELY_INSIDE: f64 = 0.75;
/// Least scale of the residuals of the squared cut, relative to twice the cut: 0.05 px of each cut.
const LEAST_SCALE_PX: f64 = 0.05;

/// A width in the turned picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PoolWidth {
    pub(super) width_px: f64,
    /// Ends of the cut, left and right.
    pub(super) ends: [[f64; 2]; 2],
}

/// Buffers of the measurement.
#[derive(Debug, Default)]
pub(super) struct WidthMeter {
    cuts: Vec<Option<(f64, f64)>>,
    lengths: Vec<f64>,
    squared: Vec<[f64; 2]>,
    middles: Vec<[f64; 2]>,
    residuals: Vec<f64>,
}

impl WidthMeter {
    /// The width of a pool.
    pub(super) fn measure(&mut self, picture: &Turned<'_>, pool: &Pool) -> Result<PoolWidth, Refusal> {
        self.cut(pool, picture.height);
        let wide = self.wide_rows().ok_or(Refusal::NoPool)?;
        let right = (picture.width - 1) as f64;
        // The wide part is cut off by a side: its width is unknown, and larger than what is seen.
        let cut_off = |row: usize| self.cuts[row].is_some_and(|(a, b)| a == 0.0 || b == right);
        if wide.clone().any(cut_off) {
            return Err(Refusal::Border(Border::Side));
        }
        let centre = 0.5 * (wide.start + wide.end - 1) as f64;
        let half = (0.5 * wide.len() as f64).max(1.0);
        self.squared.clear();
        self.middles.clear();
        for row in wide.clone() {
            let Some((a, b)) = self.cuts[row] else { continue };
            let y = row as f64;
            let left = edge(picture, [a, y], [-1.0, 0.0], pool.reach_px);
            let right = edge(picture, [b, y], [1.0, 0.0], pool.reach_px);
            if let (Some(left), Some(right)) = (left, right) {
                let (a, b) = (a - left.offset_px, b + right.offset_px);
                let t = (y - centre) / half;
                self.squared.push([t, (b - a).powi(2)]);
                self.middles.push([t, 0.5 * (a + b)]);
            }
        }
        let fewest = FEWEST_ROWS.max((LEAST_ROWS_SHARE * wide.len() as f64) as usize);
        if self.squared.len() < fewest {
            // Rays that leave the picture are those of a pool too close to its side.
            let near = |row: usize| {
                let reach = pool.reach_px as f64;
                self.cuts[row].is_some_and(|(a, b)| a < reach || b > right - reach)
            };
            return Err(if wide.clone().any(near) { Refusal::Border(Border::Side) } else { Refusal::NoEdge });
        }
        let reference = self.squared.iter().map(|point| point[1]).fold(0.0, f64::max).sqrt();
        let least_scale = 2.0 * reference * LEAST_SCALE_PX;
        let parabola = Parabola::through(&self.squared, least_scale, &mut self.residuals).ok_or(Refusal::NoEdge)?;
        let place = top(&parabola);
        // A pool that goes on beyond the picture may be wider there.
        if place <= -SURELY_INSIDE && wide.start == 0 {
            return Err(Refusal::Border(Border::Front));
        }
        if place >= SURELY_INSIDE && wide.end == picture.height {
            return Err(Refusal::Border(Border::Behind));
        }
        let place = place.clamp(-1.0, 1.0);
        let squared = parabola.at(place);
        if squared <= 0.0 {
            return Err(Refusal::NoEdge);
        }
        let middles = Parabola::through(&self.middles, LEAST_SCALE_PX, &mut self.residuals).ok_or(Refusal::NoEdge)?;
        let (width_px, middle, y) = (squared.sqrt(), middles.at(place), centre + half * place);
        let ends = [[middle - 0.5 * width_px, y], [middle + 0.5 * width_px, y]];
        if ends[0][0] < 0.0 || ends[1][0] > right {
            return Err(Refusal::Border(Border::Side));
        }
        Ok(PoolWidth { width_px, ends })
    }

    /// Outermost pixels of each row.
    fn cut(&mut self, pool: &Pool, rows: usize) {
        self.cuts.clear();
        self.cuts.resize(rows, None);
        for &[x, y] in &pool.outline {
            let cut = self.cuts[y as usize].get_or_insert((x, x));
            *cut = (cut.0.min(x), cut.1.max(x));
        }
    }

    /// The longest run of rows whose cuts are near the reference.
    fn wide_rows(&mut self) -> Option<std::ops::Range<usize>> {
        self.lengths.clear();
        self.lengths.extend(self.cuts.iter().flatten().map(|(a, b)| b - a + 1.0));
        let rank = (REFERENCE_RANK * self.lengths.len().checked_sub(1)? as f64).round() as usize;
        let reference = *self.lengths.select_nth_unstable_by(rank, f64::total_cmp).1;
        let is_wide = |cut: &Option<(f64, f64)>| cut.is_some_and(|(a, b)| b - a + 1.0 >= WIDE_PART * reference);
        let (mut best, mut start) = (0..0, 0);
        for (row, cut) in self.cuts.iter().enumerate() {
            if !is_wide(cut) {
                start = row + 1;
            } else if row + 1 - start > best.len() {
                best = start..row + 1;
            }
        }
        (!best.is_empty()).then_some(best)
    }
}

/// Where a parabola is highest within −1 to 1, or on which side beyond: its top if it has one, else its higher end.
fn top(parabola: &Parabola) -> f64 {
    let c = &parabola.coefficients;
    if c[2] < 0.0 {
        -0.5 * c[1] / c[2]
    } else if parabola.at(1.0) > parabola.at(-1.0) {
        1.0
    } else {
        -1.0
    }
}
