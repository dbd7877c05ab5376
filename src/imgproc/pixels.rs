//! Where pixels come from: a frame that is there, or one of which only what is looked at is made.

use std::ops::Range;

use crate::frame::GrayFrame;

/// A frame that is asked for the parts of it that are looked at.
pub trait Pixels {
    /// Columns and rows of the whole frame \[px\].
    fn size_px(&self) -> (usize, usize);

    /// The frame, of which at least these columns and rows are as they should be; what lies beyond it is left out.
    fn region(&mut self, columns: Range<usize>, rows: Range<usize>) -> &GrayFrame;

    /// The whole frame.
    fn whole(&mut self) -> &GrayFrame {
        let (width, height) = self.size_px();
        self.region(0..width, 0..height)
    }
}

impl Pixels for &GrayFrame {
    fn size_px(&self) -> (usize, usize) {
        (self.width_px(), self.height_px())
    }

    fn region(&mut self, _: Range<usize>, _: Range<usize>) -> &GrayFrame {
        self
    }
}

impl<P: Pixels + ?Sized> Pixels for &mut P {
    fn size_px(&self) -> (usize, usize) {
        (**self).size_px()
    }

    fn region(&mut self, columns: Range<usize>, rows: Range<usize>) -> &GrayFrame {
        (**self).region(columns, rows)
    }
}

/// Columns and rows of a tile \[px\]. Chosen: a window touches some ten.
const TILE_PX: (usize, usize) = (64, 16);

/// A frame made tile by tile.
#[derive(Debug)]
pub struct Tiles {
    frame: GrayFrame,
    /// For each tile, row by row, the number of the picture that it was made of last.
    made_of: Vec<u64>,
    picture: u64,
}

/// One of the tiles: its first column and row, its width and height \[px\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tile {
    pub u_px: usize,
    pub v_px: usize,
    pub width_px: usize,
    pub height_px: usize,
}

impl Tiles {
    /// Of a frame of no size yet: [`Self::begin`] comes first.
    pub fn new() -> Self {
        Self { frame: GrayFrame::dot(), made_of: vec![], picture: 0 }
    }

    /// Another picture, of `width` × `height` pixels, at least one each: no tile of it is made yet.
    pub fn begin(&mut self, (width, height): (usize, usize)) {
        self.picture += 1;
        if (self.frame.width_px(), self.frame.height_px()) != (width, height) {
            self.frame = GrayFrame::filled(width, height, 0).unwrap_or_else(|_| GrayFrame::dot());
            self.made_of = vec![0; width.div_ceil(TILE_PX.0) * height.div_ceil(TILE_PX.1)];
        }
    }

    /// Columns and rows \[px\].
    pub const fn size_px(&self) -> (usize, usize) {
        (self.frame.width_px(), self.frame.height_px())
    }

    /// The frame, in which these columns and rows are made: those that were not yet, by `make`, which is given a tile, the frame
    /// from the tile's first pixel on, and its width.
    pub fn region(
        &mut self,
        columns: Range<usize>,
        rows: Range<usize>,
        mut make: impl FnMut(Tile, &mut [u8], usize),
    ) -> &GrayFrame {
        let (width, height) = self.size_px();
        let (u_end, v_end) = (columns.end.min(width), rows.end.min(height));
        let tiles_a_row = width.div_ceil(TILE_PX.0);
        for j in rows.start / TILE_PX.1..v_end.div_ceil(TILE_PX.1) {
            for i in columns.start / TILE_PX.0..u_end.div_ceil(TILE_PX.0) {
                let made_of = &mut self.made_of[j * tiles_a_row + i];
                if std::mem::replace(made_of, self.picture) == self.picture {
                    continue;
                }
                let (u_px, v_px) = (i * TILE_PX.0, j * TILE_PX.1);
                let (width_px, height_px) = (TILE_PX.0.min(width - u_px), TILE_PX.1.min(height - v_px));
                let tile = Tile { u_px, v_px, width_px, height_px };
                make(tile, &mut self.frame.pixels_mut()[v_px * width + u_px..], width);
            }
        }
        &self.frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_tile_that_is_looked_at_is_made_once_a_picture_and_no_other() {
        let mut tiles = Tiles::new();
        for picture in 1..3u8 {
            tiles.begin((150, 40));
            let mut made = 0;
            let mut make = |tile: Tile, pixels: &mut [u8], stride: usize| {
                made += 1;
                for row in pixels.chunks_mut(stride).take(tile.height_px) {
                    row[..tile.width_px].fill(picture);
                }
            };
            tiles.region(60..70, 15..17, &mut make);
            let frame = tiles.region(0..usize::MAX, 0..16, &mut make);
            assert!(frame.row(0).iter().chain(&frame.row(31)[..128]).all(|&grey| grey == picture));
            assert!(frame.row(32).iter().all(|&grey| grey == 0), "not looked at");
            assert_eq!(made, 4 + 1);
        }
    }
}
