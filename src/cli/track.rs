//! `seamtrack track`: recorded frames in, the seam path in millimetres out.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use seamtrack::calib::board::pair;
use seamtrack::calib::{KnownSensor, Origin};
use seamtrack::config::{Config, Joint, Preset, Stripe};
use seamtrack::output::{Existing, WholeFolder, listing, resolve};
use seamtrack::report::atomic::write_atomically;
use seamtrack::report::export::{Exports, write_exports};
use seamtrack::report::foxglove::FoxgloveLog;
use seamtrack::report::overlay::OverlayWriter;
use seamtrack::report::results::write_path_csv;
use seamtrack::report::run::Run;
use seamtrack::report::summary::{FIRST_FRAME, Limits, write_summary};
use seamtrack::report::terminal::{Colour, terminal_summary};
use seamtrack::report::thumbnails::{DEFAULT_BUDGET_BYTES, ThumbnailStore};
use seamtrack::report::trace::write_trace_csv;
use seamtrack::report::verdict::{Trust, verdict};
use seamtrack::run::{RunOutcome, error_table, plane_errors};
use seamtrack::source::{Cut, FrameRange, FrameSource, Period, SizeCheck, SourceError};
use seamtrack::units::{MmPerPx, PixelPoint};

use super::base_frame::{BaseFrame, Robot};
use super::drawing::Drawing;
use super::places::{self, Places};
use super::recordings::{made_from, names_of, size_of, truth_beside};
use super::troubles::Troubles;
use super::truth::Truth;
use super::{batch, manifest, say};

/// Find the seam in each frame of a recording and estimate its path, in millimetres where a scale or a calibration is given
#[derive(Debug, Args)]
pub struct Track {
    /// Folders of images (png, jpg, bmp, tif), multi-page TIFFs, videos or MCAP logs
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
    /// Only these frames of the recording, from A up to but without B; either may be left out, as in 100..
    #[arg(long, value_name = "A..B")]
    frames: Option<FrameRange>,
    /// Which way the stripe runs [default: auto]
    #[arg(long)]
    stripe: Option<Stripe>,
    /// The seam in the first frame, if you know better than the seed
    #[arg(long, value_name = "U,V", value_parser = parse_point, allow_hyphen_values = true)]
    seed_at: Option<PixelPoint>,
    /// The part of the picture to look at: first column and row, columns and rows [px] [default: all of it]
    #[arg(long, value_name = "U,V,W,H", value_parser = parse_roi, allow_hyphen_values = true)]
    roi: Option<[usize; 4]>,
    /// One scale along the stripe [mm/px]; without this and --calibration the path is in pixels
    #[arg(long, value_name = "MM", allow_negative_numbers = true, conflicts_with = "calibration")]
    mm_per_px: Option<MmPerPx>,
    /// Camera and laser plane, or a scale, as `seamtrack calibrate` wrote them (TOML)
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// The recording's pictures were cut out of the calibrated ones at this column and row
    #[arg(long, value_name = "UxV", value_parser = pair, requires = "calibration")]
    crop_at: Option<[usize; 2]>,
    #[command(flatten)]
    base_frame: BaseFrame,
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
    /// Also write pictures, marks and path as an MCAP log, for Foxglove; of several recordings, a folder of logs
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    /// Also write the paths as TUM trajectories (for evo)
    #[arg(long)]
    tum: bool,
    /// Most frames that may be without a value; above it the verdict is BAD
    #[arg(long, value_name = "PCT", default_value_t = 5.0, value_parser = parse_percentage)]
    max_unavailable: f64,
    /// Half the width of the band that the path is to stay in: of the truth, or without one of x = 0; says how much of the path
    /// is inside, and where it is not
    #[arg(long, value_name = "MM", value_parser = parse_length)]
    tolerance: Option<f64>,
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
pub(super) struct Job {
    pub input: PathBuf,
    /// What it is called beside others.
    pub name: PathBuf,
    pub output: PathBuf,
    pub truth: Option<PathBuf>,
    pub overlay: Option<PathBuf>,
    pub mcap: Option<PathBuf>,
    /// What its results are made from, and whether they are there already: recordings beside others only.
    pub made_from: Option<String>,
    pub is_done: bool,
}

impl Job {
    fn places(&self) -> Places<'_> {
        Places {
            input: &self.input,
            truth: self.truth.as_deref(),
            output: &self.output,
            overlay: self.overlay.as_deref(),
            mcap: self.mcap.as_deref(),
            is_done: self.is_done,
        }
    }
}

