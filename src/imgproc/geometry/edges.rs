//! Butt and lap: the centre is the middle between the ends of the stripe on the two sides' lines.
//!
//! Along each side's line every column gets a score for the stripe's presence. The two edges are fitted jointly: before
//! the left edge the left line should be lit, behind the right edge the right line, with a truncated loss, a prior on
//! their distance and a weak one on their middle.

use super::edge_pair::{self, Expected, Presence};
use super::line::{self, Line, SideFit};
use super::ridge::{CrossSection, RidgePoint, Search, ridge};
use super::{EVEN_VARIANCE_PX2, EdgeQuality, HALF_WINDOW_PX, JointFit, JointKind, JointModel, Refusal, columns};
use crate::imgproc::Pixels;
use crate::units::PixelPoint;

/// Gap before any was measured \[px\]. Prototype.
const FIRST_GAP_BUTT_PX: f64 = 12.0;
const FIRST_GAP_LAP_PX: f64 = 6.0;
/// SD of the gap before any was measured \[px\]. Prototype.
const FIRST_GAP_SD_PX: f64 = 8.0;
/// Least distance of the edges of level plates \[px\], and of those whose lines are apart: they may overlap, where the
/// stripe's thickness or ragged edges hide the shadow. Chosen.
const LEAST_GAP_PX: f64 = 1.0;
const LARGEST_OVERLAP_PX: f64 = 8.0;
/// Columns left out on either side of the gap when the sides' lines are fitted \[px\]. A butt joint's bent edges droop over
/// tens of px, and the lines are to be those of the plates. Tuned: the row of a butt joint whose edges droop by 3.5 px is off
/// by 1.1 px with 5, .4 with 24.
const EDGE_MARGIN_BUTT_PX: f64 = 28.0;
const EDGE_MARGIN_LAP_PX: f64 = 5.0;
/// Variance of the row that a droop may still be hidden in \[px²\]. Measured on the same scenes.
const DROOP_VARIANCE_PX2: f64 = 0.06;
/// Columns from which a side's brightness is taken \[px\].
const AMPLITUDE_REACH_PX: f64 = 55.0;
/// Fewest columns of a side, and of the stretch round the gap.
const LEAST_COLUMNS: usize = 8;
const LEAST_STRETCH: usize = 20;
/// How far from its line the ridge of a lit column may lie \[px\] (SD): bent edges by 3.5 px are still the plate, the
/// bottom of a gap 7 px deep is not.
const PRESENCE_SD_PX: f64 = 3.0;
/// Lines this far apart at the seam are told apart in each column \[px\].
const DISTINCT_PX: f64 = 2.0 * PRESENCE_SD_PX;
/// SD of the preference for the line when a column's ridge is sought \[px\]: weak, so that the brightest ridge decides
/// whether the plate or the gap's bottom is seen.
const PRESENCE_PRIOR_SD_PX: f64 = 8.0;
/// Presence as a share of the side's amplitude that counts as dark, and the range up to lit.
const DARK_SHARE: f64 = 0.05;
const LIT_RANGE: f64 = 0.22;
/// Weight of a column in glare.
const GLARE_WEIGHT: f64 = 0.1;

/// Fits both sides, then both edges.
pub fn fit(
    model: &JointModel,
    frame: &mut impl Pixels,
    u_px: f64,
    dv_px: f64,
    search_px: f64,
) -> Result<JointFit, Refusal> {
    let section = CrossSection::new(model.stripe_sd_px);
    let first_gap_px = if model.kind == JointKind::Butt { FIRST_GAP_BUTT_PX } else { FIRST_GAP_LAP_PX };
    let gap_px = model.gap_px.unwrap_or(first_gap_px);
    let gap_sd_px = if model.gap_px.is_some() { model.gap_sd_px } else { FIRST_GAP_SD_PX };
    let (edge_margin_px, droop_px2) = match model.kind {
        JointKind::Butt => (EDGE_MARGIN_BUTT_PX, DROOP_VARIANCE_PX2),
        _ => (EDGE_MARGIN_LAP_PX, 0.0),
    };
    let margin_px = 0.5 * gap_px.max(0.0) + edge_margin_px;
    let window = columns(frame, u_px, HALF_WINDOW_PX);
    let sides = [
        (window.start..((u_px - margin_px).ceil().max(0.0) as usize).max(window.start), model.left),
        (((u_px + margin_px).floor() as usize + 1).min(window.end)..window.end, model.right),
    ];
    let mut fits = [None, None];
    for (((columns, line), known), fit) in sides.into_iter().zip(model.known).zip(&mut fits) {
        if columns.len() < LEAST_COLUMNS {
            return Err(Refusal::Border);
        }
        let prior = Line { v_px: line.v_px + dv_px, ..line };
        let search = Search { half_band_px: 14, prior_sd_px: 6.4 };
        let points = ridge(&mut *frame, columns, |u| prior.at(u - u_px), &section, search);
        *fit = line::fit(&points, u_px, prior, known, AMPLITUDE_REACH_PX);
    }
    let [Some(left), Some(right)] = fits else { return Err(Refusal::NoLine) };

    let stretch = columns_within(frame, u_px, search_px + 0.5 * gap_px + 10.0);
    if stretch.len() < LEAST_STRETCH {
        return Err(Refusal::Border);
    }
    let first_du = stretch.start as f64 - u_px;
    let distinct = (right.line.v_px - left.line.v_px).abs() > DISTINCT_PX;
    let mut presence = |side: &SideFit, other: &SideFit, lit_before: bool| {
        let other = distinct.then_some(other.line);
        presence(&mut *frame, stretch.clone(), u_px, (side, other, lit_before), &section)
    };
    let presences = [presence(&left, &right, true), presence(&right, &left, false)];
    let least_gap_px = if distinct { -LARGEST_OVERLAP_PX } else { LEAST_GAP_PX };
    let expected = Expected { first_du, search_px, gap_px, gap_sd_px, least_gap_px, distinct };
    let found = edge_pair::find(&presences, &expected).ok_or(Refusal::NoLine)?;
    let du = 0.5 * (found.left_du + found.right_du);
    let (at_left, at_right) = (left.line.moved(du), right.line.moved(du));
    Ok(JointFit {
        centre: PixelPoint::new(u_px + du, 0.5 * (at_left.v_px + at_right.v_px)),
        left: at_left,
        right: at_right,
        in_frame: [left.in_frame.moved(du), right.in_frame.moved(du)],
        shown: [left.shown, right.shown],
        support: left.support.min(right.support),
        residual_px: left.residual_px.max(right.residual_px),
        across_variance_px2: 0.25 * (left.covariance[(0, 0)] + right.covariance[(0, 0)]) + droop_px2,
        along_variance_px2: EVEN_VARIANCE_PX2 + found.variance_px2,
        lasting_px2: 0.0,
        has_rival: false,
        edges: Some(EdgeQuality {
            gap_px: found.right_du - found.left_du,
            cost: found.cost,
            margin: found.margin,
            distinct,
        }),
        plates: [None, None],
        plates_in_frame: [None, None],
    })
}

