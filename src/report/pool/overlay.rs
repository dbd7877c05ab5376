//! A frame with what was measured in it.

use super::results::PoolRow;
use crate::frame::GrayFrame;
use crate::report::canvas::{Canvas, Rgb};
use crate::report::marks::{FrameMarks, RoiBox};
use crate::report::overlay::{OverlayError, OverlayWriter, status_colour};
use crate::units::PixelPoint;

/// Colours of Okabe and Ito, as in the seam's overlay.
const OUTLINE: Rgb = [86, 180, 233];
const MEASURED: Rgb = [230, 159, 0];
const FILTERED: Rgb = [255, 255, 255];
/// Small frames are drawn larger, so that marks of a few pixels can be seen \[px\].
const LEAST_SIDE_PX: usize = 360;
/// Half the side of the box that marks a tip \[px\].
const TIP_HALF_PX: f64 = 3.0;

/// What was seen of the pool in one frame, in image coordinates.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoolMarks {
    /// Its outline, closed; empty when none was found.
    pub outline: Vec<PixelPoint>,
    /// The measured tip twice, or the ends of the measured width.
    pub measured: Option<[PixelPoint; 2]>,
    /// The same as the filter has it.
    pub filtered: Option<[PixelPoint; 2]>,
}

impl PoolMarks {
    /// The marks as a stored frame keeps them: the outline, and a box round the tip or a flat one along the width.
    #[must_use]
    pub fn to_frame_marks(&self) -> FrameMarks {
        let roi = self.measured.map(|[a, b]| {
            let half = if a == b { TIP_HALF_PX } else { 0.0 };
            let (left, top) = (a.u_px.min(b.u_px) - half, a.v_px.min(b.v_px) - half);
            let size = |a: f64, b: f64| (a - b).abs() + 2.0 * half;
            RoiBox { u_px: left, v_px: top, width_px: size(a.u_px, b.u_px), height_px: size(a.v_px, b.v_px) }
        });
        FrameMarks { stripe: self.outline.clone(), roi }
    }
}

/// Draws one frame into an overlay: outline, measured tip or width (crosses), filtered one (circles), status and value.
///
/// # Errors
/// When the picture cannot be drawn or written.
pub fn draw(
    overlay: &mut OverlayWriter,
    frame: &GrayFrame,
    row: &PoolRow,
    marks: &PoolMarks,
    note: &str,
) -> Result<(), OverlayError> {
    let factor = LEAST_SIDE_PX.div_ceil(frame.width_px().min(frame.height_px()));
    let large = enlarged(frame, factor);
    let scale = factor as f64;
    let place = |p: PixelPoint| PixelPoint::new(scale * (p.u_px + 0.5) - 0.5, scale * (p.v_px + 0.5) - 0.5);
    let mut canvas = Canvas::of(&large)?;
    if let Some(&first) = marks.outline.first() {
        let closed: Vec<PixelPoint> = marks.outline.iter().copied().chain([first]).map(place).collect();
        canvas.polyline(&closed, OUTLINE)?;
    }
    if let Some(ends) = marks.measured {
        let [a, b] = ends.map(place);
        canvas.polyline(&[a, b], MEASURED)?;
        for end in [a, b] {
            canvas.strokes(end, &[[(-6.0, -6.0), (6.0, 6.0)], [(-6.0, 6.0), (6.0, -6.0)]], MEASURED)?;
        }
    }
    for end in marks.filtered.into_iter().flatten() {
        canvas.circle(place(end), 8.0, FILTERED)?;
    }
    let value = row.filtered_mm.map_or(String::new(), |mm| format!("  {mm:.3} mm"));
    canvas.caption(&format!("{}  {}{value}  {note}", row.frame, row.status), status_colour(row.status))?;
    overlay.add_drawing(row.frame, canvas)
}

/// Every pixel `factor` times as large.
fn enlarged(frame: &GrayFrame, factor: usize) -> GrayFrame {
    let (width, height) = (frame.width_px() * factor, frame.height_px() * factor);
    let rows = (0..height).map(|v| frame.row(v / factor));
    let pixels = rows.flat_map(|row| (0..width).map(|u| row[u / factor])).collect();
    GrayFrame::new(width, height, pixels).unwrap_or_else(|_| frame.clone())
}
