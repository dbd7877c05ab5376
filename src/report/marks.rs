//! What the tracker saw in one frame, beyond the numbers of `path.csv`: drawn over the frame, never computed with.

use serde::{Deserialize, Serialize};

use crate::units::PixelPoint;

/// Marks of one frame in image coordinates.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FrameMarks {
    /// The stripe's centreline as a polyline; a few dozen points suffice. Empty when none was found.
    pub stripe: Vec<PixelPoint>,
    /// The window that was searched.
    pub roi: Option<RoiBox>,
}

/// An axis-parallel box in image coordinates; it may reach beyond the frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RoiBox {
    /// Left edge \[px\].
    pub u_px: f64,
    /// Top edge \[px\].
    pub v_px: f64,
    /// Columns \[px\].
    pub width_px: f64,
    /// Rows \[px\].
    pub height_px: f64,
}
