//! Many recordings at a glance: `batch.csv`, one line a recording, and `index.html`, one click to each.

use std::io::Write;
use std::path::Path;

use maud::{DOCTYPE, Markup, html};

use super::atomic::{ResultsError, Together};
use super::head::{WITHOUT_SCRIPT, head};
use super::results::{Estimator, fixed};
use super::run::Run;
use super::summary::FrameCounts;
use super::verdict::{Trust, verdict};
use crate::eval::Errors;
use crate::units::LengthUnit;

/// Name of the page in the batch's folder.
pub const PAGE: &str = "index.html";
/// Name of the table beside it.
pub const TABLE: &str = "batch.csv";

/// The columns of [`TABLE`]; later versions add at the end only.
const COLUMNS: [&str; 20] = [
    "name",
    "input",
    "badge",
    "frames",
    "tracked",
    "coasting",
    "lost",
    "seeking",
    "unreadable",
    "value_pct",
    "joint",
    "unit",
    "mae",
    "max",
    "smooth_mae",
    "smooth_max",
    "wrong_frames",
    "tolerance_inside_pct",
    "report",
    "message",
];

const STYLE: &str = include_str!("batch.css");
/// Size of a small path \[px\], and most of its points.
const SPARK: (f64, f64) = (220.0, 40.0);
const SPARK_POINTS: usize = 220;

/// One recording of a batch.
#[derive(Debug, Clone)]
pub struct Entry {
    /// What it is called: the name of its folder of results.
    pub name: String,
    /// The recording as the user gave it.
    pub input: String,
    /// Its results, or why there are none, in a line.
    pub outcome: Result<Figures, String>,
}

/// What an index shows of a run.
#[derive(Debug, Clone)]
pub struct Figures {
    /// Whether to trust it.
    pub trust: Trust,
    sentence: String,
    doubt: Option<String>,
    counts: FrameCounts,
    value_pct: f64,
    joint: String,
    filtered: Option<Errors>,
    smoothed: Option<Errors>,
    inside_pct: Option<f64>,
    path: Vec<Option<f64>>,
    unit: LengthUnit,
}

impl Figures {
    /// The figures of a run.
    #[must_use]
    pub fn of(run: &Run) -> Self {
        let verdict = verdict(run);
        let errors = |estimator| run.summary.errors.as_ref().and_then(|errors| errors.of(estimator)).copied();
        Self {
            trust: verdict.trust,
            sentence: verdict.sentence,
            doubt: verdict.doubts.into_iter().next(),
            counts: run.summary.frames,
            value_pct: 100.0 - run.unavailable().percent(),
            joint: run.summary.joint.kind.clone(),
            filtered: errors(Estimator::Filtered),
            smoothed: errors(Estimator::Smoothed),
            inside_pct: run.tolerance().map(|tolerance| tolerance.inside_pct),
            path: run.position(run.best_estimator(), &run.ruler()),
            unit: run.unit(),
        }
    }

    /// The verdict in a line: badge, sentence, first doubt.
    #[must_use]
    pub fn line(&self) -> String {
        let doubt = self.doubt.as_ref().map_or_else(String::new, |doubt| format!(" {doubt}"));
        format!("{} {}{doubt}", self.trust.word().to_uppercase(), self.sentence)
    }
}

impl Entry {
    fn badge(&self) -> &'static str {
        self.outcome.as_ref().map_or("none", |figures| figures.trust.word())
    }

    /// No results first, then bad, to be checked, good; then by name in natural order.
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        let grave = |entry: &Self| entry.outcome.as_ref().map_or(u8::MAX, |figures| figures.trust as u8);
        grave(other).cmp(&grave(self)).then_with(|| natord::compare(&self.name, &other.name))
    }

    fn cells(&self) -> Vec<String> {
        let mut cells = vec![self.name.clone(), self.input.clone(), self.badge().to_owned()];
        match &self.outcome {
            Err(reason) => {
                cells.resize(COLUMNS.len() - 1, String::new());
                cells.push(reason.clone());
            }
            Ok(figures) => {
                let c = &figures.counts;
                let counts = [c.total, c.tracked, c.coasting, c.lost, c.seeking, c.unreadable];
                cells.extend(counts.map(|count| count.to_string()));
                cells.push(fixed(figures.value_pct, 1));
                cells.push(figures.joint.clone());
                cells.push(figures.unit.to_string());
                for errors in [&figures.filtered, &figures.smoothed] {
                    let length = |of: fn(&Errors) -> f64| errors.as_ref().map_or_else(String::new, |e| fixed(of(e), 4));
                    cells.extend([length(|e| e.mae), length(|e| e.max)]);
                }
                cells.push(figures.filtered.map_or_else(String::new, |errors| errors.wrong_frames.to_string()));
                cells.push(figures.inside_pct.map_or_else(String::new, |percent| fixed(percent, 1)));
                cells.push(format!("{}/report.html", self.name));
                cells.push(figures.line());
            }
        }
        cells
    }
}

/// Whether what stands in `folder` under the names of a batch's files is of this program, or nothing.
///
/// # Errors
/// [`ResultsError::Content`] naming the first file that is not.
pub fn check(folder: &Path) -> Result<(), ResultsError> {
    let starts = |name: &str, is_ours: &dyn Fn(&str) -> bool| {
        let path = folder.join(name);
        let stands = path.symlink_metadata().is_ok();
        if stands && !std::fs::read_to_string(&path).is_ok_and(|text| is_ours(&text)) {
            return Err(ResultsError::content(
                &path,
                "is not of an earlier run: move it away, or choose another folder with -o",
            ));
        }
        Ok(())
    };
    starts(PAGE, &|text| text.contains("seamtrack</title>"))?;
    starts(TABLE, &|text| text.starts_with("name,input,badge,"))
}

