//! A small plot in plain text.

/// The dots of a Braille cell by column and row, as bits of the code point (Unicode 8-dot Braille).
const DOTS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// `values` over their index as `rows` lines of `columns` Braille cells (2 × 4 dots each), the ordinate's limits in
/// `unit` at the left. Absent values leave a gap. Empty when there is no value.
#[must_use]
pub fn text_plot(values: &[Option<f64>], columns: usize, rows: usize, unit: &str) -> Vec<String> {
    let known = || values.iter().flatten().copied();
    let (low, high) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    if low > high || columns == 0 || rows == 0 {
        return Vec::new();
    }
    let span = if high > low { high - low } else { 1.0 };
    let mut cells = vec![vec![0_u32; columns]; rows];
    for (index, value) in values.iter().enumerate() {
        let Some(value) = value else { continue };
        let x = index * columns * 2 / values.len();
        let y = ((high - value) / span * (rows * 4 - 1) as f64).round() as usize;
        cells[y / 4][x / 2] |= DOTS[x % 2][y % 4];
    }
    let labels = [format!("{high:.2} {unit}"), format!("{low:.2} {unit}")];
    let width = labels.iter().map(String::len).max().unwrap_or(0);
    let line = |(row, cells): (usize, Vec<u32>)| {
        let label = if row == 0 {
            &labels[0]
        } else if row + 1 == rows {
            &labels[1]
        } else {
            ""
        };
        let dots: String = cells.into_iter().filter_map(|dots| char::from_u32(0x2800 + dots)).collect();
        format!("{label:>width$} ┤{}", dots.trim_end_matches('\u{2800}'))
    };
    cells.into_iter().enumerate().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rising_line_runs_from_the_lower_left_to_the_upper_right() {
        let values: Vec<_> = (0..8).map(|i| Some(f64::from(i))).collect();
        assert_eq!(text_plot(&values, 4, 2, "mm"), ["7.00 mm ┤⠀⠀⡠⠊", "0.00 mm ┤⡠⠊"]);
    }

    #[test]
    fn no_value_makes_no_plot() {
        assert!(text_plot(&[None, None], 10, 4, "mm").is_empty());
    }
}
