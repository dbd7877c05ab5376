//! A grid filter over where along the stripe the seam is, how fast it moves, and whether there is one at all.
//!
//! A hidden Markov model in the sense of Rabiner 1989: the states are the cells (position, velocity) and one further
//! state, "no seam". A seam is born anywhere along the stripe, moves on with its velocity, and ends. In place of a
//! single Gaussian it can keep several places in mind until the evidence decides (docs/method.md §6.5).
//!
//! The evidence is a row of log likelihood ratios, one a column: how much likelier the frame is with a seam there than
//! with none. So the probability of "no seam" is an honest one: it falls only when the evidence along *one possible
//! path* outweighs the number of paths.

use std::ops::Range;

/// Cells a pixel: with velocities in steps of one cell a frame every shift is exact.
const CELLS_PER_PX: usize = 2;
/// Fastest seam \[cells/frame\]: ±5 px a frame (docs/method.md §6.5).
const MAX_CELLS_PER_FRAME: usize = 10;
const VELOCITIES: usize = 2 * MAX_CELLS_PER_FRAME + 1;
/// The velocity's random walk \[px/frame, 1 σ\] and the position's own diffusion to each neighbour cell (prototype).
const VELOCITY_STEP_PX: f64 = 0.3;
const DIFFUSION: f32 = 0.1;
/// A random step of the velocity reaches this many cells.
const MIX_REACH: usize = 2;
/// Prior of a new seam's velocity \[px/frame, 1 σ\] (prototype).
const BIRTH_VELOCITY_SD_PX: f64 = 2.5;
/// Chance a frame that a seam begins, and that it ends (chosen: a recording holds about one seam).
const BIRTH: f32 = 1e-3;
const DEATH: f32 = 1e-3;
/// The estimate is the mean within this distance of the likeliest cell \[px\].
const PEAK_REACH_PX: usize = 5;
/// One frame's own observation is taken within this distance of the estimate \[px\] (chosen: twice its deviation).
const OBSERVATION_REACH_PX: usize = 4;
/// Smaller probabilities are zero: denormal numbers are slow.
const SMALLEST: f32 = 1e-30;

/// What the filter knows after a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridEstimate {
    /// Position along the stripe \[px\]: the mean within 5 px of the likeliest place.
    pub u_px: f64,
    /// Standard deviation of that mean's posterior \[px\], the grid's own half pixel included.
    pub sd_px: f64,
    /// Mean velocity there \[px/frame\].
    pub velocity_px: f64,
    /// Probability, given that there is a seam, that it is within those 5 px.
    pub confidence: f64,
    /// Probability that there is a seam.
    pub presence: f64,
}

/// What one frame alone says about the place near the seam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalObservation {
    /// Position along the stripe \[px\]: the likelihood's mean.
    pub u_px: f64,
    /// The likelihood's standard deviation \[px\].
    pub sd_px: f64,
}

/// Probabilities, or backward weights, of all states.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Belief {
    /// `VELOCITIES` rows of cells.
    pub(super) cells: Vec<f32>,
    /// The state "no seam".
    pub(super) absent: f32,
}

impl Belief {
    pub(super) fn fill(&mut self, value: f32) {
        self.cells.fill(value);
        self.absent = value;
    }

    /// Multiplies by backward weights.
    pub(super) fn weigh(&mut self, weights: &Self) {
        for (p, w) in self.cells.iter_mut().zip(&weights.cells) {
            *p *= w;
        }
        self.absent *= weights.absent;
    }

    /// Divides by the largest value; what would vanish stays just above zero.
    pub(super) fn scale_to_one(&mut self) {
        let most = self.cells.iter().copied().fold(self.absent, f32::max);
        self.absent /= most;
        for p in &mut self.cells {
            *p = (*p / most).max(SMALLEST);
        }
    }

    fn rows(&self, cells: usize) -> impl Iterator<Item = &[f32]> {
        self.cells.chunks_exact(cells)
    }
}

