//! `seamtrack track`: recorded frames in, the seam path in millimetres out.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;
use seamtrack::calib::Origin;
use seamtrack::config::{Config, Joint, Preset, Stripe};
use seamtrack::eval::read_truth;
use seamtrack::report::export::{Exports, write_exports};
use seamtrack::report::overlay::OverlayWriter;
use seamtrack::report::results::write_path_csv;
use seamtrack::report::run::Run;
use seamtrack::report::summary::write_summary;
use seamtrack::report::terminal::{Colour, terminal_summary};
use seamtrack::report::thumbnails::{DEFAULT_BUDGET_BYTES, ThumbnailStore};
use seamtrack::report::trace::write_trace_csv;
use seamtrack::run::{RunOutcome, error_table};
use seamtrack::source::SizeCheck;
use seamtrack::units::{MmPerPx, PixelPoint};

/// Find the seam in each frame of a recording and estimate its path in millimetres
#[derive(Debug, Args)]
pub struct Track {
    /// Folders of images (png, jpg, bmp, tif), multi-page TIFFs or videos
    #[arg(required_unless_present = "manifest")]
    inputs: Vec<PathBuf>,
    /// Folder for the results; one folder a recording in it when there are several [default: results/<name>]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// More recordings: a CSV with the columns input[,truth]
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
    /// Recordings tracked at a time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    jobs: u16,
    /// Configuration (TOML); `seamtrack config --print` shows every key
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Pipeline
    #[arg(long)]
    preset: Option<Preset>,
    /// The joint to follow
    #[arg(long)]
    joint: Option<Joint>,
    /// Which way the stripe runs
    #[arg(long)]
    stripe: Option<Stripe>,
    /// The seam in the first frame, if you know better than the seed
    #[arg(long, value_name = "U,V", value_parser = parse_point)]
    seed_at: Option<PixelPoint>,
    /// Scale along the stripe
    #[arg(long, value_name = "MM")]
    mm_per_px: Option<MmPerPx>,
    /// Where x = 0 lies: first (the first tracked frame), centre (of the image), or a pixel
    #[arg(long, default_value = "first")]
    origin: Origin,
    /// Time from frame to frame [s], for recordings without time stamps
    #[arg(long, value_name = "S")]
    period: Option<f64>,
    /// Travel speed of the torch [mm/s], to write the way travelled into path.csv
    #[arg(long, value_name = "MM_PER_S")]
    speed: Option<f64>,
    /// The true path (frame,u_px,v_px,x_mm,occluded), to report errors against
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Also draw the recording with its marks: a folder of PNG files, or a video
    #[arg(long, value_name = "DIR|FILE.mp4")]
    overlay: Option<PathBuf>,
    /// Also write the paths as TUM trajectories (for evo)
    #[arg(long)]
    tum: bool,
    /// Exit with 3 when the seam is unavailable on more than this part of the frames
    #[arg(long, value_name = "PCT", default_value_t = 5.0, value_parser = parse_percentage)]
    max_unavailable: f64,
    /// Frames that the smoother may look ahead, as in a live run; the whole recording when it is not given
    #[arg(long, value_name = "FRAMES")]
    fixed_lag: Option<usize>,
    /// Also write trace.csv: what was measured in each frame and why it was accepted or refused
    #[arg(long)]
    trace: bool,
    /// Overwrite existing results
    #[arg(long)]
    force: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// One recording to track.
struct Job {
    input: PathBuf,
    output: PathBuf,
    truth: Option<PathBuf>,
}

impl Track {
    /// Tracks every recording; the worst exit code wins.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let config = self.effective_config()?;
        let jobs = self.job_list()?;
        for job in &jobs {
            refuse_to_overwrite(&job.output, self.force)?;
            refuse_to_draw_over(&job.input, self.overlay.as_deref())?;
        }
        if let [job] = jobs.as_slice() {
            let available = self.track_one(job, &config, true)?;
            return Ok(exit_code(available));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.jobs.into()).build()?;
        let results: Vec<anyhow::Result<bool>> =
            pool.install(|| jobs.par_iter().map(|job| self.track_one(job, &config, false)).collect());
        let mut failed = 0;
        let mut all_available = true;
        for (job, result) in jobs.iter().zip(results) {
            match result {
                Ok(available) => all_available &= available,
                Err(error) => {
                    eprintln!("seamtrack: {}: {}", job.input.display(), super::one_line(&error));
                    failed += 1;
                }
            }
        }
        if failed > 0 {
            bail!("{failed} of {} recordings failed; the others have their results", jobs.len());
        }
        Ok(exit_code(all_available))
    }

