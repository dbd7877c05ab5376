//! A table of figures, the paper's beside ours.

use std::fmt;

/// One line of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Whose figures they are.
    pub label: String,
    /// The figures, one a column; none where there is none.
    pub values: Vec<Option<f64>>,
}

/// A table with its noise model.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What was done.
    pub title: String,
    /// How the series came about.
    pub noise: String,
    /// Names of the columns, with units.
    pub columns: Vec<&'static str>,
    /// The lines.
    pub rows: Vec<Row>,
}

impl Row {
    /// A line with every figure.
    #[must_use]
    pub fn new(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        Self { label: label.into(), values: values.into_iter().map(Some).collect() }
    }

    /// A line of the paper, which may leave figures out.
    #[must_use]
    pub fn of_paper(label: impl Into<String>, values: impl IntoIterator<Item = Option<f64>>) -> Self {
        Self { label: format!("paper: {}", label.into()), values: values.into_iter().collect() }
    }
}

impl Table {
    /// The figure in the line that `label` begins, in column `column`.
    #[must_use]
    pub fn value(&self, label: &str, column: &str) -> Option<f64> {
        let row = self.rows.iter().find(|row| row.label.starts_with(label))?;
        let index = self.columns.iter().position(|name| *name == column)?;
        row.values.get(index).copied().flatten()
    }
}

/// Five significant digits.
fn figure(value: f64) -> String {
    let magnitude = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    if !(-4.0..=5.0).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 8")]
    let decimals = (4.0 - magnitude).max(0.0) as usize;
    format!("{value:.decimals$}")
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        writeln!(f, "  {}", self.noise)?;
        let label_width = self.rows.iter().map(|row| row.label.chars().count()).max().unwrap_or(0);
        write!(f, "  {:label_width$}", "")?;
        for column in &self.columns {
            write!(f, "  {column:>11}")?;
        }
        writeln!(f)?;
        for row in &self.rows {
            write!(f, "  {:label_width$}", row.label)?;
            for (value, column) in row.values.iter().zip(&self.columns) {
                let width = column.chars().count().max(11);
                let text = value.map_or_else(|| "-".to_owned(), figure);
                write!(f, "  {text:>width$}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_five_significant_digits() {
        assert_eq!(
            [0.0338, 2.5, 123.45, 1.0e-7, 0.0].map(figure),
            ["0.033800", "2.5000", "123.45", "1.0000e-7", "0.0000"]
        );
    }
}
