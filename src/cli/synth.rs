//! `seamtrack synth`: make up a recording with a known truth.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use seamtrack::calib::board::BoardSize;
use seamtrack::output::{Existing, Reads};
use seamtrack::synth::board::recording::Boards;
use seamtrack::synth::families::families;
use seamtrack::synth::pool::PoolScenario;
use seamtrack::synth::recording::{write_pool_recording, write_recording};
use seamtrack::synth::{Scenario, builtin};

use super::say;

/// Make up a recording whose truth is known: frames/, truth.csv, scenario.toml.
#[derive(Debug, Args)]
pub struct Synth {
    /// A built-in scene (see --list) or a scenario file.
    #[arg(value_name = "SCENARIO|FILE.toml", required_unless_present = "list")]
    scenario: Option<String>,
    /// Folder to write; it must not exist.
    #[arg(short, long, value_name = "DIR", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Seed of everything random, instead of the scenario's.
    #[arg(long, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: Option<u64>,
    /// Number of frames, instead of the scenario's.
    #[arg(long)]
    frames: Option<usize>,
    /// Also this many views of a board, without and with the stripe, to calibrate the scenario's [camera] and [laser] from:
    /// boards/, stripes/, and the true sensor.toml.
    #[arg(long, value_name = "VIEWS", value_parser = clap::value_parser!(u16).range(1..=1000))]
    boards: Option<u16>,
    /// Inner corners of the board.
    #[arg(long, value_name = "COLUMNSxROWS", default_value = "6x7", requires = "boards")]
    corners: BoardSize,
    /// Side of its squares [mm].
    #[arg(long, value_name = "MM", default_value_t = 15.0, value_parser = super::calibrate::parse_positive, requires = "boards")]
    square: f64,
    /// Show the built-in scenes, one line each.
    #[arg(long)]
    list: bool,
    /// Replace an earlier recording that was made up there, if nothing was changed since.
    #[arg(long)]
    force: bool,
}

impl Synth {
    /// Renders the recording, or lists the scenes.
    pub fn run(&self) -> Result<ExitCode> {
        if self.list {
            return list();
        }
        let (Some(name), Some(output)) = (&self.scenario, &self.output) else {
            bail!("a scenario and an output folder are needed");
        };
        let scenario_file = Path::new(name);
        if is_file(scenario_file) {
            let mut reads = Reads::default();
            reads.add(scenario_file);
            reads.refuse(output, "-o")?;
        }
        let existing = Existing::forced(self.force);
        match chosen(name)? {
            Chosen::Stripe(mut scenario) => {
                scenario.seed = self.seed.unwrap_or(scenario.seed);
                scenario.frames = self.frames.unwrap_or(scenario.frames);
                let bar = progress_bar(scenario.frames)?;
                let of_views = |views: u16| Boards { views: views.into(), size: self.corners, square_mm: self.square };
                write_recording(&scenario, output, existing, self.boards.map(of_views).as_ref(), || bar.inc(1))?;
                bar.finish_and_clear();
            }
            Chosen::Pool(_) if self.boards.is_some() => bail!("--boards: a melt pool has no laser stripe"),
            Chosen::Pool(mut scenario) => {
                scenario.seed = self.seed.unwrap_or(scenario.seed);
                scenario.frames = self.frames.unwrap_or(scenario.frames);
                let bar = progress_bar(scenario.frames)?;
                write_pool_recording(&scenario, output, existing, || bar.inc(1))?;
                bar.finish_and_clear();
            }
        }
        say::print(&format!("{}\n", say::shown(output)))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// What is to be made up.
enum Chosen {
    Stripe(Box<Scenario>),
    Pool(Box<PoolScenario>),
}

/// The file of that name if there is one or it must be one, else the built-in scene. A file with a `[pool]` is a melt
/// pool's.
fn chosen(name: &str) -> Result<Chosen> {
    let file = Path::new(name);
    if !is_file(file) {
        let pool = builtin::pool_names().iter().any(|known| known.eq_ignore_ascii_case(name));
        return Ok(if pool {
            Chosen::Pool(Box::new(builtin::pool_scenario(name)?))
        } else {
            Chosen::Stripe(Box::new(builtin::scenario(name)?))
        });
    }
    let text = std::fs::read_to_string(file);
    let is_pool = |text: &str| text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("pool"));
    Ok(match text {
        Ok(text) if is_pool(&text) => Chosen::Pool(Box::new(PoolScenario::from_toml(&text, name)?)),
        _ => Chosen::Stripe(Box::new(Scenario::load(file)?)),
    })
}

fn is_file(scenario: &Path) -> bool {
    scenario.extension().is_some_and(|extension| extension == "toml") || scenario.is_file()
}

fn list() -> Result<ExitCode> {
    let mut text = String::new();
    for name in builtin::names() {
        let scenario = builtin::scenario(&name)?;
        let floor_mm = scenario.noise_floor_px() * scenario.mm_per_px.get();
        text += &format!("{name:22} {} (noise floor of one frame {floor_mm:.3} mm)\n", scenario.description);
    }
    for name in builtin::sensor_names() {
        text += &format!("{name:22} {}\n", builtin::scenario(&name)?.description);
    }
    for family in families()? {
        text += &format!(
            "{:27} {} ({}; mild, medium, severe)\n",
            family.name.to_owned() + "-JOINT-LEVEL",
            family.description,
            family.joints.join(", ")
        );
    }
    for name in builtin::pool_names() {
        text += &format!("{name:22} {}\n", builtin::pool_scenario(&name)?.description);
    }
    say::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn progress_bar(frames: usize) -> Result<ProgressBar> {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left")?;
    Ok(ProgressBar::with_draw_target(Some(frames as u64), target).with_style(style))
}