    fn effective_config(&self) -> anyhow::Result<Config> {
        let mut config = self.config.as_deref().map_or_else(|| Ok(Config::default()), read_config)?;
        config.preset = self.preset.unwrap_or(config.preset);
        config.joint = self.joint.unwrap_or(config.joint);
        config.stripe = self.stripe.unwrap_or(config.stripe);
        config.mm_per_px = self.mm_per_px.unwrap_or(config.mm_per_px);
        config.period_s = self.period.unwrap_or(config.period_s);
        config.speed_mm_s = self.speed.or(config.speed_mm_s);
        config.fixed_lag = self.fixed_lag.or(config.fixed_lag);
        config.seed_at = self.seed_at.map(|p| [p.u_px, p.v_px]).or(config.seed_at);
        config.method()?;
        Ok(config)
    }

    fn job_list(&self) -> anyhow::Result<Vec<Job>> {
        let mut inputs: Vec<(PathBuf, Option<PathBuf>)> =
            self.inputs.iter().map(|input| (input.clone(), self.truth.clone())).collect();
        if let Some(manifest) = &self.manifest {
            let listed = read_manifest(manifest)?;
            if listed.is_empty() {
                bail!("{} lists no recording: add a line with the path of one", manifest.display());
            }
            inputs.extend(listed);
        }
        if inputs.len() > 1 && self.truth.is_some() {
            bail!("--truth belongs to one recording: for several, put the truths into a --manifest");
        }
        let several = inputs.len() > 1;
        let folder = self.output.clone();
        let jobs: Vec<Job> = inputs
            .into_iter()
            .map(|(input, truth)| {
                let output = match (&folder, several) {
                    (Some(folder), false) => folder.clone(),
                    (Some(folder), true) => folder.join(name_of(&input)),
                    (None, _) => Path::new("results").join(name_of(&input)),
                };
                Job { input, output, truth }
            })
            .collect();
        for (i, job) in jobs.iter().enumerate() {
            if let Some(twin) = jobs[..i].iter().find(|other| other.output == job.output) {
                bail!(
                    "{} and {} would both write to {}: track them one by one with -o",
                    twin.input.display(),
                    job.input.display(),
                    job.output.display()
                );
            }
        }
        Ok(jobs)
    }

    /// Tracks one recording; whether the seam was available often enough.
    fn track_one(&self, job: &Job, config: &Config, alone: bool) -> anyhow::Result<bool> {
        let truth = job.truth.as_deref().map(|file| Ok::<_, anyhow::Error>((file, read_truth(file)?))).transpose()?;
        let source = seamtrack::source::open(&job.input, config.period_s)?;
        std::fs::create_dir_all(&job.output)
            .with_context(|| format!("cannot make the folder {}", job.output.display()))?;
        let kind = source.kind();
        let progress = self.progress(source.frame_count(), alone);
        let mut thumbnails = ThumbnailStore::new(DEFAULT_BUDGET_BYTES, source.frame_count());
        let mut trace = vec![];
        let outcome = seamtrack::run::track(source, config, self.origin, |seen| {
            match seen.picture {
                Ok(picture) => thumbnails.offer(seen.row, picture, seen.marks),
                Err(error) => progress.suspend(|| eprintln!("seamtrack: frame {}: {error}", seen.row.frame)),
            }
            if self.trace {
                trace.push(seen.trace());
            }
            progress.inc(1);
        });
        progress.finish_and_clear();
        let outcome = outcome.with_context(|| job.input.display().to_string())?;

        let errors = match (&truth, outcome.axis) {
            (Some((file, truth)), Some(axis)) => {
                let table = error_table(&outcome.rows, truth, axis, config.mm_per_px);
                Some(table.with_context(|| format!("{} has no frame of this recording", file.display()))?)
            }
            _ => None,
        };
        let input = job.input.to_string_lossy();
        let summary = seamtrack::run::summarise(&outcome, (&input, kind), config, self.max_unavailable, errors)?;
        write_path_csv(&job.output.join("path.csv"), &outcome.rows)?;
        write_summary(&job.output.join("summary.json"), &summary)?;
        let truth_copy = job.output.join(seamtrack::report::truth::FILE_NAME);
        match &truth {
            Some((file, _)) => keep_copy(file, &truth_copy)?,
            None if truth_copy.exists() => std::fs::remove_file(&truth_copy)?,
            None => {}
        }
        if self.trace {
            write_trace_csv(&job.output.join("trace.csv"), &trace)?;
        }
        thumbnails.write(&job.output)?;
        let run = Run::read(&job.output)?;
        write_exports(&run, Exports { tum: self.tum, ..Exports::default() })?;
        if let Some(overlay) = &self.overlay {
            let target = if alone { overlay.clone() } else { overlay.join(name_of(&job.input)) };
            draw_overlay(&job.input, &target, config, &outcome)?;
        }
        if !self.quiet {
            let colour = Colour::for_stdout();
            print!("{}", terminal_summary(&run, colour));
            println!("results: {}", job.output.join("report.html").display());
        }
        Ok(100.0 * outcome.unavailable_frames() as f64 <= self.max_unavailable * outcome.rows.len() as f64)
    }

