//! From runs to what their pages draw.

use super::facts::NIS_95;
use super::measures::{Measure, measures};
use super::model::{
    Chart, PageModel, PlaceToLookAt, Points, Ribbon, Rounded, Series, Viewer, chart, curve, diagnostic,
};
use super::places::{self, places};
use super::results::{Estimator, PathRow};
use super::run::Run;
use super::tolerance::Reference;
use crate::calib::Ruler;
use crate::units::StripeAxis;

/// Places of each of several runs that are listed at least. Chosen.
const PLACES_EACH: usize = 3;
const PSR_NOTE: &str = "How far the correlation filter's peak stands out of its surroundings: high where the picture looks as the \
                        template does, low where it is covered, glaring, or changed.";
const NIS_NOTE: &str =
    "How far a measurement lies from its prediction, in σ, squared: 1 on average where σ is right; 9 is a jump of 3 σ.";
const MM_DECIMALS: i32 = 4;

/// The page of one run.
pub(super) fn single(run: &Run) -> PageModel {
    let limits = run.summary.limits;
    let mut charts = vec![path_chart(run)];
    // Gap and hi-lo stand before the error, the sizes of a groove behind it.
    let (fit_up, groove): (Vec<Measure>, Vec<Measure>) = measures(&run.rows).into_iter().partition(Measure::is_fit_up);
    charts.extend(fit_up.iter().map(measure_chart));
    charts.extend(error_chart(run));
    charts.extend(groove.iter().map(measure_chart));
    charts.push(Chart {
        series: vec![curve("PSR", "kcf", column(run, |row| row.psr), 2)],
        limits: limits.psr.into_iter().map(|psr| (psr, format!("template learns above {psr}"))).collect(),
        ..diagnostic("psr", "Peak-to-sidelobe ratio of the KCF", "PSR", 1, PSR_NOTE)
    });
    let nis_limits =
        [Some((NIS_95, format!("95 % below {NIS_95}"))), limits.nis.map(|nis| (nis, format!("gate {nis:.1}")))];
    charts.push(Chart {
        log: true,
        series: vec![Series { dots: true, ..curve("NIS", "filtered", column(run, |row| row.nis), 3) }],
        limits: nis_limits.into_iter().flatten().collect(),
        ..diagnostic("nis", "Normalised innovation squared", "NIS", 2, NIS_NOTE)
    });
    charts.retain(|chart| chart.id == "path" || chart.series.iter().any(Series::has_values));
    let marks = Estimator::ALL.into_iter().map(|e| points(run, e, e.name().to_owned(), look(e).to_owned()));
    let marks = marks.filter(|mark| mark.at.iter().any(Option::is_some));
    let found = places_of(run);
    PageModel {
        ribbons: vec![ribbon(run)],
        charts,
        viewer: viewer(run, marks.collect()),
        more_places: found.len().saturating_sub(places::MOST),
        places: found.into_iter().take(places::MOST).collect(),
        ..frame_axis(run)
    }
}

fn places_of(run: &Run) -> Vec<PlaceToLookAt> {
    let errors = run.error(Estimator::Filtered).unwrap_or_default();
    let found = places(&run.rows, (&errors, run.unit()), &run.deviation().1, &run.summary.limits);
    found.into_iter().map(PlaceToLookAt::of).collect()
}

