//! Butt and lap: the centre is the middle between the ends of the stripe on the two sides' lines.
//!
//! Along each side's line every column gets a score for the stripe's presence. The two edges are fitted jointly: before
//! the left edge the left line should be lit, behind the right edge the right line, with a truncated loss, a prior on
//! their distance and a weak one on their middle.

use super::line::{self, Line, SideFit};
use super::ridge::{CrossSection, Search, ridge};
use super::{EdgeQuality, HALF_WINDOW_PX, JointFit, JointKind, JointModel, Refusal, columns};
use crate::frame::GrayFrame;
use crate::units::PixelPoint;

/// Gap before any was measured \[px\]. Prototype.
const FIRST_GAP_BUTT_PX: f64 = 12.0;
const FIRST_GAP_LAP_PX: f64 = 6.0;
/// SD of the gap from frame to frame, and before any was measured \[px\]. Prototype.
const GAP_SD_PX: f64 = 1.6;
const FIRST_GAP_SD_PX: f64 = 8.0;
/// Weight and SD of the prior on the middle. Prototype: weak, so that the fit follows a moving seam.
const POSITION_WEIGHT: f64 = 0.4;
const POSITION_SD_PX: f64 = 4.0;
/// Columns left out on either side of the gap when the sides' lines are fitted \[px\]. A butt joint's bent edges droop over
/// tens of px, and the lines are to be those of the plates. Tuned: the row of a butt joint whose edges droop by 3.5 px is off
/// by 1.1 px with 5, .4 with 24.
const EDGE_MARGIN_BUTT_PX: f64 = 28.0;
const EDGE_MARGIN_LAP_PX: f64 = 5.0;
/// Variance of the row that a droop may still be hidden in \[px²\]. Measured on the same scenes.
const DROOP_VARIANCE_PX2: f64 = 0.06;
/// Fewest columns of a side, and of the stretch round the gap.
const LEAST_COLUMNS: usize = 8;
const LEAST_STRETCH: usize = 20;
/// Step of the edges' search \[px\].
const STEP_PX: f64 = 0.25;
/// Width of an edge's transition \[px\].
const EDGE_WIDTH_PX: f64 = 0.5;
/// Bound of a column's squared mismatch.
const TRUNCATION: f64 = 0.8;
/// How far from its line the ridge of a lit column may lie \[px\] (SD): bent edges by 3.5 px are still the plate, the
/// bottom of a gap 7 px deep is not.
const PRESENCE_SD_PX: f64 = 3.0;
/// SD of the preference for the line when a column's ridge is sought \[px\]: weak, so that the brightest ridge decides
/// whether the plate or the gap's bottom is seen.
const PRESENCE_PRIOR_SD_PX: f64 = 8.0;
/// Presence as a share of the side's amplitude that counts as dark, and the range up to lit.
const DARK_SHARE: f64 = 0.05;
const LIT_RANGE: f64 = 0.22;
/// Background above which a column says little, and its weight then: the sensor is full \[grey\].
const GLARE_GREY: f64 = 235.0;
const GLARE_WEIGHT: f64 = 0.1;
/// A place this far from the best one counts as another place \[px\].
const OTHER_PLACE_PX: f64 = 3.0;

/// One side's columns round the gap: presence of the stripe, 0 to 1, and weight.
struct Presence {
    lit: Vec<f64>,
    weight: Vec<f64>,
}

