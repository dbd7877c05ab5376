//! `seamtrack eval`: a path against a truth.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use seamtrack::calib::{Ruler, Sensor};
use seamtrack::eval::{Errors, PlaneErrors, read_truth};
use seamtrack::report::results::{Estimator, read_path_csv};
use seamtrack::report::summary::{ErrorTable, read_summary};
use seamtrack::run::{error_table, plane_errors};
use seamtrack::units::{LengthUnit, MmPerPx, PixelPoint, StripeAxis};

use super::say;

/// Compare a path with a truth: errors along the stripe, in millimetres where a scale is known.
#[derive(Debug, Args)]
pub struct Eval {
    /// The path of a run, or its folder.
    #[arg(value_name = "path.csv|DIR")]
    path: PathBuf,
    /// The truth: frame,u_px,v_px,x_mm,occluded; the coordinate along the stripe suffices.
    #[arg(value_name = "truth.csv")]
    truth: PathBuf,
    /// Scale in mm/px, instead of the one in the summary.json beside the path.
    #[arg(long, allow_negative_numbers = true)]
    mm_per_px: Option<MmPerPx>,
    /// How the stripe runs, instead of what stands in the summary.json beside the path.
    #[arg(long)]
    stripe: Option<Stripe>,
    /// Print the errors as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Stripe {
    Horizontal,
    Vertical,
}

impl Eval {
    /// Prints the errors.
    pub fn run(&self) -> Result<ExitCode> {
        let rows = read_path_csv(&self.path())?;
        let truth = read_truth(&self.truth)?;
        let ruler = self.ruler()?;
        let axis = ruler.axis;
        let summary = read_summary(&self.path().with_file_name("summary.json"));
        let first_frame = summary.map_or(0, |summary| summary.input.first_frame());
        let Ok(Some(table)) = error_table(&rows, (&truth, first_frame), &ruler) else {
            bail!(
                "{} gives no position along the {axis} stripe for any frame of {}; check --stripe",
                self.truth.display(),
                self.path.display()
            );
        };
        let plane = plane_errors(&rows, (&truth, first_frame));
        if self.json {
            let mut json = serde_json::to_value(table)?;
            if let (Some(plane), Some(object)) = (plane, json.as_object_mut()) {
                object.insert("plane".into(), serde_json::to_value(plane)?);
            }
            say::print(&(serde_json::to_string_pretty(&json)? + "\n"))?;
        } else {
            say::print(&(text_of(&table, ruler.unit()) + &plane.as_ref().map(text_of_plane).unwrap_or_default()))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn path(&self) -> PathBuf {
        if self.path.is_dir() { self.path.join("path.csv") } else { self.path.clone() }
    }

    /// What measures: the options, or what the summary beside the path says.
    fn ruler(&self) -> Result<Ruler> {
        let axis = self.stripe.map(|stripe| match stripe {
            Stripe::Horizontal => StripeAxis::Horizontal,
            Stripe::Vertical => StripeAxis::Vertical,
        });
        let origin = PixelPoint::new(0.0, 0.0);
        if let (Some(scale), Some(axis)) = (self.mm_per_px, axis) {
            return Ok(Ruler { sensor: Sensor::Scale(scale), axis, origin });
        }
        let file = self.path().with_file_name("summary.json");
        let calibration = read_summary(&file)
            .context("the run's scale and axis are not known; give --mm-per-px and --stripe")?
            .calibration;
        let sensor = self.mm_per_px.map_or_else(|| calibration.sensor(), Sensor::Scale);
        Ok(Ruler { sensor, axis: axis.unwrap_or(calibration.stripe), origin })
    }
}

fn text_of(table: &ErrorTable, unit: LengthUnit) -> String {
    let mut text = format!(
        "error in {unit}   mean abs     max  std abs    rmse     p95    bias  in 2σ  frames  wrong  unavailable\n"
    );
    for (name, estimator) in
        [("KCF", Estimator::Kcf), ("filtered", Estimator::Filtered), ("smoothed", Estimator::Smoothed)]
    {
        if let Some(errors) = table.of(estimator) {
            text += &line(name, errors);
            text.push('\n');
        }
    }
    if table == &ErrorTable::default() {
        text += "no frame has both a value and a truth\n";
    }
    text
}

fn text_of_plane(plane: &PlaneErrors) -> String {
    let mut text = "in the plane   mean abs     max    bias  calib. σ  scatter  noise σ  in 2σ  frames\n".to_owned();
    for (name, e) in [("lateral", &plane.lateral), ("height", &plane.height)] {
        let calib = e.calib_std_mm.map_or_else(|| "–".to_owned(), |std| format!("{std:.3}"));
        text += &format!(
            "{name:13} {:9.3} {:7.3} {:7.3} {calib:>9} {:8.3} {:8.3} {:4.0} % {:7}\n",
            e.mae_mm,
            e.max_mm,
            e.bias_mm,
            e.scatter_mm,
            e.noise_std_mm,
            100.0 * e.scatter_in_2sigma,
            e.frames
        );
    }
    text
}

fn line(name: &str, e: &Errors) -> String {
    let coverage = e.coverage_2sigma.map_or_else(|| "–".to_owned(), |share| format!("{:.0} %", 100.0 * share));
    format!(
        "{name:12} {:9.3} {:7.3} {:8.3} {:7.3} {:7.3} {:7.3} {coverage:>6} {:7} {:6} {:12}",
        e.mae, e.max, e.std, e.rmse, e.p95, e.bias, e.frames, e.wrong_frames, e.unavailable_frames
    )
}