/// The page of several runs on one recording; the first one gives the origin, the first that has them the truth and
/// the stored frames.
pub(super) fn several(runs: &[Run]) -> Option<PageModel> {
    let first = runs.first()?;
    let (unit, origin) = (first.unit().name(), first.ruler().origin);
    let from_there = |run: &Run| Ruler { origin, ..run.ruler() };
    let look = |index: usize| format!("run{}", index % 6);
    let named = |of: &dyn Fn(&Run) -> Vec<Option<f64>>, decimals| -> Vec<Series> {
        runs.iter().enumerate().map(|(i, run)| curve(&run.name, &look(i), of(run), decimals)).collect()
    };
    let mut path = named(&|run| run.position(run.best_estimator(), &from_there(run)), MM_DECIMALS);
    let judge = runs.iter().find(|run| run.truth_px.is_some());
    path.extend(
        judge
            .and_then(|run| run.true_position(&from_there(run)))
            .map(|truth| curve("truth", "truth", truth, MM_DECIMALS)),
    );
    let note = format!("Each run's best estimate: smoothed where it has one, else filtered. {}", sign(first));
    let mut charts = vec![Chart { series: path, note, ..chart("path", "Path", unit, 3) }];
    if let Some(truth_px) = judge.and_then(|run| run.truth_px.as_ref()) {
        let error = |run: &Run| run.error_against(run.best_estimator(), truth_px);
        let series = named(&error, MM_DECIMALS);
        let note = "Estimate minus truth, along the stripe.".to_owned();
        charts.push(Chart { histogram: true, series, note, ..chart("error", "Error", unit, 3) });
    }
    charts.push(Chart {
        series: named(&|run| column(run, |row| row.psr), 2),
        ..diagnostic("psr", "Peak-to-sidelobe ratio of the KCF", "PSR", 1, PSR_NOTE)
    });
    charts.retain(|chart| chart.id == "path" || chart.series.iter().any(Series::has_values));
    let marks = runs.iter().enumerate().map(|(i, run)| points(run, run.best_estimator(), run.name.clone(), look(i)));
    let with_images = runs.iter().find(|run| !run.thumbnails.is_empty()).unwrap_or(first);
    let each = (places::MOST / runs.len()).max(PLACES_EACH);
    let mut more_places = 0;
    let mut listed = vec![];
    for run in runs {
        let found = places_of(run);
        more_places += found.len().saturating_sub(each);
        let named = |place: PlaceToLookAt| PlaceToLookAt { why: format!("{}: {}", run.name, place.why), ..place };
        listed.extend(found.into_iter().take(each).map(named));
    }
    Some(PageModel {
        ribbons: runs.iter().map(ribbon).collect(),
        charts,
        viewer: viewer(with_images, marks.collect()),
        places: listed,
        more_places,
        ..frame_axis(first)
    })
}

/// A page of `run`'s frames without any content yet.
fn frame_axis(run: &Run) -> PageModel {
    PageModel {
        frames: run.rows.len(),
        time_s: Rounded::new(run.rows.iter().map(|row| Some(row.time_s)).collect(), 6),
        file: run.rows.iter().map(|row| row.file.clone()).collect(),
        travel_mm: run
            .rows
            .iter()
            .any(|row| row.travel_mm.is_some())
            .then(|| Rounded::new(column(run, |row| row.travel_mm), MM_DECIMALS)),
        ribbons: Vec::new(),
        charts: Vec::new(),
        viewer: viewer(run, Vec::new()),
        places: Vec::new(),
        more_places: 0,
    }
}

fn path_chart(run: &Run) -> Chart {
    let ruler = run.ruler();
    let position = |estimator| run.position(estimator, &ruler);
    let mut series = vec![
        Series { dots: true, fits: false, ..estimate(Estimator::Kcf, position(Estimator::Kcf)) },
        Series { band: Some(two_sigma(run)), ..estimate(Estimator::Filtered, position(Estimator::Filtered)) },
        estimate(Estimator::Smoothed, position(Estimator::Smoothed)),
    ];
    series.extend(run.true_position(&ruler).map(|truth| curve("truth", "truth", truth, MM_DECIMALS)));
    series.retain(Series::has_values);
    let note = format!("Where the seam lies along the stripe. {} Band: ±2σ, where it is with 95 %.", sign(run));
    let tolerance = tolerance(run, Reference::Origin);
    Chart { series, note, tolerance, ..chart("path", "Path", run.unit().name(), 3) }
}

/// Which way is +.
fn sign(run: &Run) -> &'static str {
    match run.summary.calibration.stripe {
        StripeAxis::Horizontal => "+ is to the right in the picture.",
        StripeAxis::Vertical => "+ is downwards in the picture.",
    }
}

/// The tolerance that is held against `reference`.
fn tolerance(run: &Run, reference: Reference) -> Option<f64> {
    run.summary.limits.tolerance_mm.filter(|_| run.deviation().0 == reference)
}