/// Fits both sides, then both edges.
pub fn fit(model: &JointModel, frame: &GrayFrame, u_px: f64, dv_px: f64, search_px: f64) -> Result<JointFit, Refusal> {
    let section = CrossSection::new(model.stripe_sd_px);
    let first_gap_px = if model.kind == JointKind::Butt { FIRST_GAP_BUTT_PX } else { FIRST_GAP_LAP_PX };
    let gap_px = model.gap_px.unwrap_or(first_gap_px);
    let gap_sd_px = if model.gap_px.is_some() { GAP_SD_PX } else { FIRST_GAP_SD_PX };
    let (edge_margin_px, droop_px2) = match model.kind {
        JointKind::Butt => (EDGE_MARGIN_BUTT_PX, DROOP_VARIANCE_PX2),
        _ => (EDGE_MARGIN_LAP_PX, 0.0),
    };
    let margin_px = 0.5 * gap_px + edge_margin_px;
    let window = columns(frame, u_px, HALF_WINDOW_PX);
    let sides = [
        (window.start..((u_px - margin_px).ceil().max(0.0) as usize).max(window.start), model.left),
        (((u_px + margin_px).floor() as usize + 1).min(window.end)..window.end, model.right),
    ];
    let mut fits = [None, None];
    for ((columns, line), fit) in sides.into_iter().zip(&mut fits) {
        if columns.len() < LEAST_COLUMNS {
            return Err(Refusal::Border);
        }
        let prior = Line { v_px: line.v_px + dv_px, ..line };
        let search = Search { half_band_px: 14, prior_sd_px: 6.4 };
        let points = ridge(frame, columns, |u| prior.at(u - u_px), &section, search);
        *fit = line::fit(&points, u_px, prior, 55.0);
    }
    let [Some(left), Some(right)] = fits else { return Err(Refusal::NoLine) };

    let stretch = columns_within(frame, u_px, search_px + 0.5 * gap_px + 10.0);
    if stretch.len() < LEAST_STRETCH {
        return Err(Refusal::Border);
    }
    let first_du = stretch.start as f64 - u_px;
    let presences = [&left, &right].map(|side: &SideFit| presence(frame, stretch.clone(), u_px, side, &section));
    let found = best_edges(&presences, first_du, search_px, gap_px, gap_sd_px);
    let du = 0.5 * (found.left_du + found.right_du);
    let (at_left, at_right) = (left.line.moved(du), right.line.moved(du));
    Ok(JointFit {
        centre: PixelPoint::new(u_px + du, 0.5 * (at_left.v_px + at_right.v_px)),
        left: at_left,
        right: at_right,
        free_slopes: [left.free_slope, right.free_slope],
        support: left.support.min(right.support),
        residual_px: left.residual_px.max(right.residual_px),
        across_variance_px2: 0.25 * (left.variance_px2 + right.variance_px2) + droop_px2,
        edges: Some(EdgeQuality { gap_px: found.right_du - found.left_du, cost: found.cost, margin: found.margin }),
        plates: [None, None],
    })
}

fn columns_within(frame: &GrayFrame, u_px: f64, half_px: f64) -> std::ops::Range<usize> {
    let first = (u_px - half_px).ceil().max(0.0) as usize;
    let end = ((u_px + half_px).floor() as usize + 1).min(frame.width_px());
    first..end.max(first)
}

fn presence(
    frame: &GrayFrame,
    stretch: std::ops::Range<usize>,
    u_px: f64,
    side: &SideFit,
    section: &CrossSection,
) -> Presence {
    let search = Search { half_band_px: 16, prior_sd_px: PRESENCE_PRIOR_SD_PX };
    let points = ridge(frame, stretch, |u| side.line.at(u - u_px), section, search);
    let lit = points
        .iter()
        .map(|p| {
            let near = (-0.5 * ((p.v_px - side.line.at(p.u_px - u_px)) / PRESENCE_SD_PX).powi(2)).exp();
            let strength = p.amplitude * near * ((p.quality - 0.2) / 0.4).clamp(0.0, 1.0);
            ((strength / (side.amplitude + 1e-3) - DARK_SHARE) / LIT_RANGE).clamp(0.0, 1.0)
        })
        .collect();
    let weight = points.iter().map(|p| if p.background > GLARE_GREY { GLARE_WEIGHT } else { 1.0 }).collect();
    Presence { lit, weight }
}

/// The best pair of edges, relative to the prediction.
struct Edges {
    left_du: f64,
    right_du: f64,
    cost: f64,
    margin: f64,
}

