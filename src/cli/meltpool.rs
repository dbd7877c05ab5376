//! `seamtrack meltpool`: the tip or the width of a molten pool, frame by frame.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use seamtrack::meltpool::{Measure, Noise};
use seamtrack::output::{Existing, WholeFolder};
use seamtrack::report::atomic::write_atomically;
use seamtrack::report::overlay::OverlayWriter;
use seamtrack::report::pool::{
    PoolCalibration, PoolErrors, PoolInput, PoolSummary, PoolVerdict, SENSOR, draw, pool_verdict, write_pool_csv,
    write_pool_report, write_pool_summary,
};
use seamtrack::report::results::{PathRow, Status};
use seamtrack::report::summary::SCHEMA_VERSION;
use seamtrack::report::thumbnails::{DEFAULT_BUDGET_BYTES, ThumbnailStore};
use seamtrack::report::verdict::Trust;
use seamtrack::run::meltpool::{PoolOutcome, PoolSettings, measure_pool};
use seamtrack::source::{IntensitySource, Period, SizeCheck, open_intensity};
use seamtrack::units::{MmPerPx, Travel};
use serde_json::json;

use super::calibrate::parse_finite;
use super::drawing::Drawing;
use super::places::{self, Places};
use super::recordings::name_of;
use super::say;
use super::signals::wait_if_ending;
use super::track::{exit_code, parse_percentage};
use super::troubles::Troubles;
use super::truth::PoolTruth;

/// Where the infrared paper's beam lies, equation (1) \[px\].
const INFRARED_ZERO_PX: f64 = 268.0;
/// Time between frames of the infrared paper and of Jiang 2016 \[s\].
const TIP_PERIOD_S: f64 = 1e-3;
const WIDTH_PERIOD_S: f64 = 0.1;