/// The filter. Nothing is allocated after [`GridFilter::new`].
#[derive(Debug, Clone)]
pub struct GridFilter {
    columns: usize,
    belief: Belief,
    mixed: Vec<f32>,
    likelihood: Vec<f32>,
    marginal: Vec<f32>,
    /// `mix[from][MIX_REACH + to − from]`
    mix: [[f32; 2 * MIX_REACH + 1]; VELOCITIES],
    birth_velocity: [f32; VELOCITIES],
}

impl GridFilter {
    /// A filter over `columns` positions that knows of no seam yet.
    ///
    /// # Panics
    /// When `columns` is zero.
    #[must_use]
    pub fn new(columns: usize) -> Self {
        assert!(columns > 0, "a grid without columns");
        let cells = CELLS_PER_PX * columns - 1;
        let step_px = 1.0 / CELLS_PER_PX as f64;
        let mix = std::array::from_fn(|from| {
            let raw: [f64; 2 * MIX_REACH + 1] = std::array::from_fn(|i| {
                let inside = (MIX_REACH..MIX_REACH + VELOCITIES).contains(&(from + i));
                let d = (i as f64 - MIX_REACH as f64) * step_px / VELOCITY_STEP_PX;
                if inside { (-0.5 * d * d).exp() } else { 0.0 }
            });
            let sum: f64 = raw.iter().sum();
            raw.map(|value| (value / sum) as f32)
        });
        let birth: [f64; VELOCITIES] = std::array::from_fn(|k| {
            let velocity_px = (k as f64 - MAX_CELLS_PER_FRAME as f64) * step_px;
            (-0.5 * (velocity_px / BIRTH_VELOCITY_SD_PX).powi(2)).exp()
        });
        let sum: f64 = birth.iter().sum();
        Self {
            columns,
            belief: Belief { cells: vec![0.0; VELOCITIES * cells], absent: 1.0 },
            mixed: vec![0.0; VELOCITIES * cells],
            likelihood: vec![0.0; cells],
            marginal: vec![0.0; cells],
            mix,
            birth_velocity: birth.map(|value| (value / sum) as f32),
        }
    }

    /// Number of columns.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Number of cells a velocity.
    pub(super) const fn cells(&self) -> usize {
        CELLS_PER_PX * self.columns - 1
    }

    /// Cells of the columns `inside`, where a seam can be born.
    fn birth_cells(&self, inside: &Range<usize>) -> Range<usize> {
        let first = (CELLS_PER_PX * inside.start).min(self.cells());
        first..(CELLS_PER_PX * inside.end).saturating_sub(1).clamp(first, self.cells())
    }

    /// One frame passes: the seam moves, may end, or may be born in the columns `inside`.
    pub fn predict(&mut self, inside: &Range<usize>) {
        let cells = self.cells();
        self.mixed.fill(0.0);
        for (from, row) in self.belief.rows(cells).enumerate() {
            for (i, &factor) in self.mix[from].iter().enumerate().filter(|(_, factor)| **factor > 0.0) {
                let to = from + i - MIX_REACH;
                axpy(&mut self.mixed[to * cells..(to + 1) * cells], row, factor);
            }
        }
        let absent = self.belief.absent;
        let born_in = self.birth_cells(inside);
        let mut present = 0.0;
        let rows = self.belief.cells.chunks_exact_mut(cells).zip(self.mixed.chunks_exact(cells));
        for (k, (row, mixed)) in rows.enumerate() {
            row.fill(0.0);
            for (offset, share) in [(-1, DIFFUSION), (0, 1.0 - 2.0 * DIFFUSION), (1, DIFFUSION)] {
                let shift = k as isize - MAX_CELLS_PER_FRAME as isize + offset;
                shifted_axpy(row, mixed, shift, share * (1.0 - DEATH));
            }
            let born = absent * BIRTH * self.birth_velocity[k] / born_in.len().max(1) as f32;
            row[born_in.clone()].iter_mut().for_each(|p| *p += born);
            present += row.iter().sum::<f32>();
        }
        // What ended, or left the stripe, is absent.
        self.belief.absent = (1.0 - present).max(BIRTH * DEATH);
    }

