//! Where in the picture a joint is looked for: along the stripe that stands out, and, when that carries none, along each
//! of the stripes the picture shows.
//!
//! The light on a plate may fall on the table, a fixture or a second surface too, wider and brighter there. The brightest
//! stripe is looked at first, in the whole picture; the others each in a part of it that holds no other.

use std::collections::VecDeque;

use rayon::prelude::*;

use super::RobustSettings;
use super::levels::Levels;
use super::seek::Found;
use crate::frame::GrayFrame;
use crate::imgproc::geometry::JointKind;
use crate::imgproc::{Raster, Stripe, stripes};
use crate::units::{PixelPoint, PixelRect};

/// Frames looked at in vain before the stripes are looked at one by one. Chosen: a joint with edges or a corner is found
/// within ten.
const PATIENCE_FRAMES: usize = 10;
/// Stripes are those that stay: of so many frames in a row, they show in at least so many. Chosen: spatter and glare do not.
const RECENT_FRAMES: usize = 8;
const LEAST_FRAMES: usize = 5;
/// Stripes that are looked at one by one, at most. Chosen: the plate's, and two reflections.
const MOST_STRIPES: usize = 3;
/// Room round a stripe, as a share of its length: a joint near its end, a stripe that moves. Chosen.
const ROOM: f64 = 0.25;
/// A part that found nothing for so long is looked for anew \[frames\]: the stripe may have left it.
const RENEWED_FRAMES: usize = 60;

/// Seekers of the whole field and, in time, of its stripes.
pub struct Places {
    settings: RobustSettings,
    whole: Levels,
    parts: Vec<(PixelRect, Levels)>,
    recent: VecDeque<Vec<Stripe>>,
    frames: usize,
    asked: Option<PixelPoint>,
}

impl Places {
    /// Looks for the joint of the settings, or for any; `untouched` when no weld can have been begun.
    pub fn new(settings: &RobustSettings, untouched: bool) -> Self {
        Self {
            settings: settings.clone(),
            whole: Levels::new(settings, untouched),
            parts: vec![],
            recent: VecDeque::new(),
            frames: 0,
            asked: None,
        }
    }

    /// The user knows where the seam is in the next frame.
    pub fn seed_at(&mut self, centre: PixelPoint) {
        self.asked = Some(centre);
        self.whole.seed_at(centre);
    }

    /// The place the user gave where nothing was found in time, and what showed elsewhere.
    pub fn asked_in_vain(&self) -> Option<(PixelPoint, Option<(JointKind, PixelPoint)>)> {
        Some((self.asked?, self.whole.asked_in_vain()?))
    }

    /// A frame passes that cannot be looked at.
    pub fn miss(&mut self) {
        self.whole.miss();
        self.parts.iter_mut().for_each(|(_, levels)| levels.miss());
    }

    /// Looks at the next frame: what was found, in which part of the field, and in which raster.
    pub fn look(&mut self, frame: &GrayFrame) -> (Option<PixelRect>, Raster, Found) {
        let (raster, found) = self.whole.look(frame);
        if !matches!(found, Found::Nothing { .. }) {
            return (None, raster, found);
        }
        self.frames += 1;
        self.divide(frame);
        let look = |(part, levels): &mut (PixelRect, Levels)| {
            let (raster, found) = levels.look(&frame.cropped(*part)?);
            Some((Some(*part), raster, found))
        };
        let in_parts: Vec<_> = self.parts.par_iter_mut().filter_map(look).collect();
        let is_joint = |(_, _, found): &(_, _, Found)| !matches!(found, Found::Nothing { .. });
        in_parts.into_iter().find(is_joint).unwrap_or((None, raster, found))
    }

    /// Finds the field's stripes, once it is time to look at them one by one.
    fn divide(&mut self, frame: &GrayFrame) {
        let is_due = self.parts.is_empty() && self.frames > PATIENCE_FRAMES - RECENT_FRAMES;
        let is_renewed = self.frames.is_multiple_of(RENEWED_FRAMES);
        if !(is_due || is_renewed) {
            return;
        }
        if is_renewed {
            self.parts.clear();
        }
        self.recent.push_back(stripes(frame));
        if self.recent.len() < RECENT_FRAMES {
            return;
        }
        let parts = parts(&self.recent, frame);
        self.recent.clear();
        // A place that the user gave lies on one of them.
        let parts = parts.into_iter().filter(|part| self.asked.is_none_or(|place| part.holds(place)));
        let fresh = |part: PixelRect| {
            let mut levels = Levels::new(&self.settings, false);
            if let Some(place) = self.asked {
                levels.seed_at(PixelPoint::new(place.u_px - part.u_px as f64, place.v_px - part.v_px as f64));
            }
            (part, levels)
        };
        self.parts = parts.map(fresh).collect();
    }
}

