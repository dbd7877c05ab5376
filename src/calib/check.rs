//! An independent test of a calibration by what a shop has: a flat plate, a known step, a known travel, or the boards again.

use nalgebra::Vector2;

use super::adjust::Sighting;
use super::board::BoardSize;
use super::error::CalibrationError;
use super::laser::{StripeView, board_pose, height_per_mm, offsets_mm};
use super::laser_camera::{CalibratedRange, LaserCamera};
use super::stripe::BAND_RATIO;
use crate::frame::GrayFrame;
use crate::imgproc::{CentrelineSettings, extract_along, stripe_path};
use crate::units::{PixelPoint, StripeAxis};

/// Most tilt of a plate that was laid down squarely \[°\]. Chosen: by eye a plate is square to within 2° or 3°.
pub const MOST_TILT_DEG: f64 = 5.0;
/// Share of the stripe that may lie outside the calibrated range.
pub const MOST_OUTSIDE: f64 = 0.05;
/// Parts along the stripe over which a plate's flatness is judged.
const PARTS: usize = 24;
/// A part needs this many points.
const LEAST_IN_PART: usize = 20;
/// Least points of a stripe in a frame.
const LEAST_POINTS: usize = 40;
/// Tukey's constant, in robust σ, and rounds.
const TUKEY: f64 = 4.685;
const ROUNDS: usize = 8;
/// The second level of a step needs this share of the stripe.
const LEAST_LEVEL_SHARE: f64 = 0.1;

/// One figure of a check, with its limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What it is.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Largest good value.
    pub limit: f64,
    /// Its unit.
    pub unit: &'static str,
    /// What it means, in a sentence, when it is beyond the limit.
    pub meaning: String,
}

impl Figure {
    /// Whether the value is within the limit.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.value.abs() <= self.limit
    }
}

/// What a check found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Checked {
    /// Frames or views that were used.
    pub used: usize,
    /// The figures that decide.
    pub figures: Vec<Figure>,
    /// What else is worth knowing.
    pub notes: Vec<String>,
}

impl Checked {
    /// Whether every figure is good.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.figures.iter().all(Figure::is_good)
    }
}

/// A check that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CheckError {
    /// No frame shows enough of a stripe.
    #[error("no frame shows a laser stripe of {LEAST_POINTS} points or more that meets the calibrated plane")]
    NoStripe,
    /// The stripe has one level only.
    #[error("the stripe shows one level only, no step: lay the gauge block so that the stripe crosses its edge")]
    NoStep,
    /// The travel cannot be followed.
    #[error("{0}")]
    Travel(String),
    /// The boards cannot be used.
    #[error(transparent)]
    Boards(#[from] CalibrationError),
}

/// The stripe's points in one frame.
#[derive(Debug, Clone)]
pub struct StripePoints {
    pub(super) pixels: Vec<PixelPoint>,
    pub(super) points: Vec<Vector2<f64>>,
}

/// The stripe of a frame in millimetres (lateral, height); none where too little of it is seen.
#[must_use]
pub fn stripe_points(sensor: &LaserCamera, frame: &GrayFrame) -> Option<StripePoints> {
    let axis = sensor.stripe_axis();
    let turned = if axis == StripeAxis::Vertical { frame.transposed() } else { frame.clone() };
    let path = stripe_path(&turned)?;
    let settings = CentrelineSettings { band_ratio: BAND_RATIO, ..CentrelineSettings::default() };
    let line = extract_along(&turned, &settings, &path);
    let rows = line.v_px.iter().enumerate();
    let seen = rows.filter_map(|(u, v)| {
        let pixel = axis.image_from_stripe(PixelPoint::new(u as f64, f64::from((*v)?)));
        let point = sensor.point(pixel)?;
        Some((pixel, Vector2::new(point.lateral_mm, point.height_mm)))
    });
    let (pixels, points): (Vec<PixelPoint>, Vec<Vector2<f64>>) = seen.unzip();
    (points.len() >= LEAST_POINTS).then_some(StripePoints { pixels, points })
}

