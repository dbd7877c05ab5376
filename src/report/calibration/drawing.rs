//! The drawings of the page, as SVG texts.

use std::fmt::Write;

use nalgebra::Vector2;

use crate::calib::camera::CameraFit;
use crate::calib::laser::LaserFit;
use crate::calib::laser_camera::PlanePoint;
use crate::calib::uncertainty::{COLUMNS, ROWS, UncertaintyMap};

/// How much longer than the residual an arrow is.
const ARROW: f64 = 200.0;
/// Width of a drawing in its own units.
const WIDTH: f64 = 640.0;

/// Residuals of all corners over the picture.
pub fn residuals(fit: &CameraFit) -> String {
    let (width, height) = (fit.size_px.0 as f64, fit.size_px.1 as f64);
    let dot = width / 500.0;
    let mut svg = format!(
        "<svg class=\"plate\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"Residuals over the picture\">"
    );
    let mut arrows = String::new();
    let board_mm = fit.board.points_mm(fit.square_mm);
    for view in &fit.views {
        for ((board, seen), used) in board_mm.iter().zip(&view.sighting.corners).zip(&view.sighting.used) {
            let Some(pixel) = fit.intrinsics.project(&view.pose.camera_from_board(board)).filter(|_| *used) else {
                continue;
            };
            let by = (seen - Vector2::new(pixel.u_px, pixel.v_px)) * ARROW;
            let _ = write!(arrows, "M{:.1} {:.1}l{:.1} {:.1}", seen.x, seen.y, by.x, by.y);
            let _ = write!(svg, "<circle class=\"corner\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{dot:.1}\"/>", seen.x, seen.y);
        }
    }
    let _ = write!(svg, "<path class=\"arrow\" stroke-width=\"{dot:.1}\" d=\"{arrows}\"/></svg>");
    svg
}

/// σ of the projection over the picture.
pub fn uncertainty(map: &UncertaintyMap, size_px: (usize, usize)) -> String {
    let height = WIDTH * size_px.1 as f64 / size_px.0 as f64;
    let (w, h) = (WIDTH / COLUMNS as f64, height / ROWS as f64);
    let mut svg = format!(
        "<svg class=\"plate\" viewBox=\"0 0 {WIDTH} {height:.1}\" role=\"img\" aria-label=\"Uncertainty of the projection over the picture\">"
    );
    for (i, sigma) in map.sigma_px.iter().enumerate() {
        let (x, y) = ((i % COLUMNS) as f64 * w, (i / COLUMNS) as f64 * h);
        // From .03 px, light, to 3 px, dark, by decades.
        let depth = ((sigma.max(0.03) / 0.03).log10() / 2.0).min(1.0);
        let [r, g, b] =
            [(86.0, 60.0), (170.0, 20.0), (140.0, 40.0)].map(|(light, dark)| light + (dark - light) * depth);
        let _ = write!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"rgb({r:.0},{g:.0},{b:.0})\"/>\
             <text class=\"on-cell\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"10\">{sigma:.2}</text>",
            w + 0.2,
            h + 0.2,
            x + w / 2.0,
            y + h / 2.0 + 4.0
        );
    }
    svg + "</svg>"
}

/// A bar a view: its mean distance from the others' plane.
pub fn plane_residuals(fit: &LaserFit) -> String {
    const ROW: f64 = 18.0;
    const NAMES: f64 = 170.0;
    let largest = fit.views.iter().map(|view| view.left_out_mm.abs()).filter(|x| x.is_finite()).fold(0.05, f64::max);
    let height = ROW * fit.views.len() as f64 + 24.0;
    let zero = NAMES + 0.5 * (WIDTH - NAMES - 60.0);
    let scale = 0.5 * (WIDTH - NAMES - 60.0) / largest;
    let mut svg = format!(
        "<svg class=\"plate\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"Distance of each view from the plane\">"
    );
    for (i, view) in fit.views.iter().enumerate() {
        let y = 10.0 + i as f64 * ROW;
        let mm = view.left_out_mm.clamp(-largest, largest);
        let (x, width) = (zero + scale * mm.min(0.0), (scale * mm).abs().max(0.5));
        let class = if view.flagged { "bar flagged" } else { "bar" };
        let name = maud::html! { (view.seen.board.name) }.into_string();
        let _ = write!(
            svg,
            "<text x=\"8\" y=\"{0}\">{name}</text><rect class=\"{class}\" x=\"{x:.1}\" y=\"{1}\" width=\"{width:.1}\" height=\"{2}\"/>\
             <text x=\"{3}\" y=\"{0}\" text-anchor=\"end\">{4:+.3}</text>",
            y + 12.0,
            y + 2.0,
            ROW - 4.0,
            WIDTH - 8.0,
            view.left_out_mm
        );
    }
    let _ = write!(svg, "<path class=\"axis\" d=\"M{zero} 6V{}\"/></svg>", height - 10.0);
    svg
}

/// The stripes in the laser's plane.
pub fn coverage(fit: &LaserFit) -> String {
    let Some(range) = fit.sensor.range() else { return String::new() };
    let [left, right] = range.lateral_mm;
    let [low, high] = range.height_mm;
    let scale = 0.86 * WIDTH / (right - left).max(high - low).max(1.0);
    let height = (high - low) * scale + 60.0;
    let indent = 0.5 * (WIDTH - (right - left) * scale);
    let at = |lateral: f64, h: f64| (indent + (lateral - left) * scale, 30.0 + (high - h) * scale);
    let mut svg = format!(
        "<svg class=\"plate\" viewBox=\"0 0 {WIDTH} {height:.1}\" role=\"img\" aria-label=\"Stripes in the laser's plane\">"
    );
    let (x, y) = at(left, high);
    let _ = write!(
        svg,
        "<rect class=\"range\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>\
         <text x=\"{x:.1}\" y=\"{:.1}\">lateral {left:.0} to {right:.0} mm, height {low:.0} to {high:.0} mm</text>",
        (right - left) * scale,
        (high - low) * scale,
        y - 8.0
    );
    for view in &fit.views {
        let points = || view.seen.stripe.pixels.iter().filter_map(|pixel| fit.sensor.point(*pixel));
        let along = |a: &PlanePoint, b: &PlanePoint| a.lateral_mm.total_cmp(&b.lateral_mm);
        if let (Some(a), Some(b)) = (points().min_by(along), points().max_by(along)) {
            let ((ax, ay), (bx, by)) = (at(a.lateral_mm, a.height_mm), at(b.lateral_mm, b.height_mm));
            let _ = write!(svg, "<path class=\"stripe\" d=\"M{ax:.1} {ay:.1}L{bx:.1} {by:.1}\"/>");
        }
    }
    svg + "</svg>"
}
