//! Estimates that wait a few frames, and know them.

use std::collections::VecDeque;

use super::estimate::SeamEstimate;
use super::path;
use super::robust::filter::VIBRATION_VARIANCE_PX2;
use super::robust::height;
use super::view::View;
use crate::kalman::{Link, first_of};

/// A step of the filters along the stripe and across it, in a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Links {
    pub view: View,
    pub along: Link<4>,
    pub across: Link<3>,
    /// What no filter knows of the position: what a clear sighting elsewhere leaves of it, and of the row \[px²\].
    pub doubt_px2: f64,
    pub row_bias_px2: f64,
}

impl Links {
    /// The same moment once more.
    pub fn repeated(&self) -> Self {
        Self { along: self.along.repeated(), across: self.across.repeated(), ..*self }
    }
}

/// The frames that are waited for.
#[derive(Debug)]
pub struct Lag {
    frames: usize,
    waiting: VecDeque<Option<Links>>,
}

impl Lag {
    /// Waits for `frames` frames.
    pub fn new(frames: usize) -> Self {
        Self { frames, waiting: VecDeque::new() }
    }

    /// Takes the next frame; none where nothing is followed.
    pub fn push(&mut self, links: Option<Links>) {
        if self.waiting.len() > self.frames {
            self.waiting.pop_front();
        }
        self.waiting.push_back(links);
    }

    /// The last frame.
    pub fn last(&self) -> Option<&Links> {
        self.waiting.back()?.as_ref()
    }

    /// The seam in the frame that is due, if one is: none there when it was not followed.
    pub fn due(&self) -> Option<Option<SeamEstimate>> {
        (self.waiting.len() > self.frames).then(|| self.seam(0))
    }

    /// The seam in each frame that is still waited for, the oldest first, given those that came.
    pub fn rest(&self) -> impl Iterator<Item = Option<SeamEstimate>> {
        let due = usize::from(self.waiting.len() > self.frames);
        (due..self.waiting.len()).map(|place| self.seam(place))
    }

    fn seam(&self, place: usize) -> Option<SeamEstimate> {
        let chain: Vec<Links> = self.waiting.iter().skip(place).map_while(|links| *links).collect();
        let first = chain.first()?;
        let chain: Vec<Links> = chain.iter().take_while(|links| links.view == first.view).copied().collect();
        let alongs: Vec<_> = chain.iter().map(|links| links.along).collect();
        let acrosses: Vec<_> = chain.iter().map(|links| links.across).collect();
        let (along, (v_px, across_px2)) = (first_of(&alongs)?, height::reading(&first_of(&acrosses)?));
        let doubt_px2 = chain.last().map_or(0.0, |links| links.doubt_px2);
        let along = (along.x[0], along.P[(0, 0)].max(0.0) + VIBRATION_VARIANCE_PX2 + doubt_px2);
        path::estimate(along, (v_px, across_px2 + first.row_bias_px2), &first.view)
    }
}
