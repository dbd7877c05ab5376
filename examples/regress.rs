//! Tracks built-in scenes with several seeds and prints one table: `make regress`.
//!
//! `cargo run --example regress -- [--seeds N] [SCENE]...`; without names: scenes A to K and the special
//! ones.

use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use seamtrack::config::Config;
use seamtrack::eval::Estimate;
use seamtrack::regress::{Lane, run, table};
use seamtrack::synth::{Scene, builtin};
use seamtrack::tracker::{Method, Tracker};

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
    let scores = run(&scenes, &seeds, |scene| track(scene, &method)).map_err(|error| anyhow!(error))?;
    print!("{}", table(&scores));
    Ok(())
}

/// The program's own tracker on a scene: its correlation filter's peak, and the filtered centre.
fn track(scene: &Scene, method: &Method) -> Result<Vec<Lane>, seamtrack::tracker::TrackerError> {
    let mut tracker = Tracker::new(method, None, None)?;
    let (mut kcf, mut filtered, mut frame_ms) = (vec![], vec![], vec![]);
    for i in 0..scene.frame_count() {
        let frame = scene.render(i);
        let began = Instant::now();
        let estimate = tracker.step(&frame, scene.timestamp_s(i))?;
        frame_ms.push(began.elapsed().as_secs_f64() * 1e3);
        let along = |point| scene.axis().along_px(point);
        kcf.push(estimate.kcf.map(|kcf| Estimate { position_px: along(kcf.peak), std_px: None }));
        filtered
            .push(estimate.seam.map(|seam| Estimate { position_px: along(seam.centre), std_px: Some(seam.std_px) }));
    }
    Ok(vec![
        Lane { name: "KCF".to_owned(), estimates: kcf, frame_ms: vec![] },
        Lane { name: "filtered".to_owned(), estimates: filtered, frame_ms },
    ])
}