/// Write [`PAGE`] and [`TABLE`] into `folder`, the gravest recording first.
///
/// # Errors
/// When a file cannot be written.
pub fn write_batch(folder: &Path, mut entries: Vec<Entry>) -> Result<(), ResultsError> {
    entries.sort_by(Entry::order);
    let mut files = Together::default();
    files.add(&folder.join(TABLE), |file| {
        let mut csv = csv::Writer::from_writer(file);
        csv.write_record(COLUMNS)?;
        for entry in &entries {
            csv.write_record(entry.cells())?;
        }
        csv.flush()
    })?;
    let page = page(&entries).into_string();
    files.add(&folder.join(PAGE), |file| file.write_all(page.as_bytes()))?;
    files.finish()
}

/// The names of the recordings in a batch's table that have results.
///
/// # Errors
/// When the table cannot be read.
pub fn read_names(folder: &Path) -> Result<Vec<String>, ResultsError> {
    let path = folder.join(TABLE);
    let content = |error: csv::Error| ResultsError::content(&path, error);
    let mut names = vec![];
    for record in csv::Reader::from_path(&path).map_err(content)?.records() {
        let record = record.map_err(content)?;
        if let (Some(name), Some(badge)) = (record.get(0), record.get(2))
            && badge != "none"
        {
            names.push(name.to_owned());
        }
    }
    names.sort_by(|a, b| natord::compare(a, b));
    Ok(names)
}

fn page(entries: &[Entry]) -> Markup {
    let count = |badge: &str| entries.iter().filter(|entry| entry.badge() == badge).count();
    let counts = ["good", "check", "bad", "none"].map(|badge| (badge, count(badge)));
    let said = |(badge, count): &(&str, usize)| match *badge {
        "check" => format!("{count} to check"),
        "none" => format!("{count} without results"),
        _ => format!("{count} {badge}"),
    };
    let said: Vec<String> = counts.iter().filter(|(_, count)| *count > 0).map(said).collect();
    let title = format!("{} recordings – seamtrack", entries.len());
    html! {
        (DOCTYPE)
        html lang="en" {
            (head(&title, WITHOUT_SCRIPT, &html! { style { (maud::PreEscaped(STYLE)) } }))
            body {
                header.headline {
                    p.program { "seamtrack track" }
                    h1 { (entries.len()) " recordings: " (said.join(", ")) }
                    p.note {
                        "Good: nothing speaks against the path. Check: look at the reason. Bad: do not use it as it is. The gravest "
                        "come first; the small plot is the path along the stripe, its height is the path's own range. "
                        a href=(TABLE) { "batch.csv" } " has the figures."
                    }
                }
                main.batch { @for entry in entries { (row(entry)) } }
            }
        }
    }
}

fn row(entry: &Entry) -> Markup {
    let badge = entry.badge();
    let word = if badge == "none" { "no results" } else { badge };
    html! {
        @match &entry.outcome {
            Err(reason) => div.recording.bad {
                span.light { (word) }
                div.what { h2 { (entry.name) } p.note { (entry.input) } p { (reason) } }
            },
            Ok(figures) => a class={ "recording " (badge) } href={ (address(&entry.name)) "/report.html" } {
                span.light { (word) }
                div.what {
                    h2 { (entry.name) }
                    p.note { (entry.input) " · " (figures.joint) }
                    p { (figures.sentence) @if let Some(doubt) = &figures.doubt { " " b { (doubt) } } }
                }
                (spark(&figures.path, figures.unit))
                dl {
                    div { dt { "value on" } dd { (fixed(figures.value_pct, 1)) " %" } }
                    @if let Some(errors) = figures.smoothed.or(figures.filtered) {
                        div { dt { "error, mean / max" } dd { (fixed(errors.mae, 3)) " / " (fixed(errors.max, 3)) " " (errors.unit) } }
                    }
                    @if let Some(percent) = figures.inside_pct {
                        div { dt { "in tolerance" } dd { (fixed(percent, 1)) " %" } }
                    }
                }
            },
        }
    }
}

/// The path as a small line over its own range; what has no value is a gap.
fn spark(values: &[Option<f64>], unit: LengthUnit) -> Markup {
    let known = || values.iter().flatten().copied();
    let (low, high) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    let (width, height) = SPARK;
    let step = values.len().div_ceil(SPARK_POINTS).max(1);
    let across = width / (values.len().max(2) - 1) as f64;
    let mut d = String::new();
    let mut drawing = false;
    for (frame, value) in values.iter().enumerate().step_by(step) {
        let Some(value) = value else {
            drawing = false;
            continue;
        };
        let share = if high > low { (high - value) / (high - low) } else { 0.5 };
        d += &format!(
            "{}{:.1},{:.1}",
            if drawing { 'L' } else { 'M' },
            across * frame as f64,
            2.0 + share * (height - 4.0)
        );
        drawing = true;
    }
    let range = if high > low { format!("{:.2} {unit}", high - low) } else { String::new() };
    html! {
        figure {
            svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-label="Path" { path d=(d) {} }
            figcaption { (range) }
        }
    }
}

/// A name as part of an address.
fn address(name: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    name.bytes()
        .map(|byte| if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_keeps_a_name_whole() {
        assert_eq!(address("a b#1?ü%"), "a%20b%231%3F%C3%BC%25");
    }
}
