//! Rendered sensors calibrated from board images, against their truth: `cargo run --example sensor_truth -- SEEDS [VIEWS]`.
//!
//! Each seed draws poses, renders boards with the laser off and on, calibrates camera and plane, and compares points of the
//! plane, a step of 5 mm and a lateral distance of 100 mm with what was rendered.
#![expect(clippy::print_stdout, reason = "the table is what it is for")]

#[path = "../tests/calib/sensor.rs"]
mod sensor;

use sensor::{Bench, Trial};

fn main() {
    let mut words = std::env::args().skip(1).filter_map(|word| word.parse().ok());
    let (seeds, views): (u64, usize) = (words.next().unwrap_or(3), words.next().map_or(12, |views| views as usize));
    let bench = Bench::new();
    println!("a step of 5 mm in one frame, sensor known: {:.4} mm rms over 24 speckles", bench.step_alone_mm(24));
    let mut trials: Vec<Trial> = vec![];
    for seed in 1..=seeds {
        match bench.trial(seed, views) {
            Ok(trial) => {
                println!("seed {seed}: {trial}");
                trials.push(trial);
            }
            Err(problem) => println!("seed {seed}: {problem}"),
        }
    }
    println!("{}", sensor::Summary::of(&trials));
}