    /// Weighs every place by its evidence: the natural logarithm of the likelihood of the frame with a seam in that
    /// column over that with none. Between columns the mean of the two is taken. Returns the likelihood ratio of the
    /// frame as a whole, as it was predicted, over that without a seam.
    ///
    /// # Panics
    /// When `log_ratio` is not one value a column.
    pub fn update(&mut self, log_ratio: &[f32]) -> f32 {
        self.fill_likelihood(log_ratio);
        let cells = self.cells();
        let mut sum = self.belief.absent;
        for row in self.belief.cells.chunks_exact_mut(cells) {
            for (p, likelihood) in row.iter_mut().zip(&self.likelihood) {
                *p *= likelihood;
            }
            sum += row.iter().sum::<f32>();
        }
        let scale = 1.0 / sum;
        self.belief.absent *= scale;
        for p in &mut self.belief.cells {
            let scaled = *p * scale;
            *p = if scaled < SMALLEST { 0.0 } else { scaled };
        }
        sum
    }

    fn fill_likelihood(&mut self, log_ratio: &[f32]) {
        assert_eq!(log_ratio.len(), self.columns, "one value a column");
        for (cell, likelihood) in self.likelihood.iter_mut().enumerate() {
            let (left, right) = (log_ratio[cell / 2], log_ratio[cell.div_ceil(2)]);
            *likelihood = (0.5 * (left + right)).exp();
        }
    }

    /// The present estimate.
    pub fn estimate(&mut self) -> GridEstimate {
        let mut marginal = std::mem::take(&mut self.marginal);
        let estimate = estimate_of(&self.belief, self.cells(), &mut marginal);
        self.marginal = marginal;
        estimate
    }

    /// Mean and deviation of the last frame's likelihood near `u_px`; none when no place there speaks for a seam.
    #[must_use]
    pub fn local_observation(&self, u_px: f64) -> Option<LocalObservation> {
        let near = near_cells((u_px * CELLS_PER_PX as f64).round() as usize, OBSERVATION_REACH_PX, self.cells());
        let best = self.likelihood[near.clone()].iter().copied().fold(0.0, f32::max);
        let moments = Moments::of(&self.likelihood, near);
        (best > 1.0).then_some(LocalObservation { u_px: moments.mean_px, sd_px: moments.sd_px })
    }

    pub(super) const fn belief(&self) -> &Belief {
        &self.belief
    }

    pub(super) fn set_belief(&mut self, belief: &Belief) {
        self.belief.clone_from(belief);
    }

    /// The adjoint of [`Self::predict`] after that of [`Self::update`]: turns backward weights behind a frame of
    /// evidence `log_ratio` into those before it. The caller keeps the weights in range.
    pub(super) fn step_back(&mut self, weights: &mut Belief, inside: &Range<usize>, log_ratio: &[f32]) {
        self.fill_likelihood(log_ratio);
        let cells = self.cells();
        let born_in = self.birth_cells(inside);
        let mut born = 0.0;
        for (k, row) in weights.cells.chunks_exact_mut(cells).enumerate() {
            for (w, likelihood) in row.iter_mut().zip(&self.likelihood) {
                *w *= likelihood;
            }
            let mean = row[born_in.clone()].iter().sum::<f32>() / born_in.len().max(1) as f32;
            born += self.birth_velocity[k] * mean;
        }
        let absent = weights.absent;
        self.mixed.fill(0.0);
        let rows = weights.cells.chunks_exact(cells).zip(self.mixed.chunks_exact_mut(cells));
        for (k, (row, mixed)) in rows.enumerate() {
            for (offset, share) in [(-1, DIFFUSION), (0, 1.0 - 2.0 * DIFFUSION), (1, DIFFUSION)] {
                let shift = k as isize - MAX_CELLS_PER_FRAME as isize + offset;
                shifted_axpy(mixed, row, -shift, share * (1.0 - DEATH));
            }
        }
        for (from, row) in weights.cells.chunks_exact_mut(cells).enumerate() {
            row.fill(DEATH * absent);
            for (i, &factor) in self.mix[from].iter().enumerate().filter(|(_, factor)| **factor > 0.0) {
                let to = from + i - MIX_REACH;
                axpy(row, &self.mixed[to * cells..(to + 1) * cells], factor);
            }
        }
        weights.absent = (1.0 - BIRTH) * absent + BIRTH * born;
    }
}

