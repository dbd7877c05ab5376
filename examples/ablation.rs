//! Takes the parts of the robust method away one at a time and prints one table: `make ablation`.
//!
//! `cargo run --release --features ablation --example ablation -- [--seeds 61-63] [SCENE]...`. The tracker finds the joint by itself.

use std::ops::RangeInclusive;

use anyhow::{Result, anyhow};
use clap::Parser;
use seamtrack::regress::{Lane, Score, follow_with, parse_seeds, run};
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::{Method, Part, RobustSettings, SeamPath, TrackerError};

/// Take the parts of the robust method away one at a time and print one table
#[derive(Parser)]
struct Arguments {
    /// Scenes [default: those that are hard for one reason or another]
    scenes: Vec<String>,
    /// 5 for 1 to 5, or 11-15
    #[arg(long, default_value = "61-63", value_parser = parse_seeds)]
    seeds: RangeInclusive<u64>,
}

const SCENES: [&str; 11] = [
    "C-butt-severe",
    "D-vgroove-sine",
    "F-lap-false-stripe",
    "G-butt-widening",
    "H-butt-covers",
    "I-butt-heavy",
    "J-lap-heavy",
    "K-butt-narrow",
    "tack",
    "large",
    "du-butt",
];

fn main() -> Result<()> {
    let Arguments { scenes: mut names, seeds } = Arguments::parse();
    if names.is_empty() {
        names = SCENES.map(str::to_owned).to_vec();
    }
    let named = |name: String| Ok((name.clone(), builtin::scenario(&name)?));
    let scenes = names.into_iter().map(named).collect::<Result<Vec<_>>>()?;
    let seeds: Vec<u64> = seeds.collect();
    println!(
        "| without | causal mean mm | worst | smoothed mean mm | worst | in 2σ | unavailable | wrong | not decided |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for without in std::iter::once(None).chain(Part::ALL.map(Some)) {
        let scores = run(&scenes, &seeds, |scene| lanes(scene, without)).map_err(|error| anyhow!(error))?;
        println!("{}", line(without.map_or("(nothing)", Part::name), &scores));
    }
    Ok(())
}

/// The tracker without a part.
fn lanes(scene: &Scene, without: Option<Part>) -> Result<Vec<Lane>, TrackerError> {
    let method = Method::Robust(RobustSettings::without(without));
    let whole = SeamPath::default();
    let path = if without == Some(Part::SmootherFit) { whole.without_fit() } else { whole };
    Ok(follow_with(scene, &method, path)?.0)
}

/// Means of the mean errors, worst of the maxima, sums of the counts.
fn line(name: &str, scores: &[Score]) -> String {
    let of = |lane: &'static str| scores.iter().filter(move |score| score.lane == lane);
    let mean = |lane, figure: fn(&Score) -> Option<f64>| {
        let values: Vec<f64> = of(lane).filter_map(figure).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    };
    let worst = |lane| of(lane).filter_map(|s| Some(s.errors?.max)).fold(0.0, f64::max);
    let sum = |figure: fn(&Score) -> usize| of("filtered").map(figure).sum::<usize>();
    format!(
        "| {name} | {:.4} | {:.2} | {:.4} | {:.2} | {:.3} | {} | {} | {} |",
        mean("filtered", |s| Some(s.errors?.mae)),
        worst("filtered"),
        mean("smoothed", |s| Some(s.errors?.mae)),
        worst("smoothed"),
        mean("filtered", |s| s.errors?.coverage_2sigma),
        sum(|s| s.errors.map_or(0, |e| e.unavailable_frames)),
        sum(|s| s.errors.map_or(0, |e| e.wrong_frames)),
        sum(|s| s.lost_frames - s.errors.map_or(0, |e| e.unavailable_frames + e.wrong_frames).min(s.lost_frames)),
    )
}
