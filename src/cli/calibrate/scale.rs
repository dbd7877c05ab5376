//! `seamtrack calibrate scale`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use nalgebra::Vector2;
use seamtrack::calib::file::{CalibrationFile, ScaleSection};
use seamtrack::calib::scale::{Position, ScaleFit, fit_scale};
use seamtrack::calib::travel::{Moved, Travel};
use seamtrack::source;
use seamtrack::units::StripeAxis;

use super::Target;
use super::pictures::{read_poses, still_light};

/// Find one scale from known displacements
///
/// Either a CSV with a column of pixels and one of millimetres (a gauge's displacements), or a recording of a plate
/// with the robot's position for each frame.
#[derive(Debug, Args)]
pub struct Scale {
    /// CSV with the columns px and mm, or a recording
    #[arg(value_name = "CSV|RECORDING")]
    input: PathBuf,
    /// The robot's x, y, z [mm], one line a frame of the recording
    #[arg(long, value_name = "CSV")]
    poses: Option<PathBuf>,
    /// How the stripe runs through the recording's pictures
    #[arg(long, default_value = "vertical")]
    stripe: Stripe,
    /// The image coordinate that the scale holds for [default: that of the motion; u for a CSV]
    #[arg(long)]
    axis: Option<Axis>,
    /// The calibration
    #[arg(short, long, value_name = "FILE.toml", default_value = "scale.toml")]
    output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Stripe {
    Horizontal,
    Vertical,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Axis {
    U,
    V,
}

impl Scale {
    pub fn run(&self) -> anyhow::Result<ExitCode> {
        let target = Target::new(&self.output, self.force, [&self.input].into_iter().chain(&self.poses))?;
        let (positions, moved_along) = match &self.poses {
            Some(poses) => self.follow_recording(poses)?,
            None if self.input.is_dir() => {
                bail!("{} is a recording: give the robot's positions with --poses CSV", self.input.display())
            }
            None => (read_positions(&self.input)?, Axis::U),
        };
        let fit = fit_scale(&positions).with_context(|| self.input.display().to_string())?;
        let axis = match self.axis.unwrap_or(moved_along) {
            Axis::U => "u",
            Axis::V => "v",
        };
        let scale = ScaleSection { mm_per_px: fit.mm_per_px, std_mm_per_px: fit.std_mm_per_px, axis: axis.into() };
        let mut file = CalibrationFile { scale: Some(scale), ..CalibrationFile::default() };
        target.write(&mut file, |_| String::new())?;
        print(&fit, axis);
        outln!("written: {target}");
        Ok(ExitCode::SUCCESS)
    }

    /// The plate's travel in the picture against the robot's, both along their main direction.
    fn follow_recording(&self, poses: &Path) -> anyhow::Result<(Vec<Position>, Axis)> {
        let poses = read_poses(poses)?;
        let axis = if self.stripe == Stripe::Vertical { StripeAxis::Vertical } else { StripeAxis::Horizontal };
        let mut travel = Travel::new(axis, still_light(&self.input)?);
        let mut source = source::open(&self.input, 1.0)?;
        let mut at_px = Vector2::zeros();
        let mut track: Vec<(Vector2<f64>, usize)> = vec![];
        let (mut frames, mut lost) = (0, 0);
        while let Some(frame) = source.next_frame() {
            let number = frames;
            frames += 1;
            let Ok(picture) = frame.picture else { continue };
            match travel.step(&picture) {
                Moved::Repeated => continue,
                Moved::Unknown => {
                    lost += 1;
                    continue;
                }
                Moved::First => {}
                Moved::By(by) => at_px += by,
            }
            track.push((at_px, number));
        }
        if poses.len() < frames {
            bail!("{frames} frames and only {} poses: one line a frame is needed", poses.len());
        }
        if poses.len() > frames {
            errln!("{} poses for {frames} frames: the last ones are not used", poses.len());
        }
        if lost * 5 > track.len() + lost {
            bail!(
                "the plate's texture was followed in {} of {} frames only: light it so that it shows",
                track.len(),
                track.len() + lost
            );
        }
        let (Some(first), Some(last)) = (track.first(), track.last()) else {
            bail!("{} has no frame", self.input.display())
        };
        let along_px = (last.0 - first.0).try_normalize(1e-9).context("the picture does not move")?;
        let along_mm = (poses[last.1] - poses[first.1]).try_normalize(1e-9).context("the robot does not move")?;
        let position = |(px, frame): &(Vector2<f64>, usize)| Position {
            px: px.dot(&along_px),
            mm: (poses[*frame] - poses[first.1]).dot(&along_mm),
        };
        let moved_along = if along_px.x.abs() >= along_px.y.abs() { Axis::U } else { Axis::V };
        Ok((without_lost(track.iter().map(position).collect()), moved_along))
    }
}

/// A frame whose registration went astray lies far from the line of the others, by more than this many robust σ.
const ASTRAY_SIGMAS: f64 = 5.0;

/// The positions without those of frames that went astray; their number goes to stderr.
fn without_lost(mut positions: Vec<Position>) -> Vec<Position> {
    let all = positions.len();
    for _ in 0..3 {
        let Ok(fit) = fit_scale(&positions) else { break };
        let off = |p: &Position| p.px * fit.mm_per_px - p.mm;
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(0.0)
        };
        let middle = median(positions.iter().map(off).collect());
        let sigma = 1.4826 * median(positions.iter().map(|p| (off(p) - middle).abs()).collect());
        positions.retain(|p| (off(p) - middle).abs() <= ASTRAY_SIGMAS * sigma);
    }
    if positions.len() < all {
        errln!("{} of {all} frames left out: their place does not follow the others", all - positions.len());
    }
    positions
}

/// The columns of pixels and millimetres: by name, else the first two.
fn read_positions(path: &Path) -> anyhow::Result<Vec<Position>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut places = (0, 1);
    let mut positions = vec![];
    for (i, line) in text.lines().map(|line| line.trim().trim_start_matches('\u{feff}')).enumerate() {
        let cells: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let number = |place: usize| cells.get(place)?.parse::<f64>().ok().filter(|x| x.is_finite());
        match (number(places.0), number(places.1)) {
            (Some(px), Some(mm)) => positions.push(Position { px, mm }),
            _ if positions.is_empty() && cells.iter().all(|cell| cell.parse::<f64>().is_err()) => {
                let named = |unit: &str| cells.iter().position(|cell| cell.to_lowercase().ends_with(unit));
                places = named("px").zip(named("mm")).with_context(|| {
                    format!("{}: no columns whose names end in px and mm: name them px,mm", path.display())
                })?;
            }
            _ => bail!("{}: line {} has no two numbers px,mm", path.display(), i + 1),
        }
    }
    Ok(positions)
}

fn print(fit: &ScaleFit, axis: &str) {
    outln!(
        "scale: {:.5} mm/px along {axis}, 95 % between {:.5} and {:.5}",
        fit.mm_per_px,
        fit.mm_per_px - fit.half_95_mm_per_px,
        fit.mm_per_px + fit.half_95_mm_per_px
    );
    outln!(
        "  {} positions, {:.0} of them independent; residual {:.3} mm, worst {:.3} mm at {:.2} mm; a position left out is missed by up to {:.3} mm",
        fit.positions,
        fit.independent,
        fit.rms_mm,
        fit.worst_mm,
        fit.worst_at_mm,
        fit.held_out_mm
    );
    if fit.reversed {
        outln!("  the coordinate falls while the displacement grows");
    }
}
