//! 200,000 frames through one session: what it remembers, how long a frame takes and how sure it is must not change from the first
//! ten thousand to the last; then as many steps of the filters, whose covariances must stay symmetric and positive
//! definite: `make soak`.
//!
//! `cargo run --release --example soak -- [--frames 200000]`. The frames are a made-up recording forth and back, with covers in
//! it, and now and then a fault. Exit code 1 when a covariance breaks down or memory grows.

use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Parser;
use seamtrack::config::Config;
use seamtrack::frame::GrayFrame;
use seamtrack::kalman::{ColouredMeasurement, Gaussian, Imm};
use seamtrack::synth::scenario::Covers;
use seamtrack::synth::{Scene, builtin};
use seamtrack::{Sensor, Session, SessionSettings, Status};

/// Rows of the tables.
const BLOCKS: usize = 10;
/// Most that a session may hold more after the last block than after the first \[bytes\]. Chosen: a frame of 8 bits.
const MOST_GROWTH: i64 = 128 * 1024;
/// Time from frame to frame \[s\].
const PERIOD_S: f64 = 0.02;
/// Process noise of the three models \[px²/beat⁴\], far apart.
const MODELS_PX2: [f64; 3] = [1e-4, 1e-2, 1.0];

/// Many frames through one session, many steps through the filters
#[derive(Parser)]
struct Arguments {
    /// How many
    #[arg(long, default_value_t = 200_000)]
    frames: usize,
}

fn main() -> Result<ExitCode> {
    let frames = Arguments::parse().frames.max(BLOCKS);
    let is_flat = session(frames)?;
    let is_definite = filters(frames)?;
    Ok(if is_flat && is_definite { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The frames through a session; whether its memory stays what it was.
fn session(frames: usize) -> Result<bool> {
    let mut scenario = builtin::scenario("A-butt")?;
    (scenario.frames, scenario.image.width_px, scenario.image.height_px) = (300, 400, 300);
    scenario.covers = Some(Covers { per_100_frames: 0.4, ..Covers::default() });
    let scene = Scene::new(&scenario, 1)?;
    let pictures: Vec<GrayFrame> = (0..scene.frame_count()).map(|frame| scene.render(frame)).collect();
    let sensor = Sensor::Scale(scenario.mm_per_px);
    let mut session = Session::new(&SessionSettings { sensor, ..SessionSettings::new(Config::default().method()?) })?;
    println!(
        "| frames | tracked % | wrong | p50 ms | p99 ms | p99.9 ms | longest ms | median σ px | largest σ px | held more, bytes | resident MB |\n\
         |---|---|---|---|---|---|---|---|---|---|---|"
    );
    let (mut held, mut held_after_first) = (0, 0);
    for block in 0..BLOCKS {
        let (mut took_ms, mut std_px, mut tracked, mut wrong) = (vec![], vec![], 0, 0);
        let range = block * frames / BLOCKS..(block + 1) * frames / BLOCKS;
        for number in range.clone() {
            let place = forth_and_back(number, pictures.len());
            let (began, stamp_s) = (Instant::now(), PERIOD_S * number as f64);
            let mut estimate = None;
            // A frame in a thousand cannot be read, the next few are repeated, and one has a stamp that is none.
            let used = allocation_counter::measure(|| {
                estimate = Some(match number % 1000 {
                    500 => session.miss(stamp_s),
                    501..=503 => {
                        session.step(&pictures[forth_and_back(number - number % 1000 + 501, pictures.len())], stamp_s)
                    }
                    700 => session.step(&pictures[place], f64::NAN),
                    _ => session.step(&pictures[place], stamp_s),
                });
            });
            took_ms.push(began.elapsed().as_secs_f64() * 1e3);
            held += used.bytes_current;
            let estimate = estimate.context("the step was not made")??;
            tracked += usize::from(estimate.status == Status::Tracked);
            if let (Some(seam), Some(truth)) = (estimate.seam, scene.truth(place).seam) {
                std_px.push(seam.std_px);
                let off_mm = scenario.mm_per_px.get() * (seam.centre.u_px - truth.u_px).abs();
                wrong += usize::from(off_mm > seamtrack::eval::WRONG_MM);
            }
        }
        took_ms.sort_by(f64::total_cmp);
        std_px.sort_by(f64::total_cmp);
        let at = |sorted: &[f64], share: f64| sorted.get((share * (sorted.len().max(1) - 1) as f64) as usize).copied();
        let ms = |share| at(&took_ms, share).unwrap_or(f64::NAN);
        let px = |share| at(&std_px, share).unwrap_or(f64::NAN);
        if block == 0 {
            held_after_first = held;
        }
        println!(
            "| {}–{} | {:.1} | {wrong} | {:.2} | {:.2} | {:.2} | {:.1} | {:.3} | {:.2} | {} | {} |",
            range.start,
            range.end,
            100.0 * tracked as f64 / range.len() as f64,
            ms(0.5),
            ms(0.99),
            ms(0.999),
            ms(1.0),
            px(0.5),
            px(1.0),
            held - held_after_first,
            resident_mb().map_or_else(|| "–".to_owned(), |mb| mb.to_string()),
        );
    }
    Ok(held - held_after_first <= MOST_GROWTH)
}

/// Frame `number` of a recording that is played forth and back.
const fn forth_and_back(number: usize, count: usize) -> usize {
    let place = number % (2 * (count - 1));
    if place < count { place } else { 2 * (count - 1) - place }
}

/// Steps of the interacting models with measurements that are missing one time in seven; whether each model's covariance stays
/// symmetric and positive definite.
fn filters(steps: usize) -> Result<bool> {
    let model = ColouredMeasurement::printed();
    let mut imm = Imm::<3, 3>::new(model.start(320.0)?, 0.97)?;
    println!(
        "\n| steps | broken covariances | largest asymmetry | least eigenvalue | largest eigenvalue |\n|---|---|---|---|---|"
    );
    let mut all_broken = 0;
    for block in 0..BLOCKS {
        let (mut broken, mut asymmetry, mut least, mut largest) = (0, 0.0_f64, f64::INFINITY, 0.0_f64);
        let range = block * steps / BLOCKS..(block + 1) * steps / BLOCKS;
        for step in range.clone() {
            let spaces =
                MODELS_PX2.map(|q| model.with_acceleration_variance(q).and_then(|model| model.state_space(0.2)));
            let [a, b, c] = spaces;
            let spaces = [a?, b?, c?];
            let seam_px = 320.0 + 40.0 * (step as f64 / 90.0).sin();
            let z = [(step % 7 != 3).then_some(seam_px)];
            imm = imm.predict(&spaces).update(&spaces, &z, None)?.posterior;
            let Gaussian { P, .. } = imm.output();
            let eigenvalues = P.symmetric_eigenvalues();
            asymmetry = asymmetry.max((P - P.transpose()).abs().max());
            (least, largest) = (least.min(eigenvalues.min()), largest.max(eigenvalues.max()));
            broken += usize::from(P.cholesky().is_none());
        }
        println!("| {}–{} | {broken} | {asymmetry:.1e} | {least:.2e} | {largest:.3} |", range.start, range.end);
        all_broken += broken;
    }
    Ok(all_broken == 0)
}

/// Memory that this process has at present \[MB\], where the system tells.
fn resident_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? / 1024)
}