/// Estimate from any belief, normalised or not, of rows of `cells`; `marginal` is scratch.
pub(super) fn estimate_of(belief: &Belief, cells: usize, marginal: &mut Vec<f32>) -> GridEstimate {
    marginal.clear();
    marginal.resize(cells, 0.0);
    for row in belief.rows(cells) {
        axpy(marginal, row, 1.0);
    }
    let peak = (0..cells).fold(0, |best, cell| if marginal[cell] > marginal[best] { cell } else { best });
    let near = near_cells(peak, PEAK_REACH_PX, cells);
    let moments = Moments::of(marginal, near.clone());
    let velocity: f64 = belief
        .rows(cells)
        .enumerate()
        .map(|(k, row)| {
            let velocity_px = (k as f64 - MAX_CELLS_PER_FRAME as f64) / CELLS_PER_PX as f64;
            velocity_px * f64::from(row[near.clone()].iter().sum::<f32>())
        })
        .sum();
    let present: f64 = f64::from(marginal.iter().sum::<f32>());
    let mass = moments.mass.max(f64::MIN_POSITIVE);
    GridEstimate {
        u_px: moments.mean_px,
        sd_px: moments.sd_px,
        velocity_px: velocity / mass,
        confidence: mass / present.max(f64::MIN_POSITIVE),
        presence: present / (present + f64::from(belief.absent)),
    }
}

/// Cells within `reach_px` of a cell.
fn near_cells(cell: usize, reach_px: usize, cells: usize) -> Range<usize> {
    let (cell, reach) = (cell.min(cells - 1), reach_px * CELLS_PER_PX);
    cell.saturating_sub(reach)..(cell + reach + 1).min(cells)
}

/// Mass, mean and deviation of a row of cells.
struct Moments {
    mass: f64,
    mean_px: f64,
    sd_px: f64,
}

impl Moments {
    fn of(row: &[f32], cells: Range<usize>) -> Self {
        let (mut mass, mut first, mut second) = (f64::MIN_POSITIVE, 0.0, 0.0);
        let origin_px = cells.start as f64 / CELLS_PER_PX as f64;
        for (i, &p) in row[cells].iter().enumerate() {
            let (p, d_px) = (f64::from(p), i as f64 / CELLS_PER_PX as f64);
            mass += p;
            first += p * d_px;
            second += p * d_px * d_px;
        }
        let mean_px = first / mass;
        let cell_variance_px2 = 1.0 / (12.0 * (CELLS_PER_PX * CELLS_PER_PX) as f64);
        let variance_px2 = (second / mass - mean_px * mean_px).max(0.0) + cell_variance_px2;
        Self { mass, mean_px: origin_px + mean_px, sd_px: variance_px2.sqrt() }
    }
}

fn axpy(sum: &mut [f32], row: &[f32], factor: f32) {
    for (s, r) in sum.iter_mut().zip(row) {
        *s += factor * r;
    }
}

