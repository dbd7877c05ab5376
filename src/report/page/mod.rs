//! `report.html`: one file that holds its data, pictures, style and script, and opens without a network.
//!
//! The plots are drawn as SVG by a small script of our own (`chart.js`): they must share zoom and cursor with a frame
//! viewer and leave the page as SVG, which the small canvas libraries cannot do; the large ones that can weigh
//! 1 to 4 MB a page.

use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::atomic::{ResultsError, write_atomically};
use super::charts::{several, single};
use super::compare::mixed_scales;
use super::head::head;
use super::model::{PageModel, image};
use super::run::Run;
use super::summary::{Percentiles, Summary};
use super::table::{TableRow, error_rows, heads};
use super::thumbnails::Thumbnail;
use super::verdict::{Verdict, verdict};
use crate::eval::wrong_limit;
use crate::units::LengthUnit;

/// Default limit of a page's size \[bytes\].
pub const DEFAULT_MAX_BYTES: usize = 10_000_000;
/// Kept free for markup, style, script and the marks of stored frames \[bytes\].
const MARKUP_BYTES: usize = 120_000;

const CHART_STYLE: &str = include_str!("chart.css");
const SCRIPT: [&str; 6] = [
    include_str!("axis.js"),
    include_str!("chart.js"),
    include_str!("histogram.js"),
    include_str!("viewer.js"),
    include_str!("player.js"),
    include_str!("page.js"),
];
/// The page itself forbids any network access.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:";

/// Write the page of one run as `path`, of at most about `max_bytes`.
///
/// # Errors
/// When the file cannot be written.
pub fn write_report(path: &Path, run: &Run, max_bytes: usize) -> Result<(), ResultsError> {
    let summary = &run.summary;
    let verdict = verdict(run);
    let body = html! {
        (headline(&verdict, &summary.input.path))
        (plots(true))
        section.details {
            (figures(&error_rows(run), run.unit(), "Track again with "))
            (timing(summary))
            (configuration(summary))
        }
    };
    write_page(path, &format!("{} – seamtrack", summary.input.path), single(run), &run.thumbnails, &body, max_bytes)
}

/// Write the page that compares `runs` of one recording.
///
/// # Errors
/// When the file cannot be written.
pub fn write_comparison(path: &Path, runs: &[Run], rows: &[TableRow], max_bytes: usize) -> Result<(), ResultsError> {
    let Some(model) = several(runs) else { return Ok(()) };
    let body = html! {
        header.headline {
            p.program { "seamtrack compare" }
            h1 { (runs.len()) " runs on one recording" }
            @if let Some(doubt) = mixed_scales(runs) { ul.doubts { li { (doubt) } } }
            ul.facts { @for run in runs { (verdict_of(run)) } }
        }
        (plots(false))
        section.details { (figures(rows, runs.first().map_or(LengthUnit::Mm, Run::unit), "Give one of the runs ")) }
    };
    let thumbnails = runs.iter().map(|run| &run.thumbnails).find(|list| !list.is_empty());
    write_page(path, "comparison – seamtrack", model, thumbnails.map_or(&[], Vec::as_slice), &body, max_bytes)
}

/// A run's name, badge and sentence.
fn verdict_of(run: &Run) -> Markup {
    let verdict = verdict(run);
    html! { li class=(verdict.trust.word()) { b { (run.name) } " " span.light { (verdict.trust.word()) } (verdict.sentence) } }
}

pub(super) fn write_page(
    path: &Path,
    title: &str,
    mut model: PageModel,
    thumbnails: &[Thumbnail],
    body: &Markup,
    max_bytes: usize,
) -> Result<(), ResultsError> {
    let encode = |model: &PageModel| {
        let json = serde_json::to_string(model).map_err(|error| ResultsError::content(path, error))?;
        Ok::<_, ResultsError>(json.replace('<', "\\u003c"))
    };
    let room = max_bytes.saturating_sub(encode(&model)?.len() + MARKUP_BYTES);
    let stored = fitting(thumbnails, room).into_iter();
    let encoded = stored.map(|t| image(&model.viewer, t.frame, &t.marks, BASE64_STANDARD.encode(&t.jpeg)));
    model.viewer.images = encoded.collect();
    let json = encode(&model)?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(title, POLICY, &html! { style id="chart-style" { (PreEscaped(CHART_STYLE)) } }))
            body {
                (body)
                script type="application/json" id="model" { (PreEscaped(json)) }
                script { (PreEscaped("\"use strict\";")) @for part in SCRIPT { (PreEscaped(part)) } }
            }
        }
    };
    write_atomically(path, |file| file.write_all(page.into_string().as_bytes()))
}

