//! The noise parameters of a model, from flags and TOML.

use std::path::Path;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use seamtrack::kalman::{ColouredMeasurement, ColouredProcess, ConstantVelocity, InvalidParameter, Width};
use serde::Deserialize;

/// Variance of a width whose mean absolute error is the 0.028 mm of Jiang 2016.
const JIANG_WIDTH_VARIANCE: f64 = 0.001_232;

/// Which paper's filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ModelKind {
    /// Constant velocity under white noise (Zhang 2009)
    White,
    /// Constant velocity under coloured measurement noise (Du 2022)
    ColouredMeasurement,
    /// Constant velocity under coloured process noise; z2 is the displacement (infrared paper)
    ColouredProcess,
    /// Measurement noise learnt while filtering; z2 is the change (Jiang 2016)
    Adaptive,
}

/// Noise parameters; what is left out is as printed in the model's paper. z is the unit of z1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Args, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Parameters {
    /// Variance of the random acceleration [z²/s⁴] (white, coloured-measurement, adaptive)
    #[arg(long, value_name = "VAR")]
    acceleration_variance: Option<f64>,
    /// Variance of the white measurement noise, R [z²] (white, coloured-measurement, adaptive)
    #[arg(long, value_name = "VAR")]
    white_variance: Option<f64>,
    /// Variance that drives the coloured measurement noise each period [z²] (coloured-measurement)
    #[arg(long, value_name = "VAR")]
    colour_drive_variance: Option<f64>,
    /// Coefficient of the coloured noise a period, -1 to 1 (coloured-measurement, coloured-process)
    #[arg(long, value_name = "PSI", allow_negative_numbers = true)]
    colour_coefficient: Option<f64>,
    /// Variance that drives the coloured acceleration [z²/frame⁴] (coloured-process)
    #[arg(long, value_name = "VAR")]
    drive_variance: Option<f64>,
    /// Variance of the measured position [z²] (coloured-process)
    #[arg(long, value_name = "VAR")]
    position_variance: Option<f64>,
    /// Variance of the measured displacement [z²] (coloured-process)
    #[arg(long, value_name = "VAR")]
    displacement_variance: Option<f64>,
    /// Period the coloured noise's numbers belong to [s]; default: the median time step (coloured-measurement,
    /// coloured-process)
    #[arg(long, value_name = "S")]
    period: Option<f64>,
}

impl Parameters {
    /// Reads a TOML file with the same names.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        toml::from_str(&text).map_err(|error| {
            let line = error.span().map_or(0, |span| text[..span.start].matches('\n').count()) + 1;
            anyhow::anyhow!("{}, line {line}: {}", path.display(), error.message())
        })
    }

    /// These, and where one is not given, the other's.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            acceleration_variance: self.acceleration_variance.or(other.acceleration_variance),
            white_variance: self.white_variance.or(other.white_variance),
            colour_drive_variance: self.colour_drive_variance.or(other.colour_drive_variance),
            colour_coefficient: self.colour_coefficient.or(other.colour_coefficient),
            drive_variance: self.drive_variance.or(other.drive_variance),
            position_variance: self.position_variance.or(other.position_variance),
            displacement_variance: self.displacement_variance.or(other.displacement_variance),
            period: self.period.or(other.period),
        }
    }

    /// Refuses a parameter the model does not have.
    pub fn check_belong_to(&self, model: ModelKind) -> anyhow::Result<()> {
        use ModelKind::{Adaptive, ColouredMeasurement, ColouredProcess, White};
        let uses: [(&str, Option<f64>, &[ModelKind]); 8] = [
            ("acceleration-variance", self.acceleration_variance, &[White, ColouredMeasurement, Adaptive]),
            ("white-variance", self.white_variance, &[White, ColouredMeasurement, Adaptive]),
            ("colour-drive-variance", self.colour_drive_variance, &[ColouredMeasurement]),
            ("colour-coefficient", self.colour_coefficient, &[ColouredMeasurement, ColouredProcess]),
            ("drive-variance", self.drive_variance, &[ColouredProcess]),
            ("position-variance", self.position_variance, &[ColouredProcess]),
            ("displacement-variance", self.displacement_variance, &[ColouredProcess]),
            ("period", self.period, &[ColouredMeasurement, ColouredProcess]),
        ];
        for (name, value, models) in uses {
            if value.is_some() && !models.contains(&model) {
                bail!("the chosen model has no {name}: leave it out");
            }
        }
        Ok(())
    }

    /// Zhang's model.
    pub fn white(&self) -> Result<ConstantVelocity, InvalidParameter> {
        let printed = ConstantVelocity::printed();
        ConstantVelocity::new(
            self.acceleration_variance.unwrap_or(printed.acceleration_variance_mm2_s4()),
            self.white_variance.unwrap_or(printed.white_variance_mm2()),
        )
    }

    /// Du's model; `period_s` where none is given.
    pub fn coloured_measurement(&self, period_s: f64) -> Result<ColouredMeasurement, InvalidParameter> {
        let printed = ColouredMeasurement::printed();
        ColouredMeasurement::new(
            self.acceleration_variance.unwrap_or(printed.acceleration_variance_px2_s4()),
            self.colour_drive_variance.unwrap_or(printed.colour_drive_variance_px2()),
            self.colour_coefficient.unwrap_or(printed.colour_coefficient()),
            self.white_variance.unwrap_or(printed.white_variance_px2()),
            self.period.unwrap_or(period_s),
        )
    }

    /// The infrared paper's model; `period_s` where none is given.
    pub fn coloured_process(&self, period_s: f64) -> Result<ColouredProcess, InvalidParameter> {
        let [q, colour, position, displacement] = ColouredProcess::printed().noise();
        ColouredProcess::new(
            self.drive_variance.unwrap_or(q),
            self.colour_coefficient.unwrap_or(colour),
            self.position_variance.unwrap_or(position),
            self.displacement_variance.unwrap_or(displacement),
            self.period.unwrap_or(period_s),
        )
    }

    /// Jiang's model.
    pub fn width(&self) -> Result<Width, InvalidParameter> {
        Width::new(
            self.acceleration_variance.unwrap_or(Width::ACCELERATION_VARIANCE_MM2_S4),
            self.white_variance.unwrap_or(JIANG_WIDTH_VARIANCE),
        )
    }
}