fn measure_chart(measure: &Measure) -> Chart {
    let Measure { id, title, unit, note, values, std } = measure;
    let has_std = std.iter().any(Option::is_some);
    let two_sigma = || Rounded::new(std.iter().map(|std| std.map(|std| 2.0 * std)).collect(), MM_DECIMALS);
    let values = curve(title, "measure", values.clone(), MM_DECIMALS);
    let series = vec![Series { band: has_std.then(two_sigma), dots: !has_std, ..values }];
    let band = if has_std { " Band: ±2σ." } else { " As measured in each frame." };
    Chart { series, note: format!("{note}{band}"), ..chart(id, title, unit, 2) }
}

/// Twice the filter's σ.
fn two_sigma(run: &Run) -> Rounded {
    let sigma = run.sigma(Estimator::Filtered).into_iter();
    Rounded::new(sigma.map(|sigma| sigma.map(|sigma| 2.0 * sigma)).collect(), MM_DECIMALS)
}

/// The error against the truth; without one, the distance from the smoothed path; without that, none.
fn error_chart(run: &Run) -> Option<Chart> {
    let smoothed = || -> Vec<Option<f64>> {
        let axis = run.summary.calibration.stripe;
        run.rows.iter().map(|row| row.along_px(Estimator::Smoothed, axis)).collect()
    };
    let (title, reference_px) = match &run.truth_px {
        Some(truth_px) => ("Error against the truth", truth_px.clone()),
        None => ("Distance from the smoothed path", smoothed()),
    };
    let judged = Estimator::ALL.into_iter().filter(|&e| run.truth_px.is_some() || e != Estimator::Smoothed);
    let mut series: Vec<Series> = judged
        .map(|e| Series {
            dots: e == Estimator::Kcf,
            fits: e != Estimator::Kcf,
            ..estimate(e, run.error_against(e, &reference_px))
        })
        .collect();
    series.retain(Series::has_values);
    if series.is_empty() {
        return None;
    }
    let band = two_sigma(run);
    let zero = band.values.iter().map(|half| half.map(|_| 0.0)).collect();
    series.push(Series { band: Some(band), ..curve("±2σ", "sigma", zero, 0) });
    let note = match run.truth_px {
        Some(_) => "Estimate minus truth, along the stripe. A σ that is right holds 95 % of it in ±2σ.",
        None => {
            "How far the estimate of the moment lies from the path that the whole recording tells. No truth was given."
        }
    };
    let tolerance = tolerance(run, Reference::Truth);
    Some(Chart {
        histogram: true,
        series,
        note: note.to_owned(),
        tolerance,
        ..chart("error", title, run.unit().name(), 3)
    })
}

fn estimate(estimator: Estimator, y: Vec<Option<f64>>) -> Series {
    curve(estimator.name(), look(estimator), y, MM_DECIMALS)
}

const fn look(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::Kcf => "kcf",
        Estimator::Filtered => "filtered",
        Estimator::Smoothed => "smoothed",
    }
}

fn column(run: &Run, of: impl Fn(&PathRow) -> Option<f64>) -> Vec<Option<f64>> {
    run.rows.iter().map(of).collect()
}

fn ribbon(run: &Run) -> Ribbon {
    let letters = run.rows.iter().filter_map(|row| row.status.name().chars().next());
    Ribbon { name: run.name.clone(), status: letters.collect() }
}

fn points(run: &Run, estimator: Estimator, name: String, look: String) -> Points {
    let shape = match estimator {
        Estimator::Kcf => "cross",
        Estimator::Filtered => "circle",
        Estimator::Smoothed => "diamond",
    };
    Points { name, look, shape, at: run.rows.iter().map(|row| row.point(estimator)).collect() }
}

fn viewer(run: &Run, points: Vec<Points>) -> Viewer {
    let Run { summary, .. } = run;
    Viewer {
        width: summary.input.width_px,
        height: summary.input.height_px,
        axis: summary.calibration.stripe.to_string(),
        points,
        images: Vec::new(),
    }
}
