//! The two edges that explain best where a stripe is lit, and how sure they are.
//!
//! The objective is a negative log likelihood: before the left edge the left line should be lit, behind the right edge the
//! right line, with a truncated loss, a prior on the edges' distance and a weak one on their middle. It is looked at every
//! pixel first, then every quarter of one round the best place.

use std::cell::Cell;
use std::ops::Range;
use std::sync::LazyLock;

use arrayvec::ArrayVec;

/// Steps of the fine search a pixel; the coarse one takes whole pixels.
const STEPS_PER_PX: isize = 4;
/// How far round the coarse place the fine search goes \[steps\].
const FINE_REACH: isize = 6;
/// Width of an edge's transition \[px\], and how far from it a column is all lit or all dark \[px\].
const EDGE_WIDTH_PX: f64 = 0.5;
const EDGE_REACH_PX: isize = 3;
/// How lit a column is before an edge, by how many steps the edge lies beyond it, from the farthest behind it on.
static EDGE: LazyLock<[f64; (STEPS_PER_PX * (2 * EDGE_REACH_PX + 2)) as usize]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let ahead_px = (i as isize - STEPS_PER_PX * (EDGE_REACH_PX + 1)) as f64 / STEPS_PER_PX as f64;
        1.0 / (1.0 + (-ahead_px / EDGE_WIDTH_PX).exp())
    })
});
/// Bound of a column's squared mismatch.
const TRUNCATION: f64 = 0.8;
/// Weight and SD of the prior on the middle. Prototype: weak, so that the fit follows a moving seam.
const POSITION_WEIGHT: f64 = 0.4;
const POSITION_SD_PX: f64 = 4.0;
/// A place this far from the best one counts as another place \[px\].
const OTHER_PLACE_PX: f64 = 3.0;
/// What the objective is divided by to be the log of a probability, near the best place and between two places. Chosen: a
/// sharp edge, of which a shift by a pixel costs 0.8, is known to a fifth of one; between places, all columns of a spatter
/// err together.
const TEMPERATURE: f64 = 0.08;
const RIVAL_TEMPERATURE: f64 = 0.5;

/// Most columns of a stretch \[px\], and most middles that are looked at. Chosen: search ranges and gaps of a window of 160 px.
pub const MOST_COLUMNS: usize = 384;
const MOST_MIDDLES: usize = 512;

/// One side's columns: presence of the stripe, 0 to 1, and weight.
pub struct Presence {
    columns: ArrayVec<(f64, f64), MOST_COLUMNS>,
    /// Summed mismatch of the columns before each, if all were expected lit, and dark.
    if_lit: ArrayVec<f64, { MOST_COLUMNS + 1 }>,
    if_dark: ArrayVec<f64, { MOST_COLUMNS + 1 }>,
    /// Whether the stripe is expected lit before an edge, or behind it.
    lit_before: bool,
    /// Mismatch of the columns next to an edge, by its step; NaN where it was not asked for yet.
    next_to_edge: [Cell<f64>; MOST_COLUMNS * STEPS_PER_PX as usize],
}

/// What is known beforehand; places are relative to the prediction \[px\].
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    /// Place of the first column.
    pub first_du: f64,
    /// Largest distance of the middle.
    pub search_px: f64,
    /// Distance of the edges, its SD and its least.
    pub gap_px: f64,
    pub gap_sd_px: f64,
    pub least_gap_px: f64,
    /// The sides' lines are so far apart that each column shows one or the other: then all columns speak for both
    /// edges. Else those before the middle speak for the left one only, those behind it for the right one.
    pub distinct: bool,
}

/// The best pair of edges, relative to the prediction.
#[derive(Debug, Clone, Copy)]
pub struct EdgePair {
    pub left_du: f64,
    pub right_du: f64,
    /// Variance of their middle \[px²\].
    pub variance_px2: f64,
    /// Mean mismatch of a column, 0 to [`TRUNCATION`].
    pub cost: f64,
    /// By how much the next-best place is worse.
    pub margin: f64,
}

