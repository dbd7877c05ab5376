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
use seamtrack::output::{Existing, WholeFolder};
use seamtrack::report::export::{Exports, write_exports};
use seamtrack::report::overlay::OverlayWriter;
use seamtrack::report::results::write_path_csv;
use seamtrack::report::run::Run;
use seamtrack::report::summary::write_summary;
use seamtrack::report::terminal::{Colour, terminal_summary};
use seamtrack::report::thumbnails::{DEFAULT_BUDGET_BYTES, ThumbnailStore};
use seamtrack::report::trace::write_trace_csv;
use seamtrack::report::verdict::{Trust, verdict};
use seamtrack::run::{RunOutcome, error_table};
use seamtrack::source::{Period, SizeCheck};
use seamtrack::units::{MmPerPx, PixelPoint};

use super::drawing::Drawing;
use super::places::{self, Places};
use super::signals::wait_if_ending;
use super::troubles::Troubles;
use super::truth::Truth;
use super::{manifest, say};

/// Find the seam in each frame of a recording and estimate its path in millimetres
#[derive(Debug, Args)]
pub struct Track {
    /// Folders of images (png, jpg, bmp, tif), multi-page TIFFs or videos
    #[arg(required_unless_present = "manifest")]
    inputs: Vec<PathBuf>,
    /// Folder for the results; one folder a recording in it when there are several [default: results/<name>]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// More recordings: a CSV with the columns input[,truth], with commas or semicolons
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
    /// Recordings tracked at a time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    jobs: u16,
    /// Configuration (TOML); `seamtrack config --print` shows every key
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Pipeline [default: robust]
    #[arg(long)]
    preset: Option<Preset>,
    /// The joint to follow [default: auto]
    #[arg(long)]
    joint: Option<Joint>,
    /// Which way the stripe runs [default: auto]
    #[arg(long)]
    stripe: Option<Stripe>,
    /// The seam in the first frame, if you know better than the seed
    #[arg(long, value_name = "U,V", value_parser = parse_point)]
    seed_at: Option<PixelPoint>,
    /// Scale along the stripe
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    mm_per_px: Option<MmPerPx>,
    /// Where x = 0 lies: first (the first tracked frame), centre (of the image), or a pixel
    #[arg(long, default_value = "first")]
    origin: Origin,
    /// Time from frame to frame [s], for recordings without time stamps [default: a video's own frame rate, else 0.2]
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
    /// Frames that the smoother may look ahead, as in a live run, at most 1000; the whole recording when it is not given
    #[arg(long, value_name = "FRAMES")]
    fixed_lag: Option<usize>,
    /// Also write trace.csv: what was measured in each frame and why it was accepted or refused
    #[arg(long)]
    trace: bool,
    /// Replace the results of an earlier run, and its overlay
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
    overlay: Option<PathBuf>,
}

impl Job {
    fn places(&self) -> Places<'_> {
        Places {
            input: &self.input,
            truth: self.truth.as_deref(),
            output: &self.output,
            overlay: self.overlay.as_deref(),
        }
    }
}

/// What became of it: whether the seam was available often enough, and what there is to say.
struct Done {
    available: bool,
    text: String,
}

/// Recordings tracked at a time for each processor: more only take memory from one another. Chosen.
const THREADS_PER_PROCESSOR: usize = 4;

