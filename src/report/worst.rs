//! The frames a person should look at first.

use std::collections::BTreeSet;

use super::results::{PathRow, Status};
use super::verdict::NIS_95;
use crate::units::LengthUnit;

/// Entries of one reason in the list.
const ENTRIES: usize = 8;
/// Frames closer than this show the same event.
const SEPARATION_FRAMES: usize = 5;

/// A frame worth looking at.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstFrame {
    /// Its number.
    pub frame: usize,
    /// Why, in a few words, with the figure.
    pub reason: String,
}

/// Frames worth looking at, reason by reason: losses and gaps (the longest first), the largest of `errors` if they
/// are known, largest NIS above [`NIS_95`], lowest PSR.
#[must_use]
pub fn worst_frames(rows: &[PathRow], errors: &[Option<f64>], unit: LengthUnit) -> Vec<WorstFrame> {
    let mut list = Vec::new();
    let mut episodes = episodes(rows);
    episodes.sort_by_key(|&(status, first, length)| (status != Status::Lost, std::cmp::Reverse(length), first));
    list.extend(episodes.into_iter().take(2 * ENTRIES).map(|(status, first, length)| {
        let plural = if length == 1 { "" } else { "s" };
        WorstFrame { frame: first, reason: format!("{status} for {length} frame{plural}") }
    }));
    let errors = errors.iter().map(|error| error.map(f64::abs));
    list.extend(largest(errors).map(|(frame, error)| WorstFrame { frame, reason: format!("error {error:.3} {unit}") }));
    let nis = rows.iter().map(|row| row.nis.filter(|&nis| nis > NIS_95));
    list.extend(largest(nis).map(|(frame, nis)| WorstFrame { frame, reason: format!("NIS {nis:.1}") }));
    let psr = rows.iter().map(|row| row.psr.map(|psr| -psr));
    list.extend(largest(psr).map(|(frame, psr)| WorstFrame { frame, reason: format!("PSR {:.1}", -psr) }));
    list
}

/// Stretches without an observation after the seam was found: status, first frame, length.
fn episodes(rows: &[PathRow]) -> Vec<(Status, usize, usize)> {
    let found = rows.iter().position(|row| row.status == Status::Tracked).unwrap_or(rows.len());
    rows[found..]
        .chunk_by(|a, b| a.status == b.status)
        .filter(|chunk| chunk[0].status != Status::Tracked)
        .map(|chunk| (chunk[0].status, chunk[0].frame, chunk.len()))
        .collect()
}

fn largest(values: impl Iterator<Item = Option<f64>>) -> impl Iterator<Item = (usize, f64)> {
    let mut ranked: Vec<(usize, f64)> = values.enumerate().filter_map(|(frame, value)| Some((frame, value?))).collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut taken: BTreeSet<usize> = BTreeSet::new();
    ranked
        .into_iter()
        .filter(move |&(frame, _)| {
            let near = frame.saturating_sub(SEPARATION_FRAMES - 1)..frame + SEPARATION_FRAMES;
            taken.range(near).next().is_none() && taken.insert(frame)
        })
        .take(ENTRIES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_come_first_and_neighbours_are_listed_once() {
        let status = |frame| match frame {
            0..3 => Status::Seeking,
            10..12 => Status::Coasting,
            12..20 => Status::Lost,
            _ => Status::Tracked,
        };
        let mut rows: Vec<_> = (0..60).map(|f| PathRow::empty(f, String::new(), f as f64, status(f))).collect();
        for (frame, nis) in [(30, 9.0), (31, 8.0), (50, 7.0)] {
            rows[frame].nis = Some(nis);
        }
        let list: Vec<_> = worst_frames(&rows, &[], LengthUnit::Mm).into_iter().map(|w| (w.frame, w.reason)).collect();
        let expected = [(12, "lost for 8 frames"), (10, "coasting for 2 frames"), (30, "NIS 9.0"), (50, "NIS 7.0")];
        assert_eq!(list, expected.map(|(frame, reason)| (frame, reason.to_owned())));
    }
}
