//! Which joint the program finds by itself, and when, in every kind of scene: `make kinds`.
//!
//! `cargo run --release --example kinds -- [--seeds 121-124] [--frames 60] [SCENE]...`. Right is the right kind within 10
//! frames of the seam's appearance; on a plate without a joint, none.

use std::ops::RangeInclusive;

use anyhow::{Context, Result};
use clap::Parser;
use rayon::prelude::*;
use seamtrack::config::Config;
use seamtrack::regress::{follow_with, parse_seeds, score};
use seamtrack::synth::scenario::{Joint, Scenario};
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::SeamPath;

/// Frames within which the joint should be found.
const SOON_FRAMES: usize = 10;

/// Print which joint is found when
#[derive(Parser)]
struct Arguments {
    /// Scenes [default: all families in all levels, and the special scenes]
    scenes: Vec<String>,
    /// 5 for 1 to 5, or 11-15
    #[arg(long, default_value = "121-124", value_parser = parse_seeds)]
    seeds: RangeInclusive<u64>,
    /// Length of each recording
    #[arg(long, default_value_t = 60)]
    frames: usize,
}

/// What became of one recording.
struct Found {
    right: bool,
    late: bool,
    other_kind: bool,
    invented: usize,
    wrong: usize,
}

fn main() -> Result<()> {
    let Arguments { scenes: mut names, seeds, frames } = Arguments::parse();
    if names.is_empty() {
        names = builtin::names();
    }
    println!("| scene | right within {SOON_FRAMES} frames | later or never | another kind | invented | wrong |");
    println!("|---|---|---|---|---|---|");
    for name in names {
        let scenario = Scenario { frames, ..builtin::scenario(&name)? };
        let runs = seeds.clone().into_par_iter().map(|seed| find(&scenario, seed)).collect::<Result<Vec<Found>>>()?;
        let count = |what: fn(&Found) -> bool| runs.iter().filter(|run| what(run)).count();
        let sum = |what: fn(&Found) -> usize| runs.iter().map(what).sum::<usize>();
        let (right, late, other) = (count(|run| run.right), count(|run| run.late), count(|run| run.other_kind));
        let (invented, wrong) = (sum(|run| run.invented), sum(|run| run.wrong));
        println!("| {name} | {right} of {} | {late} | {other} | {invented} | {wrong} |", runs.len());
    }
    Ok(())
}

fn find(scenario: &Scenario, seed: u64) -> Result<Found> {
    let scene = Scene::new(scenario, seed)?;
    let wanted = match scenario.joint {
        Joint::Flat => None,
        Joint::Lap(_) => Some("lap"),
        Joint::Vgroove(_) => Some("vgroove"),
        Joint::Fillet(_) => Some("fillet"),
        Joint::Butt(_) | Joint::Hairline(_) => Some("butt"),
    };
    let (lanes, joints) = follow_with(&scene, &Config::default().method()?, SeamPath::default())?;
    let filtered = lanes.iter().find(|lane| lane.name == "filtered").context("the tracker has no causal path")?;
    let score = score("", seed, &scene, filtered);
    let appeared = (0..scene.frame_count()).find(|&i| scene.truth(i).seam.is_some());
    let decided = joints.first();
    let other_kind = decided.is_some_and(|joint| Some(joint.kind) != wanted);
    let soon = decided.is_some_and(|joint| joint.frame <= appeared.unwrap_or(0) + SOON_FRAMES);
    let late = wanted.is_some() && !soon;
    let wrong = score.errors.map_or(0, |errors| errors.wrong_frames);
    Ok(Found { right: !other_kind && !late, late, other_kind, invented: score.invented_frames, wrong })
}