impl Track {
    /// Tracks every recording; the worst exit code wins.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let config = self.effective_config()?;
        let jobs = self.job_list()?;
        let all: Vec<Places<'_>> = jobs.iter().map(Job::places).collect();
        let settings: Vec<&PathBuf> = self.manifest.iter().chain(&self.config).collect();
        places::check(&all, &settings, Existing::forced(self.force))?;
        if let [job] = jobs.as_slice() {
            let done = self.track_one(job, &config, true)?;
            say::print(&done.text).context("the results are written, but")?;
            return Ok(exit_code(done.available));
        }
        // More threads than recordings or processors have nothing to do.
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = usize::from(self.jobs).min(jobs.len()).min(THREADS_PER_PROCESSOR * processors);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let results: Vec<anyhow::Result<(bool, anyhow::Result<()>)>> = pool.install(|| {
            let tracked =
                |job| self.track_one(job, &config, false).map(|done| (done.available, say::print(&done.text)));
            jobs.par_iter().map(tracked).collect()
        });
        wait_if_ending();
        let mut failed = 0;
        let mut all_available = true;
        let mut printed = Ok(());
        for (job, result) in jobs.iter().zip(results) {
            match result {
                Ok((available, print)) => {
                    all_available &= available;
                    printed = printed.and(print);
                }
                Err(error) => {
                    say::tell(&format!("{}: {}", job.input.display(), say::one_line(error.as_ref())));
                    failed += 1;
                }
            }
        }
        if failed > 0 {
            bail!("{failed} of {} recordings failed; the others have their results", jobs.len());
        }
        printed.context("the results are written, but")?;
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
            let listed = manifest::read(manifest)?;
            if listed.is_empty() {
                bail!("{} lists no recording: add a line with the path of one", manifest.display());
            }
            inputs.extend(listed);
        }
        if inputs.len() > 1 && self.truth.is_some() {
            bail!("--truth belongs to one recording: for several, put the truths into a --manifest");
        }
        let several = inputs.len() > 1;
        let jobs = inputs.into_iter().map(|(input, truth)| {
            let name = name_of(&input);
            let output = match &self.output {
                Some(folder) if several => folder.join(&name),
                Some(folder) => folder.clone(),
                None => Path::new("results").join(&name),
            };
            let overlay = self.overlay.as_ref().map(|place| if several { place.join(&name) } else { place.clone() });
            Job { input, output, truth, overlay }
        });
        Ok(jobs.collect())
    }

    /// Tracks one recording.
    fn track_one(&self, job: &Job, config: &Config, alone: bool) -> anyhow::Result<Done> {
        let truth = job.truth.as_deref().map(|file| Ok::<_, anyhow::Error>((file, Truth::read(file)?))).transpose()?;
        let source = seamtrack::source::open(&job.input, self.period(config))?;
        let config = &Config { period_s: source.period_s(), ..config.clone() };
        let mut troubles = Troubles::of(&job.input);
        source.notes().iter().for_each(|note| troubles.note(note));
        let existing = Existing::forced(self.force);
        let folder = WholeFolder::begin(&job.output, existing)?;
        let kind = source.kind();
        let progress = self.progress(source.frame_count(), alone);
        let mut thumbnails = ThumbnailStore::new(DEFAULT_BUDGET_BYTES, source.frame_count());
        let mut trace = vec![];
        let outcome = seamtrack::run::track(source, config, self.origin, |seen| {
            match seen.picture {
                Ok(picture) => thumbnails.offer(seen.row, picture, seen.marks),
                Err(error) => progress.suspend(|| troubles.unreadable(seen.row.frame, error)),
            }
            if self.trace {
                trace.push(seen.trace());
            }
            progress.inc(1);
        });
        progress.finish_and_clear();
        troubles.end();
        let outcome = if alone { outcome.with_context(|| job.input.display().to_string())? } else { outcome? };

        let errors = match (&truth, outcome.axis) {
            (Some((file, truth)), Some(axis)) => {
                let table = error_table(&outcome.rows, &truth.rows, axis, config.mm_per_px);
                truth.tell_if_short(file, outcome.rows.len());
                Some(table.with_context(|| format!("{} has no frame of this recording", file.display()))?)
            }
            _ => None,
        };
        let input = job.input.to_string_lossy();
        let summary = seamtrack::run::summarise(&outcome, (&input, kind), config, self.max_unavailable, errors)?;
        write_path_csv(&folder.path().join("path.csv"), &outcome.rows)?;
        write_summary(&folder.path().join("summary.json"), &summary)?;
        if let Some((_, truth)) = &truth {
            truth.keep_copy(folder.path())?;
        }
        if self.trace {
            write_trace_csv(&folder.path().join("trace.csv"), &trace)?;
        }
        thumbnails.write(folder.path())?;
        let run = Run::read(folder.path())?;
        write_exports(&run, Exports { tum: self.tum, ..Exports::default() })?;
        match &job.overlay {
            None => folder.finish()?,
            Some(overlay) => {
                let place = Drawing::begin(overlay, &folder, existing)?;
                let writer = self.draw_overlay(&job.input, place.path(), config, &outcome)?;
                place.finish(writer, folder)?;
            }
        }
        let mut text = String::new();
        if !self.quiet {
            text += &terminal_summary(&run, Colour::for_stdout());
            text += &format!("results: {}\n", say::shown(&job.output.join("report.html")));
        }
        Ok(Done { available: verdict(&run).trust != Trust::Bad, text })
    }

    /// The user's time between frames, else the recording's own or the configuration's default.
    fn period(&self, config: &Config) -> Period {
        let is_in_file = |file: &PathBuf| {
            let text = std::fs::read_to_string(file).unwrap_or_default();
            text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("period_s"))
        };
        if self.period.is_some() || self.config.as_ref().is_some_and(is_in_file) {
            Period::Given(config.period_s)
        } else {
            Period::OwnOr(config.period_s)
        }
    }

    /// Reads the recording a second time and draws the finished path into it.
    fn draw_overlay(
        &self,
        input: &Path,
        target: &Path,
        config: &Config,
        outcome: &RunOutcome,
    ) -> anyhow::Result<OverlayWriter> {
        let mut writer = OverlayWriter::create(target, 1.0 / config.period_s)?;
        let mut source = seamtrack::source::open(input, self.period(config))?;
        let mut sizes = SizeCheck::default();
        for (row, marks) in outcome.rows.iter().zip(&outcome.marks) {
            let Some(frame) = source.next_frame() else { break };
            if let Ok(picture) = sizes.admit(frame).picture {
                writer.add(&picture, row, marks)?;
            }
        }
        writer.complete()?;
        Ok(writer)
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

/// A configuration whose numbers are in their ranges, so that an error can name the file.
fn read_config(file: &Path) -> anyhow::Result<Config> {
    let config = Config::read(file)?;
    config.method().with_context(|| file.display().to_string())?;
    Ok(config)
}

pub(super) fn exit_code(available: bool) -> ExitCode {
    if available { ExitCode::SUCCESS } else { ExitCode::from(3) }
}

/// The folder's or file's own name, without the extension of a file; of a folder called `frames`, that of the one above.
pub(super) fn name_of(input: &Path) -> PathBuf {
    let absolute = input.canonicalize().unwrap_or_else(|_| input.to_owned());
    let above = || absolute.parent().and_then(Path::file_name);
    let name = match absolute.file_name() {
        Some(name) if absolute.is_dir() && name == "frames" => above().or(Some(name)),
        name if absolute.is_dir() => name,
        _ => absolute.file_stem(),
    };
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
