//! The picture turned so that the torch travels up.

use crate::frame::IntensityFrame;
use crate::units::Travel;

/// A picture turned so that the torch travels up: towards row 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turned<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) light: &'a [f32],
}

impl<'a> Turned<'a> {
    /// The picture turned into the buffer, or itself where it need not be turned: the largest takes 256 MB.
    pub(super) fn new(frame: &'a IntensityFrame, travel: Travel, buffer: &'a mut Vec<f32>) -> Self {
        let (w, h) = (frame.width_px(), frame.height_px());
        let (width, height) = if travel.is_along_columns() { (w, h) } else { (h, w) };
        let pixels = frame.pixels();
        buffer.clear();
        match travel {
            Travel::Up => return Self { width, height, light: pixels },
            Travel::Down => pixels.chunks_exact(w).rev().for_each(|row| buffer.extend_from_slice(row)),
            Travel::Left => (0..w).for_each(|u| buffer.extend((0..h).map(|v| pixels[v * w + u]))),
            Travel::Right => (0..w).rev().for_each(|u| buffer.extend((0..h).map(|v| pixels[v * w + u]))),
        }
        Self { width, height, light: buffer }
    }

    /// The intensity between pixel centres, bilinear; none outside the picture.
    pub(super) fn at(&self, x: f64, y: f64) -> Option<f32> {
        let inside = x >= 0.0 && y >= 0.0 && x <= (self.width - 1) as f64 && y <= (self.height - 1) as f64;
        if !inside {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        let (fx, fy) = ((x - column as f64) as f32, (y - row as f64) as f32);
        let (right, below) = ((column + 1).min(self.width - 1), (row + 1).min(self.height - 1));
        let light = |column: usize, row: usize| self.light[row * self.width + column];
        let upper = light(column, row) + fx * (light(right, row) - light(column, row));
        let lower = light(column, below) + fx * (light(right, below) - light(column, below));
        Some(upper + fy * (lower - upper))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_of_the_turned_picture_is_that_of_the_image_it_says() {
        let frame = IntensityFrame::new(5, 3, (0..15).map(|i| i as f32).collect()).unwrap();
        for travel in [Travel::Up, Travel::Down, Travel::Left, Travel::Right] {
            let mut buffer = vec![];
            let turned = Turned::new(&frame, travel, &mut buffer);
            for y in 0..turned.height {
                for x in 0..turned.width {
                    let point = travel.image_from_turned([x as f64, y as f64], (5, 3));
                    let pixel = frame.pixels()[point.v_px as usize * 5 + point.u_px as usize];
                    assert_eq!(turned.at(x as f64, y as f64), Some(pixel), "{travel} {x} {y}");
                    assert_eq!(travel.across_px(point), x as f64);
                }
            }
        }
    }

    #[test]
    fn a_plane_is_interpolated_exactly_and_ends_at_the_border() {
        let plane = IntensityFrame::new(4, 4, (0..16).map(|i| (i % 4 + 2 * (i / 4)) as f32).collect()).unwrap();
        let mut buffer = vec![];
        let turned = Turned::new(&plane, Travel::Up, &mut buffer);
        assert_eq!(turned.at(1.25, 2.5), Some(6.25));
        assert_eq!((turned.at(3.0, 3.0), turned.at(3.01, 0.0), turned.at(-0.01, 0.0)), (Some(9.0), None, None));
    }
}
