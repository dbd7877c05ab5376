//! Runs of the program that are killed at random moments, pairs of runs into one folder, a full disk, a disk that must not be
//! written, an output that is deleted: the earlier results are there whole, or the new ones are: `make kills`.
//!
//! `cargo run --release --example kills -- [--kills 500] [--pairs 50] [--seed 1]`, after `cargo build --release`. A small file
//! system is mounted where the user may do so (root, in a container); else the limit of a process's files stands for the full
//! disk. Exit code 1 when a result is mixed.
#![cfg(unix)]

mod disk;
mod program;

use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use self::program::{Found, Program};

/// Kill runs of the program and look at what they leave
#[derive(Parser)]
struct Arguments {
    /// How many runs are killed, every other one over older results
    #[arg(long, default_value_t = 500)]
    kills: usize,
    /// How many pairs of runs go into one folder at once
    #[arg(long, default_value_t = 50)]
    pairs: usize,
    /// Which campaign: each seed draws other moments
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// What was found after some runs.
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
    fn count(&mut self, found: Found) {
        self.runs += 1;
        match found {
            Found::Old => self.old += 1,
            Found::New => self.new += 1,
            Found::Nothing => self.absent += 1,
            Found::Mixed => self.mixed += 1,
        }
    }

    fn print(&self, name: &str) {
        println!(
            "| {name} | {} | {} | {} | {} | {} | {} |",
            self.runs, self.old, self.new, self.absent, self.mixed, self.lines
        );
    }
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let folder = tempfile::tempdir().context("there is no temporary folder")?;
    let program = Program::new(folder.path())?;
    let mut random = Pcg64Mcg::seed_from_u64(arguments.seed);
    println!(
        "| what | runs | old result there | new one there | none there | mixed | messages of more than one line |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut mixed = 0;
    let mut done = |name: &str, tally: Tally| {
        tally.print(name);
        mixed += tally.mixed;
    };
    for (name, over_old) in [("killed, no older result", false), ("killed over an older result", true)] {
        done(name, kills(&program, arguments.kills / 2, over_old, &mut random)?);
    }
    done("two at once", pairs(&program, arguments.pairs)?);
    done("output deleted meanwhile", deleted(&program, &mut random)?);
    for kind in disk::Kind::ALL {
        match disk::tally(&program, kind) {
            Ok(tally) => done(kind.name(), tally),
            Err(error) => println!("| {}: left out, {error:#} | 0 | 0 | 0 | 0 | 0 | 0 |", kind.name()),
        }
    }
    Ok(if mixed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs that are killed at a moment between their start and a little after they would have ended.
fn kills(program: &Program, count: usize, over_old: bool, random: &mut Pcg64Mcg) -> Result<Tally> {
    let mut tally = Tally::default();
    let whole = program.time_of_a_run()?;
    for _ in 0..count {
        program.prepare(over_old)?;
        let mut run = program.start(&program.new_input, &["--force"])?;
        std::thread::sleep(whole.mul_f64(random.random_range(0.0..1.1)));
        run.kill().context("the run cannot be killed")?;
        run.wait().context("the run cannot be awaited")?;
        tally.count(program.found()?);
        // Whatever it left, the next run sets right.
        let after = program.start(&program.old_input, &["--force"])?.wait_with_output()?;
        let is_clean = after.status.success() && program.found()? == Found::Old && !program.has_leftovers()?;
        tally.mixed += usize::from(!is_clean);
    }
    Ok(tally)
}

/// Two runs of different recordings at the same time.
fn pairs(program: &Program, count: usize) -> Result<Tally> {
    let mut tally = Tally::default();
    for pair in 0..count {
        program.prepare(pair % 2 == 1)?;
        let inputs = [&program.old_input, &program.new_input];
        let runs = [program.start(inputs[pair % 2], &["--force"])?, program.start(inputs[1 - pair % 2], &["--force"])?];
        for run in runs {
            let ended = run.wait_with_output()?;
            tally.lines += usize::from(!ended.status.success() && program::lines(&ended) != 1);
        }
        tally.count(program.found()?);
        tally.mixed += usize::from(program.has_leftovers()?);
    }
    Ok(tally)
}

/// The output, or what is being written, is removed while a run works.
fn deleted(program: &Program, random: &mut Pcg64Mcg) -> Result<Tally> {
    let mut tally = Tally::default();
    let whole = program.time_of_a_run()?;
    for number in 0..20 {
        program.prepare(true)?;
        let run = program.start(&program.new_input, &["--force"])?;
        std::thread::sleep(whole.mul_f64(random.random_range(0.0..0.9)));
        // It may be gone, or not there yet.
        let _gone =
            std::fs::remove_dir_all(if number % 2 == 0 { program.unfinished() } else { program.output.clone() });
        let ended = run.wait_with_output()?;
        tally.lines += usize::from(!ended.status.success() && program::lines(&ended) != 1);
        tally.count(program.found()?);
    }
    Ok(tally)
}
