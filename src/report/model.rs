//! What the page's script draws, as data: charts, status ribbons, marks and stored frames, frame by frame.

use serde::{Serialize, Serializer};

use super::marks::FrameMarks;
use super::places;
use crate::units::PixelPoint;

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
    pub values: Vec<Option<f64>>,
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

const PX_DECIMALS: i32 = 2;

impl PlaceToLookAt {
    pub(super) fn of(place: places::Place) -> Self {
        let places::Place { first, last, frame, reasons } = place;
        Self { first, last, frame, why: reasons.join(" · ") }
    }
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
