//! Whether a picture is the one before once more.

use crate::frame::GrayFrame;
use crate::units::PixelPoint;

/// Where a seam is followed, this far round it all pixels are kept \[px\]; of the rest, every so many rows. Chosen: a camera's noise
/// alone changes any row, and where there is no noise, as in rendered pictures, what moves is the stripe at the seam.
const REACH_PX: usize = 48;
const EVERY_ROWS: usize = 16;

/// What is kept of the picture before.
#[derive(Debug, Default)]
pub struct Previous {
    size_px: (usize, usize),
    kept: Option<Kept>,
    pixels: Vec<u8>,
}

/// Which pixels are kept: rows of a part, so many apart, and all of a window.
#[derive(Debug, Clone, Copy)]
struct Kept {
    every_rows: usize,
    columns: (usize, usize),
    rows: (usize, usize),
}

impl Previous {
    /// Columns and rows of the picture before, if there was one \[px\].
    pub fn size_px(&self) -> Option<(usize, usize)> {
        self.kept.map(|_| self.size_px)
    }

    /// Whether `picture` is the one before, as far as that was kept.
    pub fn is(&self, picture: &GrayFrame) -> bool {
        let Some(kept) = self.kept else { return false };
        if self.size_px != (picture.width_px(), picture.height_px()) {
            return false;
        }
        let mut rest = self.pixels.as_slice();
        kept.parts(picture).all(|part| {
            let (known, further) = rest.split_at(part.len().min(rest.len()));
            rest = further;
            known == part
        })
    }

    /// Takes the place of the picture before; `seam` is where a seam was seen in it.
    pub fn keep(&mut self, picture: &GrayFrame, seam: Option<PixelPoint>) {
        self.size_px = (picture.width_px(), picture.height_px());
        let kept = Kept::of(self.size_px, seam);
        self.pixels.clear();
        for part in kept.parts(picture) {
            self.pixels.extend_from_slice(part);
        }
        self.kept = Some(kept);
    }
}

impl Kept {
    fn of((width, height): (usize, usize), seam: Option<PixelPoint>) -> Self {
        let Some(seam) = seam else { return Self { every_rows: 1, columns: (0, 0), rows: (0, 0) } };
        let within = |px: f64, size: usize| {
            let middle = px.max(0.0) as usize;
            (middle.saturating_sub(REACH_PX).min(size), (middle + REACH_PX).min(size))
        };
        Self { every_rows: EVERY_ROWS, columns: within(seam.u_px, width), rows: within(seam.v_px, height) }
    }

    fn parts(self, picture: &GrayFrame) -> impl Iterator<Item = &[u8]> {
        let rows = (0..picture.height_px()).step_by(self.every_rows).map(|v| picture.row(v));
        let window = (self.rows.0..self.rows.1).map(move |v| &picture.row(v)[self.columns.0..self.columns.1]);
        rows.chain(window)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(u: usize, v: usize) -> GrayFrame {
        let mut picture = GrayFrame::filled(300, 200, 9).unwrap();
        picture.pixels_mut()[v * 300 + u] = 10;
        picture
    }

    #[test]
    fn a_picture_is_the_one_before_if_nothing_changed_where_the_seam_is_nor_in_the_rows_that_are_kept() {
        let seam = Some(PixelPoint::new(150.0, 101.0));
        let mut previous = Previous::default();
        assert!(!previous.is(&with(0, 0)) && previous.size_px().is_none());
        previous.keep(&with(150, 99), seam);
        assert!(previous.is(&with(150, 99)) && previous.size_px() == Some((300, 200)));
        assert!(!previous.is(&with(151, 99)), "at the seam");
        let mut elsewhere = with(150, 99);
        elsewhere.pixels_mut()[32 * 300 + 7] = 10;
        assert!(!previous.is(&elsewhere), "in a row that is kept");
        assert!(!previous.is(&GrayFrame::filled(200, 300, 9).unwrap()));
    }

    #[test]
    fn where_no_seam_is_known_every_pixel_counts() {
        let mut previous = Previous::default();
        previous.keep(&with(3, 5), None);
        assert!(previous.is(&with(3, 5)) && !previous.is(&with(4, 5)) && !previous.is(&with(299, 199)));
    }
}
