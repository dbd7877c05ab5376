//! How many stripes a picture shows, and where: the plate's own, and its light on the table, a fixture or a second surface.
//!
//! Narrow bright cells that go on from column to column are a piece of a stripe. Pieces that follow one another along the
//! picture are of one stripe, unless a gap or a step longer than they are sets them apart; pieces that lie over one another
//! are not.

use super::stripe_path::{CELL_PX, contrast, standing_out, strongest};
use crate::frame::GrayFrame;
use crate::units::PixelRect;

/// Longer side of the picture that is looked at \[px\]: larger ones are brought down to it. Chosen: a stripe of SD 1 px in a
/// picture of 2,600 px still has a third of its contrast there.
const LOOKED_AT_PX: usize = 900;
/// Least contrast of a cell of a stripe, as a share of what a well-lit column has. Chosen: a dark plate has a fifth of a
/// bright one's light.
const LEAST_SHARE: f32 = 0.2;
/// The least of all \[grey\]: the crest of a wide glare has less. Chosen: half of what a single column must have.
const LEAST_CONTRAST_GREY: f32 = 8.0;
/// Columns of cells that a piece may miss, and by how many rows of cells it may climb on the way, a column. Chosen: speckle;
/// a slope of 1.
const BRIDGED: usize = 6;
const CLIMB: usize = 2;
/// Least length of a piece, and of a stripe \[columns of cells\]: 48 and 100 px. Chosen: longer than a spatter's tail.
const LEAST_PIECE: usize = 12;
const LEAST_STRIPE: usize = 25;
/// Least share of a piece's columns that are lit.
const LEAST_LIT: f64 = 0.6;
/// Pieces that share no more than this part of the shorter one may follow one another.
const OVERLAP: f64 = 0.2;

/// One stripe of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stripe {
    /// The least rectangle that holds it.
    pub bounds: PixelRect,
    /// How much of it is lit \[px\].
    pub lit_px: f64,
}

/// Lit cells that go on from column to column.
#[derive(Debug, Clone)]
struct Piece {
    first: usize,
    last: usize,
    /// Row of cells where it begins and where it ends, and the least and the largest.
    ends: (usize, usize),
    rows: (usize, usize),
    lit: usize,
}

impl Piece {
    const fn begin(column: usize, row: usize) -> Self {
        Self { first: column, last: column, ends: (row, row), rows: (row, row), lit: 1 }
    }

    const fn length(&self) -> usize {
        self.last - self.first + 1
    }

    fn go_on(&mut self, column: usize, row: usize) {
        self.last = column;
        self.ends.1 = row;
        self.rows = (self.rows.0.min(row), self.rows.1.max(row));
        self.lit += 1;
    }

    fn overlap(&self, other: &Self) -> usize {
        (self.last.min(other.last) + 1).saturating_sub(self.first.max(other.first))
    }
}

/// The stripes of a picture in which they run along the rows, the one with the most light first.
#[must_use]
pub fn stripes(frame: &GrayFrame) -> Vec<Stripe> {
    let side = frame.width_px().max(frame.height_px()).div_ceil(LOOKED_AT_PX);
    let raster = super::Raster::coarser(side);
    let Some(small) = raster.resample(frame) else { return vec![] };
    let (columns, rows) = (small.width_px() / CELL_PX.0, small.height_px() / CELL_PX.1);
    if columns == 0 || rows == 0 {
        return vec![];
    }
    let contrast = contrast(&small, columns, rows);
    let pieces = pieces(&contrast, rows);
    let mut groups = groups(pieces);
    groups.retain(|group| group.iter().map(Piece::length).sum::<usize>() >= LEAST_STRIPE);
    let mut stripes: Vec<Stripe> = groups.iter().map(|group| stripe(group, side)).collect();
    stripes.sort_by(|a, b| b.lit_px.total_cmp(&a.lit_px));
    stripes
}

/// The pieces of stripes, the longest first.
fn pieces(contrast: &[f32], rows: usize) -> Vec<Piece> {
    let least = least_contrast(contrast, rows);
    let mut open: Vec<Piece> = vec![];
    let mut done: Vec<Piece> = vec![];
    for (column, cells) in contrast.chunks_exact(rows).enumerate() {
        let (ended, going): (Vec<_>, Vec<_>) = open.into_iter().partition(|piece| column - piece.last > BRIDGED);
        done.extend(ended);
        open = going;
        for row in peaks(cells, least) {
            let reaches =
                |piece: &&mut Piece| piece.last < column && piece.ends.1.abs_diff(row) <= CLIMB * (column - piece.last);
            match open.iter_mut().filter(reaches).min_by_key(|piece| piece.ends.1.abs_diff(row)) {
                Some(piece) => piece.go_on(column, row),
                None => open.push(Piece::begin(column, row)),
            }
        }
    }
    done.extend(open);
    done.retain(|piece| piece.length() >= LEAST_PIECE && piece.lit as f64 >= LEAST_LIT * piece.length() as f64);
    done.sort_by_key(|piece| std::cmp::Reverse(piece.lit));
    done
}

/// What a cell must have at least \[grey\]. Well lit is the best tenth of the columns: a stripe may be short.
fn least_contrast(contrast: &[f32], rows: usize) -> f32 {
    let mut strongest = strongest(contrast, rows);
    let rank = strongest.len() * 9 / 10;
    let well_lit = *strongest.select_nth_unstable_by(rank, f32::total_cmp).1;
    standing_out(contrast).max(LEAST_SHARE * well_lit).max(LEAST_CONTRAST_GREY)
}

