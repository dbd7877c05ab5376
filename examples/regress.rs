//! Tracks built-in scenes with several seeds and prints one table: `make regress`.
//!
//! `cargo run --example regress -- [--seeds N] [SCENE]...`; without names: scenes A to K and the special
//! ones.

use anyhow::{Context, Result, anyhow};
use seamtrack::config::Config;
use seamtrack::regress::{follow, run, table};
use seamtrack::synth::builtin;

fn main() -> Result<()> {
    let (mut seeds, mut names) = (3, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--seeds" {
            seeds = arguments.next().context("--seeds needs a number")?.parse().context("--seeds needs a number")?;
        } else {
            names.push(argument);
        }
    }
    if names.is_empty() {
        names = builtin::scene_names();
    }
    let scenes =
        names.into_iter().map(|name| Ok((name.clone(), builtin::scenario(&name)?))).collect::<Result<Vec<_>>>()?;
    let seeds: Vec<u64> = (1..=seeds).collect();
    let method = Config::default().method()?;
    let scores = run(&scenes, &seeds, |scene| follow(scene, &method)).map_err(|error| anyhow!(error))?;
    print!("{}", table(&scores));
    Ok(())
}
