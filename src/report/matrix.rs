//! Methods × recordings: batches beside one another in one table, as a paper prints it.

use std::io::Write;
use std::path::{Path, PathBuf};

use maud::{DOCTYPE, Markup, html};

use super::atomic::{ResultsError, write_atomically};
use super::batch::{TABLE, read_names};
use super::errors::errors_against;
use super::head::{WITHOUT_SCRIPT, head};
use super::results::fixed;
use super::run::Run;
use super::verdict::{Trust, verdict};
use crate::eval::Errors;

/// The columns of each method.
const HEADS: [&str; 4] = ["mean", "max", "value on [%]", "badge"];

/// The table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Matrix {
    /// The batches' names.
    pub methods: Vec<String>,
    /// A row for each recording: its name and, for each method, the mean, the largest error, the share of frames with a value and the badge; empty where a batch has no results.
    pub rows: Vec<(String, Vec<[String; HEADS.len()]>)>,
}

/// What a row shows of a run.
struct Figures {
    errors: Option<Errors>,
    value_pct: f64,
    trust: Trust,
}

/// Whether `folder` holds a batch.
#[must_use]
pub fn is_batch(folder: &Path) -> bool {
    folder.join(TABLE).is_file()
}

/// Read the batches in `folders`. A run without a truth is held against that of another batch on the same recording.
///
/// # Errors
/// When a table or a run cannot be read.
pub fn read_matrix(folders: &[PathBuf]) -> Result<Matrix, ResultsError> {
    let mut recordings: Vec<String> = vec![];
    for folder in folders {
        recordings.extend(read_names(folder)?);
    }
    recordings.sort_by(|a, b| natord::compare(a, b));
    recordings.dedup();
    let mut all: Vec<Vec<Figures>> = folders.iter().map(|_| vec![]).collect();
    let mut rows = vec![];
    for recording in recordings {
        let runs = folders
            .iter()
            .map(|folder| folder.join(&recording))
            .map(|dir| dir.join("path.csv").is_file().then(|| Run::read_figures(&dir)).transpose())
            .collect::<Result<Vec<_>, _>>()?;
        let truth = runs.iter().flatten().find_map(|run| run.truth_px.clone());
        let mut cells = vec![];
        for (run, of_method) in runs.iter().zip(&mut all) {
            let figures = run.as_ref().map(|run| figures(run, truth.as_deref()));
            cells.push(figures.as_ref().map_or_else(Default::default, row_cells));
            of_method.extend(figures);
        }
        rows.push((recording, cells));
    }
    let last = all.iter().map(|figures| summed_up(figures)).collect();
    rows.push(("all: mean, worst, mean, good".to_owned(), last));
    Ok(Matrix { methods: names(folders), rows })
}

/// The last part of each folder's name, or the whole where two are alike.
fn names(folders: &[PathBuf]) -> Vec<String> {
    let short = |folder: &PathBuf| folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let all: Vec<_> = folders.iter().map(short).collect();
    let name = |(folder, short): (&PathBuf, &Option<String>)| match short {
        Some(short) if all.iter().filter(|other| other.as_ref() == Some(short)).count() == 1 => short.clone(),
        _ => folder.display().to_string(),
    };
    folders.iter().zip(&all).map(name).collect()
}

fn figures(run: &Run, truth_px: Option<&[Option<f64>]>) -> Figures {
    let lent = |truth: &[Option<f64>]| {
        (truth.len() == run.rows.len()).then(|| errors_against(&run.rows, truth, &run.ruler())).flatten()
    };
    let table = run.summary.errors.or_else(|| truth_px.and_then(lent));
    Figures {
        errors: table.and_then(|table| table.of(run.best_estimator()).copied()),
        value_pct: 100.0 - run.unavailable().percent(),
        trust: verdict(run).trust,
    }
}

fn row_cells(figures: &Figures) -> [String; HEADS.len()] {
    let length = |of: fn(&Errors) -> f64| {
        figures
            .errors
            .as_ref()
            .map_or_else(|| "–".to_owned(), |errors| format!("{} {}", fixed(of(errors), 3), errors.unit))
    };
    [
        length(|errors| errors.mae),
        length(|errors| errors.max),
        fixed(figures.value_pct, 1),
        figures.trust.word().to_owned(),
    ]
}

