//! `seamtrack eval`: a path against a truth.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use seamtrack::eval::{Errors, read_truth};
use seamtrack::report::results::{Estimator, read_path_csv};
use seamtrack::report::summary::{Calibration, ErrorTable, read_summary};
use seamtrack::run::error_table;
use seamtrack::units::{MmPerPx, StripeAxis};

use super::say;

/// Compare a path with a truth: errors in millimetres along the stripe.
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
        let (scale, axis) = self.scale_and_axis()?;
        let summary = read_summary(&self.path().with_file_name("summary.json"));
        let first_frame = summary.map_or(0, |summary| summary.input.first_frame());
        let Some(table) = error_table(&rows, (&truth, first_frame), axis, scale) else {
            bail!(
                "{} gives no position along the {axis} stripe for any frame of {}; check --stripe",
                self.truth.display(),
                self.path.display()
            );
        };
        if self.json {
            say::print(&(serde_json::to_string_pretty(&table)? + "\n"))?;
        } else {
            say::print(&text_of(&table))?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn path(&self) -> PathBuf {
        if self.path.is_dir() { self.path.join("path.csv") } else { self.path.clone() }
    }

    fn scale_and_axis(&self) -> Result<(MmPerPx, StripeAxis)> {
        let axis = self.stripe.map(|stripe| match stripe {
            Stripe::Horizontal => StripeAxis::Horizontal,
            Stripe::Vertical => StripeAxis::Vertical,
        });
        if let (Some(scale), Some(axis)) = (self.mm_per_px, axis) {
            return Ok((scale, axis));
        }
        let file = self.path().with_file_name("summary.json");
        let Calibration { mm_per_px, stripe, .. } = read_summary(&file)
            .context("the run's scale and axis are not known; give --mm-per-px and --stripe")?
            .calibration;
        Ok((self.mm_per_px.unwrap_or(mm_per_px), axis.unwrap_or(stripe)))
    }
}

fn text_of(table: &ErrorTable) -> String {
    let mut text =
        "error in mm   mean abs     max  std abs    rmse     p95    bias  in 2σ  frames  wrong  unavailable\n"
            .to_owned();
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

fn line(name: &str, e: &Errors) -> String {
    let coverage = e.coverage_2sigma.map_or_else(|| "–".to_owned(), |share| format!("{:.0} %", 100.0 * share));
    format!(
        "{name:12} {:9.3} {:7.3} {:8.3} {:7.3} {:7.3} {:7.3} {coverage:>6} {:7} {:6} {:12}",
        e.mae_mm, e.max_mm, e.std_mm, e.rmse_mm, e.p95_mm, e.bias_mm, e.frames, e.wrong_frames, e.unavailable_frames
    )
}