impl Presence {
    /// Of columns with presence and weight, the first [`MOST_COLUMNS`]; lit before an edge, or behind it.
    pub fn new(columns: impl Iterator<Item = (f64, f64)>, lit_before: bool) -> Self {
        let columns: ArrayVec<_, MOST_COLUMNS> = columns.take(MOST_COLUMNS).collect();
        let sums = |expected: f64| {
            let costs = columns.iter().scan(0.0, move |sum, &(lit, weight)| {
                *sum += mismatch(expected, lit, weight);
                Some(*sum)
            });
            std::iter::once(0.0).chain(costs).collect()
        };
        let (if_lit, if_dark) = (sums(1.0), sums(0.0));
        let next_to_edge = [const { Cell::new(f64::NAN) }; MOST_COLUMNS * STEPS_PER_PX as usize];
        Self { columns, if_lit, if_dark, lit_before, next_to_edge }
    }

    /// The mismatch of `columns` with an edge at `step`.
    fn cost(&self, step: isize, columns: Range<usize>) -> f64 {
        let at = |px: isize| (px.max(0) as usize).clamp(columns.start, columns.end);
        let edge_px = step.div_euclid(STEPS_PER_PX);
        let (first, end) = (edge_px - EDGE_REACH_PX, edge_px + EDGE_REACH_PX + 2);
        let (near, far) = (at(first), at(end));
        let (before, behind) =
            if self.lit_before { (&self.if_lit, &self.if_dark) } else { (&self.if_dark, &self.if_lit) };
        let beyond = before[near] - before[columns.start] + behind[columns.end] - behind[far];
        if (far - near) as isize != end - first {
            return beyond + self.next_to(step, near..far);
        }
        let known = &self.next_to_edge[step as usize];
        if known.get().is_nan() {
            known.set(self.next_to(step, near..far));
        }
        beyond + known.get()
    }

    /// The mismatch of these columns next to an edge at `step`.
    fn next_to(&self, step: isize, columns: Range<usize>) -> f64 {
        let first = columns.start as isize;
        let ahead = (0..).map(|i| EDGE[(step - STEPS_PER_PX * (first + i - EDGE_REACH_PX - 1)) as usize]);
        let expected = ahead.map(|before| if self.lit_before { before } else { 1.0 - before });
        self.columns[columns]
            .iter()
            .zip(expected)
            .map(|(&(lit, weight), expected)| mismatch(expected, lit, weight))
            .sum()
    }
}

fn mismatch(expected: f64, seen: f64, weight: f64) -> f64 {
    weight * (expected - seen).powi(2).min(TRUNCATION)
}

/// What the two sides' presences and what is expected make of a pair of edges.
struct Objective<'a> {
    sides: &'a [Presence; 2],
    expected: &'a Expected,
    columns: usize,
}

/// A pair of edges \[steps from the first column\].
type Pair = (isize, isize);

