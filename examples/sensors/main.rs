//! Recordings of random sensors, joints, paths and lights, each tracked with the scale told and the joint not:
//! `make sensors`.
//!
//! `cargo run --release --example sensors -- [--seed 1] [--recordings 300] [--only N] [--write N DIR]`. A recording
//! passes when no value is off by more than 1 mm and at most 5 % of the frames after the tenth have none.
//! `draw.rs` says what is drawn, `visible.rs` what is not asked.

mod draw;
mod score;
mod table;
mod visible;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::Parser;
use rayon::prelude::*;

/// Track recordings of random sensors and print what became of them
#[derive(Parser)]
struct Arguments {
    /// Which campaign: each seed draws other recordings
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many recordings
    #[arg(long, default_value_t = 300)]
    recordings: u64,
    /// Only this recording; may be given several times
    #[arg(long, value_name = "N")]
    only: Vec<u64>,
    /// Track nothing; write recording N as a scenario for `seamtrack synth` into the folder
    #[arg(long, num_args = 2, value_names = ["N", "DIR"])]
    write: Option<Vec<String>>,
    /// Print each recording, not only those that failed
    #[arg(long)]
    all: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some([number, folder]) = arguments.write.as_deref() {
        let number = number.parse().with_context(|| format!("{number:?} is no number of a recording"))?;
        return write(arguments.seed, number, Path::new(folder));
    }
    let numbers = if arguments.only.is_empty() { (0..arguments.recordings).collect() } else { arguments.only.clone() };
    let (began, done) = (Instant::now(), AtomicUsize::new(0));
    let outcomes: Vec<score::Outcome> = numbers
        .par_iter()
        .map(|&number| {
            let outcome = score::tracked(draw::draw(arguments.seed, number))
                .with_context(|| format!("recording {number} of seed {} cannot be tracked", arguments.seed))?;
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            if done % 20 == 0 {
                eprintln!("{done} of {} recordings, {:.0} s", numbers.len(), began.elapsed().as_secs_f64());
            }
            Ok(outcome)
        })
        .collect::<Result<_>>()?;
    if arguments.all || !arguments.only.is_empty() {
        outcomes.iter().for_each(|outcome| print!("{}", table::report(outcome)));
    }
    if arguments.only.is_empty() {
        print!("{}{}{}", table::summary(&outcomes), table::given_up(&outcomes), table::failures(&outcomes));
    }
    Ok(())
}

/// Writes a recording's scenario.
fn write(seed: u64, number: u64, folder: &Path) -> Result<()> {
    let file: PathBuf = folder.join(format!("sensors-{seed}-{number}.toml"));
    if file.exists() {
        bail!("{} exists; remove it or choose another folder", file.display());
    }
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let scenario = draw::draw(seed, number).scenario;
    std::fs::write(&file, scenario.to_toml()?).with_context(|| format!("cannot write {}", file.display()))?;
    println!("{}", file.display());
    Ok(())
}