    fn progress(&self, frames: Option<usize>, alone: bool) -> ProgressBar {
        if self.quiet || !alone || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::with_draw_target(frames.map(|n| n as u64), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {per_sec}, {eta} left");
        bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
    }
}

/// Reads the recording a second time and draws the finished path into it.
fn draw_overlay(input: &Path, target: &Path, config: &Config, outcome: &RunOutcome) -> anyhow::Result<()> {
    let mut writer = OverlayWriter::create(target, 1.0 / config.period_s)?;
    let mut source = seamtrack::source::open(input, config.period_s)?;
    let mut sizes = SizeCheck::default();
    for (row, marks) in outcome.rows.iter().zip(&outcome.marks) {
        let Some(frame) = source.next_frame() else { break };
        if let Ok(picture) = sizes.admit(frame).picture {
            writer.add(&picture, row, marks)?;
        }
    }
    Ok(writer.finish()?)
}

/// The truth beside the results, for the report; nothing to do when it lies there already.
pub(super) fn keep_copy(from: &Path, to: &Path) -> anyhow::Result<()> {
    let bytes = std::fs::read(from).with_context(|| format!("cannot read {}", from.display()))?;
    seamtrack::report::atomic::write_atomically(to, |file| std::io::Write::write_all(file, &bytes))?;
    Ok(())
}

/// A configuration whose numbers are in their ranges, so that an error can name the file.
fn read_config(file: &Path) -> anyhow::Result<Config> {
    let config = Config::read(file)?;
    config.method().with_context(|| file.display().to_string())?;
    Ok(config)
}

pub(super) fn exit_code(available: bool) -> ExitCode {
    if available { ExitCode::SUCCESS } else { ExitCode::from(3) }
}

pub(super) fn refuse_to_overwrite(output: &Path, force: bool) -> anyhow::Result<()> {
    if !force && output.join("path.csv").exists() {
        bail!("{} already holds results: choose another folder with -o, or overwrite with --force", output.display());
    }
    // Results keep the truth that they were judged by under this name.
    let truth = output.join(seamtrack::report::truth::FILE_NAME);
    if truth.exists() && !output.join("path.csv").exists() {
        bail!("{} is not of earlier results and would be replaced: choose another folder with -o", truth.display());
    }
    Ok(())
}

/// The overlay's pictures never go where the recording is.
pub(super) fn refuse_to_draw_over(input: &Path, overlay: Option<&Path>) -> anyhow::Result<()> {
    let Some(overlay) = overlay else { return Ok(()) };
    let target = overlay.canonicalize();
    let is_target = |path: PathBuf| path.canonicalize().is_ok_and(|path| target.as_ref().is_ok_and(|t| *t == path));
    if is_target(input.to_owned()) || is_target(input.join("frames")) {
        bail!("--overlay {} would draw over the recording itself: name another place", overlay.display());
    }
    Ok(())
}

/// The folder's or file's own name, without the extension of a file.
pub(super) fn name_of(input: &Path) -> PathBuf {
    let absolute = input.canonicalize().unwrap_or_else(|_| input.to_owned());
    let name = if absolute.is_dir() { absolute.file_name() } else { absolute.file_stem() };
    PathBuf::from(name.unwrap_or_else(|| "recording".as_ref()))
}

fn parse_point(text: &str) -> Result<PixelPoint, String> {
    let parsed = text.split_once(',').and_then(|(u, v)| Some((u.trim().parse().ok()?, v.trim().parse().ok()?)));
    match parsed {
        Some((u_px, v_px)) => Ok(PixelPoint::new(u_px, v_px)),
        None => Err("expected U,V in pixels, for example 320,240".into()),
    }
}

pub(super) fn parse_percentage(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(percent) if (0.0..=100.0).contains(&percent) => Ok(percent),
        _ => Err("expected a percentage from 0 to 100".into()),
    }
}

fn read_manifest(manifest: &Path) -> anyhow::Result<Vec<(PathBuf, Option<PathBuf>)>> {
    let context = || format!("cannot read the manifest {}", manifest.display());
    let mut reader = csv::Reader::from_path(manifest).with_context(context)?;
    let folder = manifest.parent().unwrap_or(Path::new("."));
    let headers = reader.headers().with_context(context)?.clone();
    let Some(input) = headers.iter().position(|name| name == "input") else {
        bail!("{}: the first line must name a column `input` (and may name `truth`)", manifest.display());
    };
    let truth = headers.iter().position(|name| name == "truth");
    reader
        .records()
        .map(|record| {
            let record = record.with_context(context)?;
            let path = |column: usize| record.get(column).filter(|text| !text.is_empty()).map(|text| folder.join(text));
            let Some(input) = path(input) else { bail!("{}: a line has no input", manifest.display()) };
            Ok((input, truth.and_then(path)))
        })
        .collect()
}
