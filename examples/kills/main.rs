//! Runs of the program that are killed at random moments, pairs of runs into one place, an output that is deleted, a full disk, a
//! disk that must not be written: the earlier results are there whole, or the new ones are: `make kills`.
//!
//! `cargo run --release --example kills -- [--kills 500] [--pairs 50] [--seed 1] [--only NAME]`, after `cargo build --release`.
//! A small file system is mounted where the user may do so (root, in a container); elsewhere these rows are left out. Exit code
//! 1 when a result is mixed.
#![cfg(unix)]

mod case;
mod disk;
mod inputs;
mod program;

use std::process::ExitCode;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use self::case::{CASES, Case};
use self::program::{Found, Input, Program, lines};

/// Deletions for each command.
const DELETIONS: usize = 4;

/// Kill runs of the program and look at what they leave
#[derive(Parser)]
struct Arguments {
    /// How many runs are killed, every other one over older results
    #[arg(long, default_value_t = 500)]
    kills: usize,
    /// How many pairs of runs go into one place at once
    #[arg(long, default_value_t = 50)]
    pairs: usize,
    /// Which campaign: each seed draws other moments
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only the commands whose names begin so
    #[arg(long)]
    only: Option<String>,
}

/// What was found after some runs: of a command that writes several things, of the first one.
#[derive(Default)]
struct Tally {
    runs: usize,
    old: usize,
    new: usize,
    absent: usize,
    mixed: usize,
    lines: usize,
}

impl Tally {
    /// Counts what a run left.
    fn count(&mut self, found: &[Found]) {
        self.runs += 1;
        match found[0] {
            Found::Old => self.old += 1,
            Found::New => self.new += 1,
            Found::Nothing => self.absent += 1,
            Found::Mixed => {}
        }
        self.mixed += usize::from(found.contains(&Found::Mixed));
    }

    fn print(&self, command: &str, what: &str) {
        let Self { runs, old, new, absent, mixed, lines } = self;
        println!("| {command} | {what} | {runs} | {old} | {new} | {absent} | {mixed} | {lines} |");
    }
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let own = std::env::current_exe().context("this program has no path")?;
    let binary = own.ancestors().nth(2).context("this program has no folder")?.join("seamtrack");
    ensure!(binary.is_file(), "{} is missing: build the program first", binary.display());
    let folder = tempfile::tempdir().context("there is no temporary folder")?;
    let inputs = folder.path().join("inputs");
    std::fs::create_dir(&inputs)?;
    inputs::make(&binary, &inputs)?;
    let mut random = Pcg64Mcg::seed_from_u64(arguments.seed);
    println!(
        "| command | what | runs | old result there | new one there | none there | mixed | messages of more than one line |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let wanted = |case: &&Case| arguments.only.as_ref().is_none_or(|name| case.name.starts_with(name.as_str()));
    let cases: Vec<&Case> = CASES.iter().filter(wanted).collect();
    let shares: usize = cases.iter().map(|case| case.share).sum();
    let mut all_mixed = 0;
    for (place, case) in cases.into_iter().enumerate() {
        let program = Program::new(&binary, case, &inputs, &folder.path().join(place.to_string()))?;
        let (count, pair_count) = (arguments.kills * case.share, arguments.pairs * case.share);
        let mut done = |what: &str, tally: Tally| {
            tally.print(case.name, what);
            all_mixed += tally.mixed;
        };
        for (what, over_old) in [("killed, no older result", false), ("killed over an older result", true)] {
            done(what, kills(&program, count.div_ceil(2 * shares), over_old, &mut random)?);
        }
        done("two at once", pairs(&program, pair_count.div_ceil(shares))?);
        done("output deleted meanwhile", deleted(&program, &mut random)?);
        for kind in disk::Kind::ALL {
            match disk::tally(&program, kind) {
                Ok(tally) => done(kind.name(), tally),
                Err(error) => println!("| {} | {}: left out, {error:#} | 0 | | | | 0 | 0 |", case.name, kind.name()),
            }
        }
    }
    Ok(if all_mixed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs that are killed at a moment between their start and a little after they would have ended.
fn kills(program: &Program<'_>, count: usize, over_old: bool, random: &mut Pcg64Mcg) -> Result<Tally> {
    let mut tally = Tally::default();
    for _ in 0..count {
        program.prepare(over_old)?;
        let mut run = program.start(Input::New)?;
        std::thread::sleep(program.whole.mul_f64(random.random_range(0.0..1.1)));
        run.kill().context("the run cannot be killed")?;
        run.wait().context("the run cannot be awaited")?;
        tally.count(&program.found()?);
        // Whatever it left, the next run sets right.
        let after = program.start(Input::Old)?.wait_with_output()?;
        let is_done = matches!(after.status.code(), Some(0 | 3)) && !program.has_leftovers()?;
        if !is_done || program.found()?.iter().any(|found| *found != Found::Old) {
            eprintln!("{}: after a kill: {}", program.case.name, String::from_utf8_lossy(&after.stderr).trim());
            tally.mixed += 1;
        }
    }
    Ok(tally)
}

/// Two runs of different inputs at the same time.
fn pairs(program: &Program<'_>, count: usize) -> Result<Tally> {
    let mut tally = Tally::default();
    for pair in 0..count {
        program.prepare(pair % 2 == 1)?;
        let inputs = [Input::Old, Input::New];
        let runs = [program.start(inputs[pair % 2])?, program.start(inputs[1 - pair % 2])?];
        for run in runs {
            let ended = run.wait_with_output()?;
            tally.lines += usize::from(ended.status.code() == Some(1) && lines(&ended) > most_lines(program));
        }
        tally.count(&program.found()?);
        tally.mixed += usize::from(program.has_leftovers()?);
    }
    Ok(tally)
}

/// The output, or what is being written, is removed while a run works.
fn deleted(program: &Program<'_>, random: &mut Pcg64Mcg) -> Result<Tally> {
    let mut tally = Tally::default();
    for number in 0..DELETIONS {
        program.prepare(true)?;
        let run = program.start(Input::New)?;
        std::thread::sleep(program.whole.mul_f64(random.random_range(0.0..0.9)));
        let gone = if number % 2 == 0 { program.unfinished() } else { program.target() };
        // It may be gone, or not there yet.
        let _gone = if gone.is_dir() { std::fs::remove_dir_all(gone) } else { std::fs::remove_file(gone) };
        let ended = run.wait_with_output()?;
        tally.lines += usize::from(ended.status.code() == Some(1) && lines(&ended) > most_lines(program));
        tally.count(&program.found()?);
    }
    Ok(tally)
}

/// A batch says a line for each recording that has no results, and one for its index.
fn most_lines(program: &Program<'_>) -> usize {
    if program.case.name.ends_with("batch") { 4 } else { 1 }
}
