//! Tracks the families of plates that fight back with several seeds, the joint not told, and prints one table:
//! `make plates`.
//!
//! `cargo run --release --example plates -- [--seeds 201-205] [--by level] [--csv FILE] [NAME]...`; a NAME is a part of
//! scenes' names, as `marks`, `-flat-` or `pipe-butt-severe`; `--level severe` leaves the other levels out.

use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result};
use clap::{Parser, ValueEnum};
use rayon::prelude::*;
use seamtrack::config::Config;
use seamtrack::eval::{Estimate, WRONG_MM};
use seamtrack::regress::{Lane, follow, parse_seeds};
use seamtrack::synth::Scene;
use seamtrack::synth::families::{PlateScene, plate_scenes};

/// Track the families of difficult plates and print one table
#[derive(Parser)]
struct Arguments {
    /// Parts of scenes' names [default: all]
    names: Vec<String>,
    /// 5 for 1 to 5, or 11-15
    #[arg(long, default_value = "201-205", value_parser = parse_seeds)]
    seeds: RangeInclusive<u64>,
    /// Only this level
    #[arg(long)]
    level: Option<String>,
    /// What makes a row
    #[arg(long, value_enum, default_value = "joint")]
    by: By,
    /// Write one line for each recording to this file
    #[arg(long)]
    csv: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum By {
    /// Each family
    Family,
    /// Each joint of a family
    Joint,
    /// Each level of it
    Level,
}

/// Sums over the frames of one or more recordings for one estimate.
#[derive(Clone, Default)]
struct Sums {
    values: usize,
    sum_mm: f64,
    max_mm: f64,
    wrong: usize,
    invented: usize,
    /// Frames with a seam and without a value: after the first value, and before it.
    unavailable: usize,
    sought: usize,
    claims: usize,
    within: usize,
    /// Sum of squared errors over their stated variance.
    nees: f64,
}

/// What became of one or more recordings.
#[derive(Clone, Default)]
struct Outcome {
    recordings: usize,
    /// Recordings with a seam, and those of them with a value.
    with_seam: usize,
    found: usize,
    /// Recordings without a seam in which something was found.
    fooled: usize,
    seam_frames: usize,
    causal: Sums,
    smoothed: Sums,
}

impl Sums {
    fn of(lane: &Lane, truth_px: &[Option<f64>], mm_per_px: f64) -> Self {
        let mut sums = Self::default();
        let mut begun = false;
        for (estimate, truth_px) in lane.estimates.iter().zip(truth_px) {
            begun |= estimate.is_some();
            match (estimate, truth_px) {
                (Some(estimate), Some(truth_px)) => {
                    let error_px = estimate.position_px - truth_px;
                    let error_mm = mm_per_px * error_px.abs();
                    sums.values += 1;
                    sums.sum_mm += error_mm;
                    sums.max_mm = sums.max_mm.max(error_mm);
                    sums.wrong += usize::from(error_mm > WRONG_MM);
                    if let Some(std_px) = estimate.std_px {
                        sums.claims += 1;
                        sums.within += usize::from(error_px.abs() <= 2.0 * std_px);
                        sums.nees += (error_px / std_px).powi(2);
                    }
                }
                (Some(_), None) => sums.invented += 1,
                (None, Some(_)) if begun => sums.unavailable += 1,
                (None, Some(_)) => sums.sought += 1,
                (None, None) => {}
            }
        }
        sums
    }

    fn add(&mut self, other: &Self) {
        self.values += other.values;
        self.sum_mm += other.sum_mm;
        self.max_mm = self.max_mm.max(other.max_mm);
        self.wrong += other.wrong;
        self.invented += other.invented;
        self.unavailable += other.unavailable;
        self.sought += other.sought;
        self.claims += other.claims;
        self.within += other.within;
        self.nees += other.nees;
    }

    fn errors(&self) -> String {
        if self.values == 0 {
            return "–".to_owned();
        }
        format!("{:.3} / {:.2}", self.sum_mm / self.values as f64, self.max_mm)
    }

    fn per_claim(&self, sum: f64) -> String {
        if self.claims == 0 { "–".to_owned() } else { format!("{:.2}", sum / self.claims as f64) }
    }
}

impl Outcome {
    fn add(&mut self, other: &Self) {
        self.recordings += other.recordings;
        self.with_seam += other.with_seam;
        self.found += other.found;
        self.fooled += other.fooled;
        self.seam_frames += other.seam_frames;
        self.causal.add(&other.causal);
        self.smoothed.add(&other.smoothed);
    }

