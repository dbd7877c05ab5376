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
    /// What no smoother averages out of the position along the stripe \[px²\].
    pub lasting_px2: f64,
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
        let first = self.waiting.get(place)?.as_ref()?;
        let chain = || {
            let followed = self.waiting.iter().skip(place).map_while(Option::as_ref);
            followed.take_while(|links| links.view == first.view)
        };
        let alongs: Vec<_> = chain().map(|links| links.along).collect();
        let acrosses: Vec<_> = chain().map(|links| links.across).collect();
        let (along, (v_px, across_px2)) = (first_of(&alongs)?, height::reading(&first_of(&acrosses)?));
        let doubt_px2 = chain().last().map_or(0.0, |links| links.doubt_px2);
        let along = (along.x[0], along.P[(0, 0)].max(0.0) + VIBRATION_VARIANCE_PX2 + doubt_px2);
        path::estimate(along, first.lasting_px2, (v_px, across_px2 + first.row_bias_px2), &first.view)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{SMatrix, SVector};

    use super::*;
    use crate::imgproc::Raster;
    use crate::kalman::Gaussian;
    use crate::tracker::view::Field;
    use crate::units::{PixelPoint, StripeAxis};

    fn state<const N: usize>(place_px: f64) -> Gaussian<N> {
        let mut x = SVector::zeros();
        x[0] = place_px;
        Gaussian { x, P: SMatrix::identity() }
    }

    /// A seam that was measured at `along_px`, in a chain of its own.
    fn links(along_px: f64) -> Links {
        Links {
            view: View::new(Field::whole(StripeAxis::Horizontal), Raster::PICTURE),
            along: Link::first(state(along_px)),
            across: Link::first(state(90.0)),
            doubt_px2: 0.0,
            row_bias_px2: 0.0,
            lasting_px2: 0.0,
        }
    }

    /// The columns of the frames that are still waited for.
    fn rest_px(lag: &Lag) -> Vec<Option<f64>> {
        lag.rest().map(|seam| seam.map(|seam| seam.centre.u_px)).collect()
    }

    #[test]
    fn a_frame_is_due_once_as_many_came_after_it_as_are_waited_for() {
        let mut lag = Lag::new(2);
        for place_px in [10.0, 11.0] {
            lag.push(Some(links(place_px)));
            assert!(lag.due().is_none());
        }
        for (place_px, due_px) in [(12.0, 10.0), (13.0, 11.0), (14.0, 12.0)] {
            lag.push(Some(links(place_px)));
            assert_eq!(lag.due().unwrap().unwrap().centre, PixelPoint::new(due_px, 90.0));
        }
        assert_eq!(rest_px(&lag), [Some(13.0), Some(14.0)]);
    }

    #[test]
    fn where_nothing_was_followed_nothing_is_due_and_it_parts_the_chains() {
        let mut lag = Lag::new(1);
        lag.push(None);
        lag.push(Some(links(20.0)));
        assert_eq!(lag.due(), Some(None));
        lag.push(None);
        assert_eq!(lag.due().unwrap().unwrap().centre.u_px, 20.0);
        assert_eq!(rest_px(&lag), [None]);
    }

    #[test]
    fn a_repeated_picture_is_the_same_moment() {
        let mut lag = Lag::new(1);
        lag.push(Some(links(20.0)));
        lag.push(Some(links(20.0).repeated()));
        let due = lag.due().unwrap().unwrap();
        assert_eq!(Some(Some(due.centre.u_px)), rest_px(&lag).first().copied());
    }

    #[test]
    fn doubt_of_the_last_frame_widens_what_is_due() {
        let std_px = |doubt_px2| {
            let mut lag = Lag::new(0);
            lag.push(Some(Links { doubt_px2, ..links(20.0) }));
            lag.due().unwrap().unwrap().std_px
        };
        assert!((std_px(3.0).powi(2) - std_px(0.0).powi(2) - 3.0).abs() < 1e-9);
    }
}