/// As many frames as fit into `room` bytes of base64: the worst ones first, then every k-th with the smallest k.
fn fitting(thumbnails: &[Thumbnail], room: usize) -> Vec<&Thumbnail> {
    let size = |thumbnail: &Thumbnail| thumbnail.jpeg.len().div_ceil(3) * 4 + 900;
    let total = |chosen: &[&Thumbnail]| chosen.iter().map(|thumbnail| size(thumbnail)).sum::<usize>();
    let usable: Vec<&Thumbnail> = thumbnails.iter().filter(|thumbnail| !thumbnail.jpeg.is_empty()).collect();
    let mut every = 1;
    let mut chosen = usable.clone();
    while total(&chosen) > room && every <= 2 * usable.len() {
        every *= 2;
        let regular = usable.iter().filter(|t| !t.worst).step_by(every);
        chosen = usable.iter().filter(|t| t.worst).chain(regular).copied().collect();
    }
    while total(&chosen) > room {
        chosen.pop();
    }
    chosen.sort_by_key(|thumbnail| thumbnail.frame);
    chosen
}

fn headline(verdict: &Verdict, input: &str) -> Markup {
    html! {
        header class={ "headline " (verdict.trust.word()) } {
            p.program { "seamtrack · " (input) }
            h1 { span.light { (verdict.trust.word()) } " " (verdict.sentence) }
            @if !verdict.doubts.is_empty() { ul.doubts { @for doubt in &verdict.doubts { li { (doubt) } } } }
            ul.facts { @for fact in &verdict.facts { li { (fact) } } }
        }
    }
}

/// The places the script fills. A page without script says so.
pub(super) fn plots(single: bool) -> Markup {
    html! {
        noscript { p { "The plots need JavaScript; the figures below do not." } }
        main {
            section #charts aria-label="Plots over the frames" {
                div.hint {
                    span {
                        "Hover to see a frame, click to hold it (its address can be passed on), drag to zoom, double-click to "
                        "zoom out, ← → to step, space to play; a name in a plot's key hides its curve."
                    }
                    span #axes {}
                    button #zoom-out hidden type="button" {}
                }
            }
            aside {
                figure #viewer { figcaption {} }
                section #places {
                    h2 { @if single { "Places to look at" } @else { "Places to look at, run by run" } }
                    div.list {}
                }
            }
        }
    }
}

/// The papers' table; without a truth, `remedy` says who is to be given one.
fn figures(rows: &[TableRow], unit: LengthUnit, remedy: &str) -> Markup {
    html! {
        section.figures {
            h2 { "Errors along the stripe" }
            @if rows.is_empty() {
                p { "No truth was given, so errors are unknown. " (remedy) code { "seamtrack track --truth FILE" } "." }
            } @else {
                div.scroll {
                    table {
                        thead { tr { th {} @for head in heads(unit) { th scope="col" { (head) } } } }
                        tbody { @for row in rows {
                            tr {
                                th scope="row" { (row.name) }
                                @for (head, cell) in heads(unit).iter().zip(&row.cells) { td data-head=(head) { (cell) } }
                            }
                        } }
                    }
                }
                p.note {
                    "SD is that of the absolute error, as in the papers. RMSE: root of the mean square. P95: 95 % of the frames have a "
                    "smaller error. Bias: the mean error with its sign. In ±2σ: 95 % where σ is right. Wrong: a valid value "
                    "off by over " (wrong_limit(unit)) ". Unavailable: no value after the seam was first confirmed."
                }
            }
        }
    }
}

const LATENCY: [&str; 3] = ["median [ms]", "99 % [ms]", "max [ms]"];

fn timing(summary: &Summary) -> Markup {
    let row = |name: &str, p: Percentiles| {
        html! {
            tr {
                th scope="row" { (name) }
                @for (head, ms) in LATENCY.iter().zip([p.p50, p.p99, p.max]) { td data-head=(head) { (format!("{ms:.2}")) } }
            }
        }
    };
    html! {
        section.timing {
            h2 { "Latency" }
            table {
                thead { tr { th {} @for head in LATENCY { th scope="col" { (head) } } } }
                tbody {
                    (row("decode", summary.timing.decode_ms))
                    (row("track", summary.timing.track_ms))
                }
            }
            p.note { (format!("{:.1}", summary.timing.frames_per_second)) " frames a second by wall clock." }
        }
    }
}

fn configuration(summary: &Summary) -> Markup {
    let text = serde_json::to_string_pretty(&summary.config).unwrap_or_default();
    html! {
        section.configuration {
            h2 { "Configuration" }
            details { summary { "The effective configuration" } pre { (text) } }
            p.note { (summary.program) ", schema version " (summary.schema_version) "." }
        }
    }
}
