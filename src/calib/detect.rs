//! Boards in a set of pictures: one size of board, one size of picture, no picture twice.

use std::collections::BTreeMap;

use nalgebra::Vector2;
use rayon::prelude::*;

use super::board::BoardSize;
use super::corners::{Corners, find_any, find_sized};
use super::error::CalibrationError;
use crate::frame::GrayFrame;

/// Two boards whose corners differ by less than this \[px\] on average stood in one pose. Chosen: above what vibration
/// moves and a laser's glare draws, below any wanted move.
const SAME_POSE_PX: f64 = 3.0;
/// The stripe of a laser draws corners by up to 22 px; they are left out within this distance \[px\] of it.
pub const STRIPE_REACH_PX: f64 = 25.0;

/// A picture from a file.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Name of the file.
    pub name: String,
    /// SHA-256 of the file, in hexadecimal digits.
    pub sha256: String,
    /// The picture.
    pub frame: GrayFrame,
}

/// A set of pictures that are read when they are needed.
pub trait Pictures: Sync {
    /// How many.
    fn count(&self) -> usize;
    /// The name of one.
    fn name(&self, index: usize) -> String;
    /// Reads one; the error says in one line why it cannot be read.
    ///
    /// # Errors
    /// When the file is no picture.
    fn read(&self, index: usize) -> Result<Picture, String>;
}

/// A board seen in a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardSighting {
    /// Name of the picture.
    pub name: String,
    /// SHA-256 of its file.
    pub sha256: String,
    /// The corners in the order of [`BoardSize::points_mm`] \[px\].
    pub corners: Vec<Vector2<f64>>,
    /// Which of them are used.
    pub used: Vec<bool>,
}

/// What a set of pictures shows.
#[derive(Debug, Clone)]
pub struct Detected {
    /// The board's size.
    pub board: BoardSize,
    /// Columns and rows of the pictures.
    pub size_px: (usize, usize),
    /// For each picture its board.
    pub sightings: Vec<Option<BoardSighting>>,
    /// Which pictures are left out, and why.
    pub left_out: Vec<String>,
}

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

impl BoardSighting {
    /// The corners that are used, with their places on the board.
    #[must_use]
    pub fn pairs(&self, board_mm: &[Vector2<f64>]) -> Vec<(Vector2<f64>, Vector2<f64>)> {
        let all = board_mm.iter().copied().zip(self.corners.iter().copied());
        all.zip(&self.used).filter_map(|(pair, used)| used.then_some(pair)).collect()
    }

    /// Number of corners used.
    #[must_use]
    pub fn used_corners(&self) -> usize {
        self.used.iter().filter(|used| **used).count()
    }

    /// Whether another board stood in the same pose.
    #[must_use]
    pub fn is_in_pose_of(&self, other: &Self) -> bool {
        let mut moved: Vec<f64> = self.corners.iter().zip(&other.corners).map(|(a, b)| (a - b).norm()).collect();
        if moved.is_empty() || self.corners.len() != other.corners.len() {
            return false;
        }
        moved.sort_by(f64::total_cmp);
        moved[moved.len() / 2] < SAME_POSE_PX
    }
}

/// For each sighting the number of its pose, counted from 0 in the order in which they appear.
#[must_use]
pub fn poses_of(sightings: &[&BoardSighting]) -> Vec<usize> {
    let mut firsts: Vec<&BoardSighting> = vec![];
    sightings
        .iter()
        .map(|sighting| match firsts.iter().position(|first| sighting.is_in_pose_of(first)) {
            Some(pose) => pose,
            None => {
                firsts.push(sighting);
                firsts.len() - 1
            }
        })
        .collect()
}
