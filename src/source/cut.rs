//! A part of a recording.

use std::fmt;
use std::str::FromStr;

use super::{FrameSource, NextFrame, SixteenBitScale, SourceError, SourceFrame};

/// The frames from one number up to another, which is the first that is left out; numbers count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRange {
    /// The first frame.
    pub first: usize,
    /// The first one behind it, if not the recording's end.
    pub end: Option<usize>,
}

/// Text that is no range of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected A..B, frame numbers from 0 with B behind A, for example 100..250, 100.. or ..250")]
pub struct NoFrameRange;

impl FromStr for FrameRange {
    type Err = NoFrameRange;

    fn from_str(text: &str) -> Result<Self, NoFrameRange> {
        let number = |text: &str| match text.trim() {
            "" => Ok(None),
            digits => digits.parse().map(Some).map_err(|_| NoFrameRange),
        };
        let (first, end) = text.split_once("..").ok_or(NoFrameRange)?;
        let range = Self { first: number(first)?.unwrap_or(0), end: number(end)? };
        if range.end.is_some_and(|end| end <= range.first) { Err(NoFrameRange) } else { Ok(range) }
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..", self.first)?;
        self.end.map_or(Ok(()), |end| write!(f, "{end}"))
    }
}

/// A recording of which a range of frames is given; they keep their names and time stamps.
pub struct Cut {
    whole: Box<dyn FrameSource>,
    range: FrameRange,
    next: usize,
}

impl Cut {
    /// The frames of `whole` that lie in `range`.
    #[must_use]
    pub const fn new(whole: Box<dyn FrameSource>, range: FrameRange) -> Self {
        Self { whole, range, next: 0 }
    }
}

impl FrameSource for Cut {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        self.next_encoded().map(NextFrame::decoded)
    }

    fn next_encoded(&mut self) -> Option<NextFrame> {
        if self.next < self.range.first {
            self.skip(0);
        }
        if self.range.end.is_some_and(|end| self.next >= end) {
            return None;
        }
        self.next = self.next.saturating_add(1);
        self.whole.next_encoded()
    }

    fn skip(&mut self, frames: usize) {
        let to = self.next.max(self.range.first).saturating_add(frames);
        self.whole.skip(to - self.next);
        self.next = to;
    }

    fn frame_count(&self) -> Option<usize> {
        let end = self.whole.frame_count()?.min(self.range.end.unwrap_or(usize::MAX));
        Some(end.saturating_sub(self.range.first))
    }

    fn kind(&self) -> &'static str {
        self.whole.kind()
    }

    fn period_s(&self) -> f64 {
        self.whole.period_s()
    }

    fn notes(&self) -> &[String] {
        self.whole.notes()
    }

    fn sixteen_bit_scale(&self) -> Option<SixteenBitScale> {
        self.whole.sixteen_bit_scale()
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(Self::new(self.whole.again()?, self.range)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_leaves_out_its_end_and_either_end_may_be_open() {
        for (text, first, end) in [("3..9", 3, Some(9)), ("3..", 3, None), ("..9", 0, Some(9)), ("..", 0, None)] {
            assert_eq!(text.parse(), Ok(FrameRange { first, end }), "{text}");
        }
        for wrong in ["", "3", "9..3", "3..3", "a..b", "-1..2", "1..2..3", "0..99999999999999999999"] {
            assert_eq!(wrong.parse::<FrameRange>(), Err(NoFrameRange), "{wrong}");
        }
    }
}