/// Measure the tip of a molten pool, where the seam is, or its width
#[derive(Debug, Args)]
pub struct Meltpool {
    /// Folders of images (png, jpg, bmp, tif), NumPy stacks (frames, rows, columns), multi-page TIFFs, videos or MCAP logs
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// What to measure
    #[arg(long)]
    measure: PoolMeasure,
    /// Folder for the results; one folder a recording in it when there are several [default: results/<name>]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Where the torch travels to in the picture
    #[arg(long, default_value = "up")]
    travel: TravelTo,
    /// Level between pool and surroundings: otsu (found in each frame), or a value of the recording
    #[arg(long, value_name = "otsu|VALUE", default_value = "otsu", value_parser = parse_threshold, allow_negative_numbers = true)]
    threshold: Level,
    /// Scale across the travel; the default is the infrared paper's 1/114
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    mm_per_px: Option<MmPerPx>,
    /// Coordinate across the travel where the tip's offset is 0
    #[arg(long, value_name = "PX", default_value_t = INFRARED_ZERO_PX, value_parser = parse_finite, allow_negative_numbers = true)]
    zero: f64,
    /// Time from frame to frame [s], for recordings without time stamps [default: a video's own frame rate, else 0.001 for
    /// a tip, 0.1 for a width]
    #[arg(long, value_name = "S", value_parser = parse_period)]
    period: Option<f64>,
    /// The filter's noise levels: fitted to the recording, or the papers' own
    #[arg(long, default_value = "fit")]
    noise: NoiseFrom,
    /// The truth (frame, u_px, v_px of the tip; width_px): errors are reported
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Also draw the recording with what was measured: a folder of PNG files, or a video
    #[arg(long, value_name = "DIR|FILE.mp4")]
    overlay: Option<PathBuf>,
    /// Also write trace.csv: in each frame why its value was not taken, and where it was measured
    #[arg(long)]
    trace: bool,
    /// Most frames that may be without a value; above it the verdict is BAD
    #[arg(long, value_name = "PCT", default_value_t = 5.0, value_parser = parse_percentage)]
    max_unavailable: f64,
    /// Overwrite existing results
    #[arg(long)]
    force: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PoolMeasure {
    /// The corner at the pool's front: the seam, and its offset from the beam
    Tip,
    /// The longest cut across the travel
    Width,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TravelTo {
    Up,
    Down,
    Left,
    Right,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum NoiseFrom {
    /// Scatter and motion of the recording itself
    Fit,
    /// As printed, whatever the recording
    Paper,
}

/// One recording to measure.
struct Job<'a> {
    input: &'a Path,
    output: PathBuf,
    overlay: Option<PathBuf>,
}

/// A fixed level, or Otsu's.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Level(Option<f64>);

impl Meltpool {
    /// Measures every recording; the worst exit code wins.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let several = self.inputs.len() > 1;
        if several && self.truth.is_some() {
            bail!("--truth belongs to one recording: measure them one by one");
        }
        let jobs: Vec<Job<'_>> = self.inputs.iter().map(|input| self.job(input)).collect();
        let all: Vec<Places<'_>> = jobs.iter().map(|job| self.places(job)).collect();
        places::check(&all, &[], Existing::forced(self.force))?;
        if let [job] = jobs.as_slice() {
            let (is_bad, text) = self.measure_one(job)?;
            say::print(&text).context("the results are written, but")?;
            return Ok(exit_code(is_bad));
        }
        let (mut failed, mut any_bad, mut printed) = (0, false, Ok(()));
        for job in &jobs {
            match self.measure_one(job) {
                Ok((is_bad, text)) => {
                    any_bad |= is_bad;
                    printed = printed.and(say::print(&text));
                }
                Err(error) => {
                    wait_if_ending();
                    say::tell(&say::one_line(error.as_ref()));
                    failed += 1;
                }
            }
        }
        if failed > 0 {
            bail!("{failed} of {} recordings failed; the others have their results", jobs.len());
        }
        printed.context("the results are written, but")?;
        Ok(exit_code(any_bad))
    }

    fn places<'a>(&'a self, job: &'a Job<'_>) -> Places<'a> {
        let (truth, overlay) = (self.truth.as_deref(), job.overlay.as_deref());
        Places { input: job.input, truth, output: &job.output, overlay, mcap: None, is_done: false }
    }

    fn job<'a>(&self, input: &'a Path) -> Job<'a> {
        let (several, name) = (self.inputs.len() > 1, name_of(input));
        let within = |place: &PathBuf| if several { place.join(&name) } else { place.clone() };
        let output = self.output.as_ref().map_or_else(|| Path::new("results").join(&name), within);
        Job { input, output, overlay: self.overlay.as_ref().map(within) }
    }

    fn settings(&self) -> PoolSettings {
        let (measure, period_s) = match self.measure {
            PoolMeasure::Tip => (Measure::Tip, TIP_PERIOD_S),
            PoolMeasure::Width => (Measure::Width, WIDTH_PERIOD_S),
        };
        PoolSettings {
            measure,
            travel: match self.travel {
                TravelTo::Up => Travel::Up,
                TravelTo::Down => Travel::Down,
                TravelTo::Left => Travel::Left,
                TravelTo::Right => Travel::Right,
            },
            threshold: self.threshold.0,
            mm_per_px: self.mm_per_px.unwrap_or(MmPerPx::INFRARED),
            zero_px: if measure == Measure::Tip { self.zero } else { 0.0 },
            period_s: self.period.unwrap_or(period_s),
            noise: match self.noise {
                NoiseFrom::Fit => Noise::Fit,
                NoiseFrom::Paper => Noise::Paper,
            },
        }
    }

    /// Measures one recording: whether its verdict is BAD, and what there is to say.
    fn measure_one(&self, job: &Job<'_>) -> anyhow::Result<(bool, String)> {
        let input = job.input;
        let (settings, existing) = (self.settings(), Existing::forced(self.force));
        let truth = self.truth.as_deref().map(|file| PoolTruth::read(file, &settings)).transpose()?;
        let mut source = open_intensity(input, self.period(&settings))?;
        let settings = PoolSettings { period_s: source.period_s(), ..settings };
        let kind = source.kind();
        let mut troubles = Troubles::of(input);
        source.notes().iter().for_each(|note| troubles.note(note));
        let folder = WholeFolder::begin(&job.output, existing)?;
        let mut thumbnails = ThumbnailStore::new(DEFAULT_BUDGET_BYTES, source.frame_count());
        let outcome = measure_pool(&mut *source, &settings, |seen| match seen.picture {
            Err(error) => troubles.unreadable(seen.frame, error),
            Ok(to_gray) => {
                let status = if seen.is_measured { Status::Tracked } else { Status::Coasting };
                let row = PathRow::empty(seen.frame, String::new(), 0.0, status);
                thumbnails.offer(&row, &to_gray(), &seen.marks.to_frame_marks());
            }
        });
        troubles.end();
        let outcome = outcome.with_context(|| input.display().to_string())?;
        let errors = truth.as_ref().map(|truth| truth.errors(&outcome, settings.mm_per_px)).transpose()?;
        write_pool_csv(&folder.path().join("path.csv"), &outcome.rows)?;
        let summary = self.summary(input, kind, &settings, &outcome, errors)?;
        write_pool_summary(&folder.path().join("summary.json"), &summary)?;
        if let Some(truth) = &truth {
            truth.keep_copy(folder.path())?;
        }
        if self.trace {
            write_trace(&folder.path().join("trace.csv"), &outcome)?;
        }
        thumbnails.write(folder.path())?;
        write_pool_report(folder.path())?;
        match &job.overlay {
            None => folder.finish()?,
            Some(overlay) => {
                let place = Drawing::begin(overlay, &folder, existing)?;
                let writer = draw_overlay(source.again()?, place.path(), settings.period_s, &outcome)?;
                place.finish(writer, folder)?;
            }
        }
        let verdict = pool_verdict(&summary, &outcome.rows);
        let mut said = String::new();
        if !self.quiet {
            said = text(&outcome, &summary, &verdict);
            said += &format!("results: {}\n", say::shown(&job.output.join("report.html")));
        }
        Ok((verdict.trust == Trust::Bad, said))
    }

    /// The user's time between frames, else a video's own, else the paper's.
    const fn period(&self, settings: &PoolSettings) -> Period {
        match self.period {
            Some(period_s) => Period::Given(period_s),
            None => Period::OwnOr(settings.period_s),
        }
    }

    fn summary(
        &self,
        input: &Path,
        kind: &str,
        settings: &PoolSettings,
        outcome: &PoolOutcome,
        errors: Option<PoolErrors>,
    ) -> anyhow::Result<PoolSummary> {
        Ok(PoolSummary {
            schema_version: SCHEMA_VERSION,
            program: format!("seamtrack {}", env!("CARGO_PKG_VERSION")),
            sensor: SENSOR.into(),
            input: PoolInput {
                path: input.to_string_lossy().into_owned(),
                width_px: outcome.size_px.0,
                height_px: outcome.size_px.1,
                kind: kind.into(),
                scale: serde_json::to_value(outcome.scale)?,
            },
            config: serde_json::to_value(settings)?,
            calibration: PoolCalibration {
                mm_per_px: settings.mm_per_px,
                zero_px: settings.zero_px,
                assumed: self.mm_per_px.is_none(),
            },
            noise: json!({
                "measurement_px2": outcome.noise.measurement_px2,
                "drive": outcome.noise.drive,
                "drive_unit": match settings.measure { Measure::Tip => "px2/frame4", Measure::Width => "px2/s4" },
                "from": if outcome.noise_is_fitted { "the recording" } else { "the paper" },
            }),
            frames: outcome.counts,
            refused: outcome.refused(),
            max_unavailable_pct: self.max_unavailable,
            timing: outcome.timing,
            errors,
        })
    }
}

