//! How long a step takes, by what the tracker is doing and by the size of the picture, and beside OpenCV's KCF and MOSSE on
//! the same frames, in turn, on one thread: `make speed`.
//!
//! `cargo run --release --features peers --example speed -- [--frames 300] [SCENE]...`. All frames are rendered beforehand. The peers
//! are started at the true centre with a box of 80 × 60 px, and take the same grey frame as three channels.
#![expect(clippy::disallowed_types, reason = "OpenCV's trackers take a Mat; it stays in this program")]

#[path = "shared/opencv_frame.rs"]
mod opencv_frame;

use std::time::Instant;

use anyhow::{Context, Result};
use clap::Parser;
use opencv::core::{Ptr, Rect, set_num_threads};
use opencv::prelude::TrackerTrait;
use opencv::tracking::{Legacy_TrackerMOSSE, TrackerKCF, upgrade_tracking_api};
use opencv::video::Tracker;
use seamtrack::config::Config;
use seamtrack::frame::GrayFrame;
use seamtrack::synth::{Scene, builtin};
use seamtrack::units::{MmPerPx, PixelPoint, StripeAxis};
use seamtrack::{Sensor, Session, SessionSettings, Status};

use self::opencv_frame::image_of;

/// The sizes of pictures that a step is timed on \[px\].
const SIZES_PX: [(usize, usize); 4] = [(640, 480), (1280, 960), (2048, 1088), (2592, 2048)];
/// Steps that come before those that are counted.
const WARM_UP: usize = 30;

/// Time steps of the tracker, and of OpenCV's
#[derive(Parser)]
struct Arguments {
    /// Scenes of the first table [default: one of each joint]
    scenes: Vec<String>,
    /// Frames of each
    #[arg(long, default_value_t = 300)]
    frames: usize,
}

fn main() -> Result<()> {
    let Arguments { mut scenes, frames } = Arguments::parse();
    let frames = frames.max(2 * WARM_UP);
    if scenes.is_empty() {
        scenes = ["A-butt", "B-lap", "D-vgroove-sine", "E-fillet", "I-butt-heavy", "hairline-clean"]
            .map(String::from)
            .into();
    }
    println!(
        "| scene, 640 × 480 | first ms | step p50 ms | p99 ms | p99 / p50 | MOSSE p50 ms | KCF p50 ms | step / MOSSE | KCF / step |\n|---|---|---|---|---|---|---|---|---|"
    );
    for name in &scenes {
        let pictures = pictures(name, SIZES_PX[0], frames)?;
        beside_peers(name, &pictures)?;
    }
    println!(
        "\n| A-butt at | step p50 ms | / 640 × 480 | p99 ms | seeking p50 ms | p99 ms | searching p50 ms | p99 ms |\n|---|---|---|---|---|---|---|---|"
    );
    let mut smallest_ms = None;
    for size in SIZES_PX {
        by_phase(size, frames.min(200), &mut smallest_ms)?;
    }
    Ok(())
}

/// A recording's frames and where its seam is in the first.
struct Pictures {
    frames: Vec<GrayFrame>,
    seam: PixelPoint,
}

fn pictures(name: &str, (width_px, height_px): (usize, usize), frames: usize) -> Result<Pictures> {
    let mut scenario = builtin::scenario(name)?;
    scenario.frames = frames;
    (scenario.image.width_px, scenario.image.height_px) = (width_px, height_px);
    scenario.image.stripe = StripeAxis::Horizontal;
    scenario.recorder.repeated = 0.0;
    let scene = Scene::new(&scenario, 61)?;
    let seam = scene.truth(0).seam.context("the scene has no seam in frame 0")?;
    Ok(Pictures { frames: (0..frames).map(|i| scene.render(i)).collect(), seam })
}

fn session() -> Result<Session> {
    let sensor = Sensor::Scale(MmPerPx::DU_2022);
    Ok(Session::new(&SessionSettings { sensor, ..SessionSettings::new(Config::default().method()?) })?)
}

/// What `work` gives, and how long it takes \[ms\].
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let began = Instant::now();
    let done = work();
    (done, began.elapsed().as_secs_f64() * 1e3)
}

/// The value that a share of all are not above; NaN of none.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