impl Objective<'_> {
    fn du(&self, step: f64) -> f64 {
        self.expected.first_du + step / STEPS_PER_PX as f64
    }

    fn middle(&self, (left, right): Pair) -> f64 {
        self.du(0.5 * (left + right) as f64)
    }

    /// The mismatch of the columns.
    fn data(&self, (left, right): Pair) -> f64 {
        let all = 0..self.columns;
        if self.expected.distinct {
            return self.sides[0].cost(left, all.clone()) + self.sides[1].cost(right, all);
        }
        let middle = 0.5 * (left + right) as f64 / STEPS_PER_PX as f64;
        let parting = ((middle + 0.5).round().max(0.0) as usize).min(self.columns);
        self.sides[0].cost(left, 0..parting) + self.sides[1].cost(right, parting..self.columns)
    }

    /// The whole, infinite where the pair may not be.
    fn at(&self, pair: Pair) -> f64 {
        let middle = self.middle(pair);
        if middle.abs() > self.expected.search_px {
            return f64::INFINITY;
        }
        let prior = self.prior_of_gap(pair.1 - pair.0) + prior_of_middle(middle);
        if prior.is_infinite() { prior } else { self.data(pair) + prior }
    }

    /// What is expected of the edges' distance \[steps\]; infinite where it may not be.
    fn prior_of_gap(&self, gap: isize) -> f64 {
        let gap_px = gap as f64 / STEPS_PER_PX as f64;
        let expected = self.expected;
        if gap_px < expected.least_gap_px {
            return f64::INFINITY;
        }
        0.5 * ((gap_px - expected.gap_px) / expected.gap_sd_px).powi(2)
    }

    /// The best pair of whole pixels from `first` to `last` of which the middle lies at half of `sum` \[px\].
    fn best_of_middle(&self, sum: isize, (first, last): (isize, isize)) -> (Pair, f64) {
        let mut best = ((0, 0), f64::INFINITY);
        let middle = self.du(0.5 * (sum * STEPS_PER_PX) as f64);
        if middle.abs() > self.expected.search_px {
            return best;
        }
        let prior_of_middle = prior_of_middle(middle);
        // From the expected distance on, larger ones, then smaller ones: as long as the prior alone is not worse than all.
        let expected = self.expected.gap_px.round() as isize;
        let start = expected + (expected + sum).rem_euclid(2);
        let most = (sum - 2 * first).min(2 * last - sum);
        let mut larger = (start..=most).step_by(2);
        let mut smaller =
            (0..).map(|i| start - 2 - 2 * i).skip_while(|&gap| gap > most).take_while(|&gap| gap >= -most);
        for gaps in [&mut larger as &mut dyn Iterator<Item = isize>, &mut smaller] {
            for gap in gaps {
                let prior = self.prior_of_gap(gap * STEPS_PER_PX) + prior_of_middle;
                if prior >= best.1 || prior.is_infinite() {
                    break;
                }
                let pair = ((sum - gap) / 2 * STEPS_PER_PX, (sum + gap) / 2 * STEPS_PER_PX);
                let value = self.data(pair) + prior;
                if value < best.1 {
                    best = (pair, value);
                }
            }
        }
        best
    }

    /// The best pair within `reach` of `pair`, with its value.
    fn best_near(&self, pair: Pair, reach: isize, allowed: impl Fn(Pair) -> bool) -> (Pair, f64) {
        let near = (-reach..=reach).flat_map(|i| (-reach..=reach).map(move |j| (pair.0 + i, pair.1 + j)));
        near.filter(|&pair| allowed(pair))
            .map(|pair| (pair, self.at(pair)))
            .fold((pair, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
    }
}

/// What is expected of the middle, where it may be \[px\].
fn prior_of_middle(middle: f64) -> f64 {
    0.5 * POSITION_WEIGHT * (middle / POSITION_SD_PX).powi(2)
}

/// The best pair of edges; none where none is allowed.
pub fn find(sides: &[Presence; 2], expected: &Expected) -> Option<EdgePair> {
    let columns = sides[0].columns.len().min(sides[1].columns.len());
    let objective = Objective { sides, expected, columns };
    let reach_px = expected.search_px + 0.5 * expected.gap_px.abs() + expected.gap_sd_px + 1.5;
    let end = |du: f64| (du - expected.first_du).round() as isize;
    let (first, last) = (end(-reach_px), end(reach_px));
    // The best pair of each middle, in half pixels.
    let sums = 2 * first..=2 * last;
    let best_of = sums.map(|sum| objective.best_of_middle(sum, (first, last))).filter(|best| best.1.is_finite());
    let best_of: ArrayVec<(Pair, f64), MOST_MIDDLES> = best_of.take(MOST_MIDDLES).collect();
    let least = |a: (Pair, f64), b: &(Pair, f64)| if b.1 < a.1 { *b } else { a };
    let coarse = best_of.iter().fold(((0, 0), f64::INFINITY), least);
    if coarse.1.is_infinite() {
        return None;
    }
    let (best, lowest) = objective.best_near(coarse.0, FINE_REACH, |_| true);
    let away_px = |pair: Pair| (objective.middle(pair) - objective.middle(best)).abs();
    let elsewhere = |pair: Pair| away_px(pair) > OTHER_PLACE_PX;
    let rival = best_of.iter().filter(|(pair, _)| elsewhere(*pair)).fold(((0, 0), f64::INFINITY), least);
    let (rival, rival_value) =
        if rival.1.is_finite() { objective.best_near(rival.0, STEPS_PER_PX / 2, elsewhere) } else { rival };
    let margin = if rival_value.is_finite() { rival_value - lowest } else { 0.0 };
    let (left, right, spread_px2) = moments(&objective, best, lowest);
    // Two places, the other of which has this share of the probability.
    let odds = if rival_value.is_finite() { (-margin / RIVAL_TEMPERATURE).exp() } else { 0.0 };
    let rival_px2 = odds / (1.0 + odds) * away_px(rival).powi(2);
    let weight: f64 = sides.iter().flat_map(|side| &side.columns).map(|(_, weight)| weight).sum::<f64>() * 0.5;
    Some(EdgePair {
        left_du: objective.du(left),
        right_du: objective.du(right),
        variance_px2: spread_px2 + rival_px2,
        cost: objective.data(best) / weight,
        margin,
    })
}

/// Means of both edges \[steps\] and variance of their middle \[px²\] round the best pair, as probable as the objective has
/// each place.
fn moments(objective: &Objective<'_>, best: Pair, lowest: f64) -> (f64, f64, f64) {
    let (mut sum, mut left, mut right, mut square) = (0.0, 0.0, 0.0, 0.0);
    for i in -FINE_REACH..=FINE_REACH {
        for j in -FINE_REACH..=FINE_REACH {
            let p = ((lowest - objective.at((best.0 + i, best.1 + j))) / TEMPERATURE).exp();
            let middle = 0.5 * (i + j) as f64;
            (sum, left, right) = (sum + p, left + p * i as f64, right + p * j as f64);
            square += p * middle * middle;
        }
    }
    let mean = 0.5 * (left + right) / sum;
    let variance = (square / sum - mean * mean) / (STEPS_PER_PX * STEPS_PER_PX) as f64;
    (best.0 as f64 + left / sum, best.1 as f64 + right / sum, variance)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPECTED: Expected =
        Expected { first_du: -28.5, search_px: 12.0, gap_px: 12.0, gap_sd_px: 1.6, least_gap_px: 1.0, distinct: false };

    /// Columns that are lit before (or behind) an edge, relative to the prediction.
    fn lit(edge_du: f64, before: bool) -> Presence {
        let lit = (0..58).map(|x| {
            let ahead = edge_du - (EXPECTED.first_du + f64::from(x));
            let is_before = 1.0 / (1.0 + (-ahead / EDGE_WIDTH_PX).exp());
            (if before { is_before } else { 1.0 - is_before }, 1.0)
        });
        Presence::new(lit, before)
    }

    #[test]
    fn two_edges_are_found_to_a_twentieth_of_a_pixel() {
        for shift in [0.0, 0.3, 0.55, 4.1] {
            let found = find(&[lit(shift - 6.0, true), lit(shift + 6.0, false)], &EXPECTED).unwrap();
            let middle = 0.5 * (found.left_du + found.right_du);
            // The prediction draws it a little.
            assert!((middle - shift).abs() < 0.03 + 0.02 * shift, "{shift}: {found:?}");
            assert!((found.right_du - found.left_du - 12.0).abs() < 0.2, "{found:?}");
            assert!(found.cost < 0.003 && found.margin > 3.0 && found.variance_px2 < 0.1, "{found:?}");
        }
    }

    #[test]
    fn edges_of_plates_at_different_heights_may_overlap() {
        let expected = Expected { gap_px: 0.0, gap_sd_px: 4.0, least_gap_px: -8.0, distinct: true, ..EXPECTED };
        let found = find(&[lit(2.0, true), lit(-1.0, false)], &expected).unwrap();
        // What was expected draws the gap a little.
        assert!((found.right_du - found.left_du + 3.0).abs() < 0.7, "{found:?}");
        assert!((0.5 * (found.left_du + found.right_du) - 0.5).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn two_gaps_alike_leave_the_place_open_and_the_variance_says_so() {
        let both = |right: bool| {
            let dark = |x: f64| (-9.0..-4.0).contains(&x) || (4.0..9.0).contains(&x) || (right && x < -4.0);
            let lit = (0..58).map(|x| (f64::from(u8::from(!dark(EXPECTED.first_du + f64::from(x)))), 1.0));
            Presence::new(lit, !right)
        };
        let found = find(&[both(false), both(true)], &Expected { gap_px: 5.0, ..EXPECTED }).unwrap();
        assert!(found.margin < 1.0 && found.variance_px2 > 1.0, "{found:?}");
    }

    #[test]
    fn a_covered_stripe_costs_much_and_columns_without_weight_cost_nothing() {
        let dark = |before| Presence::new([(0.0, 1.0); 58].into_iter(), before);
        assert!(find(&[dark(true), dark(false)], &EXPECTED).unwrap().cost > 0.3);
        let glare = |edge_du: f64, before: bool| {
            let mut columns = lit(edge_du, before).columns;
            columns[40..50].fill((0.5, 0.0));
            Presence::new(columns.into_iter(), before)
        };
        let found = find(&[glare(-6.0, true), glare(6.0, false)], &EXPECTED).unwrap();
        assert!(found.cost < 0.003 && (0.5 * (found.left_du + found.right_du)).abs() < 0.1, "{found:?}");
    }
}
