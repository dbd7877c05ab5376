//! V-groove and fillet: the centre is where the lines of the two sides meet.

use super::line::{self, FrameLine, Knowledge, Line};
use super::ridge::{CrossSection, Search, ridge};
use super::second::{self, Beside};
use super::{HALF_WINDOW_PX, JointFit, JointModel, LEAST_SUPPORT_CORNER, Refusal, columns};
use crate::imgproc::Pixels;
use crate::units::PixelPoint;

/// Columns left out beside the V-groove's shoulder \[px\]; this and the next two in the smallest window.
const SHOULDER_PX: f64 = 5.0;
/// Variance of a corner along the stripe beside that of its lines \[px²\]: flanks are not quite straight. Chosen.
pub const CORNER_VARIANCE_PX2: f64 = 0.06;
/// Longest stretch of a plate that is looked at \[px\].
const PLATE_PX: f64 = 60.0;
/// How far a shoulder may move from where the model has it \[px\]: the flanks of ragged edges differ.
const SHOULDER_SLACK_PX: f64 = 12.0;
/// By how much a flank's end lies off its straight line \[px\], drawn on from there to the root by its distance from the middle of
/// what is seen in halves of that; up to so many it is nearly whole. Chosen: worn shoulders, a bead's toe that runs out on it.
const BOWED_PX: f64 = 0.5;
const SEEN_WHOLE: f64 = 1.6;
/// Fewest columns of a side: of a flank that a bead leaves in sight.
const LEAST_COLUMNS: usize = 7;
/// Least difference of the sides' slopes that makes a corner.
const LEAST_BEND: f64 = 0.15;
/// How far beyond the search range the corner may lie \[px\].
const SLACK_PX: f64 = 8.0;

/// Fits both sides and intersects them, twice: the second time with the columns parted at the first corner.
pub fn fit(
    model: &JointModel,
    frame: &mut impl Pixels,
    u_px: f64,
    dv_px: f64,
    search_px: f64,
) -> Result<JointFit, Refusal> {
    let section = CrossSection::new(model.stripe_sd_px);
    let window = columns(frame, u_px, model.half_window_px);
    let [on_left, on_right] = &model.flanks_px;
    let mut corner_u = u_px;
    let mut priors = [model.left, model.right].map(|line| Line { v_px: line.v_px + dv_px, ..line });
    let mut result: Result<JointFit, Refusal> = Err(Refusal::NoLine);
    for _ in 0..2 {
        let part = |from_px: f64, to_px: f64| {
            let first = (corner_u + from_px).ceil().max(window.start as f64) as usize;
            let end = (corner_u + to_px).floor().min(window.end as f64 - 1.0).max(0.0) as usize + 1;
            first..end.max(first)
        };
        let parts = [part(-on_left.end, -on_left.start), part(on_right.start, on_right.end)];
        // The second time the first one's lines say along what a second line may run.
        let seen = result.as_ref().ok().map(|fit| [fit.left, fit.right]);
        let mut beside = [Beside::default(); 2];
        let mut fits = [None, None];
        for (i, ((columns, prior), known)) in parts.into_iter().zip(priors).zip(model.known).enumerate() {
            if columns.len() < LEAST_COLUMNS {
                return Err(Refusal::Border);
            }
            let search = Search { half_band_px: 14, prior_sd_px: 8.0 };
            let mut points = ridge(&mut *frame, columns, |u| prior.at(u - corner_u), &section, search);
            if let Some(seen) = seen {
                beside[i] =
                    second::leave_out(&mut *frame, &mut points, |u| seen[i].at(u - corner_u), model.stripe_sd_px);
            }
            fits[i] = line::fit(&points, corner_u, prior, known, model.half_window_px);
        }
        let [Some(left), Some(right)] = fits else { return Err(Refusal::NoLine) };
        let bend = left.line.slope - right.line.slope;
        if bend.abs() < LEAST_BEND {
            return Err(Refusal::NoCorner);
        }
        let (du, v_px) = left.line.meets(right.line).ok_or(Refusal::NoCorner)?;
        if (corner_u + du - u_px).abs() > search_px + SLACK_PX {
            return Err(Refusal::NoCorner);
        }
        corner_u += du;
        let sides = [left.line.moved(du), right.line.moved(du)];
        priors = [Line { v_px, ..model.left }, Line { v_px, ..model.right }];
        let variances_px2 = [left.covariance[(0, 0)], right.covariance[(0, 0)]];
        result = Ok(JointFit {
            centre: PixelPoint::new(corner_u, v_px),
            left: sides[0],
            right: sides[1],
            in_frame: [left.in_frame.moved(du), right.in_frame.moved(du)],
            shown: [left.shown, right.shown],
            support: left.support.min(right.support),
            residual_px: left.residual_px.max(right.residual_px),
            along_variance_px2: CORNER_VARIANCE_PX2 + (variances_px2[0] + variances_px2[1]) / (bend * bend),
            lasting_px2: lasting_px2(model, sides, beside),
            has_rival: beside.iter().any(|beside| beside.is_rival),
            across_variance_px2: row_variance_px2(sides, variances_px2),
            edges: None,
            plates: [None, None],
            plates_in_frame: [None, None],
        });
    }
    result.map(|fit| {
        let seen = plates(model, frame, &fit, dv_px, &section);
        let plates = seen.map(|plate| plate.map(|(line, _)| line));
        JointFit { plates, plates_in_frame: seen.map(|plate| plate.map(|(_, in_frame)| in_frame)), ..fit }
    })
}