fn columns_within(frame: &impl Pixels, u_px: f64, half_px: f64) -> std::ops::Range<usize> {
    let first = (u_px - half_px).ceil().max(0.0) as usize;
    let end = ((u_px + half_px).floor() as usize + 1).min(frame.size_px().0);
    first..end.clamp(first, first + edge_pair::MOST_COLUMNS)
}

/// Where a side's stripe is, before its edge or behind it; what lies nearer to the `other` side's line, if that is apart, is the
/// other's.
fn presence(
    frame: impl Pixels,
    stretch: std::ops::Range<usize>,
    u_px: f64,
    (side, other, lit_before): (&SideFit, Option<Line>, bool),
    section: &CrossSection,
) -> Presence {
    let search = Search { half_band_px: 16, prior_sd_px: PRESENCE_PRIOR_SD_PX };
    let points = ridge(frame, stretch, |u| side.line.at(u - u_px), section, search);
    let lit = |p: &RidgePoint| {
        let off_px = |line: Line| (p.v_px - line.at(p.u_px - u_px)).abs();
        if other.is_some_and(|other| off_px(other) < off_px(side.line)) {
            return 0.0;
        }
        let near = (-0.5 * (off_px(side.line) / PRESENCE_SD_PX).powi(2)).exp();
        let strength = p.amplitude * near * ((p.quality - 0.2) / 0.4).clamp(0.0, 1.0);
        ((strength / (side.amplitude + 1e-3) - DARK_SHARE) / LIT_RANGE).clamp(0.0, 1.0)
    };
    let weight = |p: &RidgePoint| if p.has_glare { GLARE_WEIGHT } else { 1.0 };
    Presence::new(points.iter().map(|p| (lit(p), weight(p))), lit_before)
}

#[cfg(test)]
mod tests {
    use super::super::drawn::{drawn, fitted};
    use super::super::{JointKind, Refusal, learn};
    use crate::units::PixelPoint;

    /// A stripe with a gap of `gap_px` round column 100.3, behind which it lies lower by `step_px`.
    fn plates(gap_px: f64, step_px: f64) -> impl Fn(f64) -> Option<f64> {
        move |u| {
            let du = u - 100.3;
            (du.abs() > 0.5 * gap_px).then_some(80.0 + if du > 0.0 { step_px } else { 0.0 })
        }
    }

    #[test]
    fn the_centre_is_the_middle_of_the_gap_and_the_gap_is_as_wide_as_it_is() {
        for gap_px in [7.0, 12.0, 18.0] {
            let fit = fitted(&drawn(plates(gap_px, 0.0)), JointKind::Butt, 102.0).unwrap();
            assert!((fit.centre.u_px - 100.3).abs() < 0.6, "{gap_px}: {:?}", fit.centre);
            assert!((fit.centre.v_px - 80.0).abs() < 0.1, "{gap_px}: {:?}", fit.centre);
            assert!((fit.edges.unwrap().gap_px - gap_px).abs() < 1.5, "{gap_px}: {:?}", fit.edges);
            assert_eq!(fit.refusal(), None);
        }
    }

    #[test]
    fn plates_at_two_heights_are_told_apart_and_their_mismatch_is_the_step() {
        let fit = fitted(&drawn(plates(5.0, 14.0)), JointKind::Lap, 100.0).unwrap();
        assert!((fit.mismatch_px().unwrap() - 14.0).abs() < 0.2, "{fit:?}");
        assert!(fit.edges.unwrap().distinct && (fit.centre.v_px - 87.0).abs() < 0.1, "{fit:?}");
    }

    #[test]
    fn a_covered_gap_is_refused_once_the_gap_is_known_and_one_at_the_border_too() {
        let frame = drawn(plates(12.0, 0.0));
        let mut model = learn(&frame, PixelPoint::new(100.0, 80.0), JointKind::Butt).unwrap().model;
        model.learn(&model.fit(&frame, 100.0, 0.0, 12.0).unwrap());
        let covered = drawn(|u| ((u - 100.0).abs() > 45.0).then_some(80.0));
        let refused = model.fit(&covered, 100.0, 0.0, 12.0).map_or_else(Some, |fit| fit.refusal());
        assert!(refused.is_some());
        assert_eq!(model.fit(&covered, 20.0, 0.0, 12.0).unwrap_err(), Refusal::Border);
    }
}
