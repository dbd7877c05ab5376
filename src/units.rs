//! Units and coordinates.
//!
//! Pixel centres are integers, the origin is the top left pixel: u is the column, v the row. A quantity's unit is
//! in its name (`_px`, `_mm`, `_s`) or in its type.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A point in an image: u = column, v = row, both in pixels, sub-pixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PixelPoint {
    /// Column \[px\].
    pub u_px: f64,
    /// Row \[px\].
    pub v_px: f64,
}

impl PixelPoint {
    /// The point in column `u_px` and row `v_px`.
    #[must_use]
    pub const fn new(u_px: f64, v_px: f64) -> Self {
        Self { u_px, v_px }
    }

    /// The same point in the transposed image.
    #[must_use]
    pub const fn transposed(self) -> Self {
        Self { u_px: self.v_px, v_px: self.u_px }
    }
}

/// A rectangle of whole pixels: its top left one, its columns and its rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct PixelRect {
    /// Its first column \[px\].
    pub u_px: usize,
    /// Its first row \[px\].
    pub v_px: usize,
    /// Columns \[px\].
    pub width_px: usize,
    /// Rows \[px\].
    pub height_px: usize,
}

impl PixelRect {
    /// All of a picture of so many columns and rows.
    #[must_use]
    pub const fn whole((width_px, height_px): (usize, usize)) -> Self {
        Self { u_px: 0, v_px: 0, width_px, height_px }
    }

    /// What of it lies in a picture of so many columns and rows; none where nothing does.
    #[must_use]
    pub fn within(self, (width_px, height_px): (usize, usize)) -> Option<Self> {
        let columns = self.u_end_px().min(width_px).checked_sub(self.u_px)?;
        let rows = self.v_end_px().min(height_px).checked_sub(self.v_px)?;
        (columns > 0 && rows > 0).then_some(Self { width_px: columns, height_px: rows, ..self })
    }

    /// Whether `point` lies in it.
    #[must_use]
    pub fn holds(self, point: PixelPoint) -> bool {
        (self.u_px as f64..self.u_end_px() as f64).contains(&point.u_px)
            && (self.v_px as f64..self.v_end_px() as f64).contains(&point.v_px)
    }

    /// One past the last column \[px\].
    #[must_use]
    pub const fn u_end_px(self) -> usize {
        self.u_px.saturating_add(self.width_px)
    }

    /// One past the last row \[px\].
    #[must_use]
    pub const fn v_end_px(self) -> usize {
        self.v_px.saturating_add(self.height_px)
    }
}

/// How the laser stripe runs through the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StripeAxis {
    /// The stripe runs along the rows; the seam position is u.
    Horizontal,
    /// The stripe runs along the columns; the seam position is v.
    Vertical,
}

impl StripeAxis {
    /// The coordinate of `point` along the stripe \[px\].
    #[must_use]
    pub const fn along_px(self, point: PixelPoint) -> f64 {
        match self {
            Self::Horizontal => point.u_px,
            Self::Vertical => point.v_px,
        }
    }

    /// The coordinate of `point` across the stripe \[px\].
    #[must_use]
    pub const fn across_px(self, point: PixelPoint) -> f64 {
        match self {
            Self::Horizontal => point.v_px,
            Self::Vertical => point.u_px,
        }
    }

    /// Image coordinates of a point given in the stripe's own frame (u along it).
    #[must_use]
    pub const fn image_from_stripe(self, point: PixelPoint) -> PixelPoint {
        match self {
            Self::Horizontal => point,
            Self::Vertical => point.transposed(),
        }
    }

    /// A point of the image in the stripe's own frame: the inverse, which is the same map.
    #[must_use]
    pub const fn stripe_from_image(self, point: PixelPoint) -> PixelPoint {
        self.image_from_stripe(point)
    }
}

impl fmt::Display for StripeAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Horizontal => "horizontal",
            Self::Vertical => "vertical",
        })
    }
}

/// The direction of travel as seen in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Travel {
    /// Towards the first row.
    #[default]
    Up,
    /// Towards the last row.
    Down,
    /// Towards the first column.
    Left,
    /// Towards the last column.
    Right,
}

impl Travel {
    /// Whether the rows run across the travel, so that a position across it is a column.
    #[must_use]
    pub const fn is_along_columns(self) -> bool {
        matches!(self, Self::Up | Self::Down)
    }

    /// The coordinate of a point of the image across the travel \[px\]: its column, or its row.
    #[must_use]
    pub const fn across_px(self, point: PixelPoint) -> f64 {
        if self.is_along_columns() { point.u_px } else { point.v_px }
    }

    /// The point of an image of `size_px` columns and rows that lies at column `x`, row `y` of the turned picture. The
    /// column is the image's own coordinate across the travel.
    #[must_use]
    pub fn image_from_turned(self, [x, y]: [f64; 2], size_px: (usize, usize)) -> PixelPoint {
        let (last_column, last_row) = (size_px.0 as f64 - 1.0, size_px.1 as f64 - 1.0);
        match self {
            Self::Up => PixelPoint::new(x, y),
            Self::Down => PixelPoint::new(x, last_row - y),
            Self::Left => PixelPoint::new(y, x),
            Self::Right => PixelPoint::new(last_column - y, x),
        }
    }
}

impl fmt::Display for Travel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Up => "up",
            Self::Down => "down",
            Self::Left => "left",
            Self::Right => "right",
        })
    }
}

/// What a length is counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// Millimetres.
    Mm,
    /// Pixels of the picture, where nobody gave a scale.
    Px,
}

impl LengthUnit {
    /// The unit's sign.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Px => "px",
        }
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A scale in millimetres per pixel, finite and positive.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct MmPerPx(f64);

impl MmPerPx {
    /// The scale of Du 2022, section 2.
    pub const DU_2022: Self = Self(0.073);
    /// The scale of the infrared paper, equation (1): 114 pixels a millimetre.
    pub const INFRARED: Self = Self(1.0 / 114.0);

    /// A scale of `mm_per_px` millimetres per pixel.
    ///
    /// # Errors
    /// When the number is not finite and positive.
    pub fn new(mm_per_px: f64) -> Result<Self, InvalidScale> {
        if mm_per_px.is_finite() && mm_per_px > 0.0 { Ok(Self(mm_per_px)) } else { Err(InvalidScale(mm_per_px)) }
    }

    /// Millimetres per pixel.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl TryFrom<f64> for MmPerPx {
    type Error = InvalidScale;
    fn try_from(mm_per_px: f64) -> Result<Self, InvalidScale> {
        Self::new(mm_per_px)
    }
}

impl From<MmPerPx> for f64 {
    fn from(scale: MmPerPx) -> Self {
        scale.0
    }
}

impl std::str::FromStr for MmPerPx {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let number: f64 = text.parse().map_err(|e| format!("{e}"))?;
        Self::new(number).map_err(|e| e.to_string())
    }
}

/// A scale that is not finite and positive.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a scale of {0} mm/px is not a positive number")]
pub struct InvalidScale(f64);
