//! Why a frame gives no value.

use std::fmt;

/// A side of the picture, seen in the direction of travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Border {
    /// To the left or right of the travel.
    Side,
    /// In front.
    Front,
    /// Behind.
    Behind,
}

/// Why a frame gives no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refusal {
    /// Nothing is brighter than its surroundings by enough, or what is is too small.
    NoPool,
    /// A glow without an edge: what is left when the pool has frozen, or a plume alone.
    NoEdge,
    /// Most of the frame is at white.
    Saturated,
    /// The pool reaches the picture's border where its measure lies.
    Border(Border),
    /// The pool's front is round: it has no protruding corner.
    NoCorner,
    /// The measure is too far from what the filter expects.
    Outlier,
    /// The frame could not be read.
    Unreadable,
}

impl Refusal {
    /// The name in `trace.csv` and `summary.json`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoPool => "no-pool",
            Self::NoEdge => "no-edge",
            Self::Saturated => "saturated",
            Self::Border(Border::Side) => "border-side",
            Self::Border(Border::Front) => "border-front",
            Self::Border(Border::Behind) => "border-behind",
            Self::NoCorner => "no-corner",
            Self::Outlier => "outlier",
            Self::Unreadable => "unreadable",
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