fn best_edges([left, right]: &[Presence; 2], first_du: f64, search_px: f64, gap_px: f64, gap_sd_px: f64) -> Edges {
    let columns = left.lit.len();
    let reach_px = search_px + 0.5 * gap_px + 3.0;
    let edges: Vec<f64> = {
        let n = (2.0 * reach_px / STEP_PX).round() as usize;
        (0..=n).map(|i| -reach_px + i as f64 * STEP_PX).collect()
    };
    // Summed costs from the left end up to each column for the left edge, and from each column on for the right edge.
    let n = edges.len();
    let mut left_sum = vec![0.0f64; n * (columns + 1)];
    let mut right_sum = vec![0.0f64; n * (columns + 1)];
    for (e, &edge) in edges.iter().enumerate() {
        let row = e * (columns + 1);
        for x in 0..columns {
            let lit_before = step(edge - (first_du + x as f64));
            left_sum[row + x + 1] = left_sum[row + x] + mismatch(lit_before, left.lit[x], left.weight[x]);
        }
        for x in (0..columns).rev() {
            let lit_behind = 1.0 - step(edge - (first_du + x as f64));
            right_sum[row + x] = right_sum[row + x + 1] + mismatch(lit_behind, right.lit[x], right.weight[x]);
        }
    }
    let data = |i: usize, j: usize| {
        let middle = 0.5 * (edges[i] + edges[j]);
        let parting = ((middle - first_du + 0.5).round().max(0.0) as usize).min(columns);
        left_sum[i * (columns + 1) + parting] + right_sum[j * (columns + 1) + parting]
    };
    let total = |i: usize, j: usize| {
        let (middle, gap) = (0.5 * (edges[i] + edges[j]), edges[j] - edges[i]);
        if gap < 1.0 || middle.abs() > search_px {
            return f64::INFINITY;
        }
        data(i, j)
            + 0.5 * ((gap - gap_px) / gap_sd_px).powi(2)
            + 0.5 * POSITION_WEIGHT * (middle / POSITION_SD_PX).powi(2)
    };
    let mut objective = vec![f64::INFINITY; n * n];
    let mut best = (0, n - 1, f64::INFINITY);
    for i in 0..n {
        for j in i..n {
            let value = total(i, j);
            objective[i * n + j] = value;
            if value < best.2 {
                best = (i, j, value);
            }
        }
    }
    let (bi, bj, lowest) = best;
    let middle = edges[bi] + edges[bj];
    let mut elsewhere = f64::INFINITY;
    for i in 0..n {
        for j in i..n {
            if (edges[i] + edges[j] - middle).abs() > 2.0 * OTHER_PLACE_PX {
                elsewhere = elsewhere.min(objective[i * n + j]);
            }
        }
    }
    let mean_weight = left.weight.iter().sum::<f64>() / columns as f64;
    Edges {
        left_du: vertex(&edges, bi, |i| objective[i * n + bj]),
        right_du: vertex(&edges, bj, |j| objective[bi * n + j]),
        cost: data(bi, bj) / (mean_weight * columns as f64),
        margin: if elsewhere.is_finite() { elsewhere - lowest } else { 0.0 },
    }
}

/// A smooth step: 1 well before the edge, 0 well behind it.
fn step(before_edge_px: f64) -> f64 {
    1.0 / (1.0 + (-before_edge_px / EDGE_WIDTH_PX).exp())
}

fn mismatch(expected: f64, seen: f64, weight: f64) -> f64 {
    weight * (expected - seen).powi(2).min(TRUNCATION)
}

/// The vertex of a parabola fitted to the objective within three steps of its minimum.
fn vertex(edges: &[f64], best: usize, objective: impl Fn(usize) -> f64) -> f64 {
    let around = best.saturating_sub(3)..(best + 4).min(edges.len());
    let samples: Vec<(f64, f64)> =
        around.map(|i| (edges[i] - edges[best], objective(i))).filter(|(_, value)| value.is_finite()).collect();
    if samples.len() < 4 {
        return edges[best];
    }
    let design = nalgebra::DMatrix::from_fn(samples.len(), 3, |r, c| samples[r].0.powi(c as i32));
    let values = nalgebra::DVector::from_iterator(samples.len(), samples.iter().map(|s| s.1));
    let normal = design.transpose() * &design;
    let Some(solution) = normal.cholesky().map(|c| c.solve(&(design.transpose() * values))) else {
        return edges[best];
    };
    let (slope, curvature) = (solution[1], solution[2]);
    if curvature <= 1e-3 {
        return edges[best];
    }
    edges[best] + (-slope / (2.0 * curvature)).clamp(-0.6, 0.6)
}