    fn row(&self, name: &str) -> String {
        let (c, s) = (&self.causal, &self.smoothed);
        let unavailable = if self.seam_frames == 0 {
            "–".to_owned()
        } else {
            let percent = 100.0 * c.unavailable as f64 / self.seam_frames as f64;
            format!("{} ({percent:.1} %); {}", c.unavailable, c.sought)
        };
        let found = if self.with_seam > 0 {
            format!("{} of {}", self.found, self.with_seam)
        } else {
            format!("({} of {})", self.fooled, self.recordings)
        };
        format!(
            "| {name} | {found} | {} | {} | {}; {} | {}; {} | {unavailable} | {}; {} | {}; {} |",
            c.errors(),
            s.errors(),
            c.wrong,
            s.wrong,
            c.invented,
            s.invented,
            c.per_claim(c.within as f64),
            s.per_claim(s.within as f64),
            c.per_claim(c.nees),
            s.per_claim(s.nees),
        )
    }
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let wanted = |scene: &PlateScene| {
        let named =
            arguments.names.is_empty() || arguments.names.iter().any(|name| scene.name().contains(name.as_str()));
        named && arguments.level.as_ref().is_none_or(|level| level == scene.level)
    };
    let scenes: Vec<PlateScene> = plate_scenes()?.into_iter().filter(wanted).collect();
    let seeds: Vec<u64> = arguments.seeds.clone().collect();
    let cases: Vec<(PlateScene, u64)> =
        scenes.iter().flat_map(|&scene| seeds.iter().map(move |&seed| (scene, seed))).collect();
    let done = AtomicUsize::new(0);
    let outcomes: Vec<Outcome> = cases
        .par_iter()
        .map(|(scene, seed)| {
            let outcome = outcome(scene, *seed)?;
            eprint!("\r{} of {} recordings", done.fetch_add(1, Ordering::Relaxed) + 1, cases.len());
            Ok(outcome)
        })
        .collect::<Result<Vec<_>>>()?;
    eprintln!();
    println!(
        "| plates | found | causal: mean / max mm | smoothed: mean / max mm | wrong causal; smoothed | invented causal; smoothed | unavailable; before the first value | in 2σ causal; smoothed | NEES causal; smoothed |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut rows: Vec<(String, Outcome)> = Vec::new();
    for ((scene, _), outcome) in cases.iter().zip(&outcomes) {
        let name = match arguments.by {
            By::Family if scene.joint == "flat" => format!("{}, no seam", scene.family),
            By::Family => scene.family.to_owned(),
            By::Joint => format!("{}: {}", scene.family, scene.joint),
            By::Level => format!("{}: {}, {}", scene.family, scene.joint, scene.level),
        };
        match rows.iter_mut().find(|(row, _)| *row == name) {
            Some((_, sum)) => sum.add(outcome),
            None => rows.push((name, outcome.clone())),
        }
    }
    for (name, outcome) in &rows {
        println!("{}", outcome.row(name));
    }
    for (name, seam) in [("**all with a seam**", true), ("**all without**", false)] {
        let mut sum = Outcome::default();
        cases.iter().zip(&outcomes).filter(|((s, _), _)| (s.joint != "flat") == seam).for_each(|(_, o)| sum.add(o));
        println!("{}", sum.row(name));
    }
    if let Some(file) = &arguments.csv {
        let mut text = String::from(
            "family,joint,level,seed,values,mean_mm,max_mm,wrong,smoothed_wrong,invented,unavailable,within,nees,smoothed_within,smoothed_nees\n",
        );
        for ((scene, seed), o) in cases.iter().zip(&outcomes) {
            let (c, s) = (&o.causal, &o.smoothed);
            let mean = |sum: f64, count: usize| if count == 0 { f64::NAN } else { sum / count as f64 };
            writeln!(
                text,
                "{},{},{},{seed},{},{:.4},{:.4},{},{},{},{},{:.3},{:.3},{:.3},{:.3}",
                scene.family,
                scene.joint,
                scene.level,
                c.values,
                mean(c.sum_mm, c.values),
                c.max_mm,
                c.wrong,
                s.wrong,
                c.invented,
                c.unavailable,
                mean(c.within as f64, c.claims),
                mean(c.nees, c.claims),
                mean(s.within as f64, s.claims),
                mean(s.nees, s.claims),
            )?;
        }
        std::fs::write(file, text).with_context(|| format!("cannot write {}", file.display()))?;
    }
    Ok(())
}

fn outcome(plates: &PlateScene, seed: u64) -> Result<Outcome> {
    let scene = Scene::new(&plates.scenario()?, seed)?;
    let lanes = follow(&scene, &Config::default().method()?)?;
    let lane = |name: &str| lanes.iter().find(|lane| lane.name == name).context("the tracker has no such path");
    let (causal, smoothed) = (lane("filtered")?, lane("smoothed")?);
    let along = |point| scene.axis().along_px(point);
    let seams = |second: bool| -> Vec<Option<f64>> {
        let point = |i| if second { scene.truth(i).second } else { scene.truth(i).seam };
        (0..scene.frame_count()).map(|i| point(i).map(along)).collect()
    };
    // Of two equal seams either may be followed, but only one: the one it was first nearer to.
    let (first, second) = (seams(false), seams(true));
    let begun = causal.estimates.iter().position(Option::is_some);
    let distance = |truth: &[Option<f64>]| {
        let estimate: Estimate = causal.estimates[begun?]?;
        Some((estimate.position_px - truth[begun?]?).abs())
    };
    let truth = match (distance(&first), distance(&second)) {
        (Some(to_first), Some(to_second)) if to_second < to_first => second,
        _ => first,
    };
    let mm_per_px = scene.drawn_scenario().mm_per_px.get();
    let seam_frames = truth.iter().flatten().count();
    let causal = Sums::of(causal, &truth, mm_per_px);
    Ok(Outcome {
        recordings: 1,
        with_seam: usize::from(seam_frames > 0),
        found: usize::from(causal.values > 0),
        fooled: usize::from(seam_frames == 0 && causal.invented > 0),
        seam_frames,
        smoothed: Sums::of(smoothed, &truth, mm_per_px),
        causal,
    })
}