/// Reads the recording a second time and draws the finished path into it.
fn draw_overlay(
    mut source: Box<dyn IntensitySource>,
    target: &Path,
    period_s: f64,
    outcome: &PoolOutcome,
) -> anyhow::Result<OverlayWriter> {
    let mut writer = OverlayWriter::create(target, 1.0 / period_s)?;
    let mut sizes = SizeCheck::default();
    for ((row, marks), refusal) in outcome.rows.iter().zip(&outcome.marks).zip(&outcome.refusals) {
        let Some(frame) = source.next_frame() else { break };
        if let Ok(picture) = sizes.admit_intensity(frame).picture {
            let note = refusal.map_or("", |refusal| refusal.name());
            draw(&mut writer, &picture.to_gray(), row, marks, note)?;
        }
    }
    writer.complete()?;
    Ok(writer)
}

fn write_trace(path: &Path, outcome: &PoolOutcome) -> anyhow::Result<()> {
    write_atomically(path, |file| {
        let mut csv = csv::Writer::from_writer(file);
        csv.write_record(["frame", "refused", "u1_px", "v1_px", "u2_px", "v2_px"])?;
        for ((row, refusal), marks) in outcome.rows.iter().zip(&outcome.refusals).zip(&outcome.marks) {
            let places = marks.measured.map(|[a, b]| [a.u_px, a.v_px, b.u_px, b.v_px]);
            let cell = |i: usize| places.map_or(String::new(), |places| format!("{:.3}", places[i]));
            let reason = refusal.map_or("", |refusal| refusal.name());
            csv.write_record([&row.frame.to_string(), reason, &cell(0), &cell(1), &cell(2), &cell(3)])?;
        }
        csv.flush()
    })?;
    Ok(())
}

fn text(outcome: &PoolOutcome, summary: &PoolSummary, verdict: &PoolVerdict) -> String {
    let mut text = format!("{} {}\n", verdict.trust.word().to_uppercase(), verdict.sentence);
    for doubt in &verdict.doubts {
        text += &format!("  {doubt}\n");
    }
    for (reason, frames) in outcome.refused() {
        text += &format!("  not taken, {reason}: {frames}\n");
    }
    let from = if outcome.noise_is_fitted { "the recording" } else { "the paper" };
    text += &format!("  one measurement scatters by {:.3} px ({from})\n", outcome.noise.measurement_px2.sqrt());
    if let Some(errors) = &summary.errors {
        for (name, errors) in
            [("measured", errors.measured), ("filtered", errors.filtered), ("smoothed", errors.smoothed)]
        {
            if let Some(e) = errors {
                text += &format!("  {name}: mean absolute error {:.4} mm, largest {:.4} mm\n", e.mae, e.max);
            }
        }
    }
    text
}

fn parse_threshold(text: &str) -> Result<Level, String> {
    if text == "otsu" {
        return Ok(Level(None));
    }
    parse_finite(text).map(|value| Level(Some(value))).map_err(|_| "expected otsu, or a value of the recording".into())
}

fn parse_period(text: &str) -> Result<f64, String> {
    parse_finite(text)
        .ok()
        .filter(|&period_s| period_s > 0.0)
        .ok_or_else(|| "expected a time above 0 in seconds".into())
}
