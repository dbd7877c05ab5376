//! V-groove and fillet: the centre is where the lines of the two sides meet.

use super::line::{self, Line};
use super::ridge::{CrossSection, Search, ridge};
use super::{HALF_WINDOW_PX, JointFit, JointKind, JointModel, LEAST_SUPPORT_CORNER, Refusal, columns};
use crate::frame::GrayFrame;
use crate::units::PixelPoint;

/// Columns left out on both sides of the V-groove's shoulder \[px\]; this and the next two in the smallest window.
const SHOULDER_PX: f64 = 5.0;
/// Longest stretch of a plate that is looked at \[px\].
const PLATE_PX: f64 = 60.0;
/// How far a shoulder may move from where the model has it \[px\]: the flanks of ragged edges differ.
const SHOULDER_SLACK_PX: f64 = 12.0;
/// Fewest columns of a side.
const LEAST_COLUMNS: usize = 8;
/// Least difference of the sides' slopes that makes a corner.
const LEAST_BEND: f64 = 0.15;
/// How far beyond the search range the corner may lie \[px\].
const SLACK_PX: f64 = 8.0;

/// Fits both sides and intersects them, twice: the second time with the columns parted at the first corner.
pub fn fit(model: &JointModel, frame: &GrayFrame, u_px: f64, dv_px: f64, search_px: f64) -> Result<JointFit, Refusal> {
    let section = CrossSection::new(model.stripe_sd_px);
    let toe_px = model.toe_px;
    let reach_px = match (model.kind, model.half_width_px) {
        (JointKind::VGroove, Some(half_px)) => half_px - SHOULDER_PX,
        _ => model.half_window_px,
    };
    let shifted = |line: Line| Line { v_px: line.v_px + dv_px, ..line };
    let mut corner_u = u_px;
    let mut sides = [shifted(model.left), shifted(model.right)];
    let mut result = Err(Refusal::NoLine);
    for _ in 0..2 {
        let window = columns(frame, u_px, model.half_window_px);
        let part = |from_px: f64, to_px: f64| {
            let first = (corner_u + from_px).ceil().max(window.start as f64) as usize;
            let end = (corner_u + to_px).floor().min(window.end as f64 - 1.0).max(0.0) as usize + 1;
            first..end.max(first)
        };
        let parts = [part(-reach_px, -toe_px), part(toe_px, reach_px)];
        let mut fits = [None, None];
        for ((columns, prior), fit) in parts.into_iter().zip(sides).zip(&mut fits) {
            if columns.len() < LEAST_COLUMNS {
                return Err(Refusal::Border);
            }
            let search = Search { half_band_px: 14, prior_sd_px: 8.0 };
            let points = ridge(frame, columns, |u| prior.at(u - corner_u), &section, search);
            *fit = line::fit(&points, corner_u, prior, model.half_window_px);
        }
        let [Some(left), Some(right)] = fits else { return Err(Refusal::NoLine) };
        let bend = left.line.slope - right.line.slope;
        if bend.abs() < LEAST_BEND {
            return Err(Refusal::NoCorner);
        }
        let du = (right.line.v_px - left.line.v_px) / bend;
        if (corner_u + du - u_px).abs() > search_px + SLACK_PX {
            return Err(Refusal::NoCorner);
        }
        corner_u += du;
        sides = [left.line.moved(du), right.line.moved(du)];
        result = Ok(JointFit {
            centre: PixelPoint::new(corner_u, sides[0].v_px),
            left: sides[0],
            right: sides[1],
            free_slopes: [left.free_slope, right.free_slope],
            support: left.support.min(right.support),
            residual_px: left.residual_px.max(right.residual_px),
            across_variance_px2: 0.25 * (left.variance_px2 + right.variance_px2),
            edges: None,
            plates: [None, None],
        });
    }
    result.map(|fit| JointFit { plates: plates(model, frame, &fit, dv_px, &section), ..fit })
}

/// The plates beside the shoulders, where they are seen at their places.
fn plates(
    model: &JointModel,
    frame: &GrayFrame,
    fit: &JointFit,
    dv_px: f64,
    section: &CrossSection,
) -> [Option<Line>; 2] {
    let Some(priors) = model.plates else { return [None, None] };
    let (u0_px, scale) = (fit.centre.u_px, model.half_window_px / HALF_WINDOW_PX);
    let plate = |prior: Line, flanks: [Line; 2]| {
        let (shoulder_du, _) = flanks[0].meets(prior)?;
        let near_px = shoulder_du.abs() + SHOULDER_PX * scale;
        let far_px = (near_px + PLATE_PX * scale).min(model.half_window_px);
        let ends = [near_px, far_px].map(|du| u0_px + shoulder_du.signum() * du);
        let (first, last) = (ends[0].min(ends[1]).ceil(), ends[0].max(ends[1]).floor());
        if first < 0.0 || last >= frame.width_px() as f64 || last - first < LEAST_COLUMNS as f64 {
            return None;
        }
        let prior = Line { v_px: prior.v_px + dv_px, ..prior };
        let search = Search { half_band_px: 14, prior_sd_px: 8.0 };
        let points = ridge(frame, first as usize..last as usize + 1, |u| prior.at(u - u0_px), section, search);
        let middle_px = 0.5 * (first + last);
        let found = line::fit(&points, middle_px, prior.moved(middle_px - u0_px), PLATE_PX * scale)?;
        let plate = found.line.moved(u0_px - middle_px);
        let (du, _) = flanks[1].meets(plate)?;
        let in_place = (du - shoulder_du).abs() < SHOULDER_SLACK_PX * scale;
        (found.support > LEAST_SUPPORT_CORNER && in_place).then_some(plate)
    };
    [plate(priors[0], [model.left, fit.left]), plate(priors[1], [model.right, fit.right])]
}