/// A line height = at_zero + slope · lateral.
#[derive(Debug, Clone, Copy)]
struct Level {
    at_zero: f64,
    slope: f64,
}

impl Level {
    fn off(self, p: &Vector2<f64>) -> f64 {
        p.y - self.at_zero - self.slope * p.x
    }
}

/// A flat plate: its tilt, its flatness, and whether it lies where the calibration was made.
///
/// # Errors
/// When no frame shows a stripe.
pub fn check_plate(
    sensor: &LaserCamera,
    frames: &[StripePoints],
    gate_mm: f64,
    tilt_deg: f64,
) -> Result<Checked, CheckError> {
    let mut tilts_deg = vec![];
    let mut kept: Vec<Vector2<f64>> = vec![];
    let mut pixels: Vec<PixelPoint> = vec![];
    for frame in frames {
        let Some((level, limit)) = robust_level(&frame.points) else { continue };
        tilts_deg.push(level.slope.atan().to_degrees());
        for (pixel, point) in frame.pixels.iter().zip(&frame.points).filter(|(_, p)| level.off(p).abs() < limit) {
            kept.push(Vector2::new(point.x, level.off(point)));
            pixels.push(*pixel);
        }
    }
    if kept.is_empty() {
        return Err(CheckError::NoStripe);
    }
    let mut checked = Checked { used: tilts_deg.len(), ..Checked::default() };
    let tilt = median(&mut tilts_deg);
    let (flatness_mm, noise_mm) = flatness(&kept);
    checked.figures.push(Figure {
        name: "flatness",
        value: flatness_mm,
        limit: gate_mm,
        unit: "mm",
        meaning: "a flat plate comes out bent: lens or plane are wrong, or the plate is not flat".into(),
    });
    checked.notes.push(format!("{noise_mm:.3} mm of the flatness are the scatter of single points"));
    checked.figures.push(tilt_figure(tilt, tilt_deg));
    checked.figures.push(outside(sensor, &pixels));
    Ok(checked)
}

fn tilt_figure(tilt_deg: f64, expected_deg: f64) -> Figure {
    Figure {
        name: "tilt",
        value: tilt_deg - expected_deg,
        limit: MOST_TILT_DEG,
        unit: "°",
        meaning: format!(
            "the plate comes out tilted by {tilt_deg:.1}° where {expected_deg:.1}° was expected: if it lay squarely, camera or laser were moved after the calibration"
        ),
    }
}

/// The share of the pixels outside the calibrated range, and by how much.
fn outside(sensor: &LaserCamera, pixels: &[PixelPoint]) -> Figure {
    let out = pixels.iter().filter(|p| !sensor.is_calibrated(**p)).count();
    let mut heights: Vec<f64> = pixels.iter().filter_map(|p| Some(sensor.point(*p)?.height_mm)).collect();
    let height_mm = median(&mut heights);
    let meaning = match sensor.range() {
        None => "the file has no [range], so nothing counts as calibrated".to_owned(),
        Some(CalibratedRange { height_mm: [low, high], u_px, v_px, .. }) => format!(
            "the stripe leaves the calibrated range: it lies at a height of {height_mm:.0} mm, calibrated were {low:.0} to {high:.0} mm, columns {:.0} to {:.0} and rows {:.0} to {:.0}",
            u_px[0], u_px[1], v_px[0], v_px[1]
        ),
    };
    let share = 100.0 * out as f64 / pixels.len().max(1) as f64;
    Figure { name: "outside the calibrated range", value: share, limit: 100.0 * MOST_OUTSIDE, unit: "%", meaning }
}