/// The rows of a column that have more than `least` and more than the rows beside them.
fn peaks(cells: &[f32], least: f32) -> impl Iterator<Item = usize> {
    let near = |v: usize| v.saturating_sub(2)..(v + 3).min(cells.len());
    let is_peak = move |&v: &usize| near(v).all(|w| cells[w] < cells[v] || (cells[w] == cells[v] && w >= v));
    (0..cells.len()).filter(move |&v| cells[v] > least).filter(is_peak)
}

/// Pieces that follow one another along the picture, put together: the longest first, each with the nearest that goes on.
fn groups(mut pieces: Vec<Piece>) -> Vec<Vec<Piece>> {
    let mut groups = vec![];
    while !pieces.is_empty() {
        let mut group = vec![pieces.remove(0)];
        loop {
            let fits = |piece: &Piece| {
                group
                    .iter()
                    .all(|other| (piece.overlap(other) as f64) <= OVERLAP * piece.length().min(other.length()) as f64)
            };
            let away = |piece: &Piece| group.iter().map(|other| distance(piece, other)).min();
            let length: usize = group.iter().map(Piece::length).sum();
            let is_near = |piece: &Piece| away(piece).is_some_and(|away| away <= length * CELL_PX.0);
            let fitting = (0..pieces.len()).filter(|&i| fits(&pieces[i]) && is_near(&pieces[i]));
            let Some(next) = fitting.min_by_key(|&i| away(&pieces[i])) else { break };
            group.push(pieces.remove(next));
        }
        groups.push(group);
    }
    groups
}

/// From the end of one piece to the beginning of the other \[px of what is looked at\].
fn distance(a: &Piece, b: &Piece) -> usize {
    let (left, right) = if a.first <= b.first { (a, b) } else { (b, a) };
    let along = (right.first.saturating_sub(left.last)) * CELL_PX.0;
    along + left.ends.1.abs_diff(right.ends.0) * CELL_PX.1
}

fn stripe(group: &[Piece], side: usize) -> Stripe {
    let first = group.iter().map(|piece| piece.first).min().unwrap_or(0);
    let end = group.iter().map(|piece| piece.last + 1).max().unwrap_or(0);
    let top = group.iter().map(|piece| piece.rows.0).min().unwrap_or(0);
    let bottom = group.iter().map(|piece| piece.rows.1 + 1).max().unwrap_or(0);
    let bounds = PixelRect {
        u_px: first * CELL_PX.0 * side,
        v_px: top * CELL_PX.1 * side,
        width_px: (end - first) * CELL_PX.0 * side,
        height_px: (bottom - top) * CELL_PX.1 * side,
    };
    Stripe { bounds, lit_px: (group.iter().map(|piece| piece.lit).sum::<usize>() * CELL_PX.0 * side) as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stripe's brightness, SD and row, where it is lit.
    type Drawn<'a> = (f64, f64, &'a dyn Fn(f64) -> Option<f64>);

    fn picture(drawn: &[Drawn<'_>]) -> GrayFrame {
        let mut frame = GrayFrame::filled(1200, 800, 0).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 1200) as f64, (i / 1200) as f64);
            let light = drawn
                .iter()
                .filter_map(|(grey, sd, row)| row(u).map(|row| grey * (-0.5 * ((v - row) / sd).powi(2)).exp()));
            *pixel = (20.0 + light.sum::<f64>()).min(255.0) as u8;
        }
        frame
    }

    #[test]
    fn the_plates_short_stripe_and_its_brighter_light_on_the_table_are_two() {
        let plate = |u: f64| (470.0..740.0).contains(&u).then_some(300.0 + 0.05 * u);
        let table = |u: f64| (450.0..840.0).contains(&u).then_some(620.0);
        let found = stripes(&picture(&[(90.0, 1.5, &plate), (220.0, 7.0, &table)]));
        assert_eq!(found.len(), 2, "{found:?}");
        let of_plate = found.iter().find(|stripe| stripe.bounds.v_px < 400).unwrap();
        assert!(of_plate.bounds.u_px.abs_diff(470) <= 16 && of_plate.bounds.u_end_px().abs_diff(740) <= 16);
    }

    #[test]
    fn two_plates_with_a_gap_and_a_step_between_them_carry_one_stripe() {
        let lap = |u: f64| (!(500.0..620.0).contains(&u)).then_some(if u < 560.0 { 300.0 } else { 380.0 });
        let found = stripes(&picture(&[(180.0, 2.0, &lap)]));
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].bounds.width_px > 1150 && found[0].bounds.height_px > 70);
    }

    #[test]
    fn a_reflection_under_the_stripe_is_a_stripe_of_its_own() {
        let lap = |u: f64| (!(500.0..520.0).contains(&u)).then_some(if u < 510.0 { 300.0 } else { 340.0 });
        let ghost = |u: f64| lap(u).map(|v| v + 60.0);
        let found = stripes(&picture(&[(180.0, 2.0, &lap), (100.0, 2.0, &ghost)]));
        assert_eq!(found.len(), 2, "{found:?}");
    }

    #[test]
    fn a_glare_and_an_even_picture_show_none() {
        let glare = |u: f64| (300.0..500.0).contains(&u).then_some(400.0);
        assert_eq!(stripes(&picture(&[(220.0, 60.0, &glare)])), vec![]);
        assert_eq!(stripes(&picture(&[])), vec![]);
        assert_eq!(stripes(&GrayFrame::filled(1, 1, 3).unwrap()), vec![]);
    }
}
