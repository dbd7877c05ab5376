//! Light on the sensor before it is quantised, in the stripe's frame: columns run along the stripe.

/// Light in grey values, not limited above.
#[derive(Debug, Clone)]
pub(super) struct Canvas {
    width_px: usize,
    height_px: usize,
    light: Vec<f32>,
}

impl Canvas {
    /// A canvas of one grey value.
    pub(super) fn filled(width_px: usize, height_px: usize, grey: f32) -> Self {
        Self { width_px, height_px, light: vec![grey; width_px * height_px] }
    }

    /// Extent along the stripe.
    pub(super) const fn width_px(&self) -> usize {
        self.width_px
    }

    /// Extent across the stripe.
    pub(super) const fn height_px(&self) -> usize {
        self.height_px
    }

    /// All values, row by row.
    pub(super) fn light(&self) -> &[f32] {
        &self.light
    }

    /// Applies `change(column, row, value)` to every pixel.
    pub(super) fn change(&mut self, change: impl Fn(usize, usize, &mut f32)) {
        for (row, line) in self.light.chunks_exact_mut(self.width_px).enumerate() {
            for (column, value) in line.iter_mut().enumerate() {
                change(column, row, value);
            }
        }
    }

    /// Applies `change(column, row, value)` to the pixels within `reach_px` of a point.
    pub(super) fn change_around(
        &mut self,
        column: f64,
        row: f64,
        reach_px: f64,
        change: impl Fn(usize, usize, &mut f32),
    ) {
        let span = |middle: f64, size: usize| {
            (middle - reach_px).clamp(0.0, size as f64) as usize
                ..(middle + reach_px + 1.0).clamp(0.0, size as f64) as usize
        };
        let columns = span(column, self.width_px);
        for row in span(row, self.height_px) {
            let line = &mut self.light[row * self.width_px..(row + 1) * self.width_px];
            for (value, column) in line[columns.clone()].iter_mut().zip(columns.clone()) {
                change(column, row, value);
            }
        }
    }

    /// Adds light to one pixel; outside the canvas nothing happens.
    pub(super) fn add(&mut self, column: i64, row: i64, grey: f32) {
        if (0..self.width_px as i64).contains(&column) && (0..self.height_px as i64).contains(&row) {
            self.light[row as usize * self.width_px + column as usize] += grey;
        }
    }

    /// Moves one pixel towards a grey value by a share; outside the canvas nothing happens.
    pub(super) fn mix(&mut self, column: usize, row: usize, grey: f32, share: f32) {
        if column < self.width_px && row < self.height_px {
            let light = &mut self.light[row * self.width_px + column];
            *light += share * (grey - *light);
        }
    }

    /// Blurs the canvas by a Gaussian of standard deviation `sigma_px`; the border is continued outwards.
    pub(super) fn blur(&mut self, sigma_px: f32) {
        let radius = (3.0 * sigma_px).ceil() as usize;
        let weights: Vec<f32> =
            (0..=2 * radius).map(|i| (-0.5 * ((i as f32 - radius as f32) / sigma_px).powi(2)).exp()).collect();
        let total: f32 = weights.iter().sum();
        let (width, height) = (self.width_px, self.height_px);
        let mut rows = vec![0.0; self.light.len()];
        let mut line = vec![0.0; width + 2 * radius];
        for (source, target) in self.light.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
            line[..radius].fill(source[0]);
            line[radius..radius + width].copy_from_slice(source);
            line[radius + width..].fill(source[width - 1]);
            for (column, value) in target.iter_mut().enumerate() {
                let window = &line[column..=column + 2 * radius];
                *value = window.iter().zip(&weights).map(|(light, weight)| light * weight).sum::<f32>() / total;
            }
        }
        for (row, target) in self.light.chunks_exact_mut(width).enumerate() {
            target.fill(0.0);
            for (i, weight) in weights.iter().enumerate() {
                let from = (row + i).saturating_sub(radius).min(height - 1);
                let source = &rows[from * width..(from + 1) * width];
                target.iter_mut().zip(source).for_each(|(value, light)| *value += weight / total * light);
            }
        }
    }

    /// Applies `change(field, value)` to every pixel, the field computed on a grid of `cell_px` and interpolated
    /// bilinearly: for fields that are smooth over many pixels.
    pub(super) fn change_by_field(
        &mut self,
        cell_px: usize,
        field: impl Fn(f64, f64) -> f32,
        change: impl Fn(f32, &mut f32),
    ) {
        let columns = self.width_px / cell_px + 2;
        let rows = self.height_px / cell_px + 2;
        let grid: Vec<f32> = (0..rows)
            .flat_map(|j| (0..columns).map(move |i| ((i * cell_px) as f64, (j * cell_px) as f64)))
            .map(|(x, y)| field(x, y))
            .collect();
        let cell = cell_px as f32;
        let mut line = vec![0.0_f32; columns];
        for (row, pixels) in self.light.chunks_exact_mut(self.width_px).enumerate() {
            let (j, fraction) = (row / cell_px, (row % cell_px) as f32 / cell);
            for (i, value) in line.iter_mut().enumerate() {
                let (above, below) = (grid[j * columns + i], grid[(j + 1) * columns + i]);
                *value = above + (below - above) * fraction;
            }
            for (i, cells) in pixels.chunks_mut(cell_px).enumerate() {
                let (left, slope) = (line[i], (line[i + 1] - line[i]) / cell);
                for (k, value) in cells.iter_mut().enumerate() {
                    change(left + slope * k as f32, value);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_field_is_interpolated_exactly() {
        let mut canvas = Canvas::filled(37, 21, 0.0);
        canvas.change_by_field(8, |x, y| (x + 2.0 * y) as f32, |field, value| *value = field);
        for (i, &value) in canvas.light().iter().enumerate() {
            assert!((value - ((i % 37) + 2 * (i / 37)) as f32).abs() < 1e-3);
        }
    }
}
