//! What a welder wants to know of the joint besides its place: gap, hi-lo, the groove's size. A page shows those that a run
//! has.

use super::results::PathRow;

/// A measured quantity, frame by frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// What it is called in the page's addresses.
    pub id: &'static str,
    /// Its name.
    pub title: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it means, in a sentence.
    pub note: &'static str,
    /// The values.
    pub values: Vec<Option<f64>>,
    /// One σ of each.
    pub std: Vec<Option<f64>>,
}

impl Measure {
    /// Whether it says how the plates lie to one another: gap and hi-lo.
    #[must_use]
    pub fn is_fit_up(&self) -> bool {
        matches!(self.id, "gap" | "hi-lo")
    }
}

struct Kind {
    id: &'static str,
    title: &'static str,
    note: &'static str,
    /// Columns of value and σ with their unit, the best first.
    columns: &'static [(Column, Column, &'static str)],
}

type Column = fn(&PathRow) -> Option<f64>;

const KINDS: [Kind; 8] = [
    Kind {
        id: "gap",
        title: "Gap",
        note: "Distance between the two plates along the stripe; of a lap joint, the shadow of the upper plate.",
        columns: &[(|row| row.gap_mm, |row| row.gap_std_mm, "mm"), (|row| row.gap_px, |_| None, "px")],
    },
    Kind {
        id: "hi-lo",
        title: "Hi-lo",
        note: "Step from one plate to the other. + : the plate on the + side lies lower in the picture, or to its right.",
        columns: &[(|row| row.hi_lo_mm, |row| row.hi_lo_std_mm, "mm"), (|row| row.mismatch_px, |_| None, "px")],
    },
    Kind {
        id: "groove-width",
        title: "Groove width",
        note: "From shoulder to shoulder.",
        columns: &[(|row| row.groove_width_mm, |row| row.groove_width_std_mm, "mm")],
    },
    Kind {
        id: "depth",
        title: "Depth",
        note: "From the line through the shoulders down to the root.",
        columns: &[(|row| row.depth_mm, |row| row.depth_std_mm, "mm")],
    },
    Kind {
        id: "opening-angle",
        title: "Opening angle",
        note: "Between the two flanks.",
        columns: &[(|row| row.opening_angle_deg, |row| row.opening_angle_std_deg, "°")],
    },
    Kind {
        id: "root-opening",
        title: "Root opening",
        note: "Gap at the root of the groove.",
        columns: &[(|row| row.root_opening_mm, |row| row.root_opening_std_mm, "mm")],
    },
    Kind {
        id: "area",
        title: "Cross-section area",
        note: "What has to be filled, between the flanks and the line through the shoulders.",
        columns: &[(|row| row.area_mm2, |row| row.area_std_mm2, "mm²")],
    },
    Kind {
        id: "height",
        title: "Height",
        note: "Height of the seam in the laser's plane, by the calibration.",
        columns: &[(|row| row.height_mm, |row| row.height_std_mm, "mm")],
    },
];

/// The measures of which `rows` have any value.
#[must_use]
pub fn measures(rows: &[PathRow]) -> Vec<Measure> {
    let measure = |kind: &Kind| {
        kind.columns.iter().find_map(|&(value, std, unit)| {
            let values: Vec<Option<f64>> = rows.iter().map(value).collect();
            let Kind { id, title, note, .. } = *kind;
            let has_values = values.iter().any(Option::is_some);
            has_values.then(|| Measure { id, title, unit, note, values, std: rows.iter().map(std).collect() })
        })
    };
    let mut measures: Vec<Measure> = KINDS.iter().filter_map(measure).collect();
    // Of a joint without a groove the root's opening is the gap.
    let gap = measures.iter().find(|measure| measure.id == "gap").map(|gap| gap.values.clone());
    measures.retain(|measure| measure.id != "root-opening" || Some(&measure.values) != gap.as_ref());
    measures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::results::Status;

    #[test]
    fn the_best_column_with_a_value_is_taken_and_what_is_empty_or_said_twice_is_left_out() {
        let empty = |frame| PathRow::empty(frame, String::new(), 0.0, Status::Tracked);
        let rows = [
            PathRow {
                gap_px: Some(3.5),
                mismatch_px: Some(2.0),
                opening_angle_deg: Some(59.5),
                opening_angle_std_deg: Some(0.4),
                root_opening_mm: Some(3.5),
                ..empty(0)
            },
            empty(1),
        ];
        let found: Vec<_> = measures(&rows).into_iter().map(|m| (m.id, m.unit, m.values, m.std)).collect();
        let expected = [
            ("gap", "px", vec![Some(3.5), None], vec![None; 2]),
            ("hi-lo", "px", vec![Some(2.0), None], vec![None; 2]),
            ("opening-angle", "°", vec![Some(59.5), None], vec![Some(0.4), None]),
        ];
        assert_eq!(found, expected);
    }
}