/// A part of the field for each of its lasting stripes; none where there is but one.
fn parts(recent: &VecDeque<Vec<Stripe>>, frame: &GrayFrame) -> Vec<PixelRect> {
    let mut lasting: Vec<Lasting> = vec![];
    for stripe in recent.iter().flatten() {
        match lasting.iter_mut().find(|known| known.is_of(stripe)) {
            Some(known) => known.take(stripe),
            None => lasting.push(Lasting { bounds: stripe.bounds, frames: 1 }),
        }
    }
    lasting.retain(|stripe| stripe.frames >= LEAST_FRAMES);
    if lasting.len() < 2 {
        return vec![];
    }
    let part = |stripe: &Lasting| stripe.part(&lasting, frame);
    lasting.iter().take(MOST_STRIPES).map(part).collect()
}

/// A stripe that shows in several frames.
struct Lasting {
    bounds: PixelRect,
    frames: usize,
}

impl Lasting {
    /// Whether it shows again: as far across the field as its own length lets it be.
    fn is_of(&self, stripe: &Stripe) -> bool {
        let (a, b) = (self.bounds, stripe.bounds);
        let share_columns = a.u_px < b.u_end_px() && b.u_px < a.u_end_px();
        let apart_px = a.v_px.max(b.v_px).saturating_sub(a.v_end_px().min(b.v_end_px()));
        share_columns && apart_px <= ROOM_ACROSS_PX
    }

    fn take(&mut self, stripe: &Stripe) {
        let (a, b) = (self.bounds, stripe.bounds);
        let (u_px, v_px) = (a.u_px.min(b.u_px), a.v_px.min(b.v_px));
        let (width_px, height_px) = (a.u_end_px().max(b.u_end_px()) - u_px, a.v_end_px().max(b.v_end_px()) - v_px);
        self.bounds = PixelRect { u_px, v_px, width_px, height_px };
        self.frames += 1;
    }

    /// The stripe with room round it, up to half of the way to the next one.
    fn part(&self, others: &[Self], frame: &GrayFrame) -> PixelRect {
        let own = self.bounds;
        let room_px = (ROOM * own.width_px as f64) as usize;
        let mut top = own.v_px.saturating_sub(room_px);
        let mut bottom = (own.v_end_px() + room_px).min(frame.height_px());
        for other in others.iter().map(|other| other.bounds).filter(|other| *other != own) {
            let share_columns = other.u_px < own.u_end_px() + room_px && own.u_px < other.u_end_px() + room_px;
            if share_columns && other.v_end_px() <= own.v_px {
                top = top.max(other.v_end_px().midpoint(own.v_px));
            }
            if share_columns && other.v_px >= own.v_end_px() {
                bottom = bottom.min(own.v_end_px().midpoint(other.v_px));
            }
        }
        let u_px = own.u_px.saturating_sub(room_px);
        let width_px = (own.u_end_px() + room_px).min(frame.width_px()) - u_px;
        PixelRect { u_px, v_px: top, width_px, height_px: bottom - top }
    }
}

/// How far a stripe may move across the field over the frames that are compared \[px\]. Chosen: twice its own thickness.
const ROOM_ACROSS_PX: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: [usize; 2] = [70, 150];

    /// Stripes from column 40 to 280, one in each of `rows`.
    fn shown(rows: &[usize]) -> Vec<Stripe> {
        let mut frame = GrayFrame::filled(320, 240, 12).unwrap();
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = (i % 320, i / 320);
            if (40..280).contains(&u) && rows.iter().any(|row| row.abs_diff(v) < 3) {
                *pixel = 190;
            }
        }
        stripes(&frame)
    }

    fn parts_of(recent: Vec<Vec<Stripe>>) -> Vec<PixelRect> {
        parts(&recent.into(), &GrayFrame::filled(320, 240, 12).unwrap())
    }

    #[test]
    fn each_of_two_stripes_has_a_part_that_holds_it_and_not_the_other() {
        let parts = parts_of(vec![shown(&ROWS); RECENT_FRAMES]);
        assert_eq!(parts.len(), 2);
        for part in parts {
            let held = ROWS.map(|row| part.holds(PixelPoint::new(160.0, row as f64)));
            assert!(held[0] != held[1], "{part:?}");
        }
    }

    #[test]
    fn one_stripe_is_not_parted() {
        assert!(parts_of(vec![shown(&ROWS[..1]); RECENT_FRAMES]).is_empty());
    }

    #[test]
    fn what_shows_in_few_frames_is_no_stripe() {
        let mut recent = vec![shown(&ROWS[..1]); RECENT_FRAMES];
        recent[..LEAST_FRAMES - 1].fill(shown(&ROWS));
        assert!(parts_of(recent).is_empty());
    }
}
