//! Boards in a set of pictures: one size of board, one size of picture, no picture twice.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::board::BoardSize;
use super::corners::{Corners, find_any, find_sized};
use super::error::CalibrationError;
pub use super::sightings::{BoardSighting, Detected, Picture, Pictures, poses_of};

/// The stripe of a laser draws corners by up to 22 px; they are left out within this distance \[px\] of it.
pub const STRIPE_REACH_PX: f64 = 25.0;

enum Seen {
    Unreadable(String),
    Read { sha256: String, size_px: (usize, usize), corners: Option<Corners> },
}

/// Finds the board in every picture. Without `declared` the size is the one that most pictures show.
///
/// # Errors
/// When no picture shows a board, pictures differ in size, or the board is larger than declared.
pub fn detect(pictures: &dyn Pictures, declared: Option<BoardSize>) -> Result<Detected, CalibrationError> {
    let seen: Vec<Seen> = (0..pictures.count())
        .into_par_iter()
        .map(|i| match pictures.read(i) {
            Err(reason) => Seen::Unreadable(reason),
            Ok(Picture { sha256, frame, .. }) => {
                let corners = find_any(&frame);
                Seen::Read { sha256, size_px: (frame.width_px(), frame.height_px()), corners }
            }
        })
        .collect();
    let size_px = common_size(pictures, &seen)?;
    let board = board_size(pictures, &seen, declared)?;
    let mut left_out = vec![];
    let mut first_with: BTreeMap<String, String> = BTreeMap::new();
    let again: Vec<Option<Corners>> = (0..seen.len())
        .into_par_iter()
        .map(|i| match &seen[i] {
            Seen::Read { corners: Some(corners), .. } if corners.size == board => Some(corners.clone()),
            Seen::Read { .. } => pictures.read(i).ok().and_then(|picture| find_sized(&picture.frame, board)),
            Seen::Unreadable(_) => None,
        })
        .collect();
    let mut sightings = vec![];
    for ((i, seen), corners) in seen.into_iter().enumerate().zip(again) {
        let name = pictures.name(i);
        let sighting = match (seen, corners) {
            (Seen::Unreadable(reason), _) => {
                left_out.push(reason);
                None
            }
            (_, None) => {
                left_out.push(format!("{name} does not show the whole board of {board} inner corners"));
                None
            }
            (Seen::Read { sha256, .. }, Some(corners)) => match first_with.get(&sha256) {
                Some(first) => {
                    left_out.push(format!("{name} is the same picture as {first}"));
                    None
                }
                None => {
                    first_with.insert(sha256.clone(), name.clone());
                    let used = vec![true; corners.pixels.len()];
                    Some(BoardSighting { name, sha256, corners: corners.pixels, used })
                }
            },
        };
        sightings.push(sighting);
    }
    Ok(Detected { board, size_px, sightings, left_out })
}

fn common_size(pictures: &dyn Pictures, seen: &[Seen]) -> Result<(usize, usize), CalibrationError> {
    let mut expected = None;
    for (i, seen) in seen.iter().enumerate() {
        let Seen::Read { size_px, .. } = seen else { continue };
        let expected_px = *expected.get_or_insert(*size_px);
        if *size_px != expected_px {
            return Err(CalibrationError::MixedSizes { name: pictures.name(i), got_px: *size_px, expected_px });
        }
    }
    expected.ok_or_else(|| no_board(pictures))
}

fn no_board(pictures: &dyn Pictures) -> CalibrationError {
    let names: Vec<String> = (0..pictures.count().min(3)).map(|i| pictures.name(i)).collect();
    let more = if pictures.count() > 3 { ", ..." } else { "" };
    CalibrationError::NoBoard { names: names.join(", ") + more }
}

fn board_size(
    pictures: &dyn Pictures,
    seen: &[Seen],
    declared: Option<BoardSize>,
) -> Result<BoardSize, CalibrationError> {
    let mut votes: BTreeMap<BoardSize, (usize, usize)> = BTreeMap::new();
    for (i, seen) in seen.iter().enumerate() {
        if let Seen::Read { corners: Some(corners), .. } = seen {
            votes.entry(corners.size).or_insert((0, i)).0 += 1;
        }
    }
    // Of sizes seen equally often the larger: a board is never seen larger than it is, but it is seen cut off.
    let most = votes.iter().max_by_key(|(size, (votes, _))| (*votes, size.corners()));
    let Some(declared) = declared else {
        return most.map(|(size, _)| *size).ok_or_else(|| no_board(pictures));
    };
    if let Some((&found, &(_, first))) = most {
        let larger = found.columns >= declared.columns && found.rows >= declared.rows && found != declared;
        if larger {
            return Err(CalibrationError::PartOfBoard { name: pictures.name(first), declared, found });
        }
    }
    Ok(declared)
}
