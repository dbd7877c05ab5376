//! `filter.csv` and `filter.json`.

use std::io::Write;
use std::path::Path;

use anyhow::bail;
use seamtrack::kalman::NoiseParameter;
use seamtrack::kalman::consistency::mean_band_999;
use seamtrack::report::atomic::write_atomically;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};

use super::measurements::Measurements;

/// The name of the table; its presence means that a folder holds results.
pub const CSV_NAME: &str = "filter.csv";
/// The name of the summary.
pub const JSON_NAME: &str = "filter.json";
/// Version of both; columns and keys may be added under the same one.
const SCHEMA_VERSION: u32 = 1;

/// What the filter says of one line of the input; empty cells where it says nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Row {
    /// Filtered position \[z\].
    #[serde(serialize_with = "nine_digits")]
    pub x: Option<f64>,
    /// One σ of it \[z\].
    #[serde(serialize_with = "nine_digits")]
    pub x_std: Option<f64>,
    /// Filtered velocity \[z/s\].
    #[serde(serialize_with = "nine_digits")]
    pub velocity: Option<f64>,
    /// One σ of it \[z/s\].
    #[serde(serialize_with = "nine_digits")]
    pub velocity_std: Option<f64>,
    /// z1 less its prediction \[z\].
    #[serde(serialize_with = "nine_digits")]
    pub innovation1: Option<f64>,
    /// z2 less its prediction \[z\].
    #[serde(serialize_with = "nine_digits")]
    pub innovation2: Option<f64>,
    /// Normalised innovation squared.
    #[serde(serialize_with = "nine_digits")]
    pub nis: Option<f64>,
    /// Weight of the measurement, below 1 where it was taken for an outlier.
    #[serde(serialize_with = "nine_digits")]
    pub weight: Option<f64>,
    /// Position given the later measurements too \[z\].
    #[serde(serialize_with = "nine_digits")]
    pub smooth_x: Option<f64>,
    /// One σ of it \[z\].
    #[serde(serialize_with = "nine_digits")]
    pub smooth_x_std: Option<f64>,
}

impl Row {
    const fn numbers(&self) -> [Option<f64>; 10] {
        [
            self.x,
            self.x_std,
            self.velocity,
            self.velocity_std,
            self.innovation1,
            self.innovation2,
            self.nis,
            self.weight,
            self.smooth_x,
            self.smooth_x_std,
        ]
    }
}

/// The result of one run.
pub struct Outcome {
    /// One row a line of the input.
    pub rows: Vec<Row>,
    /// The parameters used.
    pub parameters: Vec<NoiseParameter>,
    /// Log-likelihood of the series; none where the equations define none.
    pub log_likelihood: Option<f64>,
    /// Rows a complete measurement has.
    pub measured_rows: usize,
    /// What else is worth saying.
    pub more: Map<String, Value>,
}

impl Outcome {
    /// Refuses numbers that have left the range of floating point.
    pub fn check_finite(&self) -> anyhow::Result<()> {
        let first = self.rows.iter().position(|row| row.x.is_some()).unwrap_or(0);
        // The printed equations may lose a state; every other filter has one from its start on.
        let has_states = self.log_likelihood.is_some();
        for (line, row) in self.rows.iter().enumerate().skip(first) {
            let is_finite = row.numbers().into_iter().flatten().all(f64::is_finite);
            if !is_finite || (has_states && row.x.is_none()) {
                bail!("measurement {}: the filter's numbers overflow: give the series in a larger unit", line + 1);
            }
        }
        if self.log_likelihood.is_some_and(|likelihood| !likelihood.is_finite()) {
            bail!("the likelihood of the series overflows: give the series in a larger unit");
        }
        Ok(())
    }

    /// The summary as JSON; `run` says what was asked for.
    pub fn summary(&self, run: Map<String, Value>) -> Value {
        let nis: Vec<f64> = self.rows.iter().filter_map(|row| row.nis).collect();
        #[expect(clippy::cast_precision_loss, reason = "counts far below 2⁵²")]
        let mean = (!nis.is_empty()).then(|| nis.iter().sum::<f64>() / nis.len() as f64);
        let (low, high) = mean_band_999(nis.len(), self.measured_rows);
        let mut summary = Map::new();
        summary.insert("schema_version".into(), SCHEMA_VERSION.into());
        summary.insert("program".into(), concat!("seamtrack ", env!("CARGO_PKG_VERSION")).into());
        summary.extend(run);
        let parameters = self.parameters.iter().map(|p| (p.name.to_owned(), json!({"value": p.value, "unit": p.unit})));
        summary.insert("parameters".into(), Value::Object(parameters.collect()));
        summary.insert("log_likelihood".into(), json!(self.log_likelihood));
        let measured = self.rows.iter().filter(|row| row.nis.is_some()).count();
        let estimated = self.rows.iter().filter(|row| row.x.is_some()).count();
        let weakened = self.rows.iter().filter(|row| row.weight.is_some_and(|weight| weight < 1.0)).count();
        summary.insert(
            "lines".into(),
            json!({"total": self.rows.len(), "estimated": estimated, "updated": measured, "weakened": weakened}),
        );
        summary.insert("nis".into(), json!({"mean": mean, "consistent_band_999": [low, high]}));
        summary.extend(self.more.clone());
        Value::Object(summary)
    }
}

/// A cell with at most nine digits that say something, far finer than any σ.
#[expect(clippy::ref_option, reason = "serde hands over references")]
fn nine_digits<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    let rounded = value.map(|value| format!("{value:.8e}").parse().unwrap_or(value));
    rounded.serialize(serializer)
}

/// A parameter with seven digits: enough to give it back to the program, and to read.
pub fn digits(value: f64) -> String {
    let magnitude = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if (-4..7).contains(&magnitude) {
        let decimals = usize::try_from(6 - magnitude).unwrap_or(0);
        format!("{value:.decimals$}")
    } else {
        format!("{value:.6e}")
    }
}

/// The mean NIS and where it lies when the filter's σ are right.
pub fn nis_line(summary: &Value) -> String {
    let number = |value: &Value| value.as_f64().map_or_else(|| "none".to_owned(), |value| format!("{value:.3}"));
    let (nis, band) = (&summary["nis"], &summary["nis"]["consistent_band_999"]);
    format!("mean NIS {} (consistent within {} to {})\n", number(&nis["mean"]), number(&band[0]), number(&band[1]))
}

/// Writes both files, each complete or not at all.
pub fn write(folder: &Path, series: &Measurements, outcome: &Outcome, summary: &Value) -> anyhow::Result<()> {
    let z2 = |line: usize| series.z2.as_ref().and_then(|z2| z2[line]);
    write_atomically(&folder.join(CSV_NAME), |file| {
        let mut csv = csv::WriterBuilder::new().has_headers(false).from_writer(file);
        csv.write_record(["time_s", "z1", "z2", "x", "x_std", "velocity", "velocity_std"].iter().chain(&[
            "innovation1",
            "innovation2",
            "nis",
            "weight",
            "smooth_x",
            "smooth_x_std",
        ]))?;
        for (line, row) in outcome.rows.iter().enumerate() {
            csv.serialize((series.time_s[line], series.z1[line], z2(line), row))?;
        }
        csv.flush()
    })?;
    write_atomically(&folder.join(JSON_NAME), |file| {
        serde_json::to_writer_pretty(&mut *file, summary)?;
        file.write_all(b"\n")
    })?;
    Ok(())
}
