//! What the page's script draws, as data: charts, status ribbons, marks and stored frames, frame by frame.

use serde::{Serialize, Serializer};

use super::marks::FrameMarks;
use super::results::{Estimator, PathRow};
use super::run::Run;
use super::verdict::NIS_95;
use super::worst::worst_frames;
use crate::calib::Ruler;
use crate::units::PixelPoint;

/// The data of one page; serialised into it as JSON.
#[derive(Debug, Serialize)]
pub(super) struct PageModel {
    pub frames: usize,
    pub time_s: Rounded,
    pub file: Vec<String>,
    pub ribbons: Vec<Ribbon>,
    pub charts: Vec<Chart>,
    pub viewer: Viewer,
    pub worst: Vec<(usize, String)>,
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

const MM_DECIMALS: i32 = 4;
const PX_DECIMALS: i32 = 2;

/// The page of one run.
pub(super) fn single(run: &Run) -> PageModel {
    let limits = run.summary.limits;
    let worst_error = run.error(Estimator::Filtered).unwrap_or_default();
    let mut charts = vec![path_chart(run)];
    charts.extend(error_chart(run));
    charts.push(Chart {
        series: vec![curve("PSR", "filtered", column(run, |row| row.psr), 2)],
        limits: limits.psr.into_iter().map(|psr| (psr, format!("template learns above {psr}"))).collect(),
        ..chart("psr", "Peak-to-sidelobe ratio of the KCF", "PSR", 1)
    });
    let nis_limits =
        [Some((NIS_95, format!("95 % below {NIS_95}"))), limits.nis.map(|nis| (nis, format!("gate {nis:.1}")))];
    charts.push(Chart {
        log: true,
        series: vec![Series { dots: true, ..curve("NIS", "filtered", column(run, |row| row.nis), 3) }],
        limits: nis_limits.into_iter().flatten().collect(),
        ..chart("nis", "Normalised innovation squared", "NIS", 2)
    });
    charts.retain(|chart| chart.id == "path" || chart.series.iter().any(Series::has_values));
    let marks = Estimator::ALL.into_iter().map(|e| points(run, e, e.name().to_owned(), look(e).to_owned()));
    let marks = marks.filter(|mark| mark.at.iter().any(Option::is_some));
    PageModel {
        ribbons: vec![ribbon(run)],
        charts,
        viewer: viewer(run, marks.collect()),
        worst: worst_frames(&run.rows, &worst_error, run.unit()).into_iter().map(|w| (w.frame, w.reason)).collect(),
        ..frame_axis(run)
    }
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
    let mut path = named(&|run| run.position(Estimator::Filtered, &from_there(run)), MM_DECIMALS);
    let judge = runs.iter().find(|run| run.truth_px.is_some());
    path.extend(
        judge
            .and_then(|run| run.true_position(&from_there(run)))
            .map(|truth| curve("truth", "truth", truth, MM_DECIMALS)),
    );
    let mut charts = vec![Chart { series: path, ..chart("path", "Filtered path", unit, 3) }];
    if let Some(truth_px) = judge.and_then(|run| run.truth_px.as_ref()) {
        let error = |run: &Run| run.error_against(Estimator::Filtered, truth_px);
        let series = named(&error, MM_DECIMALS);
        charts.push(Chart { histogram: true, series, ..chart("error", "Error of the filtered path", unit, 3) });
    }
    charts.push(Chart {
        series: named(&|run| column(run, |row| row.psr), 2),
        ..chart("psr", "Peak-to-sidelobe ratio", "PSR", 1)
    });
    let marks = runs.iter().enumerate().map(|(i, run)| points(run, Estimator::Filtered, run.name.clone(), look(i)));
    let with_images = runs.iter().find(|run| !run.thumbnails.is_empty()).unwrap_or(first);
    Some(PageModel {
        ribbons: runs.iter().map(ribbon).collect(),
        charts,
        viewer: viewer(with_images, marks.collect()),
        worst: runs
            .iter()
            .flat_map(|run| {
                let error = run.error(Estimator::Filtered).unwrap_or_default();
                let name = run.name.clone();
                let listed = worst_frames(&run.rows, &error, run.unit()).into_iter().take(8);
                listed.map(move |w| (w.frame, format!("{name}: {}", w.reason))).collect::<Vec<_>>()
            })
            .collect(),
        ..frame_axis(first)
    })
}

/// A page of `run`'s frames without any content yet.
fn frame_axis(run: &Run) -> PageModel {
    PageModel {
        frames: run.rows.len(),
        time_s: Rounded::new(run.rows.iter().map(|row| Some(row.time_s)).collect(), 6),
        file: run.rows.iter().map(|row| row.file.clone()).collect(),
        ribbons: Vec::new(),
        charts: Vec::new(),
        viewer: viewer(run, Vec::new()),
        worst: Vec::new(),
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
    Chart { series, ..chart("path", "Seam position with ±2σ", run.unit().name(), 3) }
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
    Some(Chart { histogram: true, series, ..chart("error", title, run.unit().name(), 3) })
}

impl Series {
    pub(super) fn has_values(&self) -> bool {
        self.y.values.iter().any(Option::is_some)
    }
}

pub(super) fn chart(id: &'static str, title: &str, unit: &'static str, decimals: usize) -> Chart {
    let (series, limits) = (Vec::new(), Vec::new());
    Chart { id, title: title.to_owned(), unit, decimals, log: false, histogram: false, series, limits }
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