/// What all recordings of a call are tracked by.
#[derive(Clone, Copy)]
struct Measuring<'a> {
    config: &'a Config,
    known: &'a KnownSensor,
    robot: Option<&'a Robot>,
}

impl Track {
    /// Tracks every recording; the worst exit code wins.
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let config = self.effective_config()?;
        let known = self.calibration.as_deref().map_or_else(|| Ok(config.sensor()), KnownSensor::read)?;
        if self.tum && !known.sensor.has_millimetres() {
            bail!("--tum writes metres: give --mm-per-px or --calibration");
        }
        if self.tolerance.is_some() && !known.sensor.has_millimetres() {
            bail!("--tolerance is in millimetres: give --mm-per-px or --calibration");
        }
        let robot = self.base_frame.robot(&known)?;
        let measuring = Measuring { config: &config, known: &known, robot: robot.as_ref() };
        let jobs = self.job_list(&measuring)?;
        if robot.is_some() && jobs.len() > 1 {
            bail!("--poses belongs to one recording: track each with its own");
        }
        let all: Vec<Places<'_>> = jobs.iter().map(Job::places).collect();
        let settings: Vec<&PathBuf> =
            self.manifest.iter().chain(&self.config).chain(&self.calibration).chain(self.base_frame.files()).collect();
        places::check(&all, &settings, Existing::forced(self.force))?;
        if let [job] = jobs.as_slice() {
            let run = self.track_one(job, &measuring, true)?;
            if !self.quiet {
                let report = say::shown(&job.output.join("report.html"));
                let text = terminal_summary(&run, Colour::for_stdout()) + &format!("results: {report}\n");
                say::print(&text).context("the results are written, but")?;
            }
            return Ok(exit_code(verdict(&run).trust == Trust::Bad));
        }
        let settings = batch::Batch { folder: self.folder(), jobs_at_a_time: self.jobs, quiet: self.quiet };
        batch::run(&settings, &jobs, |job| self.track_one(job, &measuring, false))
    }

    /// Where the results of several recordings lie side by side.
    fn folder(&self) -> &Path {
        self.output.as_deref().unwrap_or(Path::new("results"))
    }

    fn effective_config(&self) -> anyhow::Result<Config> {
        let mut config = self.config.as_deref().map_or_else(|| Ok(Config::default()), read_config)?;
        config.preset = self.preset.unwrap_or(config.preset);
        config.joint = self.joint.unwrap_or(config.joint);
        config.stripe = self.stripe.unwrap_or(config.stripe);
        config.mm_per_px = self.mm_per_px.or(config.mm_per_px);
        config.period_s = self.period.unwrap_or(config.period_s);
        config.speed_mm_s = self.speed.or(config.speed_mm_s);
        config.fixed_lag = self.fixed_lag.or(config.fixed_lag);
        config.seed_at = self.seed_at.map(|p| [p.u_px, p.v_px]).or(config.seed_at);
        config.roi = self.roi.or(config.roi);
        config.method()?;
        Ok(config)
    }

    fn job_list(&self, measuring: &Measuring<'_>) -> anyhow::Result<Vec<Job>> {
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
        let names = names_of(&inputs.iter().map(|(input, _)| input.as_path()).collect::<Vec<_>>());
        let jobs = inputs.into_iter().zip(names).map(|((input, truth), name)| {
            let output = match &self.output {
                Some(folder) if !several => folder.clone(),
                _ => self.folder().join(&name),
            };
            let overlay = self.overlay.as_ref().map(|place| if several { place.join(&name) } else { place.clone() });
            let log = |place: &PathBuf| place.join(format!("{}.mcap", name.display()));
            let mcap = self.mcap.as_ref().map(|place| if several { log(place) } else { place.clone() });
            let settings = self.settings(measuring, [overlay.as_deref(), mcap.as_deref()]);
            let made_from = if several { made_from(&input, truth.as_deref(), &settings) } else { None };
            let is_drawn = overlay.iter().chain(&mcap).all(|drawn| drawn.exists());
            let is_done = !self.force
                && is_drawn
                && made_from.as_ref().is_some_and(|made_from| listing::is_whole(&output, made_from));
            Job { input, name, output, truth, overlay, mcap, made_from, is_done }
        });
        Ok(jobs.collect())
    }

    /// All options that decide on a recording's results.
    fn settings(&self, measuring: &Measuring<'_>, drawings: [Option<&Path>; 2]) -> String {
        let Measuring { config, known, .. } = measuring;
        let Self { crop_at, origin, frames, max_unavailable, tolerance, tum, trace, .. } = self;
        let period = self.period(config);
        format!(
            "{config:?} {known:?} {crop_at:?} {period:?} {origin:?} {frames:?} {max_unavailable:?} {tolerance:?} {tum} {trace} {drawings:?}"
        )
    }

    /// Tracks one recording.
    fn track_one(&self, job: &Job, measuring: &Measuring<'_>, alone: bool) -> anyhow::Result<Run> {
        let Measuring { config, known, robot } = *measuring;
        let cropped = self.crop_at.map(|[u, v]| {
            let cropped = known.cropped((u, v), size_of(&job.input)?);
            cropped.with_context(|| {
                format!("--crop-at {u}x{v}: {} reaches beyond the calibrated picture", job.input.display())
            })
        });
        let cropped = cropped.transpose()?;
        let known = cropped.as_ref().unwrap_or(known);
        let truth = job.truth.as_deref().map(|file| Ok::<_, anyhow::Error>((file, Truth::read(file)?))).transpose()?;
        let mut source = self.open(&job.input, config)?;
        let config = &Config { period_s: source.period_s(), ..config.clone() };
        let mut troubles = Troubles::of(&job.input);
        source.notes().iter().for_each(|note| troubles.note(note));
        if truth.is_none()
            && !self.quiet
            && let Some(beside) = truth_beside(&job.input)
        {
            troubles.note(&format!("a truth lies beside it: --truth {} reports errors", beside.display()));
        }
        let existing = Existing::forced(self.force);
        let mut folder = WholeFolder::begin(&job.output, existing)?;
        job.made_from.iter().for_each(|made_from| folder.made_from(made_from.clone()));
        let kind = source.kind();
        let progress = self.progress(source.frame_count(), alone);
        let mut thumbnails = ThumbnailStore::new(DEFAULT_BUDGET_BYTES, source.frame_count());
        let mut trace = vec![];
        let outcome = seamtrack::run::track(&mut *source, (config, known), self.origin, |seen| {
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

        let first_frame = self.frames.map_or(0, |range| range.first);
        let errors = match (&truth, &outcome.ruler) {
            (Some((file, truth)), Some(ruler)) => {
                let table = error_table(&outcome.rows, (&truth.rows, first_frame), ruler);
                truth.tell_if_short(file, first_frame, outcome.rows.len());
                let table = table.with_context(|| file.display().to_string())?;
                truth.tell_if_seamless(file, &table, &outcome.rows);
                table
            }
            _ => None,
        };
        let in_plane = truth.as_ref().and_then(|(_, truth)| plane_errors(&outcome.rows, (&truth.rows, first_frame)));
        let input = job.input.to_string_lossy();
        let limits = Limits {
            max_unavailable_pct: Some(self.max_unavailable),
            tolerance_mm: self.tolerance,
            ..Limits::default()
        };
        let mut summary =
            seamtrack::run::summarise(&outcome, (&input, kind), (config, known), limits, (errors, in_plane))?;
        if let Some(range) = self.frames {
            summary.input.more.insert(FIRST_FRAME.into(), range.first.into());
        }
        write_path_csv(&folder.path().join("path.csv"), &outcome.rows)?;
        write_summary(&folder.path().join("summary.json"), &summary)?;
        if let Some((_, truth)) = &truth {
            truth.keep_copy(folder.path())?;
        }
        if self.trace {
            write_trace_csv(&folder.path().join("trace.csv"), &trace)?;
        }
        if let Some(robot) = robot {
            robot.write(folder.path(), &outcome.rows, known)?;
        }
        thumbnails.write(folder.path())?;
        let mut run = Run::read(folder.path())?;
        // Not that of the folder in which it is made.
        run.name = folder.target().file_name().unwrap_or_default().to_string_lossy().into_owned();
        run.summary.tolerance = run.tolerance();
        if run.summary.tolerance.is_some() {
            write_summary(&folder.path().join("summary.json"), &run.summary)?;
        }
        write_exports(&run, Exports { tum: self.tum, ..Exports::default() })?;
        // A log within the results appears with them, one elsewhere before them: what was finished has its log.
        if let Some(mcap) = &job.mcap {
            let place = resolve(mcap)?;
            let within = place.strip_prefix(folder.target()).map(|within| folder.path().join(within));
            write_mcap(source.again()?, &within.unwrap_or(place), &outcome)?;
        }
        match &job.overlay {
            None => folder.finish()?,
            Some(overlay) => {
                let place = Drawing::begin(overlay, &folder, existing)?;
                let writer = draw_overlay(source.again()?, place.path(), config.period_s, &outcome)?;
                place.finish(writer, folder)?;
            }
        }
        Ok(run)
    }

    /// Opens a recording, or the part of it that was asked for.
    fn open(&self, input: &Path, config: &Config) -> Result<Box<dyn FrameSource>, SourceError> {
        let whole = seamtrack::source::open(input, self.period(config))?;
        match (self.frames, whole.frame_count()) {
            (None, _) => Ok(whole),
            (Some(range), Some(count)) if count <= range.first => {
                let problem = format!("--frames {range}: it has {count} frames, numbered from 0");
                Err(SourceError::Frames { path: input.to_owned(), problem })
            }
            (Some(range), _) => Ok(Box::new(Cut::new(whole, range))),
        }
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
fn draw_overlay(
    mut source: Box<dyn FrameSource>,
    target: &Path,
    period_s: f64,
    outcome: &RunOutcome,
) -> anyhow::Result<OverlayWriter> {
    let mut writer = OverlayWriter::create(target, 1.0 / period_s)?;
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

/// Reads the recording a second time and writes it with the finished path as a log.
fn write_mcap(mut source: Box<dyn FrameSource>, target: &Path, outcome: &RunOutcome) -> anyhow::Result<()> {
    if let Some(folder) = target.parent() {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot write {}", folder.display()))?;
    }
    let mut sizes = SizeCheck::default();
    write_atomically(target, |file| {
        file.flush()?;
        let mut log = FoxgloveLog::begin(file.get_mut()).map_err(std::io::Error::other)?;
        for (row, marks) in outcome.rows.iter().zip(&outcome.marks) {
            let Some(frame) = source.next_frame() else { break };
            let picture = sizes.admit(frame).picture.ok();
            let drawn = picture.as_ref().map(|picture| (picture, marks));
            log.add(row, drawn).map_err(std::io::Error::other)?;
        }
        log.finish().map_err(std::io::Error::other)
    })?;
    Ok(())
}

/// A configuration whose numbers are in their ranges, so that an error can name the file.
fn read_config(file: &Path) -> anyhow::Result<Config> {
    let config = Config::read(file)?;
    config.method().with_context(|| file.display().to_string())?;
    Ok(config)
}

/// The exit code of what was done: 3 when one may not trust it.
pub(super) fn exit_code(is_bad: bool) -> ExitCode {
    if is_bad { ExitCode::from(3) } else { ExitCode::SUCCESS }
}

fn parse_point(text: &str) -> Result<PixelPoint, String> {
    let parsed = text.split_once(',').and_then(|(u, v)| Some((u.trim().parse().ok()?, v.trim().parse().ok()?)));
    match parsed {
        Some((u_px, v_px)) => Ok(PixelPoint::new(u_px, v_px)),
        None => Err("expected U,V in pixels, for example 320,240".into()),
    }
}

fn parse_length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(mm) if mm.is_finite() && mm > 0.0 => Ok(mm),
        _ => Err("expected a length in millimetres above 0, for example 0.3".into()),
    }
}

fn parse_roi(text: &str) -> Result<[usize; 4], String> {
    let numbers: Result<Vec<usize>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let roi = numbers.ok().and_then(|numbers| <[usize; 4]>::try_from(numbers).ok());
    roi.ok_or_else(|| "expected U,V,W,H in whole pixels, for example 600,380,320,460".into())
}

pub(super) fn parse_percentage(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(percent) if (0.0..=100.0).contains(&percent) => Ok(percent),
        _ => Err("expected a percentage from 0 to 100".into()),
    }
}
