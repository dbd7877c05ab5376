//! The faults.

use anyhow::{Context, Result};

/// What happens to a recording. Numbers are drawn anew for each run, frames from the middle of the recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Nothing, to compare with.
    Nothing,
    /// 1 to 12 frames are missing; the stamps tell.
    Dropped,
    /// A picture comes 2 to 4 times.
    Repeated,
    /// The files of 1 to 12 frames are cut: unreadable.
    Truncated,
    /// 1 to 10 pictures end early: the rest is black, grey, or still that of the picture before.
    Torn,
    /// 1 to 10 pictures are of another size.
    OtherSize,
    /// Neighbours change places, over 2 to 10 frames.
    Swapped,
    /// 1 to 20 black pictures.
    Black,
    /// 1 to 20 white pictures.
    White,
    /// Blurred by an SD of 3 to 8 px, 5 to 30 frames.
    Defocused,
    /// All light times 0.15 to 6, 10 to 60 frames.
    Exposure,
    /// The camera is moved by 5 to 40 px along the stripe and up to 20 px across it, and stays there.
    Knocked,
    /// The seam leaves the picture at 6 px a frame, and comes back 15 frames later.
    Leaving,
    /// A dark or bright thing before the seam for 60 frames.
    Covered,
    /// The laser is off for 10 to 60 frames.
    StripeOff,
    /// 30 frames with a second seam like the first one, 40 to 90 px beside it.
    SecondEdge,
    /// The joint ends; plain plates follow.
    Ending,
    /// The joint ends, and another one begins elsewhere after 15 to 30 frames.
    Another,
    /// The same picture for 15 to 60 frames, while the plates move on.
    Frozen,
    /// 1 to 10 stamps that are none: no number, again the same, earlier, or an hour ahead.
    Stamps,
}

impl Kind {
    /// All, in the order of the table.
    pub const ALL: [Self; 20] = [
        Self::Nothing,
        Self::Dropped,
        Self::Repeated,
        Self::Truncated,
        Self::Torn,
        Self::OtherSize,
        Self::Swapped,
        Self::Black,
        Self::White,
        Self::Defocused,
        Self::Exposure,
        Self::Knocked,
        Self::Leaving,
        Self::Covered,
        Self::StripeOff,
        Self::SecondEdge,
        Self::Ending,
        Self::Another,
        Self::Frozen,
        Self::Stamps,
    ];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Dropped => "dropped",
            Self::Repeated => "repeated",
            Self::Truncated => "truncated",
            Self::Torn => "torn",
            Self::OtherSize => "other-size",
            Self::Swapped => "swapped",
            Self::Black => "black",
            Self::White => "white",
            Self::Defocused => "defocused",
            Self::Exposure => "exposure",
            Self::Knocked => "knocked",
            Self::Leaving => "leaving",
            Self::Covered => "covered",
            Self::StripeOff => "stripe-off",
            Self::SecondEdge => "second-edge",
            Self::Ending => "ending",
            Self::Another => "another",
            Self::Frozen => "frozen",
            Self::Stamps => "stamps",
        }
    }

    /// The fault of this name.
    pub fn called(name: &str) -> Result<Self> {
        let known = || Self::ALL.map(Self::name).join(", ");
        Self::ALL.into_iter().find(|kind| kind.name() == name).with_context(|| format!("the faults are {}", known()))
    }
}
