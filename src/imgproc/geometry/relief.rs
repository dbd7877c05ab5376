//! Whether there is more between two edges than a dark stretch of a flat plate: slag, paint and marker make edges too.

use super::line::Line;
use super::ridge::{CrossSection, RidgePoint, Search, ridge};
use crate::frame::GrayFrame;

/// Columns next to an edge that the optics fill \[px\], and the fewest between two edges that tell a mark from a gap.
const BLURRED_PX: f64 = 1.5;
const LEAST_COLUMNS: usize = 4;
/// Half-height of the band in which the stripe is sought, and the SD of the preference for the line, in a gap and beside it
/// \[px\]: a bottom may lie deep. Chosen.
const GAP_SEARCH: Search = Search { half_band_px: 40, prior_sd_px: 30.0 };
const SIDE_SEARCH: Search = Search { half_band_px: 14, prior_sd_px: 8.0 };
/// Correlation with the stripe's cross-section at which a column shows it. Chosen: noise hardly ever passes, a mark does
/// that is a twentieth as bright as the plate.
const QUALITY: f64 = 0.75;
/// How far from the plates' line the stripe of a mark lies at most, and the bottom of a gap at least \[px\].
const ON_LINE_PX: f64 = 1.5;
const BELOW_PX: f64 = 4.0;
/// Columns beside an edge in which it may droop \[px\].
const DROOP_PX: std::ops::Range<f64> = 1.0..8.0;
/// What counts as relief: a bottom in this share of the gap, edges that droop by this much, plates of different height
/// \[px\]. Chosen: three times what speckle makes of each.
const LEAST_FLOOR: f64 = 0.3;
const LEAST_DROOP_PX: f64 = 1.0;
const LEAST_STEP_PX: f64 = 2.0;
/// Largest share of a gap through which the stripe may go on. Chosen: through a mark it does nearly everywhere.
const LARGEST_BRIDGED: f64 = 0.6;

/// What lies between two edges and beside them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relief {
    /// Share of the columns between the edges in which the stripe goes on along the sides' lines, however faint.
    pub bridged: f64,
    /// Share of them in which it lies elsewhere: a gap's bottom.
    pub floor: f64,
    /// By how much the stripe leaves the plates' lines next to the edges, both to the same side \[px\].
    pub droop_px: f64,
    /// By how much the plates differ in height at the joint \[px\].
    pub step_px: f64,
}

impl Relief {
    /// Whether it is a mark: the plate goes on in it.
    #[must_use]
    pub fn is_mark(&self) -> bool {
        self.bridged > LARGEST_BRIDGED
    }

    /// Whether something shows that no mark on a flat plate has. A narrow gap without a bottom in sight has nothing either:
    /// then only time tells.
    #[must_use]
    pub fn is_seen(&self) -> bool {
        self.floor >= LEAST_FLOOR || self.droop_px >= LEAST_DROOP_PX || self.step_px >= LEAST_STEP_PX
    }
}

/// Looks between and beside the edges at columns `left_u` and `right_u`; the sides' lines are relative to column 0.
pub fn between(
    frame: &GrayFrame,
    [left_u, right_u]: [f64; 2],
    [left, right]: [Line; 2],
    section: &CrossSection,
) -> Relief {
    let middle_u = 0.5 * (left_u + right_u);
    let look = |from_u: f64, to_u: f64, search: Search, line: &dyn Fn(f64) -> f64| -> (usize, Vec<f64>) {
        let first = from_u.ceil().max(0.0) as usize;
        let end = (to_u.floor().max(0.0) as usize + 1).min(frame.width_px());
        let points = ridge(frame, first..end.max(first), line, section, search);
        let seen = |p: &&RidgePoint| p.quality > QUALITY;
        (points.len(), points.iter().filter(seen).map(|p| p.v_px - line(p.u_px)).collect())
    };
    let (count, off) =
        look(left_u + BLURRED_PX, right_u - BLURRED_PX, GAP_SEARCH, &|u| 0.5 * (left.at(u) + right.at(u)));
    let share = |within: &dyn Fn(f64) -> bool| match count {
        0..LEAST_COLUMNS => 0.0,
        _ => off.iter().filter(|off| within(off.abs())).count() as f64 / count as f64,
    };
    let mean = |(_, off): (usize, Vec<f64>)| match off.len() {
        0..LEAST_COLUMNS => 0.0,
        count => off.iter().sum::<f64>() / count as f64,
    };
    let droops = [
        mean(look(left_u - DROOP_PX.end, left_u - DROOP_PX.start, SIDE_SEARCH, &|u| left.at(u))),
        mean(look(right_u + DROOP_PX.start, right_u + DROOP_PX.end, SIDE_SEARCH, &|u| right.at(u))),
    ];
    let alike = droops[0] * droops[1] > 0.0;
    Relief {
        bridged: share(&|off_px| off_px < ON_LINE_PX),
        floor: share(&|off_px| off_px > BELOW_PX),
        droop_px: if alike { droops[0].abs().min(droops[1].abs()) } else { 0.0 },
        step_px: (left.at(middle_u) - right.at(middle_u)).abs(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stripe along row 40, its row and brightness in each column as given.
    fn relief(stripe: impl Fn(f64) -> (f64, f64)) -> Relief {
        let mut frame = GrayFrame::filled(160, 90, 0).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = ((i % 160) as f64, (i / 160) as f64);
            let (row, grey) = stripe(u);
            *pixel = (9.0 + grey * (-0.5 * ((v - row) / 2.4).powi(2)).exp()).round() as u8;
        }
        let line = Line::straight(40.0, 0.0);
        between(&frame, [74.0, 86.0], [line, line], &CrossSection::new(2.4))
    }

    fn in_gap(u: f64) -> bool {
        (74.0..86.0).contains(&u)
    }

    #[test]
    fn a_dark_mark_is_bridged_and_shows_no_relief() {
        let mark = relief(|u| (40.0, if in_gap(u) { 20.0 } else { 190.0 }));
        assert!(mark.is_mark() && !mark.is_seen(), "{mark:?}");
    }

    #[test]
    fn a_gap_shows_its_bottom_or_its_edges_droop() {
        let bottom = relief(|u| if in_gap(u) { (52.0, 40.0) } else { (40.0, 190.0) });
        assert!(!bottom.is_mark() && bottom.is_seen(), "{bottom:?}");
        let droop = |u: f64| 3.5 * (-((u - 80.0).abs() - 6.0).max(0.0) / 5.0).exp();
        let drooping = relief(|u| (40.0 + droop(u), if in_gap(u) { 0.0 } else { 190.0 }));
        assert!(!drooping.is_mark() && drooping.is_seen(), "{drooping:?}");
    }

    #[test]
    fn a_black_gap_with_sharp_edges_is_neither() {
        let black = relief(|u| (40.0, if in_gap(u) { 0.0 } else { 190.0 }));
        assert!(!black.is_mark() && !black.is_seen(), "{black:?}");
    }
}