/// Mean of the means, worst of the maxima, mean availability, how many are good.
fn summed_up(figures: &[Figures]) -> [String; HEADS.len()] {
    // Pixels and millimetres have no common mean.
    let unit = figures.iter().find_map(|f| f.errors).map(|errors| errors.unit);
    let errors: Vec<Errors> = figures.iter().filter_map(|f| f.errors).collect();
    let errors = if errors.iter().all(|errors| Some(errors.unit) == unit) { errors } else { vec![] };
    let means: Vec<f64> = errors.iter().map(|errors| errors.mae).collect();
    let mean = |values: &[f64]| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
    let values: Vec<f64> = figures.iter().map(|f| f.value_pct).collect();
    let good = figures.iter().filter(|f| f.trust == Trust::Good).count();
    let number = |value: Option<f64>, decimals| value.map_or_else(|| "–".to_owned(), |value| fixed(value, decimals));
    let length = |value: Option<f64>| {
        value.zip(unit).map_or_else(|| "–".to_owned(), |(value, unit)| format!("{} {unit}", fixed(value, 3)))
    };
    [
        length(mean(&means)),
        length(errors.iter().map(|errors| errors.max).reduce(f64::max)),
        number(mean(&values), 1),
        format!("{good} of {}", figures.len()),
    ]
}

impl Matrix {
    /// The table with aligned columns.
    #[must_use]
    pub fn text(&self) -> String {
        let mut lines = vec![vec![String::new()], vec![String::new()]];
        for method in &self.methods {
            lines[0].extend([method.clone(), String::new(), String::new(), String::new()]);
            lines[1].extend(HEADS.map(str::to_owned));
        }
        for (name, cells) in &self.rows {
            lines.push(std::iter::once(name.clone()).chain(cells.iter().flatten().cloned()).collect());
        }
        let columns = lines[1].len();
        // A method's name stands over its columns and widens none of them.
        let width = |column: usize| lines[1..].iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let of_method = |first: usize| widths[first..first + HEADS.len()].iter().sum::<usize>() + 2 * (HEADS.len() - 1);
        let mut text = format!("{:w$}", "", w = widths[0]);
        for (k, method) in self.methods.iter().enumerate() {
            text += &format!("  {method:>w$}", w = of_method(1 + k * HEADS.len()));
        }
        text.push('\n');
        for line in &lines[1..] {
            text += &format!("{:w$}", line[0], w = widths[0]);
            for (cell, width) in line.iter().zip(&widths).skip(1) {
                text += &format!("  {cell:>width$}");
            }
            text.push('\n');
        }
        text
    }

    /// Write the table as a page.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_page(&self, path: &Path) -> Result<(), ResultsError> {
        let page = self.page().into_string();
        write_atomically(path, |file| file.write_all(page.as_bytes()))
    }

    fn page(&self) -> Markup {
        let heads: Vec<(&str, &str)> =
            self.methods.iter().flat_map(|method| HEADS.map(|head| (method.as_str(), head))).collect();
        html! {
            (DOCTYPE)
            html lang="en" {
                (head("comparison – seamtrack", WITHOUT_SCRIPT, &html! {}))
                body {
                    header.headline {
                        p.program { "seamtrack compare" }
                        h1 { (self.methods.len()) " methods on " (self.rows.len().saturating_sub(1)) " recordings" }
                        p.note {
                            "Mean and largest absolute error along the stripe of each method's best path (smoothed where it has one), "
                            "and the share of the frames with a value. The last row: mean of the means, worst of the maxima, mean "
                            "share, recordings with the badge good."
                        }
                    }
                    div.scroll { table {
                        thead {
                            tr { th {} @for method in &self.methods { th colspan=(HEADS.len()) scope="colgroup" { (method) } } }
                            tr { th {} @for (_, head) in &heads { th scope="col" { (head) } } }
                        }
                        tbody { @for (name, cells) in &self.rows { tr {
                            th scope="row" { (name) }
                            @for ((method, head), cell) in heads.iter().zip(cells.iter().flatten()) {
                                td data-head={ (method) ", " (head) } { (cell) }
                            }
                        } } }
                    } }
                }
            }
        }
    }
}
