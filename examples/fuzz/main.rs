//! Hostile inputs on a stable compiler, without the guidance of cargo-fuzz: `make fuzz`.
//!
//! `cargo run --release --example fuzz -- [--inputs 1000000] [--seed 1] [--target NAME] [--only NUMBER]`. No input may
//! panic, take more than two seconds or more than a gigabyte. Those that do are written to `fuzz/artifacts`, and the exit code is 1.
#![allow(clippy::expect_used, reason = "a promise that is broken ends a target by a panic, which is what is sought")]

#[path = "../../fuzz/mutate.rs"]
mod mutate;
#[path = "../../fuzz/targets.rs"]
mod targets;

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use clap::Parser;
use rayon::prelude::*;

use self::mutate::Corpus;
use self::targets::{TARGETS, Target};

/// Longest time and most memory that an input may take.
const LONGEST: Duration = Duration::from_secs(2);
const MOST_BYTES: u64 = 1 << 30;
/// Inputs that a thread takes at a time.
const BATCH: u64 = 500;
/// Failures of a target that are shown and kept.
const SHOWN_FAILURES: usize = 10;

/// Feed hostile inputs to everything that reads
#[derive(Parser)]
struct Arguments {
    /// How many, over all targets
    #[arg(long, default_value_t = 1_000_000)]
    inputs: u64,
    /// Which campaign: each seed makes others
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only this target
    #[arg(long)]
    target: Option<String>,
    /// Only this input of the target
    #[arg(long, requires = "target")]
    only: Option<u64>,
}

/// What some inputs of a target took.
#[derive(Clone, Default)]
struct Taken {
    inputs: u64,
    longest: Duration,
    most_bytes: u64,
    all: Duration,
    failures: Vec<(u64, String)>,
}

impl Taken {
    fn with(mut self, other: Self) -> Self {
        self.failures.extend(other.failures);
        Self {
            inputs: self.inputs + other.inputs,
            longest: self.longest.max(other.longest),
            most_bytes: self.most_bytes.max(other.most_bytes),
            all: self.all + other.all,
            failures: self.failures,
        }
    }
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let wanted = |target: &&Target| arguments.target.as_ref().is_none_or(|name| name == target.name);
    let wanted: Vec<&Target> = TARGETS.iter().filter(wanted).collect();
    anyhow::ensure!(!wanted.is_empty(), "the targets are {}", TARGETS.map(|target| target.name).join(", "));
    let shares: u64 = wanted.iter().map(|target| target.share).sum();
    println!("| target | inputs | longest ms | mean ms | most memory MB | failures |\n|---|---|---|---|---|---|");
    let mut all = Taken::default();
    for target in wanted {
        let corpus = Corpus::read(target.name).with_context(|| format!("cannot read the corpus of {}", target.name))?;
        let count = (arguments.inputs * target.share).div_ceil(shares);
        let taken = match arguments.only {
            Some(number) => batch(target, &corpus, arguments.seed, number..number + 1),
            None => (0..count.div_ceil(BATCH))
                .into_par_iter()
                .map(|n| batch(target, &corpus, arguments.seed, n * BATCH..count.min((n + 1) * BATCH)))
                .reduce(Taken::default, Taken::with),
        };
        print_row(target.name, &taken);
        for (number, why) in taken.failures.iter().take(SHOWN_FAILURES) {
            let file = keep(target.name, *number, &corpus.changed(arguments.seed, *number))?;
            println!("  {} --only {number}: {why} ({file})", target.name);
        }
        all = all.with(taken);
    }
    print_row("**all**", &all);
    Ok(if all.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn batch(target: &Target, corpus: &Corpus, seed: u64, numbers: std::ops::Range<u64>) -> Taken {
    let mut taken = Taken::default();
    for number in numbers {
        // The first ones are the corpus itself.
        let unchanged = usize::try_from(number).ok().and_then(|number| corpus.inputs().get(number).cloned());
        let input = unchanged.unwrap_or_else(|| corpus.changed(seed, number));
        let (began, mut outcome) = (Instant::now(), Ok(()));
        let memory = allocation_counter::measure(|| {
            outcome = std::panic::catch_unwind(|| (target.run)(&input));
        });
        let took = began.elapsed();
        taken.inputs += 1;
        taken.all += took;
        taken.longest = taken.longest.max(took);
        taken.most_bytes = taken.most_bytes.max(memory.bytes_max);
        let why = match outcome {
            Err(_) => Some("it panics".to_owned()),
            Ok(()) if took > LONGEST => Some(format!("it takes {:.1} s", took.as_secs_f64())),
            Ok(()) if memory.bytes_max > MOST_BYTES => Some(format!("it takes {} MB", memory.bytes_max >> 20)),
            Ok(()) => None,
        };
        taken.failures.extend(why.map(|why| (number, why)));
    }
    taken
}

fn print_row(name: &str, taken: &Taken) {
    println!(
        "| {name} | {} | {:.0} | {:.3} | {:.1} | {} |",
        taken.inputs,
        taken.longest.as_secs_f64() * 1e3,
        taken.all.as_secs_f64() * 1e3 / taken.inputs.max(1) as f64,
        taken.most_bytes as f64 / 1e6,
        taken.failures.len()
    );
}

fn keep(target: &str, number: u64, input: &[u8]) -> Result<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/artifacts");
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let file = folder.join(format!("{target}-{number}"));
    std::fs::write(&file, input).with_context(|| format!("cannot write {}", file.display()))?;
    Ok(file.display().to_string())
}
