//! A chessboard to print, with a ruler to check the print by.

use std::fmt::Write;

/// White around the board \[squares\]: the outer corners need it, and hands hold it there.
const MARGIN_SQUARES: f64 = 1.0;
/// Room for the ruler and its words under the board \[mm\].
const FOOT_MM: f64 = 24.0;
/// Most squares a side, and largest square \[mm\].
pub const MOST_SQUARES: usize = 61;
/// See above.
pub const LARGEST_SQUARE_MM: f64 = 500.0;

/// The board of `squares` columns and rows as an SVG drawing in true size.
///
/// # Errors
/// When the board is none.
pub fn board_svg([columns, rows]: [usize; 2], square_mm: f64) -> Result<String, String> {
    let sides = 4..=MOST_SQUARES;
    if !sides.contains(&columns) || !sides.contains(&rows) {
        return Err(format!("a board has 4 to {MOST_SQUARES} squares a side, not {columns}x{rows}"));
    }
    if !(square_mm.is_finite() && square_mm > 0.0 && square_mm <= LARGEST_SQUARE_MM) {
        return Err(format!("a square has a side above 0 and up to {LARGEST_SQUARE_MM} mm, not {square_mm}"));
    }
    let margin = MARGIN_SQUARES * square_mm;
    let (board_w, board_h) = (columns as f64 * square_mm, rows as f64 * square_mm);
    let (width, height) = (board_w + 2.0 * margin, board_h + 2.0 * margin + FOOT_MM);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">\n\
         <title>Chessboard of {columns} x {rows} squares of {square_mm} mm, {} x {} inner corners</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n<path fill=\"#000\" d=\"",
        columns - 1,
        rows - 1
    );
    for row in 0..rows {
        for column in (0..columns).filter(|column| (column + row) % 2 == 0) {
            let (x, y) = (margin + column as f64 * square_mm, margin + row as f64 * square_mm);
            let _ = write!(svg, "M{x} {y}h{square_mm}v{square_mm}h-{square_mm}z");
        }
    }
    svg += "\"/>\n";
    // The longest whole number of centimetres that fits.
    let length_mm = ((board_w / 10.0).floor() * 10.0).max(10.0);
    let base = board_h + 2.0 * margin + 2.0;
    let _ = writeln!(
        svg,
        "<g stroke=\"#000\" stroke-width=\"0.2\" fill=\"none\"><path d=\"M{margin} {base}h{length_mm}\"/><path d=\""
    );
    for mm in 0..=length_mm as usize {
        let tick = if mm % 10 == 0 {
            6.0
        } else if mm % 5 == 0 {
            4.0
        } else {
            2.5
        };
        let _ = write!(svg, "M{} {base}v{tick}", margin + mm as f64);
    }
    let _ = write!(
        svg,
        "\"/></g>\n<text x=\"{margin}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"4\">This ruler must measure {length_mm} mm: print at 100 %, not \
         fitted to the page. {columns} x {rows} squares of {square_mm} mm.</text>\n\
         <text x=\"{margin}\" y=\"{}\" font-family=\"sans-serif\" font-size=\"4\">Glue it to something flat. Measure a row of squares and give what one \
         measures: --square {square_mm}</text>\n</svg>\n",
        base + 12.0,
        base + 18.0
    );
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::board_svg;

    #[test]
    fn the_drawing_has_true_size_half_the_squares_and_a_ruler() {
        let svg = board_svg([7, 8], 30.0).unwrap();
        assert!(svg.contains("width=\"270mm\" height=\"324mm\""), "{}", &svg[..200]);
        assert_eq!(svg.matches("h30v30h-30z").count(), 28);
        assert!(svg.contains("must measure 210 mm") && svg.contains("6 x 7 inner corners"));
    }

    #[test]
    fn boards_that_cannot_be_printed_are_refused() {
        assert!(board_svg([2, 8], 30.0).is_err());
        assert!(board_svg([7, 8], 0.0).is_err());
        assert!(board_svg([7, 8], f64::NAN).is_err());
        assert!(board_svg([7, 800], 30.0).is_err());
    }
}