fn beside_peers(name: &str, pictures: &Pictures) -> Result<()> {
    let mut session = session()?;
    let mut peers = Peers::start(pictures)?;
    let (mut ours, mut first_ms) = (vec![], f64::NAN);
    for (i, frame) in pictures.frames.iter().enumerate() {
        let (estimate, took_ms) = timed(|| session.step(frame, 0.2 * i as f64));
        let estimate = estimate?;
        if i == 0 {
            first_ms = took_ms;
        }
        if i >= WARM_UP && estimate.status == Status::Tracked {
            ours.push(took_ms);
        }
        peers.step(i)?;
    }
    let (p50, p99) = (quantile(&mut ours, 0.5), quantile(&mut ours, 0.99));
    let [mosse, kcf] = peers.medians_ms();
    println!(
        "| {name} | {first_ms:.2} | {p50:.3} | {p99:.3} | {:.1} | {mosse:.3} | {kcf:.3} | {:.2} | {:.1} |",
        p99 / p50,
        p50 / mosse,
        kcf / p50
    );
    Ok(())
}

fn by_phase(size: (usize, usize), frames: usize, smallest_ms: &mut Option<f64>) -> Result<()> {
    let Pictures { frames: pictures, .. } = pictures("A-butt", size, frames)?;
    let (mut following, mut seeking, mut searching) = (vec![], vec![], vec![]);
    let mut session = session()?;
    for (i, frame) in pictures.iter().enumerate() {
        let (estimate, took_ms) = timed(|| session.step(frame, 0.2 * i as f64));
        if i >= WARM_UP && estimate?.status == Status::Tracked {
            following.push(took_ms);
        }
    }
    // The plate goes on and its seam does not: at first it is waited for, then searched.
    let without: Vec<GrayFrame> = pictures.iter().map(covered).collect();
    for (i, frame) in without.iter().enumerate() {
        let (estimate, took_ms) = timed(|| session.step(frame, 0.2 * (frames + i) as f64));
        if estimate?.status == Status::Lost {
            searching.push(took_ms);
        }
    }
    let mut session = crate::session()?;
    for (i, frame) in without.iter().enumerate() {
        let (estimate, took_ms) = timed(|| session.step(frame, 0.2 * i as f64));
        if estimate?.status == Status::Seeking {
            seeking.push(took_ms);
        }
    }
    let p50 = quantile(&mut following, 0.5);
    let ratio = p50 / *smallest_ms.get_or_insert(p50);
    println!(
        "| {} × {} | {p50:.3} | {ratio:.2} | {:.3} | {:.3} | {:.3} | {:.3} | {:.3} |",
        size.0,
        size.1,
        quantile(&mut following, 0.99),
        quantile(&mut seeking, 0.5),
        quantile(&mut seeking, 0.99),
        quantile(&mut searching, 0.5),
        quantile(&mut searching, 0.99),
    );
    Ok(())
}

/// The frame with its middle third covered by something grey and grainy.
fn covered(frame: &GrayFrame) -> GrayFrame {
    let mut frame = frame.clone();
    let width_px = frame.width_px();
    for row in frame.pixels_mut().chunks_exact_mut(width_px) {
        for pixel in &mut row[width_px / 3..2 * width_px / 3] {
            *pixel = 20 + *pixel % 16;
        }
    }
    frame
}

/// OpenCV's trackers.
struct Peers<'a> {
    pictures: &'a Pictures,
    mosse: Ptr<Tracker>,
    kcf: Ptr<TrackerKCF>,
    took_ms: [Vec<f64>; 2],
}

impl<'a> Peers<'a> {
    fn start(pictures: &'a Pictures) -> Result<Self> {
        set_num_threads(1)?;
        let mut mosse = upgrade_tracking_api(&Legacy_TrackerMOSSE::create()?.into())?;
        let mut kcf = TrackerKCF::create_def()?;
        let corner = [pictures.seam.u_px - 40.0, pictures.seam.v_px - 30.0].map(|px| px.round() as i32);
        let first = Rect::new(corner[0], corner[1], 80, 60);
        let image = image_of(&pictures.frames[0])?;
        mosse.init(&image, first)?;
        kcf.init(&image, first)?;
        Ok(Self { pictures, mosse, kcf, took_ms: [vec![], vec![]] })
    }

    fn step(&mut self, i: usize) -> Result<()> {
        let image = image_of(&self.pictures.frames[i])?;
        let mut found = Rect::default();
        let (is_found, mosse_ms) = timed(|| self.mosse.update(&image, &mut found));
        is_found?;
        let (is_found, kcf_ms) = timed(|| self.kcf.update(&image, &mut found));
        is_found?;
        self.took_ms[0].push(mosse_ms);
        self.took_ms[1].push(kcf_ms);
        Ok(())
    }

    fn medians_ms(mut self) -> [f64; 2] {
        [0, 1].map(|i| quantile(&mut self.took_ms[i], 0.5))
    }
}