/// A step of known height.
///
/// # Errors
/// When no frame shows two levels.
pub fn check_step(
    sensor: &LaserCamera,
    frames: &[StripePoints],
    step_mm: f64,
    gate_mm: f64,
) -> Result<Checked, CheckError> {
    let mut steps: Vec<f64> = frames.iter().filter_map(|frame| step_of(&frame.points)).collect();
    if frames.is_empty() {
        return Err(CheckError::NoStripe);
    }
    if steps.is_empty() {
        return Err(CheckError::NoStep);
    }
    let pixels: Vec<PixelPoint> = frames.iter().flat_map(|frame| frame.pixels.iter().copied()).collect();
    let used = steps.len();
    let measured = median(&mut steps);
    let error = Figure {
        name: "step",
        value: measured - step_mm.abs(),
        limit: gate_mm,
        unit: "mm",
        meaning: format!("a step of {:.3} mm comes out as {measured:.3} mm", step_mm.abs()),
    };
    let mut checked = Checked { used, figures: vec![error, outside(sensor, &pixels)], notes: vec![] };
    if used > 1 {
        checked.notes.push(format!(
            "the step's median over {used} frames, between {:.3} and {:.3} mm",
            steps[0],
            steps[used - 1]
        ));
    }
    Ok(checked)
}

/// The distance of two parallel levels.
fn step_of(points: &[Vector2<f64>]) -> Option<f64> {
    let (first, limit) = robust_level(points)?;
    let rest: Vec<Vector2<f64>> = points.iter().filter(|p| first.off(p).abs() >= limit).copied().collect();
    if (rest.len() as f64) < LEAST_LEVEL_SHARE * points.len() as f64 || rest.len() < LEAST_POINTS / 2 {
        return None;
    }
    let mut offs: Vec<f64> = rest.iter().map(|p| first.off(p)).collect();
    let middle = median(&mut offs);
    let mut apart: Vec<f64> = offs.iter().map(|o| (o - middle).abs()).collect();
    let reach = (TUKEY * 1.4826 * median(&mut apart)).max(limit / 2.0);
    let upper: Vec<Vector2<f64>> = rest.into_iter().filter(|p| (first.off(p) - middle).abs() < reach).collect();
    let lower: Vec<Vector2<f64>> = points.iter().filter(|p| first.off(p).abs() < limit).copied().collect();
    // Both levels with one slope, by least squares.
    let sums = |level: &[Vector2<f64>]| {
        let mean = level.iter().sum::<Vector2<f64>>() / level.len() as f64;
        let xx: f64 = level.iter().map(|p| (p.x - mean.x).powi(2)).sum();
        let xy: f64 = level.iter().map(|p| (p.x - mean.x) * (p.y - mean.y)).sum();
        (mean, xx, xy)
    };
    let ((a, axx, axy), (b, bxx, bxy)) = (sums(&lower), sums(&upper));
    let slope = (axy + bxy) / (axx + bxx);
    Some(((b.y - a.y - slope * (b.x - a.x)) / (1.0 + slope * slope).sqrt()).abs())
}

/// A robust line through a stripe, and how near a point must be to count \[mm\].
fn robust_level(points: &[Vector2<f64>]) -> Option<(Level, f64)> {
    let n = points.len();
    let mut best: Option<(f64, Level)> = None;
    // Lines through points a third of the stripe apart; the one with the least 40 % quantile of distances.
    for i in 0..n.min(240) {
        let a = points[i * 2 * n / 3 / n.min(240)];
        let b = points[(i * 2 * n / 3 / n.min(240) + n / 3).min(n - 1)];
        let slope = (b.y - a.y) / (b.x - a.x);
        if !slope.is_finite() {
            continue;
        }
        let level = Level { at_zero: a.y - slope * a.x, slope };
        let mut off: Vec<f64> = points.iter().map(|p| level.off(p).abs()).collect();
        let rank = n * 2 / 5;
        let quantile = *off.select_nth_unstable_by(rank, f64::total_cmp).1;
        if best.is_none_or(|(least, _)| quantile < least) {
            best = Some((quantile, level));
        }
    }
    // 40 % of a normal's values are within .524 σ.
    let (quantile, mut level) = best?;
    let mut limit = TUKEY * (quantile / 0.524).max(1e-6);
    for _ in 0..ROUNDS {
        let mut sums = [0.0; 5];
        for p in points {
            let w = (1.0 - (level.off(p) / limit).powi(2)).max(0.0).powi(2);
            for (sum, value) in sums.iter_mut().zip([1.0, p.x, p.y, p.x * p.x, p.x * p.y]) {
                *sum += w * value;
            }
        }
        let [w, wx, wy, wxx, wxy] = sums;
        let slope = (wxy - wx * wy / w) / (wxx - wx * wx / w);
        if !slope.is_finite() {
            return None;
        }
        level = Level { at_zero: (wy - slope * wx) / w, slope };
        let mut off: Vec<f64> = points.iter().map(|p| level.off(p).abs()).filter(|off| *off < limit).collect();
        if off.is_empty() {
            return None;
        }
        limit = TUKEY * (1.4826 * median(&mut off)).max(1e-6);
    }
    Some((level, limit))
}

