//! The places of a recording that a person should look at, each with its reasons.

use super::results::{PathRow, Status};
use super::summary::Limits;
use super::tolerance::{Stretch, stretches};
use crate::units::LengthUnit;

/// Places in the list; the rest are counted.
pub const MOST: usize = 12;
/// Findings of one reason.
const ENTRIES: usize = 8;
/// Largest errors that are listed, whatever their size.
const ERRORS: usize = 3;
/// Findings closer than this belong to one place \[frames\].
const SEPARATION_FRAMES: usize = 5;
/// Above this NIS a measurement lies over 3 σ from its prediction: 3 in 1000 are expected to.
const SURPRISING_NIS: f64 = 9.0;

/// A stretch of frames worth looking at.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Its first frame.
    pub first: usize,
    /// Its last frame.
    pub last: usize,
    /// The frame that shows it best.
    pub frame: usize,
    /// Why, each in a few words with the figure, the gravest first.
    pub reasons: Vec<String>,
}

/// One reason to look at a stretch. The smaller the rank and the larger the weight, the graver.
struct Finding {
    first: usize,
    last: usize,
    frame: usize,
    rank: u8,
    weight: f64,
    reason: String,
}

impl Finding {
    fn at(frame: usize, rank: u8, weight: f64, reason: String) -> Self {
        Self { first: frame, last: frame, frame, rank, weight, reason }
    }
}

/// The places of a run, the gravest first: losses and predictions, stretches where `deviation_mm` leaves the tolerance,
/// the largest of `errors` where they are known, measurements far from their prediction, a KCF under its threshold.
#[must_use]
pub fn places(
    rows: &[PathRow],
    (errors, unit): (&[Option<f64>], LengthUnit),
    deviation_mm: &[Option<f64>],
    limits: &Limits,
) -> Vec<Place> {
    let mut findings = episodes(rows);
    if let Some(tolerance_mm) = limits.tolerance_mm {
        let outside = stretches(deviation_mm, tolerance_mm).into_iter();
        findings.extend(outside.map(|Stretch { first, last, worst, worst_mm }| Finding {
            first,
            last,
            frame: worst,
            rank: 1,
            weight: worst_mm.abs(),
            reason: format!("outside ±{tolerance_mm} mm, by up to {:.3} mm", worst_mm.abs() - tolerance_mm),
        }));
    }
    let errors = largest(errors.iter().map(|error| error.map(f64::abs)));
    findings.extend(
        errors.take(ERRORS).map(|(frame, error)| Finding::at(frame, 3, error, format!("error {error:.3} {unit}"))),
    );
    let nis = rows.iter().map(|row| row.nis.filter(|&nis| nis > SURPRISING_NIS));
    findings.extend(
        largest(nis).take(ENTRIES).map(|(frame, nis)| {
            Finding::at(frame, 4, nis, format!("measured {:.1} σ from the prediction", nis.sqrt()))
        }),
    );
    if let Some(limit) = limits.psr {
        let below = rows.iter().map(|row| row.psr.filter(|&psr| psr < limit).map(|psr| -psr));
        findings.extend(largest(below).take(ENTRIES).map(|(frame, psr)| {
            Finding::at(frame, 5, psr, format!("the picture is unlike the template: PSR {:.1}", -psr))
        }));
    }
    grouped(findings)
}

/// Neighbours made one place; then the gravest place first.
fn grouped(mut findings: Vec<Finding>) -> Vec<Place> {
    findings.sort_by_key(|finding| (finding.first, finding.last));
    let mut groups: Vec<(usize, Vec<Finding>)> = vec![];
    for finding in findings {
        match groups.last_mut() {
            Some((end, group)) if finding.first < *end + SEPARATION_FRAMES => {
                *end = (*end).max(finding.last);
                group.push(finding);
            }
            _ => groups.push((finding.last, vec![finding])),
        }
    }
    for (_, group) in &mut groups {
        group.sort_by(|a, b| a.rank.cmp(&b.rank).then(b.weight.total_cmp(&a.weight)));
    }
    groups.sort_by(|(_, a), (_, b)| a[0].rank.cmp(&b[0].rank).then(b[0].weight.total_cmp(&a[0].weight)));
    let place = |(last, group): (usize, Vec<Finding>)| Place {
        first: group.iter().map(|finding| finding.first).min().unwrap_or(last),
        last,
        frame: group[0].frame,
        reasons: reasons(group),
    };
    groups.into_iter().map(place).collect()
}

