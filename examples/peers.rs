//! The trackers a user would otherwise take, on the same frames and with the same figures: `make peers`.
//!
//! `cargo run --features peers --example peers -- [--seeds N] [SCENE]...`. Each is started at the true centre of frame 0
//! with a box of 80 × 60 px and runs on one thread. Their answers are OpenCV's boxes: the centre moves by what the box
//! moves, so that rounding the first box costs nothing.
#![expect(clippy::disallowed_types, reason = "OpenCV's trackers take a Mat; it stays in this program")]

#[path = "shared/opencv_frame.rs"]
mod opencv_frame;

use std::ops::RangeInclusive;
use std::time::Instant;

use anyhow::{Result, anyhow};
use clap::Parser;
use opencv::core::{Rect, set_num_threads};
use opencv::prelude::TrackerTrait;
use opencv::tracking::{Legacy_TrackerMOSSE, TrackerCSRT, TrackerKCF, upgrade_tracking_api};
use opencv::video::TrackerMIL;
use seamtrack::config::Config;
use seamtrack::eval::Estimate;
use seamtrack::regress::{Coordinate, Lane, follow, parse_seeds, run, table};
use seamtrack::synth::{Scene, builtin};
use seamtrack::units::StripeAxis;

use self::opencv_frame::image_of;

/// Width and height of the box round the seam \[px\]: the ROI of Du 2022.
const BOX_PX: (f64, f64) = (80.0, 60.0);

/// Measure OpenCV's trackers on built-in scenes
#[derive(Parser)]
struct Arguments {
    /// Scenes [default: A to K]
    scenes: Vec<String>,
    /// 5 for 1 to 5, or 11-15
    #[arg(long, default_value = "1-3", value_parser = parse_seeds)]
    seeds: RangeInclusive<u64>,
}

fn main() -> Result<()> {
    let Arguments { scenes: mut names, seeds } = Arguments::parse();
    if names.is_empty() {
        // Scenes A to K: the special ones have frames without a seam or no seam in frame 0.
        names = builtin::scene_names().into_iter().take(12).collect();
    }
    let scenes =
        names.into_iter().map(|name| Ok((name.clone(), builtin::scenario(&name)?))).collect::<Result<Vec<_>>>()?;
    let seeds: Vec<u64> = seeds.collect();
    set_num_threads(1)?;
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let scores = one_thread.install(|| run(&scenes, &seeds, peers)).map_err(|error| anyhow!(error))?;
    print!("{}", table(&scores));
    Ok(())
}

/// All peers on a scene, one after another.
/// The peers, then the program's own causal and smoothed path with its default configuration, which finds the seam by
/// itself.
fn peers(scene: &Scene) -> Result<Vec<Lane>> {
    let mut lanes = vec![
        lane("OpenCV KCF", TrackerKCF::create_def()?, scene)?,
        lane("OpenCV CSRT", TrackerCSRT::create_def()?, scene)?,
        // MOSSE's boxes move by whole pixels, so that the newer interface loses nothing.
        lane("OpenCV MOSSE", upgrade_tracking_api(&Legacy_TrackerMOSSE::create()?.into())?, scene)?,
        lane("OpenCV MIL", TrackerMIL::create_def()?, scene)?,
    ];
    lanes.extend(
        follow(scene, &Config::default().method()?)?
            .into_iter()
            .filter(|lane| ["filtered", "smoothed"].contains(&lane.name.as_str())),
    );
    Ok(lanes)
}

/// A tracker on a scene, started at the true centre. A frame for which it reports no box has no value.
fn lane(name: &str, mut tracker: impl TrackerTrait, scene: &Scene) -> opencv::Result<Lane> {
    let start = scene.truth(0).seam.ok_or_else(|| opencv::Error::new(0, "the scene has no seam in frame 0"))?;
    let corner = (start.u_px - 0.5 * BOX_PX.0, start.v_px - 0.5 * BOX_PX.1);
    let first = Rect::new(corner.0.round() as i32, corner.1.round() as i32, BOX_PX.0 as i32, BOX_PX.1 as i32);
    tracker.init(&image_of(&scene.render(0))?, first)?;
    let start_px = scene.axis().along_px(start);
    let mut lane = Lane {
        name: name.to_owned(),
        coordinate: Coordinate::Along,
        estimates: vec![Some(Estimate { position_px: start_px, std_px: None })],
        frame_ms: vec![],
    };
    for i in 1..scene.frame_count() {
        let image = image_of(&scene.render(i))?;
        let mut found = first;
        let began = Instant::now();
        let valid = tracker.update(&image, &mut found)?;
        lane.frame_ms.push(began.elapsed().as_secs_f64() * 1e3);
        let moved_px = match scene.axis() {
            StripeAxis::Horizontal => f64::from(found.x - first.x) + 0.5 * f64::from(found.width - first.width),
            StripeAxis::Vertical => f64::from(found.y - first.y) + 0.5 * f64::from(found.height - first.height),
        };
        lane.estimates.push(valid.then_some(Estimate { position_px: start_px + moved_px, std_px: None }));
    }
    Ok(lane)
}
