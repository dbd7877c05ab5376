//! The summary a run prints: it stands on its own without the page.

use std::fmt::Write;

use super::results::Status;
use super::run::Run;
use super::table::{TableRow, error_rows, heads};
use super::textplot::text_plot;
use super::verdict::{Trust, verdict};
use crate::units::LengthUnit;

const PLOT_COLUMNS: usize = 64;
const PLOT_ROWS: usize = 7;

/// Whether the terminal understands colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// ANSI colours.
    Ansi,
    /// Plain text.
    Plain,
}

impl Colour {
    /// ANSI colours on a terminal, unless `NO_COLOR` is set (<https://no-color.org>).
    #[must_use]
    pub fn for_stdout() -> Self {
        let wanted = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        if wanted && std::io::IsTerminal::is_terminal(&std::io::stdout()) { Self::Ansi } else { Self::Plain }
    }

    fn paint(self, code: &str, text: &str) -> String {
        match self {
            Self::Ansi => format!("\x1b[{code}m{text}\x1b[0m"),
            Self::Plain => text.to_owned(),
        }
    }
}

/// Verdict, status line, plot of the path, the papers' table and the latency, as text that ends with a newline.
#[must_use]
pub fn terminal_summary(run: &Run, colour: Colour) -> String {
    let verdict = verdict(run);
    let code = match verdict.trust {
        Trust::Good => "1;32",
        Trust::Check => "1;33",
        Trust::Bad => "1;31",
    };
    let mut text = format!("{} {}\n", colour.paint(code, &verdict.trust.word().to_uppercase()), verdict.sentence);
    for doubt in &verdict.doubts {
        text += &format!("  {}\n", colour.paint(code, doubt));
    }
    for fact in &verdict.facts {
        text += &format!("  {fact}\n");
    }
    let estimator = run.best_estimator();
    let plot = text_plot(&run.position(estimator, &run.ruler()), PLOT_COLUMNS, PLOT_ROWS, run.unit().name());
    if !plot.is_empty() {
        let indent = plot[0].chars().position(|c| c == '┤').unwrap_or(0);
        let last = run.rows.len().saturating_sub(1);
        let _ = write!(text, "\n  {} path, frames 0 to {last}\n", estimator.name());
        for line in &plot {
            text += &format!("  {line}\n");
        }
        text += &format!("  {:indent$} └{}\n", "", status_line(run));
        text += &format!("  {:indent$}  . tracked  ~ coasting  X lost  s seeking  ! unreadable\n", "");
    }
    let rows = error_rows(run);
    if !rows.is_empty() {
        text += &format!("\n{}", text_table(&rows, run.unit()));
    }
    let timing = &run.summary.timing;
    let _ = write!(
        text,
        "\n  track {:.1} ms median, {:.1} ms 99 %, {:.1} ms max; {:.1} frames/s\n",
        timing.track_ms.p50, timing.track_ms.p99, timing.track_ms.max, timing.frames_per_second
    );
    text
}

/// One letter a column of the plot: the most alarming status of its frames.
fn status_line(run: &Run) -> String {
    let columns = PLOT_COLUMNS.min(run.rows.len());
    let alarm = |column: usize| {
        let from = column * run.rows.len() / columns;
        let to = (column + 1) * run.rows.len() / columns;
        run.rows[from..to].iter().map(|row| severity(row.status)).max()
    };
    // Fewer frames than columns: the plot spreads them, so the letters do too.
    let spread = |column: usize| if columns == 0 { None } else { alarm(column * columns / PLOT_COLUMNS) };
    (0..PLOT_COLUMNS).filter_map(spread).map(|(_, letter)| letter).collect()
}

const fn severity(status: Status) -> (u8, char) {
    match status {
        Status::Tracked => (0, '.'),
        Status::Seeking => (1, 's'),
        Status::Coasting => (2, '~'),
        Status::Unreadable => (3, '!'),
        Status::Lost => (4, 'X'),
    }
}

/// The papers' table with aligned columns.
#[must_use]
pub fn text_table(rows: &[TableRow], unit: LengthUnit) -> String {
    let heads = heads(unit);
    let name_width = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row.cells[column].chars().count());
        cells.chain([heads[column].chars().count()]).max().unwrap_or(0)
    };
    let line = |name: &str, cells: &[String]| {
        let cells: String =
            cells.iter().enumerate().map(|(column, cell)| format!("  {cell:>width$}", width = width(column))).collect();
        format!("  {name:<name_width$}{cells}\n")
    };
    std::iter::once(line("", &heads)).chain(rows.iter().map(|row| line(&row.name, &row.cells))).collect()
}
