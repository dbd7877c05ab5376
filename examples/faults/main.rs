//! What becomes of recordings to which something happens: made-up recordings, scripted faults at random places, and what
//! each does to the values: `make faults`. Then pictures that show no seam at all.
//!
//! `cargo run --release --example faults -- [--seed 1] [--recordings 2] [--repeats 2] [--only KIND]`; `--rows KIND JOINT
//! RECORDING REPEAT` prints one run frame by frame, `--write DIR` with it, or with `--picture NAME NUMBER`, leaves its frames
//! in a folder for `seamtrack track`. The scale is told, the joint is not. Every run is that of the program, from the
//! source of the frames on.

mod apply;
mod kinds;
mod not_a_seam;
mod paint;
mod pictures;
mod recording;
mod replay;
mod score;
mod table;

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result};
use clap::Parser;
use rayon::prelude::*;

use self::kinds::Kind;
use self::not_a_seam::Shown;
use self::recording::Recording;
use self::score::Run;

/// Track recordings to which something happens, and pictures without a seam
#[derive(Parser)]
struct Arguments {
    /// Which campaign: each seed draws other recordings, places and sizes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Recordings of each joint
    #[arg(long, default_value_t = 2)]
    recordings: u64,
    /// How often each fault strikes each recording
    #[arg(long, default_value_t = 2)]
    repeats: u64,
    /// Only this fault; may be given several times
    #[arg(long, value_name = "KIND")]
    only: Vec<String>,
    /// Print one run frame by frame: fault, joint, number of the recording, repeat
    #[arg(long, num_args = 4, value_names = ["KIND", "JOINT", "RECORDING", "REPEAT"])]
    rows: Option<Vec<String>>,
    /// Print what is claimed of one recording without a seam: a part of its name, its number
    #[arg(long, num_args = 2, value_names = ["NAME", "NUMBER"])]
    picture: Option<Vec<String>>,
    /// Write the frames of that run or recording into this folder
    #[arg(long)]
    write: Option<PathBuf>,
    /// Leave the faults out
    #[arg(long)]
    no_faults: bool,
    /// Leave the pictures without a seam out
    #[arg(long)]
    no_pictures: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some([kind, joint, number, repeat]) = arguments.rows.as_deref() {
        let kind = Kind::called(kind)?;
        let joint = recording::JOINTS.into_iter().find(|known| known == joint).context("there is no such joint")?;
        let recording = Recording::render(joint, arguments.seed, number.parse()?)?;
        let repeat = repeat.parse()?;
        let run = score::run(&recording, kind, repeat)?.context("this fault cannot strike that joint")?;
        print!("{}", table::rows(&run));
        if let Some(folder) = &arguments.write {
            let shots = score::shots(&recording, kind, repeat)?.context("this fault cannot strike that joint")?;
            replay::write(&shots, folder)?;
        }
        return Ok(());
    }
    if let Some([name, number]) = arguments.picture.as_deref() {
        let (name, made) =
            pictures::KINDS.into_iter().find(|kind| kind.0.contains(name.as_str())).context("no such picture")?;
        let seed = not_a_seam::seed(arguments.seed, number.parse()?);
        if let Some(folder) = &arguments.write {
            replay::write(&not_a_seam::shots(made, seed)?, folder)?;
        }
        print!("{}", table::not_a_seam(&[Shown::called(name).with(&not_a_seam::run(made, seed)?)]));
        return Ok(());
    }
    if !arguments.no_faults {
        let runs = faults(&arguments)?;
        print!("{}\n{}", table::faults(&runs), table::failures(&runs));
    }
    if !arguments.no_pictures && arguments.only.is_empty() {
        print!("\n{}", table::not_a_seam(&not_a_seam::runs(arguments.seed)?));
    }
    Ok(())
}

/// All runs with a fault, in the order of the recordings.
fn faults(arguments: &Arguments) -> Result<Vec<Run>> {
    let kinds: Vec<Kind> = match arguments.only.as_slice() {
        [] => Kind::ALL.to_vec(),
        names => names.iter().map(|name| Kind::called(name)).collect::<Result<_>>()?,
    };
    let recordings: Vec<(&str, u64)> =
        recording::JOINTS.into_iter().flat_map(|joint| (0..arguments.recordings).map(move |n| (joint, n))).collect();
    let done = AtomicUsize::new(0);
    let runs: Vec<Vec<Run>> = recordings
        .par_iter()
        .map(|&(joint, number)| {
            let recording = Recording::render(joint, arguments.seed, number)?;
            let mut runs = vec![];
            for &kind in &kinds {
                for repeat in 0..arguments.repeats {
                    let run = score::run(&recording, kind, repeat);
                    runs.extend(run.with_context(|| format!("{} on {joint} {number} {repeat}", kind.name()))?);
                }
            }
            eprintln!("{} of {} recordings", done.fetch_add(1, Ordering::Relaxed) + 1, recordings.len());
            Ok(runs)
        })
        .collect::<Result<_>>()?;
    Ok(runs.into_iter().flatten().collect())
}
