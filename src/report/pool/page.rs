//! `report.html` of a melt pool: the page of a seam with the melt pool's plots.

use std::path::Path;

use maud::html;

use super::results::{PoolRow, read_pool_csv};
use super::summary::{PoolErrors, PoolSummary, read_pool_summary};
use super::truth::truth_beside;
use super::verdict::pool_verdict;
use crate::eval::Errors;
use crate::report::atomic::ResultsError;
use crate::report::model::{
    Chart, PageModel, PlaceToLookAt, Ribbon, Rounded, Series, Viewer, chart, curve, diagnostic,
};
use crate::report::page::{DEFAULT_MAX_BYTES, plots, write_page};
use crate::report::places::{self, places};
use crate::report::results::PathRow;
use crate::report::summary::Limits;
use crate::report::thumbnails::read_thumbnails;
use crate::units::LengthUnit;

const MM_DECIMALS: i32 = 5;
/// 95 % of a χ² variable with two degrees of freedom: position and displacement.
const NIS_95: f64 = 5.99;
const NIS_NOTE: &str =
    "How far position and displacement lie from their prediction, in σ, squared: 2 on average where σ is right.";

/// Writes `report.html` into a melt pool's results directory, from the files in it.
///
/// # Errors
/// When a file cannot be read or written.
pub fn write_pool_report(dir: &Path) -> Result<(), ResultsError> {
    let summary = read_pool_summary(&dir.join("summary.json"))?;
    let rows = read_pool_csv(&dir.join("path.csv"))?;
    let thumbnails = read_thumbnails(dir)?;
    let measure = summary.config.get("measure").and_then(|value| value.as_str()).unwrap_or("tip").to_owned();
    let verdict = pool_verdict(&summary, &rows);
    let truth_px = truth_beside(dir, &summary, rows.len())?;
    let title = format!("{} – seamtrack", summary.input.path);
    let body = html! {
        header class={ "headline " (verdict.trust.word()) } {
            p.program { "seamtrack meltpool · " (summary.input.path) }
            h1 { span.light { (verdict.trust.word()) } " " (verdict.sentence) }
            @if !verdict.doubts.is_empty() { ul.doubts { @for doubt in &verdict.doubts { li { (doubt) } } } }
            ul.facts { @for fact in facts(&summary) { li { (fact) } } }
        }
        (plots(true))
        section.details {
            @if let Some(errors) = &summary.errors { (figures(errors)) }
            section.configuration {
                h2 { "Configuration" }
                details {
                    summary { "The effective configuration" }
                    pre { (serde_json::to_string_pretty(&summary.config).unwrap_or_default()) }
                }
                p.note { (summary.program) ", schema version " (summary.schema_version) "." }
            }
        }
    };
    write_page(
        &dir.join("report.html"),
        &title,
        model(&summary, &rows, &measure, truth_px.as_deref()),
        &thumbnails,
        &body,
        DEFAULT_MAX_BYTES,
    )
}

fn facts(summary: &PoolSummary) -> Vec<String> {
    let calibration = summary.calibration;
    let mut facts = vec![
        format!("{:.6} mm/px, zero at {} px", calibration.mm_per_px.get(), calibration.zero_px),
        format!("{:.0} frames a second by wall clock", summary.timing.frames_per_second),
    ];
    facts.extend(summary.refused.iter().map(|(reason, frames)| format!("not taken, {reason}: {frames} frames")));
    facts
}

fn model(summary: &PoolSummary, rows: &[PoolRow], measure: &str, truth_px: Option<&[Option<f64>]>) -> PageModel {
    let calibration = summary.calibration;
    let column = |of: &dyn Fn(&PoolRow) -> Option<f64>| -> Vec<Option<f64>> { rows.iter().map(of).collect() };
    let mm = |px: f64| calibration.mm_per_px.get() * (px - calibration.zero_px);
    let band = |of: &dyn Fn(&PoolRow) -> Option<f64>| {
        Some(Rounded::new(column(&|row| of(row).map(|sigma| 2.0 * sigma)), MM_DECIMALS))
    };
    let measured = column(&|row| row.measured_px.map(mm));
    let mut path = vec![
        Series { dots: true, fits: false, ..curve("measured", "kcf", measured, MM_DECIMALS) },
        Series {
            band: band(&|row| row.filtered_std_mm),
            ..curve("filtered", "filtered", column(&|row| row.filtered_mm), MM_DECIMALS)
        },
        curve("smoothed", "smoothed", column(&|row| row.smooth_mm), MM_DECIMALS),
    ];
    let truth = truth_px.map(|truth| truth.iter().map(|px| px.map(mm)).collect());
    path.extend(truth.map(|truth| curve("truth", "truth", truth, MM_DECIMALS)));
    path.retain(Series::has_values);
    let (title, note) = match measure {
        "width" => ("Width", "The longest cut through the pool across the travel. Band: ±2σ."),
        _ => ("Offset of the seam", "How far the pool's tip lies beside the zero, across the travel. Band: ±2σ."),
    };
    let charts = vec![
        Chart { series: path, note: note.to_owned(), ..chart("path", title, "mm", 4) },
        Chart {
            log: true,
            series: vec![Series { dots: true, ..curve("NIS", "filtered", column(&|row| row.nis), 3) }],
            limits: vec![(NIS_95, format!("95 % below {NIS_95}"))],
            ..diagnostic("nis", "Normalised innovation squared", "NIS", 2, NIS_NOTE)
        },
    ];
    let letters = rows.iter().filter_map(|row| row.status.name().chars().next()).collect();
    let as_path =
        |row: &PoolRow| PathRow { nis: row.nis, ..PathRow::empty(row.frame, String::new(), row.time_s, row.status) };
    let path_rows: Vec<PathRow> = rows.iter().map(as_path).collect();
    let found = places(&path_rows, (&[], LengthUnit::Mm), &[], &Limits::default());
    PageModel {
        frames: rows.len(),
        time_s: Rounded::new(rows.iter().map(|row| Some(row.time_s)).collect(), 6),
        file: rows.iter().map(|row| row.file.clone()).collect(),
        ribbons: vec![Ribbon { name: measure.to_owned(), status: letters }],
        charts,
        viewer: Viewer {
            width: summary.input.width_px,
            height: summary.input.height_px,
            axis: "horizontal".into(),
            points: vec![],
            images: vec![],
        },
        travel_mm: None,
        more_places: found.len().saturating_sub(places::MOST),
        places: found.into_iter().take(places::MOST).map(PlaceToLookAt::of).collect(),
    }
}

const HEADS: [&str; 4] = ["mean abs. [mm]", "max [mm]", "SD [mm]", "bias [mm]"];

fn figures(errors: &PoolErrors) -> maud::Markup {
    let lines = [("measured", errors.measured), ("filtered", errors.filtered), ("smoothed", errors.smoothed)];
    let cells = |e: &Errors| [e.mae, e.max, e.std, e.bias].map(|mm| format!("{mm:.4}"));
    html! {
        section.figures {
            h2 { "Errors" }
            div.scroll {
                table {
                    thead { tr {
                        th {} @for head in HEADS { th scope="col" { (head) } }
                    } }
                    tbody { @for (name, errors) in lines { @if let Some(errors) = errors {
                        tr {
                            th scope="row" { (name) }
                            @for (head, cell) in HEADS.iter().zip(cells(&errors)) { td data-head=(head) { (cell) } }
                        }
                    } } }
                }
            }
        }
    }
}
