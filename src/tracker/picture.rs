//! The picture as the camera took it, and what a method looks at in it: filtered, turned, in the raster of its view. Only what is
//! looked at is made, so that a step costs what its window holds and not what the camera has.

use std::borrow::Cow;
use std::ops::Range;

use super::view::{Field, View};
use crate::frame::GrayFrame;
use crate::imgproc::{MedianFilter, MedianKernel, Pixels, Raster, Tiles};
use crate::units::{PixelRect, StripeAxis};

/// A camera's picture, and what of it a tracker is given.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    frame: &'a GrayFrame,
    field: Field,
    /// Columns and rows of the field, its stripe along the rows \[px\].
    size_px: (usize, usize),
}

impl<'a> Picture<'a> {
    /// The part `roi` of `frame`, or all of it, in which the stripe runs along `axis`. None where the part lies outside.
    pub fn new(frame: &'a GrayFrame, axis: StripeAxis, roi: Option<PixelRect>) -> Option<Self> {
        let all = (frame.width_px(), frame.height_px());
        let part = roi.unwrap_or(PixelRect::whole(all)).within(all)?;
        let size_px = match axis {
            StripeAxis::Horizontal => (part.width_px, part.height_px),
            StripeAxis::Vertical => (part.height_px, part.width_px),
        };
        Some(Self { frame, field: Field { axis, origin_px: (part.u_px, part.v_px) }, size_px })
    }

    /// Which part of the picture it is, and how it is turned.
    pub const fn field(&self) -> Field {
        self.field
    }

    /// The field, its stripe along the rows, unfiltered.
    pub fn whole(&self) -> Cow<'a, GrayFrame> {
        let (width, height) = self.size_px;
        let is_all = width * height == self.frame.pixels().len();
        match self.field.axis {
            StripeAxis::Horizontal if is_all => Cow::Borrowed(self.frame),
            StripeAxis::Vertical if is_all => Cow::Owned(self.frame.transposed()),
            _ => {
                let mut pixels = vec![0; width * height];
                self.gather((0, 0), (width, height), &mut pixels);
                Cow::Owned(GrayFrame::new(width, height, pixels).unwrap_or_else(|_| GrayFrame::dot()))
            }
        }
    }

    /// Copies `size` pixels of the field from column and row `first` on into `target`, row by row; the field's border is continued
    /// outwards.
    fn gather(&self, first: (isize, isize), (width, height): (usize, usize), target: &mut [u8]) {
        let clamped = |i: isize, n: usize| i.clamp(0, n as isize - 1) as usize;
        let (u_origin, v_origin) = self.field.origin_px;
        match self.field.axis {
            StripeAxis::Horizontal => {
                let within = usize::try_from(first.0).ok().filter(|u| u + width <= self.size_px.0);
                for (v, target) in (first.1..).zip(target.chunks_exact_mut(width)) {
                    let row = &self.frame.row(v_origin + clamped(v, self.size_px.1))[u_origin..];
                    match within {
                        Some(u) => target.copy_from_slice(&row[u..u + width]),
                        None => {
                            for (u, grey) in (first.0..).zip(target) {
                                *grey = row[clamped(u, self.size_px.0)];
                            }
                        }
                    }
                }
            }
            StripeAxis::Vertical => {
                for i in 0..width {
                    let row = &self.frame.row(v_origin + clamped(first.0 + i as isize, self.size_px.0))[u_origin..];
                    for j in 0..height {
                        target[j * width + i] = row[clamped(first.1 + j as isize, self.size_px.1)];
                    }
                }
            }
        }
    }
}

/// What was made of the picture so far; it keeps its buffers.
#[derive(Debug)]
pub struct Darkroom {
    filter: MedianFilter,
    field: Tiles,
    view: Tiles,
}

impl Darkroom {
    /// Filters by `kernel`.
    pub fn new(kernel: MedianKernel) -> Self {
        Self { filter: MedianFilter::new(kernel), field: Tiles::new(), view: Tiles::new() }
    }

    /// Begins with another picture.
    pub fn begin<'a>(&'a mut self, picture: Picture<'a>) -> Developed<'a> {
        self.field.begin(picture.size_px);
        Developed { picture, filter: &mut self.filter, field: &mut self.field, view: &mut self.view }
    }
}

/// The filtered field.
#[derive(Debug)]
pub struct Developed<'a> {
    picture: Picture<'a>,
    filter: &'a mut MedianFilter,
    field: &'a mut Tiles,
    view: &'a mut Tiles,
}

impl<'a> Developed<'a> {
    /// Which part of the picture it is, and how it is turned.
    pub const fn origin(&self) -> Field {
        self.picture.field
    }

