//! A row of `path.csv`: its columns, each with name, kind and decimals in one place.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize};

use crate::units::{LengthUnit, PixelPoint, StripeAxis};

/// Decimals of pixels, millimetres, PSR and NIS.
const PX: usize = 3;
const MM: usize = 4;
const PSR: usize = 3;
const NIS: usize = 4;

/// What the tracker knew about the seam in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The seam has not been found yet.
    Seeking,
    /// The seam was seen.
    Tracked,
    /// The seam was not seen; the value is a prediction with a growing σ.
    Coasting,
    /// The seam was lost; no value is given.
    Lost,
    /// The frame could not be decoded.
    Unreadable,
}

impl Status {
    /// Whether a frame of this status has a value.
    #[must_use]
    pub const fn has_value(self) -> bool {
        matches!(self, Self::Tracked | Self::Coasting)
    }

    /// The name used in `path.csv`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Seeking => "seeking",
            Self::Tracked => "tracked",
            Self::Coasting => "coasting",
            Self::Lost => "lost",
            Self::Unreadable => "unreadable",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A cell of `path.csv`.
trait Cell: Sized {
    /// What stands for no value.
    const EMPTY: Self;
    /// Its text; a number with `decimals` decimals.
    fn text(&self, decimals: usize) -> String;
    /// Its number, if it holds one; 0 or 1 of a boolean.
    fn number(&self) -> Option<f64>;
    /// As its text says it.
    fn rounded(self, decimals: usize) -> Self;
}

impl Cell for Option<f64> {
    const EMPTY: Self = None;
    fn text(&self, decimals: usize) -> String {
        self.map_or(String::new(), |value| fixed(value, decimals))
    }
    fn number(&self) -> Option<f64> {
        *self
    }
    fn rounded(self, decimals: usize) -> Self {
        self.map(|value| written(value, decimals))
    }
}

impl Cell for bool {
    const EMPTY: Self = false;
    fn text(&self, _: usize) -> String {
        u8::from(*self).to_string()
    }
    fn number(&self) -> Option<f64> {
        Some(f64::from(u8::from(*self)))
    }
    fn rounded(self, _: usize) -> Self {
        self
    }
}

impl Cell for Option<bool> {
    const EMPTY: Self = None;
    fn text(&self, _: usize) -> String {
        self.map_or(String::new(), |flag| u8::from(flag).to_string())
    }
    fn number(&self) -> Option<f64> {
        self.map(|flag| f64::from(u8::from(flag)))
    }
    fn rounded(self, _: usize) -> Self {
        self
    }
}

/// Makes [`PathRow`], its columns in their order, and what walks over its cells.
macro_rules! path_row {
    ($($(#[$attribute:meta])* $name:ident: $kind:ty, $decimals:expr;)*) => {
        /// One row of `path.csv`.
        #[derive(Debug, Clone, PartialEq, Deserialize)]
        pub struct PathRow {
            /// Number of the frame, from 0 in processing order.
            pub frame: usize,
            /// Name of the frame's file; `name[number]` for a page or a picture of a video.
            pub file: String,
            /// Time stamp \[s\].
            pub time_s: f64,
            /// What the tracker knew.
            pub status: Status,
            $($(#[$attribute])* pub $name: $kind,)*
        }

        /// The columns of the contract, in order, then those added since.
        pub(super) const COLUMNS: &[&str] = &["frame", "file", "time_s", "status", $(stringify!($name)),*];

        impl PathRow {
            /// A row without any value.
            #[must_use]
            pub const fn empty(frame: usize, file: String, time_s: f64, status: Status) -> Self {
                Self { frame, file, time_s, status, $($name: <$kind as Cell>::EMPTY),* }
            }

            pub(super) fn cells(&self, time_decimals: usize) -> Vec<String> {
                vec![
                    self.frame.to_string(),
                    self.file.clone(),
                    fixed(self.time_s, time_decimals),
                    self.status.name().to_owned(),
                    $(self.$name.text($decimals)),*
                ]
            }

            pub(super) fn numbers(&self) -> impl Iterator<Item = f64> {
                self.values().into_iter().flatten().chain([self.time_s])
            }

            /// The columns behind `status`, in order.
            pub const VALUE_COLUMNS: &'static [&'static str] = &[$(stringify!($name)),*];

            /// What stands in [`Self::VALUE_COLUMNS`]; booleans are 0 or 1.
            #[must_use]
            pub fn values(&self) -> [Option<f64>; Self::VALUE_COLUMNS.len()] {
                [$(self.$name.number()),*]
            }

            /// The row as it is read back from `path.csv`.
            pub(super) fn rounded(self, time_decimals: usize) -> Self {
                Self {
                    time_s: written(self.time_s, time_decimals),
                    $($name: self.$name.rounded($decimals),)*
                    ..self
                }
            }
        }
    };
}

path_row! {
    /// The KCF's own peak, column \[px\].
    kcf_u_px: Option<f64>, PX;
    /// The KCF's own peak, row \[px\].
    kcf_v_px: Option<f64>, PX;
    /// Raw peak-to-sidelobe ratio of the KCF response.
    psr: Option<f64>, PSR;
    /// The KCF template learned from this frame.
    #[serde(deserialize_with = "zero_or_one")]
    template_updated: bool, 0;
    /// Filtered seam centre, column \[px\]; empty unless tracked or coasting.
    u_px: Option<f64>, PX;
    /// Filtered seam centre, row \[px\].
    v_px: Option<f64>, PX;
    /// Filtered position along the stripe from the origin \[mm\]; with a calibration, in the laser's plane.
    x_mm: Option<f64>, MM;
    /// One σ of `x_mm` \[mm\], without the scale's or the calibration's own.
    x_std_mm: Option<f64>, MM;
    /// Normalised innovation squared of the observation.
    nis: Option<f64>, NIS;
    /// Smoothed seam centre, column \[px\].
    smooth_u_px: Option<f64>, PX;
    /// Smoothed seam centre, row \[px\].
    smooth_v_px: Option<f64>, PX;
    /// Smoothed position along the stripe from the origin \[mm\].
    smooth_x_mm: Option<f64>, MM;
    /// One σ of `smooth_x_mm` \[mm\].
    smooth_x_std_mm: Option<f64>, MM;
    /// Gap of a butt joint, shadow of a lap joint, as measured in this frame, along the stripe \[px\].
    #[serde(default)]
    gap_px: Option<f64>, PX;
    /// The same \[mm\].
    #[serde(default)]
    gap_mm: Option<f64>, MM;
    /// By how much the stripe behind the seam has the larger coordinate across it \[px\].
    #[serde(default)]
    mismatch_px: Option<f64>, PX;
    /// Shoulder of a V-groove before the root, column \[px\].
    #[serde(default)]
    shoulder_before_u_px: Option<f64>, PX;
    /// Shoulder before the root, row \[px\].
    #[serde(default)]
    shoulder_before_v_px: Option<f64>, PX;
    /// Shoulder behind the root, column \[px\].
    #[serde(default)]
    shoulder_behind_u_px: Option<f64>, PX;
    /// Shoulder behind the root, row \[px\].
    #[serde(default)]
    shoulder_behind_v_px: Option<f64>, PX;
    /// Way of the torch since the first frame, where its speed is given \[mm\].
    #[serde(default)]
    travel_mm: Option<f64>, MM;
    /// With a calibration: the filtered seam in the laser's plane, along the stripe \[mm\].
    #[serde(default)]
    lateral_mm: Option<f64>, MM;
    /// The same towards the camera \[mm\].
    #[serde(default)]
    height_mm: Option<f64>, MM;
    /// One σ of `lateral_mm` \[mm\]: the noise of the pictures alone, which averages out over frames.
    #[serde(default)]
    lateral_std_mm: Option<f64>, MM;
    /// One σ of `height_mm` \[mm\], likewise.
    #[serde(default)]
    height_std_mm: Option<f64>, MM;
    /// One σ of `lateral_mm` \[mm\]: the calibration's error alone, the same in every frame.
    #[serde(default)]
    calib_lateral_std_mm: Option<f64>, MM;
    /// One σ of `height_mm` \[mm\], likewise.
    #[serde(default)]
    calib_height_std_mm: Option<f64>, MM;
    /// Whether the seam lies where stripes were seen when the sensor was calibrated.
    #[serde(default, deserialize_with = "empty_zero_or_one")]
    calibrated: Option<bool>, 0;
    /// One σ of `gap_mm` \[mm\], ragged edges included.
    #[serde(default)]
    gap_std_mm: Option<f64>, MM;
    /// Height of the plate behind the seam above that before it \[mm\].
    #[serde(default)]
    hi_lo_mm: Option<f64>, MM;
    /// One σ of it \[mm\].
    #[serde(default)]
    hi_lo_std_mm: Option<f64>, MM;
    /// Between a groove's shoulders \[mm\].
    #[serde(default)]
    groove_width_mm: Option<f64>, MM;
    /// One σ of it \[mm\].
    #[serde(default)]
    groove_width_std_mm: Option<f64>, MM;
    /// From a groove's plates down to where its flanks meet \[mm\].
    #[serde(default)]
    depth_mm: Option<f64>, MM;
    /// One σ of it \[mm\].
    #[serde(default)]
    depth_std_mm: Option<f64>, MM;
    /// Between a groove's flanks, or a fillet's legs \[°\].
    #[serde(default)]
    opening_angle_deg: Option<f64>, MM;
    /// One σ of it \[°\].
    #[serde(default)]
    opening_angle_std_deg: Option<f64>, MM;
    /// Between the plates at the root: a square butt joint's gap \[mm\].
    #[serde(default)]
    root_opening_mm: Option<f64>, MM;
    /// One σ of it \[mm\].
    #[serde(default)]
    root_opening_std_mm: Option<f64>, MM;
    /// Between a groove's flanks and its shoulders' line \[mm²\].
    #[serde(default)]
    area_mm2: Option<f64>, MM;
    /// One σ of it \[mm²\].
    #[serde(default)]
    area_std_mm2: Option<f64>, MM;
    /// One σ of the filtered position along the stripe \[px\].
    #[serde(default)]
    along_std_px: Option<f64>, PX;
    /// One σ of the smoothed position along the stripe \[px\].
    #[serde(default)]
    smooth_along_std_px: Option<f64>, PX;
}

impl PathRow {
    /// Whether there is a value: the filter's, or, before the seam was found, the smoother's.
    #[must_use]
    pub fn has_value(&self) -> bool {
        self.status.has_value() || (self.status == Status::Seeking && self.smooth_u_px.is_some())
    }

    /// The seam centre of one estimate.
    #[must_use]
    pub fn point(&self, estimate: Estimator) -> Option<PixelPoint> {
        let (u, v) = match estimate {
            Estimator::Kcf => (self.kcf_u_px, self.kcf_v_px),
            Estimator::Filtered => (self.u_px, self.v_px),
            Estimator::Smoothed => (self.smooth_u_px, self.smooth_v_px),
        };
        Some(PixelPoint::new(u?, v?))
    }

    /// One σ of one estimate along the stripe.
    #[must_use]
    pub const fn sigma(&self, estimate: Estimator, unit: LengthUnit) -> Option<f64> {
        match (estimate, unit) {
            (Estimator::Kcf, _) => None,
            (Estimator::Filtered, LengthUnit::Mm) => self.x_std_mm,
            (Estimator::Filtered, LengthUnit::Px) => self.along_std_px,
            (Estimator::Smoothed, LengthUnit::Mm) => self.smooth_x_std_mm,
            (Estimator::Smoothed, LengthUnit::Px) => self.smooth_along_std_px,
        }
    }

    /// The coordinate of one estimate along the stripe \[px\].
    #[must_use]
    pub fn along_px(&self, estimate: Estimator, axis: StripeAxis) -> Option<f64> {
        self.point(estimate).map(|point| axis.along_px(point))
    }
}

/// The three estimates of the seam centre in a row, in the order of the papers' tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    /// The KCF's own peak in this run.
    Kcf,
    /// The causal filter.
    Filtered,
    /// The smoother.
    Smoothed,
}

impl Estimator {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Kcf, Self::Filtered, Self::Smoothed];

    /// The name in tables and plots.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kcf => "KCF alone",
            Self::Filtered => "filtered",
            Self::Smoothed => "smoothed",
        }
    }
}

/// `value` with `decimals` decimals, without a negative zero.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| b == b'0' || b == b'.') => digits.to_owned(),
        _ => text,
    }
}

/// `value` as [`fixed`] writes it; a value that is no number stays as it is.
fn written(value: f64, decimals: usize) -> f64 {
    fixed(value, decimals).parse().unwrap_or(value)
}

fn zero_or_one<'de, D: Deserializer<'de>>(cell: D) -> Result<bool, D::Error> {
    match u8::deserialize(cell)? {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(serde::de::Error::custom(format!("expected 0 or 1, got {other}"))),
    }
}

fn empty_zero_or_one<'de, D: Deserializer<'de>>(cell: D) -> Result<Option<bool>, D::Error> {
    match Option::<u8>::deserialize(cell)? {
        None => Ok(None),
        Some(0) => Ok(Some(false)),
        Some(1) => Ok(Some(true)),
        Some(other) => Err(serde::de::Error::custom(format!("expected 0, 1 or nothing, got {other}"))),
    }
}