/// What the legs leave open in every frame alike: second lines beside them, and a flank of which only its upper end is seen above
/// a bead.
fn lasting_px2(model: &JointModel, [left, right]: [Line; 2], beside: [Beside; 2]) -> f64 {
    let hidden_px = model.flanks_px.each_ref().map(|seen| {
        let (middle_px, half_px) = (0.5 * (seen.start + seen.end), 0.5 * (seen.end - seen.start));
        BOWED_PX * (middle_px / half_px - SEEN_WHOLE).max(0.0)
    });
    let rows_px2 = beside.iter().zip(hidden_px).map(|(beside, hidden_px)| beside.row_sd_px.powi(2) + hidden_px.powi(2));
    rows_px2.sum::<f64>() / (left.slope - right.slope).powi(2)
}

/// Variance of the row where two lines meet, those of their rows there being `variances_px2`: the row is their mean, each
/// weighted by the slope of the other.
fn row_variance_px2([left, right]: [Line; 2], [left_px2, right_px2]: [f64; 2]) -> f64 {
    let bend = left.slope - right.slope;
    ((right.slope / bend).powi(2) * left_px2) + ((left.slope / bend).powi(2) * right_px2)
}

/// The plates beside the shoulders, where they are seen at their places, with the covariance of row and slope at the centre.
fn plates(
    model: &JointModel,
    frame: &mut impl Pixels,
    fit: &JointFit,
    dv_px: f64,
    section: &CrossSection,
) -> [Option<(Line, FrameLine)>; 2] {
    let Some(priors) = model.plates else { return [None, None] };
    let (u0_px, scale) = (fit.centre.u_px, model.half_window_px / HALF_WINDOW_PX);
    let mut plate = |prior: Line, flanks: [Line; 2]| {
        let (shoulder_du, _) = flanks[0].meets(prior)?;
        let near_px = shoulder_du.abs() + SHOULDER_PX * scale;
        let far_px = (near_px + PLATE_PX * scale).min(model.half_window_px);
        let ends = [near_px, far_px].map(|du| u0_px + shoulder_du.signum() * du);
        let (first, last) = (ends[0].min(ends[1]).ceil(), ends[0].max(ends[1]).floor());
        if first < 0.0 || last >= frame.size_px().0 as f64 || last - first < LEAST_COLUMNS as f64 {
            return None;
        }
        let prior = Line { v_px: prior.v_px + dv_px, ..prior };
        let search = Search { half_band_px: 14, prior_sd_px: 8.0 };
        let points = ridge(&mut *frame, first as usize..last as usize + 1, |u| prior.at(u - u0_px), section, search);
        let middle_px = 0.5 * (first + last);
        let prior = prior.moved(middle_px - u0_px);
        let found = line::fit(&points, middle_px, prior, Knowledge::of_flank(PLATE_PX), PLATE_PX * scale)?;
        let (plate, in_frame) = (found.line.moved(u0_px - middle_px), found.in_frame.moved(u0_px - middle_px));
        let (du, _) = flanks[1].meets(plate)?;
        let in_place = (du - shoulder_du).abs() < SHOULDER_SLACK_PX * scale;
        (found.support > LEAST_SUPPORT_CORNER && in_place).then_some((plate, in_frame))
    };
    [plate(priors[0], [model.left, fit.left]), plate(priors[1], [model.right, fit.right])]
}

#[cfg(test)]
mod tests {
    use super::super::drawn::{drawn, fitted};
    use super::super::{JointKind, Refusal};

    const KIND: JointKind = JointKind::Fillet;

    /// Two legs that meet in column 100.3.
    fn legs(slopes: [f64; 2]) -> impl Fn(f64) -> Option<f64> {
        move |u| Some(80.0 + slopes[usize::from(u > 100.3)] * (u - 100.3))
    }

    #[test]
    fn the_corner_is_where_the_legs_meet_also_when_it_is_sought_beside_it() {
        let frame = drawn(legs([0.4, -0.3]));
        for sought_at in [100.0, 95.0, 106.0] {
            let fit = fitted(&frame, KIND, sought_at).unwrap();
            assert!((fit.centre.u_px - 100.3).abs() < 0.2 && (fit.centre.v_px - 80.0).abs() < 0.1, "{:?}", fit.centre);
            assert!((fit.left.slope - 0.4).abs() < 0.02 && (fit.right.slope + 0.3).abs() < 0.02);
            assert!(fit.is_clear() && fit.mismatch_px().is_none());
        }
    }

    #[test]
    fn a_blunt_corner_is_less_sure_along_the_stripe_than_a_sharp_one() {
        let along_px2 = |slopes| fitted(&drawn(legs(slopes)), KIND, 100.0).unwrap().along_variance_px2;
        assert!(along_px2([0.12, -0.12]) > along_px2([0.5, -0.5]));
    }

    #[test]
    fn legs_that_have_no_bend_any_more_are_no_corner() {
        use super::super::learn;
        use crate::units::PixelPoint;
        let model = learn(&drawn(legs([0.2, -0.1])), PixelPoint::new(100.0, 80.0), KIND).unwrap().model;
        let straight = drawn(|u| Some(80.0 + 0.05 * (u - 100.0)));
        assert_eq!(model.fit(&straight, 100.0, 0.0, 12.0).unwrap_err(), Refusal::NoCorner);
        assert_eq!(model.fit(&straight, 2.0, 0.0, 12.0).unwrap_err(), Refusal::Border);
    }
}
