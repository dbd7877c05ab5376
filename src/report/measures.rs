//! What a welder wants to know of the joint besides its place: gap, hi-lo, the groove's size. Read from `path.csv` by the
//! names of the columns, so that a page shows those that a run has.

use std::path::Path;

use super::atomic::ResultsError;

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
    columns: &'static [(&'static str, &'static str, &'static str)],
}

const KINDS: [Kind; 8] = [
    Kind {
        id: "gap",
        title: "Gap",
        note: "Distance between the two plates along the stripe; of a lap joint, the shadow of the upper plate.",
        columns: &[("gap_mm", "gap_std_mm", "mm"), ("gap_px", "", "px")],
    },
    Kind {
        id: "hi-lo",
        title: "Hi-lo",
        note: "Step from one plate to the other. + : the plate on the + side lies lower in the picture, or to its right.",
        columns: &[("hi_lo_mm", "hi_lo_std_mm", "mm"), ("mismatch_px", "", "px")],
    },
    Kind {
        id: "groove-width",
        title: "Groove width",
        note: "From shoulder to shoulder.",
        columns: &[("groove_width_mm", "groove_width_std_mm", "mm")],
    },
    Kind {
        id: "depth",
        title: "Depth",
        note: "From the line through the shoulders down to the root.",
        columns: &[("depth_mm", "depth_std_mm", "mm")],
    },
    Kind {
        id: "opening-angle",
        title: "Opening angle",
        note: "Between the two flanks.",
        columns: &[("opening_angle_deg", "opening_angle_std_deg", "°")],
    },
    Kind {
        id: "root-opening",
        title: "Root opening",
        note: "Gap at the root of the groove.",
        columns: &[("root_opening_mm", "root_opening_std_mm", "mm")],
    },
    Kind {
        id: "area",
        title: "Cross-section area",
        note: "What has to be filled, between the flanks and the line through the shoulders.",
        columns: &[("area_mm2", "area_std_mm2", "mm²")],
    },
    Kind {
        id: "height",
        title: "Height",
        note: "Height of the seam in the laser's plane, by the calibration.",
        columns: &[("height_mm", "height_std_mm", "mm")],
    },
];

/// The measures of which `path` (a `path.csv`) has any value.
///
/// # Errors
/// When the file cannot be read.
pub fn read_measures(path: &Path) -> Result<Vec<Measure>, ResultsError> {
    let content = |error: csv::Error| ResultsError::content(path, error);
    let mut reader = csv::Reader::from_path(path).map_err(content)?;
    let heads = reader.headers().map_err(content)?.clone();
    let records = reader.records().collect::<Result<Vec<_>, _>>().map_err(content)?;
    let column = |name: &str| -> Vec<Option<f64>> {
        let place = heads.iter().position(|head| head == name);
        let value =
            |record: &csv::StringRecord| record.get(place?)?.parse().ok().filter(|value: &f64| value.is_finite());
        records.iter().map(value).collect()
    };
    let measure = |kind: &Kind| {
        kind.columns.iter().find_map(|&(value, std, unit)| {
            let values = column(value);
            let Kind { id, title, note, .. } = *kind;
            let has_values = values.iter().any(Option::is_some);
            has_values.then(|| Measure { id, title, unit, note, values, std: column(std) })
        })
    };
    let mut measures: Vec<Measure> = KINDS.iter().filter_map(measure).collect();
    // Of a joint without a groove the root's opening is the gap.
    let gap = measures.iter().find(|measure| measure.id == "gap").map(|gap| gap.values.clone());
    measures.retain(|measure| measure.id != "root-opening" || Some(&measure.values) != gap.as_ref());
    Ok(measures)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_column_with_a_value_is_taken_and_what_is_empty_or_said_twice_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        let text = "frame,gap_px,gap_mm,mismatch_px,depth_mm,opening_angle_deg,opening_angle_std_deg,root_opening_mm\n\
                    0,3.5,,2.0,,59.5,0.4,3.5\n1,,,,,,,\n";
        std::fs::write(&path, text).unwrap();
        let found: Vec<_> =
            read_measures(&path).unwrap().into_iter().map(|m| (m.id, m.unit, m.values, m.std)).collect();
        let expected = [
            ("gap", "px", vec![Some(3.5), None], vec![None; 2]),
            ("hi-lo", "px", vec![Some(2.0), None], vec![None; 2]),
            ("opening-angle", "°", vec![Some(59.5), None], vec![Some(0.4), None]),
        ];
        assert_eq!(found, expected);
    }
}
