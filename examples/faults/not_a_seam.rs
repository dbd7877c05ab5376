//! Pictures that show no seam, and what is claimed of them.

use std::collections::BTreeMap;

use anyhow::Result;
use rayon::prelude::*;
use seamtrack::config::Config;
use seamtrack::report::results::Status;
use seamtrack::units::MmPerPx;

use crate::pictures::{KINDS, Made};
use crate::replay::{Shot, replay};

/// Frames of a recording, and recordings of each kind.
const FRAMES: usize = 60;
const RECORDINGS: u64 = 5;
/// Time from frame to frame \[s\].
const PERIOD_S: f64 = 0.2;
/// A value with a smaller σ is a claim \[mm\].
const SURE_MM: f64 = 1.0;

/// What was claimed of some recordings.
#[derive(Debug, Clone, Default)]
pub struct Shown {
    pub name: &'static str,
    pub recordings: usize,
    pub frames: usize,
    pub tracked: usize,
    pub coasting: usize,
    /// Values with a σ under 1 mm, and smoothed ones.
    pub sure: usize,
    pub smoothed_sure: usize,
    /// Joints that were found, by kind, in how many recordings first.
    pub taken_for: BTreeMap<&'static str, usize>,
}

impl Shown {
    /// Nothing yet.
    pub fn called(name: &'static str) -> Self {
        Self { name, ..Self::default() }
    }

    /// Both together.
    pub fn with(mut self, other: &Self) -> Self {
        for (kind, count) in &other.taken_for {
            *self.taken_for.entry(kind).or_default() += count;
        }
        Self {
            taken_for: self.taken_for,
            name: self.name,
            recordings: self.recordings + other.recordings,
            frames: self.frames + other.frames,
            tracked: self.tracked + other.tracked,
            coasting: self.coasting + other.coasting,
            sure: self.sure + other.sure,
            smoothed_sure: self.smoothed_sure + other.smoothed_sure,
        }
    }
}

/// Each kind of picture, over all its recordings.
pub fn runs(seed: u64) -> Result<Vec<Shown>> {
    KINDS
        .par_iter()
        .map(|(name, made)| {
            (0..RECORDINGS)
                .try_fold(Shown::called(name), |sum, number| Ok(sum.with(&run(*made, self::seed(seed, number))?)))
        })
        .collect()
}

/// The seed of a recording.
pub const fn seed(campaign: u64, number: u64) -> u64 {
    1000 * campaign + number
}

/// Its frames.
pub fn shots(made: Made, seed: u64) -> Result<Vec<Shot>> {
    let mut pictures = made(seed)?;
    (0..FRAMES).map(|frame| Ok(Shot { time_s: PERIOD_S * frame as f64, picture: Some(pictures(frame)?) })).collect()
}

/// What is claimed of it.
pub fn run(made: Made, seed: u64) -> Result<Shown> {
    let outcome = replay(shots(made, seed)?, &Config { mm_per_px: Some(MmPerPx::DU_2022), ..Config::default() })?;
    let rows = outcome.rows;
    let with = |status| rows.iter().filter(|row| row.status == status && row.u_px.is_some()).count();
    let is_sure = |std_mm: Option<f64>| std_mm.is_some_and(|std_mm| std_mm < SURE_MM);
    Ok(Shown {
        name: "",
        recordings: 1,
        frames: rows.len(),
        tracked: with(Status::Tracked),
        coasting: with(Status::Coasting),
        sure: rows.iter().filter(|row| is_sure(row.x_std_mm)).count(),
        taken_for: outcome.joints.first().map(|joint| (joint.kind, 1)).into_iter().collect(),
        smoothed_sure: rows.iter().filter(|row| is_sure(row.smooth_x_std_mm)).count(),
    })
}
