//! The configuration: one TOML file, validated into settings that cannot be wrong.
//!
//! `seamtrack config --print` shows every key with its default.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::calib::KnownSensor;
use crate::imgproc::MedianKernel;
use crate::imgproc::geometry::JointKind;
use crate::kalman::smoother::LONGEST_LAG;
use crate::kalman::{ColouredMeasurement, InvalidParameter};
use crate::kcf::{Kcf, KcfError, KcfSettings};
use crate::tracker::{Method, PaperSettings, RobustSettings};
use crate::units::{MmPerPx, PixelPoint, PixelRect, StripeAxis};

/// The sampling period that the printed noise numbers belong to \[s\]; other time steps are derived from it.
const DU_2022_PERIOD_S: f64 = 0.2;

/// Which pipeline follows the seam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Stripe geometry, KCF and interacting models.
    Robust,
    /// The method of Du 2022, as printed.
    Paper,
}

/// The joint to follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Joint {
    /// Found from the frames.
    Auto,
    /// Butt joint.
    Butt,
    /// Lap joint.
    Lap,
    /// V-groove.
    Vgroove,
    /// Fillet or corner joint.
    Fillet,
}

impl Joint {
    /// The kind, where it is given.
    #[must_use]
    pub const fn kind(self) -> Option<JointKind> {
        match self {
            Self::Auto => None,
            Self::Butt => Some(JointKind::Butt),
            Self::Lap => Some(JointKind::Lap),
            Self::Vgroove => Some(JointKind::VGroove),
            Self::Fillet => Some(JointKind::Fillet),
        }
    }
}

/// Which way the stripe runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Stripe {
    /// Found from the first frame that shows one.
    Auto,
    /// Along the rows.
    Horizontal,
    /// Along the columns.
    Vertical,
}

impl Stripe {
    /// The axis, where it is given.
    #[must_use]
    pub const fn axis(self) -> Option<StripeAxis> {
        match self {
            Self::Auto => None,
            Self::Horizontal => Some(StripeAxis::Horizontal),
            Self::Vertical => Some(StripeAxis::Vertical),
        }
    }
}

/// The whole configuration. Unknown keys are refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Which pipeline follows the seam.
    pub preset: Preset,
    /// The joint to follow.
    pub joint: Joint,
    /// Which way the stripe runs.
    pub stripe: Stripe,
    /// Time from frame to frame \[s\], where the recording has no time stamps. Du 2022: 0.2.
    pub period_s: f64,
    /// Scale along the stripe \[mm/px\]; without one lengths stay pixels. The preset paper has that of Du 2022: 0.073.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mm_per_px: Option<MmPerPx>,
    /// Where the seam is in the first frame \[px\], u and v in the image; found by the seed when it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed_at: Option<[f64; 2]>,
    /// The part of the picture that is looked at \[px\]: first column and row, columns and rows; all of it when it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roi: Option<[usize; 4]>,
    /// Frames that the smoother may look ahead, at most 1000; the whole recording when it is not given. Preset robust only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixed_lag: Option<usize>,
    /// Travel speed of the torch \[mm/s\], for the column travel_mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_mm_s: Option<f64>,
    /// The method of Du 2022.
    pub paper: PaperConfig,
}

/// The numbers of Du 2022.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PaperConfig {
    /// Side of the median \[px\]: 1 (off), 3 or 5.
    pub median_px: u8,
    /// KCF window \[px\], width and height: ROI 80 × 60 times padding 2.5.
    pub window_px: [usize; 2],
    /// SD of the KCF's label \[px\]: 0.1·√(80·60).
    pub label_sd_px: f64,
    /// Bandwidth σ of the Gaussian kernel, grey in \[0,1\].
    pub kernel_sigma: f64,
    /// Regularisation λ.
    pub lambda: f64,
    /// Learning rate η (eq. 8), 0 to 1.
    pub learning_rate: f64,
    /// The template learns at this PSR or above (section 3.3). Belongs to the window and the label.
    pub psr_threshold: f64,
    /// Variance of the random acceleration ω \[px²/s⁴\].
    pub acceleration_variance_px2_s4: f64,
    /// Variance of ξ, which drives the coloured noise \[px²\].
    pub colour_drive_variance_px2: f64,
    /// ψ, the coloured noise's correlation from one period to the next, −1 to 1.
    pub colour_coefficient: f64,
    /// R, variance of the white measurement noise \[px²\].
    pub white_variance_px2: f64,
    /// Variance of the velocity at the start \[px²/s²\]; it must cover the seam's slope.
    pub start_velocity_variance_px2_s2: f64,
    /// Variance of the seed's position \[px²\].
    pub seed_variance_px2: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            preset: Preset::Robust,
            joint: Joint::Auto,
            stripe: Stripe::Auto,
            period_s: 0.2,
            mm_per_px: None,
            seed_at: None,
            roi: None,
            fixed_lag: None,
            speed_mm_s: None,
            paper: PaperConfig::default(),
        }
    }
}

impl Default for PaperConfig {
    fn default() -> Self {
        let kcf = KcfSettings::du_2022();
        let paper = PaperSettings::default();
        Self {
            median_px: 5,
            window_px: [kcf.window_width_px, kcf.window_height_px],
            label_sd_px: kcf.label_sd_px,
            kernel_sigma: kcf.kernel_sigma,
            lambda: kcf.lambda,
            learning_rate: paper.learning_rate,
            psr_threshold: paper.psr_threshold,
            acceleration_variance_px2_s4: 0.01,
            colour_drive_variance_px2: 0.01,
            colour_coefficient: 0.5,
            white_variance_px2: 5.0,
            start_velocity_variance_px2_s2: 25.0,
            seed_variance_px2: paper.seed_variance_px2,
        }
    }
}

