//! Pictures that are already there, as a source of frames.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use image::GrayImage;
use seamtrack::calib::{KnownSensor, Origin};
use seamtrack::config::Config;
use seamtrack::frame::GrayFrame;
use seamtrack::run::{self, RunOutcome};
use seamtrack::source::{FrameError, FrameSource, SourceError, SourceFrame};

/// A frame as the camera gives it.
pub struct Shot {
    /// Its stamp \[s\].
    pub time_s: f64,
    /// Its picture; none when the file cannot be read.
    pub picture: Option<GrayFrame>,
}

/// Writes the frames as a recording that the program reads, but for stamps that are no numbers.
pub fn write(shots: &[Shot], folder: &Path) -> Result<()> {
    std::fs::create_dir(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let mut stamps = String::from("#timestamp [ns],filename\n");
    for (number, shot) in shots.iter().enumerate() {
        let name = format!("{number:06}.png");
        let file = folder.join(&name);
        let _ = writeln!(stamps, "{:.0},{name}", 1e9 * shot.time_s);
        let Some(picture) = &shot.picture else {
            std::fs::write(&file, "cut")?;
            continue;
        };
        let (width, height) = (picture.width_px() as u32, picture.height_px() as u32);
        let image = GrayImage::from_raw(width, height, picture.pixels().to_vec());
        image.context("the picture has another size")?.save(&file)?;
    }
    Ok(std::fs::write(folder.join("timestamps.csv"), stamps)?)
}

/// Runs the program on the frames, as it runs on a recording: it may look at them twice.
pub fn replay(shots: Vec<Shot>, config: &Config) -> Result<RunOutcome> {
    let known = config.mm_per_px.map_or_else(KnownSensor::unknown, |scale| KnownSensor::scale(scale, "the scene"));
    let mut source = Replay { shots: shots.into(), next: 0 };
    Ok(run::track(&mut source, (config, &known), Origin::Centre, |_| {})?)
}

/// The frames one after another.
struct Replay {
    shots: Arc<[Shot]>,
    next: usize,
}

impl FrameSource for Replay {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let number = self.next;
        let shot = self.shots.get(number)?;
        self.next += 1;
        let file = format!("{number:06}.png");
        let cut = || FrameError::Decode { file: file.clone(), source: "the file ends early".into() };
        Some(SourceFrame { time_s: shot.time_s, picture: shot.picture.clone().ok_or_else(cut), file })
    }

    fn frame_count(&self) -> Option<usize> {
        Some(self.shots.len())
    }

    fn kind(&self) -> &'static str {
        "made-up recording"
    }

    fn period_s(&self) -> f64 {
        0.2
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(Self { shots: Arc::clone(&self.shots), next: 0 }))
    }
}
