//! Tracks built-in scenes with several seeds and prints one table: `make regress`.
//!
//! `cargo run --release --example regress -- [--seeds 11-15] [--find-joint] [SCENE]...`. The tracker is
//! told the joint unless `--find-joint` asks it to find out.

use std::ops::RangeInclusive;

use anyhow::{Result, anyhow};
use clap::Parser;
use seamtrack::config::{Config, Joint, Preset};
use seamtrack::regress::{Lane, follow, parse_seeds, run, table};
use seamtrack::synth::scenario::Joint as DrawnJoint;
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::TrackerError;

/// Track built-in scenes with several seeds and print one table
#[derive(Parser)]
struct Arguments {
    /// Scenes [default: A to K and the special ones]
    scenes: Vec<String>,
    /// 5 for 1 to 5, or 11-15
    #[arg(long, default_value = "1-3", value_parser = parse_seeds)]
    seeds: RangeInclusive<u64>,
    /// Let the program find the kind of joint
    #[arg(long)]
    find_joint: bool,
    /// Leave the paper's method out
    #[arg(long)]
    ours: bool,
}

fn main() -> Result<()> {
    let Arguments { scenes: mut names, seeds, find_joint, ours } = Arguments::parse();
    if names.is_empty() {
        names = builtin::scene_names();
    }
    let named = |name: String| Ok((name.clone(), builtin::scenario(&name)?));
    let scenes = names.into_iter().map(named).collect::<Result<Vec<_>>>()?;
    let seeds: Vec<u64> = seeds.collect();
    let scores = run(&scenes, &seeds, |scene| lanes(scene, find_joint, ours)).map_err(|error| anyhow!(error))?;
    print!("{}", table(&scores));
    Ok(())
}

/// The paper's method, then the robust one: causal, smoothed, and its height.
fn lanes(scene: &Scene, find_joint: bool, ours: bool) -> Result<Vec<Lane>, TrackerError> {
    let joint = match scene.drawn_scenario().joint {
        _ if find_joint => Joint::Auto,
        DrawnJoint::Butt(_) => Joint::Butt,
        DrawnJoint::Lap(_) => Joint::Lap,
        DrawnJoint::Vgroove(_) => Joint::Vgroove,
        DrawnJoint::Fillet(_) => Joint::Fillet,
        _ => Joint::Auto,
    };
    let paper = Config { preset: Preset::Paper, ..Config::default() };
    let robust = Config { joint, ..Config::default() };
    let renamed = |lane: Lane, name: &str| Lane { name: name.to_owned(), ..lane };
    let mut lanes = vec![];
    let of_paper = [("KCF", "KCF alone"), ("filtered", "paper")];
    let of_robust = [
        ("filtered", "causal"),
        ("smoothed", "smoothed"),
        ("height", "height"),
        ("smoothed height", "smoothed height"),
    ];
    for (config, wanted) in [(paper, &of_paper[..]), (robust, &of_robust)] {
        if ours && config.preset == Preset::Paper {
            continue;
        }
        let Ok(method) = config.method() else { continue };
        for lane in follow(scene, &method)? {
            if let Some((_, name)) = wanted.iter().find(|(name, _)| *name == lane.name) {
                lanes.push(renamed(lane, name));
            }
        }
    }
    Ok(lanes)
}
