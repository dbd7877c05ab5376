//! What the page's script draws, as data: charts, status ribbons, marks and stored frames, frame by frame.

use serde::{Serialize, Serializer};

use super::marks::FrameMarks;
use super::measures::Measure;
use super::places::{self, places};
use super::results::{Estimator, PathRow};
use super::run::Run;
use super::tolerance::Reference;
use super::verdict::NIS_95;
use crate::calib::Ruler;
use crate::units::{PixelPoint, StripeAxis};

/// The data of one page; serialised into it as JSON.
#[derive(Debug, Serialize)]
pub(super) struct PageModel {
    pub frames: usize,
    pub time_s: Rounded,
    /// Way of the torch, where its speed is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub travel_mm: Option<Rounded>,
    pub file: Vec<String>,
    pub ribbons: Vec<Ribbon>,
    pub charts: Vec<Chart>,
    pub viewer: Viewer,
    pub places: Vec<PlaceToLookAt>,
    /// Places beyond those that are listed.
    pub more_places: usize,
}

/// A stretch of frames to look at, and why.
#[derive(Debug, Serialize)]
pub(super) struct PlaceToLookAt {
    pub first: usize,
    pub last: usize,
    pub frame: usize,
    pub why: String,
}

/// The statuses of one run, a letter a frame.
#[derive(Debug, Serialize)]
pub(super) struct Ribbon {
    pub name: String,
    pub status: String,
}

/// One plot over the frames.
#[derive(Debug, Serialize)]
pub(super) struct Chart {
    pub id: &'static str,
    pub title: String,
    pub unit: &'static str,
    /// What it shows, in words.
    pub note: String,
    /// Of the method's workings, not of the seam: folded.
    pub diagnostic: bool,
    /// Half the width of a band round 0 that the curves are to stay in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// How many decimals a value is shown with.
    pub decimals: usize,
    /// Logarithmic ordinate.
    pub log: bool,
    /// A histogram of the visible frames belongs to it.
    pub histogram: bool,
    pub series: Vec<Series>,
    /// Horizontal lines with their names.
    pub limits: Vec<(f64, String)>,
}

/// One curve.
#[derive(Debug, Serialize)]
pub(super) struct Series {
    pub name: String,
    /// The class that gives colour and dashes.
    pub look: String,
    pub dots: bool,
    /// The ordinate's range includes it.
    pub fits: bool,
    pub y: Rounded,
    /// Half width of a band round `y`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<Rounded>,
}

/// What the frame viewer shows.
#[derive(Debug, Serialize)]
pub(super) struct Viewer {
    pub width: usize,
    pub height: usize,
    /// Length of the stripe mark's own axis: horizontal or vertical.
    pub axis: String,
    pub points: Vec<Points>,
    pub images: Vec<Image>,
}

/// One kind of mark.
#[derive(Debug, Serialize)]
pub(super) struct Points {
    pub name: String,
    pub look: String,
    pub shape: &'static str,
    /// The positions, frame by frame; only those of stored frames enter the page.
    #[serde(skip)]
    pub at: Vec<Option<PixelPoint>>,
}

/// A stored frame.
#[derive(Debug, Serialize)]
pub(super) struct Image {
    pub frame: usize,
    pub stripe: Vec<(f64, f64)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roi: Option<[f64; 4]>,
    /// One position for each of [`Viewer::points`].
    pub points: Vec<Option<(f64, f64)>>,
    /// Base64 of a JPEG file.
    pub jpeg: String,
}

/// Numbers with a fixed count of decimals, so that the page stays small.
#[derive(Debug, Clone)]
pub(super) struct Rounded {
    values: Vec<Option<f64>>,
    decimals: i32,
}

impl Rounded {
    pub(super) fn new(values: Vec<Option<f64>>, decimals: i32) -> Self {
        Self { values, decimals }
    }
}

impl Serialize for Rounded {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.values.iter().map(|value| value.map(|value| round(value, self.decimals))))
    }
}

fn round(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale + 0.0
}

/// Places of each of several runs that are listed at least. Chosen.
const PLACES_EACH: usize = 3;
const PSR_NOTE: &str = "How far the correlation filter's peak stands out of its surroundings: high where the picture looks as the \
                        template does, low where it is covered, glaring, or changed.";
const NIS_NOTE: &str =
    "How far a measurement lies from its prediction, in σ, squared: 1 on average where σ is right; 9 is a jump of 3 σ.";
const MM_DECIMALS: i32 = 4;
const PX_DECIMALS: i32 = 2;

/// The page of one run.
pub(super) fn single(run: &Run) -> PageModel {
    let limits = run.summary.limits;
    let mut charts = vec![path_chart(run)];
    charts.extend(run.measures.iter().map(measure_chart));
    charts.extend(error_chart(run));
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

impl PlaceToLookAt {
    pub(super) fn of(place: places::Place) -> Self {
        let places::Place { first, last, frame, reasons } = place;
        Self { first, last, frame, why: reasons.join(" · ") }
    }
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

impl Series {
    pub(super) fn has_values(&self) -> bool {
        self.y.values.iter().any(Option::is_some)
    }
}

pub(super) fn chart(id: &'static str, title: &str, unit: &'static str, decimals: usize) -> Chart {
    let (series, limits) = (Vec::new(), Vec::new());
    let (title, note) = (title.to_owned(), String::new());
    let (diagnostic, log, histogram, tolerance) = (false, false, false, None);
    Chart { id, title, unit, note, diagnostic, tolerance, decimals, log, histogram, series, limits }
}

pub(super) fn diagnostic(id: &'static str, title: &str, unit: &'static str, decimals: usize, note: &str) -> Chart {
    Chart { note: note.to_owned(), diagnostic: true, ..chart(id, title, unit, decimals) }
}

pub(super) fn curve(name: &str, look: &str, y: Vec<Option<f64>>, decimals: i32) -> Series {
    let y = Rounded::new(y, decimals);
    Series { name: name.to_owned(), look: look.to_owned(), dots: false, fits: true, y, band: None }
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

/// A stored frame with its marks, rounded for the page.
pub(super) fn image(viewer: &Viewer, frame: usize, marks: &FrameMarks, jpeg: String) -> Image {
    let px = |value: f64| round(value, PX_DECIMALS);
    let point = |points: &Points| points.at.get(frame).copied().flatten().map(|p| (px(p.u_px), px(p.v_px)));
    Image {
        frame,
        points: viewer.points.iter().map(point).collect(),
        stripe: marks.stripe.iter().map(|p| (px(p.u_px), px(p.v_px))).collect(),
        roi: marks.roi.map(|roi| [px(roi.u_px), px(roi.v_px), px(roi.width_px), px(roi.height_px)]),
        jpeg,
    }
}
