//! Forward–backward over a recording: what every frame says about every other (Rabiner 1989, §III.B).

use std::ops::Range;

use super::grid::{Belief, GridEstimate, GridFilter, estimate_of};

/// One frame's evidence along the stripe, kept for smoothing. Repeated frames have none and are left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EvidenceRow {
    /// Columns in which a seam could be.
    pub inside: Range<usize>,
    /// Log likelihood ratio a column \[nats\].
    pub log_ratio: Vec<f32>,
}

/// Forward beliefs are kept for so many frames at a time and recomputed from the block's first one: the memory needed
/// is that of two blocks' worth of beliefs, whatever the recording's length below a million frames.
const BLOCK: usize = 64;

/// The estimate of every frame given all frames.
///
/// # Panics
/// When the rows differ in length.
#[must_use]
pub fn smooth(rows: &[EvidenceRow]) -> Vec<GridEstimate> {
    let Some(first) = rows.first() else { return Vec::new() };
    let mut filter = GridFilter::new(first.log_ratio.len());
    let advance = |filter: &mut GridFilter, row: &EvidenceRow| {
        filter.predict(&row.inside);
        filter.update(&row.log_ratio);
    };
    let mut before_block = Vec::new();
    for block in rows.chunks(BLOCK) {
        before_block.push(filter.belief().clone());
        block.iter().for_each(|row| advance(&mut filter, row));
    }
    let mut weights = filter.belief().clone();
    weights.fill(1.0);
    let mut marginal = Vec::new();
    let mut estimates = Vec::with_capacity(rows.len());
    let mut beliefs: Vec<Belief> = Vec::new();
    for (block, before) in rows.chunks(BLOCK).zip(&before_block).rev() {
        filter.set_belief(before);
        beliefs.clear();
        for row in block {
            advance(&mut filter, row);
            beliefs.push(filter.belief().clone());
        }
        for (row, belief) in block.iter().zip(&mut beliefs).rev() {
            belief.weigh(&weights);
            estimates.push(estimate_of(belief, filter.cells(), &mut marginal));
            filter.step_back(&mut weights, &row.inside, &row.log_ratio);
            weights.scale_to_one();
        }
    }
    estimates.reverse();
    estimates
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seam that moves at 0.8 px a frame, hidden in 6 of 150 frames by a competitor that jumps about.
    fn rows() -> Vec<EvidenceRow> {
        (0..150_usize)
            .map(|i| {
                let seam = 20.0 + 0.8 * i as f64;
                let peak = if (60..66).contains(&i) { ((i * 71) % 160) as f64 } else { seam };
                let log_ratio =
                    (0..180).map(|u| -2.0 + 5.0 * (-0.5 * ((u as f64 - peak) / 1.5).powi(2)).exp() as f32).collect();
                EvidenceRow { inside: 5..175, log_ratio }
            })
            .collect()
    }

    #[test]
    fn the_path_is_carried_through_frames_that_mislead() {
        for (i, estimate) in smooth(&rows()).iter().enumerate() {
            let truth = 20.0 + 0.8 * i as f64;
            assert!((estimate.u_px - truth).abs() < 1.5, "frame {i}: {estimate:?}");
        }
    }

    #[test]
    fn the_last_frame_is_the_filter_s_own() {
        let rows = rows();
        let mut filter = GridFilter::new(180);
        for row in &rows {
            filter.predict(&row.inside);
            filter.update(&row.log_ratio);
        }
        let (last, filtered) = (*smooth(&rows).last().unwrap(), filter.estimate());
        assert!((last.u_px - filtered.u_px).abs() < 1e-6);
        assert!((last.presence - filtered.presence).abs() < 1e-6);
    }
}