/// `sum[i + shift] += factor · row[i]` where both exist.
fn shifted_axpy(sum: &mut [f32], row: &[f32], shift: isize, factor: f32) {
    let by = shift.unsigned_abs().min(row.len());
    let kept = row.len() - by;
    if shift >= 0 {
        axpy(&mut sum[by..], &row[..kept], factor);
    } else {
        axpy(&mut sum[..kept], &row[by..], factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: usize = 120;

    /// A peak of `height` nats at `u_px` over −2.
    fn row(u_px: f64, height: f32) -> Vec<f32> {
        (0..COLUMNS).map(|u| -2.0 + (height + 2.0) * (-0.5 * ((u as f64 - u_px) / 1.5).powi(2)).exp() as f32).collect()
    }

    #[test]
    fn a_moving_peak_is_followed_with_its_velocity_and_its_presence() {
        let mut grid = GridFilter::new(COLUMNS);
        for i in 0..30 {
            grid.predict(&(6..COLUMNS - 6));
            grid.update(&row(30.0 + 1.3 * i as f64, 4.0));
        }
        let estimate = grid.estimate();
        assert!((estimate.u_px - (30.0 + 1.3 * 29.0)).abs() < 0.3, "{estimate:?}");
        assert!((estimate.velocity_px - 1.3).abs() < 0.3, "{estimate:?}");
        assert!(estimate.presence > 0.999 && estimate.confidence > 0.99, "{estimate:?}");
    }

    #[test]
    fn an_uninformative_row_leaves_the_presence_near_the_balance_of_birth_and_death() {
        let mut grid = GridFilter::new(COLUMNS);
        for _ in 0..20 {
            grid.predict(&(0..COLUMNS));
            grid.update(&[0.0; COLUMNS]);
        }
        let presence = grid.estimate().presence;
        assert!((0.01..0.03).contains(&presence), "{presence}");
    }

    #[test]
    fn a_peak_that_jumps_about_is_no_seam() {
        let mut grid = GridFilter::new(COLUMNS);
        for i in 0..40 {
            grid.predict(&(0..COLUMNS));
            grid.update(&row(10.0 + ((i * 37) % 100) as f64, 4.0));
            assert!(grid.estimate().presence < 0.6, "frame {i}: {}", grid.estimate().presence);
        }
    }

    #[test]
    fn a_seam_that_ends_becomes_absent() {
        let mut grid = GridFilter::new(COLUMNS);
        for _ in 0..20 {
            grid.predict(&(0..COLUMNS));
            grid.update(&row(60.0, 4.0));
        }
        for _ in 0..15 {
            grid.predict(&(0..COLUMNS));
            grid.update(&[-2.0; COLUMNS]);
        }
        assert!(grid.estimate().presence < 0.01, "{:?}", grid.estimate());
    }

    #[test]
    fn stepping_back_is_the_adjoint_of_predict_and_update() {
        // <w, U P b> = <(U P)ᵀ w, b>, for a belief away from the rims, where nothing leaves the grid.
        let inside = 20..100;
        let mut grid = GridFilter::new(COLUMNS);
        for i in 0..4 {
            grid.predict(&inside);
            grid.update(&row(50.0 + i as f64, 3.0));
        }
        let before = grid.belief().clone();
        let evidence = row(55.0, 2.0);
        let mut weights =
            Belief { cells: (0..before.cells.len()).map(|i| ((i * 7919) % 101) as f32 / 101.0).collect(), absent: 0.7 };
        let dot = |a: &Belief, b: &Belief| -> f64 {
            let cells: f64 = a.cells.iter().zip(&b.cells).map(|(x, y)| f64::from(x * y)).sum();
            cells + f64::from(a.absent * b.absent)
        };
        grid.set_belief(&before);
        grid.predict(&inside);
        let sum = grid.update(&evidence);
        let forward = f64::from(sum) * dot(&weights, grid.belief());
        grid.step_back(&mut weights, &inside, &evidence);
        approx::assert_relative_eq!(dot(&weights, &before), forward, max_relative = 1e-4);
    }
}