    /// The field as `view` has it; none where the view's raster leaves nothing of it.
    pub fn in_view(&mut self, view: View) -> Option<InView<'_, 'a>> {
        let all = self.picture.size_px;
        let part = view.part().unwrap_or(PixelRect::whole(all)).within(all)?;
        let side = view.raster().coarseness();
        let size_px = (part.width_px / side, part.height_px / side);
        if size_px.0 == 0 || size_px.1 == 0 {
            return None;
        }
        let is_field = size_px == all;
        if !is_field {
            self.view.begin(size_px);
        }
        Some(InView { field: self, corner_px: (part.u_px, part.v_px), raster: view.raster(), is_field })
    }
}

/// The field, in which these columns and rows are filtered.
fn develop<'a>(
    picture: &Picture<'_>,
    filter: &mut MedianFilter,
    field: &'a mut Tiles,
    columns: Range<usize>,
    rows: Range<usize>,
) -> &'a GrayFrame {
    let reach = filter.radius_px();
    field.region(columns, rows, |tile, target, stride| {
        let first = (tile.u_px as isize - reach as isize, tile.v_px as isize - reach as isize);
        let padded = (tile.width_px + 2 * reach, tile.height_px + 2 * reach);
        let gather = |target: &mut [u8]| picture.gather(first, padded, target);
        filter.block((tile.width_px, tile.height_px), gather, target, stride);
    })
}

impl Pixels for Developed<'_> {
    fn size_px(&self) -> (usize, usize) {
        self.field.size_px()
    }

    fn region(&mut self, columns: Range<usize>, rows: Range<usize>) -> &GrayFrame {
        develop(&self.picture, self.filter, self.field, columns, rows)
    }
}

/// The filtered field in the raster of a view.
#[derive(Debug)]
pub struct InView<'s, 'a> {
    field: &'s mut Developed<'a>,
    /// The view's first pixel in the field.
    corner_px: (usize, usize),
    raster: Raster,
    /// The view is the field itself.
    is_field: bool,
}

impl Pixels for InView<'_, '_> {
    fn size_px(&self) -> (usize, usize) {
        if self.is_field { self.field.size_px() } else { self.field.view.size_px() }
    }

    fn region(&mut self, columns: Range<usize>, rows: Range<usize>) -> &GrayFrame {
        if self.is_field {
            return self.field.region(columns, rows);
        }
        let ((u_corner, v_corner), side) = (self.corner_px, self.raster.coarseness());
        let Developed { picture, filter, field, view } = &mut *self.field;
        view.region(columns, rows, |tile, target, stride| {
            let (u_px, v_px) = (u_corner + tile.u_px * side, v_corner + tile.v_px * side);
            let (columns, rows) = (u_px..u_px + tile.width_px * side, v_px..v_px + tile.height_px * side);
            let covered = develop(picture, filter, field, columns, rows);
            for (j, target) in target.chunks_mut(stride).take(tile.height_px).enumerate() {
                self.raster.mean_row(covered, (u_px, v_px + j * side), &mut target[..tile.width_px]);
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imgproc::median;

    fn noise(width: usize, height: usize) -> GrayFrame {
        let pixels = (0..width * height).map(|i| ((i as u32).wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        GrayFrame::new(width, height, pixels).unwrap()
    }

    #[test]
    fn what_is_made_on_the_way_is_what_the_whole_picture_would_be() {
        let picture = noise(301, 187);
        let roi = PixelRect { u_px: 13, v_px: 9, width_px: 201, height_px: 999 };
        let part = PixelRect { u_px: 30, v_px: 22, width_px: 100, height_px: 90 };
        for axis in [StripeAxis::Horizontal, StripeAxis::Vertical] {
            for roi in [None, Some(roi)] {
                let cut = roi.map_or_else(|| picture.clone(), |roi| picture.cropped(roi).unwrap());
                let field = if axis == StripeAxis::Vertical { cut.transposed() } else { cut };
                let filtered = median(&field, MedianKernel::Three);
                for (part, coarseness) in [(None, 1), (None, 3), (Some(part), 1), (Some(part), 2)] {
                    let given = Picture::new(&picture, axis, roi).unwrap();
                    assert_eq!(*given.whole(), field);
                    let view = View::of_part(given.field(), part, Raster::coarser(coarseness));
                    let expected = view.frame(&filtered).unwrap().into_owned();
                    let mut darkroom = Darkroom::new(MedianKernel::Three);
                    let mut developed = darkroom.begin(given);
                    let mut seen = developed.in_view(view).unwrap();
                    assert_eq!(seen.size_px(), (expected.width_px(), expected.height_px()));
                    for (columns, rows) in [(3..20, 5..9), (15..50, 0..30)] {
                        let region = seen.region(columns.clone(), rows.clone());
                        for v in rows {
                            assert_eq!(region.row(v)[columns.clone()], expected.row(v)[columns.clone()]);
                        }
                    }
                    assert_eq!(*seen.whole(), expected);
                    assert_eq!(*developed.whole(), filtered);
                }
            }
        }
        assert!(Picture::new(&picture, StripeAxis::Vertical, Some(PixelRect { u_px: 301, ..part })).is_none());
    }
}