/// A configuration that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read the configuration {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is not TOML, or has a key or a type that is not known.
    #[error("{}: {problem}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Where and why.
        problem: String,
    },
    /// The configuration cannot be written as JSON.
    #[error("the configuration cannot be written into the summary")]
    Json(#[from] serde_json::Error),
    /// A number is out of its range.
    #[error("the configuration's {key} must be {range}, not {value}")]
    Range {
        /// The key.
        key: &'static str,
        /// What is allowed.
        range: &'static str,
        /// What it is.
        value: f64,
    },
    /// The paper's method does not smooth.
    #[error("a fixed lag belongs to the preset robust: the method of the preset paper does not smooth")]
    LagWithoutSmoother,
    /// The KCF refuses its settings.
    #[error(transparent)]
    Kcf(#[from] KcfError),
    /// The Kalman filter refuses its noise.
    #[error(transparent)]
    Kalman(#[from] InvalidParameter),
}

impl Config {
    /// Reads a TOML file; keys that it leaves out keep their defaults.
    ///
    /// # Errors
    /// When the file cannot be read, is not TOML, or has an unknown key.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let text =
            std::fs::read_to_string(path).map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
        toml::from_str(&text)
            .map_err(|error| ConfigError::Parse { path: path.to_owned(), problem: error.to_string().trim().to_owned() })
    }

    /// Where the user says that the seam is.
    #[must_use]
    pub fn seed_at(&self) -> Option<PixelPoint> {
        self.seed_at.map(|[u_px, v_px]| PixelPoint::new(u_px, v_px))
    }

    /// The part of the picture that is looked at.
    #[must_use]
    pub fn roi(&self) -> Option<PixelRect> {
        self.roi.map(|[u_px, v_px, width_px, height_px]| PixelRect { u_px, v_px, width_px, height_px })
    }

    /// The scale that the configuration states, or that belongs to its preset.
    #[must_use]
    pub fn sensor(&self) -> KnownSensor {
        match (self.mm_per_px, self.preset) {
            (Some(mm_per_px), _) => KnownSensor::scale(mm_per_px, "one scale along the stripe"),
            (None, Preset::Paper) => KnownSensor::scale(MmPerPx::DU_2022, "the preset's: Du 2022"),
            (None, Preset::Robust) => KnownSensor::unknown(),
        }
    }

    /// The method that the configuration describes.
    ///
    /// # Errors
    /// When a number is out of its range.
    pub fn method(&self) -> Result<Method, ConfigError> {
        range("period_s", self.period_s, "between 0.00001 and 3600 s", (1e-5..=3600.0).contains(&self.period_s))?;
        if let Some([u_px, v_px]) = self.seed_at {
            range("seed_at", u_px, "a point of the image", u_px.is_finite() && u_px >= 0.0)?;
            range("seed_at", v_px, "a point of the image", v_px.is_finite() && v_px >= 0.0)?;
        }
        if let Some(roi) = self.roi() {
            let side = roi.width_px.min(roi.height_px) as f64;
            range("roi", side, "a part of at least 32 x 32 pixels", side >= LEAST_ROI_PX)?;
        }
        if let Some(speed) = self.speed_mm_s {
            range("speed_mm_s", speed, "a number from 0", speed.is_finite() && speed >= 0.0)?;
        }
        if let Some(lag) = self.fixed_lag {
            range("fixed_lag", lag as f64, "at most 1000 frames", lag <= LONGEST_LAG)?;
        }
        match self.preset {
            Preset::Paper if self.fixed_lag.is_some() => Err(ConfigError::LagWithoutSmoother),
            Preset::Paper => Ok(Method::Paper(self.paper.settings()?)),
            Preset::Robust => {
                Ok(Method::Robust(RobustSettings { joint: self.joint.kind(), ..RobustSettings::default() }))
            }
        }
    }
}

/// Least side of the part to look at \[px\]. Chosen: no stripe can be told from its background in less.
const LEAST_ROI_PX: f64 = 32.0;

fn range(key: &'static str, value: f64, range: &'static str, holds: bool) -> Result<(), ConfigError> {
    if holds { Ok(()) } else { Err(ConfigError::Range { key, range, value }) }
}

impl PaperConfig {
    fn settings(&self) -> Result<PaperSettings, ConfigError> {
        let median = match self.median_px {
            1 => MedianKernel::Off,
            3 => MedianKernel::Three,
            5 => MedianKernel::Five,
            other => return Err(ConfigError::Range { key: "median_px", range: "1, 3 or 5", value: other.into() }),
        };
        let rate = self.learning_rate;
        range("learning_rate", rate, "between 0 and 1", (0.0..=1.0).contains(&rate))?;
        let threshold = self.psr_threshold;
        range("psr_threshold", threshold, "a number from 0", threshold.is_finite() && threshold >= 0.0)?;
        let kcf = KcfSettings {
            window_width_px: self.window_px[0],
            window_height_px: self.window_px[1],
            label_sd_px: self.label_sd_px,
            kernel_sigma: self.kernel_sigma,
            lambda: self.lambda,
        };
        Kcf::new(kcf)?;
        let kalman = ColouredMeasurement::new(
            self.acceleration_variance_px2_s4,
            self.colour_drive_variance_px2,
            self.colour_coefficient,
            self.white_variance_px2,
            DU_2022_PERIOD_S,
        )?
        .with_velocity_variance(self.start_velocity_variance_px2_s2)?;
        kalman.start_from_clean(0.0, self.seed_variance_px2)?;
        Ok(PaperSettings {
            median,
            kcf,
            psr_threshold: self.psr_threshold,
            learning_rate: rate,
            kalman,
            seed_variance_px2: self.seed_variance_px2,
            ..PaperSettings::default()
        })
    }
}
