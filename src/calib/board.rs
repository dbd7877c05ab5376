//! The chessboard: its size in inner corners, and where they lie on it.

use std::fmt;
use std::str::FromStr;

use nalgebra::Vector2;

/// Fewest inner corners a side: with fewer a board has hardly any pose.
pub const LEAST_CORNERS: usize = 3;
/// Most inner corners a side: more than any printed board has, and a bound for what a file may ask for.
pub const MOST_CORNERS: usize = 60;

/// A board's size in inner corners, the places where four squares meet. A board of 7 × 8 squares has 6 × 7.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct BoardSize {
    /// Inner corners along a row.
    pub columns: usize,
    /// Rows of inner corners.
    pub rows: usize,
}

impl BoardSize {
    /// A board of `columns` × `rows` inner corners, turned so that it has no more columns than rows.
    ///
    /// # Errors
    /// When a side has fewer than [`LEAST_CORNERS`] or more than [`MOST_CORNERS`].
    pub fn new(columns: usize, rows: usize) -> Result<Self, String> {
        let sides = LEAST_CORNERS..=MOST_CORNERS;
        if !sides.contains(&columns) || !sides.contains(&rows) {
            return Err(format!(
                "a board has {LEAST_CORNERS} to {MOST_CORNERS} inner corners a side, not {columns}x{rows}"
            ));
        }
        Ok(Self { columns: columns.min(rows), rows: columns.max(rows) })
    }

    /// Number of inner corners.
    #[must_use]
    pub const fn corners(self) -> usize {
        self.columns * self.rows
    }

    /// Whether a half turn of the board can be seen by its colours.
    #[must_use]
    pub const fn shows_half_turn(self) -> bool {
        (self.columns + self.rows) % 2 == 1
    }

    /// Where the corners lie on the board \[mm\], row by row, from the board's middle.
    #[must_use]
    pub fn points_mm(self, square_mm: f64) -> Vec<Vector2<f64>> {
        let middle = Vector2::new(self.columns as f64 - 1.0, self.rows as f64 - 1.0) / 2.0;
        let point = |i: usize| Vector2::new((i % self.columns) as f64, (i / self.columns) as f64) - middle;
        (0..self.corners()).map(|i| point(i) * square_mm).collect()
    }
}

impl fmt::Display for BoardSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.columns, self.rows)
    }
}

impl FromStr for BoardSize {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let [columns, rows] = pair(text)?;
        Self::new(columns, rows)
    }
}

/// Two numbers with an x between them, as in `7x8`.
///
/// # Errors
/// When the text is none.
pub fn pair(text: &str) -> Result<[usize; 2], String> {
    let numbers =
        text.split_once(['x', 'X', '×']).and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    numbers.ok_or_else(|| format!("expected two numbers such as 7x8, not {text}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_is_the_same_whichever_side_is_named_first() {
        assert_eq!("7x6".parse::<BoardSize>(), "6x7".parse());
        assert!("6".parse::<BoardSize>().is_err());
        assert!("2x7".parse::<BoardSize>().unwrap_err().contains("inner corners"));
        let points = BoardSize::new(6, 7).unwrap().points_mm(30.0);
        assert_eq!(points.len(), 42);
        assert_eq!(points[0], Vector2::new(-75.0, -90.0));
        assert_eq!(points[41], Vector2::new(75.0, 90.0));
    }
}