/// SD over parts of the stripe of the mean distance from the line, and what of it is noise \[mm\].
fn flatness(kept: &[Vector2<f64>]) -> (f64, f64) {
    let least = kept.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
    let most = kept.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    let mut parts = vec![(0.0, 0.0, 0usize); PARTS];
    for p in kept {
        let part = (((p.x - least) / (most - least) * PARTS as f64) as usize).min(PARTS - 1);
        parts[part] = (parts[part].0 + p.y, parts[part].1 + p.y * p.y, parts[part].2 + 1);
    }
    let used: Vec<(f64, f64)> = parts
        .into_iter()
        .filter(|(.., count)| *count >= LEAST_IN_PART)
        .map(|(sum, squares, count)| {
            let mean = sum / count as f64;
            (mean, (squares / count as f64 - mean * mean).max(0.0) / count as f64)
        })
        .collect();
    let count = used.len().max(1) as f64;
    let sd = (used.iter().map(|(mean, _)| mean * mean).sum::<f64>() / count).sqrt();
    (sd, (used.iter().map(|(_, variance)| variance).sum::<f64>() / count).sqrt())
}

/// The boards with their stripes against the plane.
///
/// # Errors
/// When a board's pose cannot be found.
pub fn check_boards(
    sensor: &LaserCamera,
    (board, square_mm): (BoardSize, f64),
    views: &[StripeView],
    gate_mm: f64,
) -> Result<Checked, CheckError> {
    let board_mm = board.points_mm(square_mm);
    let (mut means, mut heights, mut notes) = (vec![], vec![], vec![]);
    let mut pixels: Vec<PixelPoint> = vec![];
    for view in views {
        let sighting = Sighting { corners: view.board.pairs(&board_mm), stripe: vec![] };
        let pose = board_pose(sensor.intrinsics(), &board_mm, &view.board, &sighting)?;
        let offsets = offsets_mm(sensor.intrinsics(), sensor.plane(), &pose, &view.stripe);
        let mean = offsets.iter().sum::<f64>() / offsets.len().max(1) as f64;
        let height = mean * height_per_mm(sensor, &view.stripe);
        notes.push(format!("{}: {mean:+.3} mm off the plane, {height:+.2} mm of height", view.board.name));
        means.push(mean);
        heights.push(height);
        pixels.extend(&view.stripe.pixels);
    }
    if means.is_empty() {
        return Err(CheckError::NoStripe);
    }
    let rms = |all: &[f64]| (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt();
    let worst = heights.iter().fold(0.0f64, |worst, h| worst.max(h.abs()));
    let figure = Figure {
        name: "boards off the plane (rms of the views' means)",
        value: rms(&means),
        limit: gate_mm,
        unit: "mm",
        meaning: format!(
            "the stripes on the boards lie off the plane, up to {worst:.1} mm in height: the plane contradicts its images"
        ),
    };
    let mut figures = vec![figure];
    if sensor.range().is_some() {
        figures.push(outside(sensor, &pixels));
    }
    Ok(Checked { used: views.len(), figures, notes })
}

pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