/// The gravest finding of each kind.
fn reasons(group: Vec<Finding>) -> Vec<String> {
    let mut ranks = vec![];
    let mut reasons = vec![];
    for finding in group {
        if !ranks.contains(&finding.rank) {
            ranks.push(finding.rank);
            reasons.push(finding.reason);
        }
    }
    reasons
}

/// Stretches without an observation after the seam was found.
fn episodes(rows: &[PathRow]) -> Vec<Finding> {
    let found = rows.iter().position(|row| row.status == Status::Tracked).unwrap_or(rows.len());
    let gaps = rows[found..].chunk_by(|a, b| a.status == b.status).filter(|chunk| chunk[0].status != Status::Tracked);
    gaps.map(|chunk| {
        let (first, length) = (chunk[0].frame, chunk.len());
        let plural = if length == 1 { "" } else { "s" };
        Finding {
            first,
            last: first + length - 1,
            frame: first,
            rank: if chunk[0].status == Status::Lost { 0 } else { 2 },
            weight: length as f64,
            reason: format!("{} for {length} frame{plural}", chunk[0].status),
        }
    })
    .collect()
}

/// Frames by falling value, one of each neighbourhood.
fn largest(values: impl Iterator<Item = Option<f64>>) -> impl Iterator<Item = (usize, f64)> {
    let mut ranked: Vec<(usize, f64)> = values.enumerate().filter_map(|(frame, value)| Some((frame, value?))).collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut taken = std::collections::BTreeSet::new();
    ranked.into_iter().filter(move |&(frame, _)| {
        let near = frame.saturating_sub(SEPARATION_FRAMES - 1)..frame + SEPARATION_FRAMES;
        taken.range(near).next().is_none() && taken.insert(frame)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(frames: usize, status: impl Fn(usize) -> Status) -> Vec<PathRow> {
        (0..frames).map(|f| PathRow::empty(f, String::new(), f as f64, status(f))).collect()
    }

    fn summed_up(places: &[Place]) -> Vec<(usize, usize, usize, String)> {
        places.iter().map(|p| (p.first, p.last, p.frame, p.reasons.join("; "))).collect()
    }

    #[test]
    fn a_loss_and_what_led_to_it_are_one_place_and_come_first() {
        let mut rows = rows(60, |frame| match frame {
            0..3 => Status::Seeking,
            10..12 => Status::Coasting,
            12..20 => Status::Lost,
            _ => Status::Tracked,
        });
        for (frame, nis) in [(22, 16.0), (30, 9.5), (31, 25.0), (50, 7.0)] {
            rows[frame].nis = Some(nis);
        }
        let places = places(&rows, (&[], LengthUnit::Mm), &[], &Limits::default());
        let expected = [
            (10, 22, 12, "lost for 8 frames; coasting for 2 frames; measured 4.0 σ from the prediction"),
            (31, 31, 31, "measured 5.0 σ from the prediction"),
        ];
        assert_eq!(summed_up(&places), expected.map(|(a, b, c, reason)| (a, b, c, reason.to_owned())));
    }

    #[test]
    fn what_leaves_the_tolerance_is_a_place_with_its_worst_frame() {
        let rows = rows(40, |_| Status::Tracked);
        let deviation: Vec<_> =
            (0..40).map(|f| Some(if (20..24).contains(&f) { 0.1 * (f - 18) as f64 } else { 0.0 })).collect();
        let limits = Limits { tolerance_mm: Some(0.25), ..Limits::default() };
        let found = summed_up(&places(&rows, (&[], LengthUnit::Mm), &deviation, &limits));
        assert_eq!(found, [(21, 23, 23, "outside ±0.25 mm, by up to 0.250 mm".to_owned())]);
    }

    #[test]
    fn a_run_without_events_has_no_place() {
        assert!(places(&rows(40, |_| Status::Tracked), (&[], LengthUnit::Mm), &[], &Limits::default()).is_empty());
    }
}
