//! Boards as they were seen in a set of pictures, however they were found.

use nalgebra::Vector2;

use super::board::BoardSize;
use crate::frame::GrayFrame;

/// Two boards whose corners differ by less than this \[px\] on average stood in one pose. Chosen: above what vibration
/// moves and a laser's glare draws, below any wanted move.
const SAME_POSE_PX: f64 = 3.0;

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
