//! A melt-pool scenario with a seed: frames and truth.

use super::light;
use super::scenario::PoolScenario;
use super::shape::Shape;
use crate::frame::{FrameSizeError, IntensityFrame};
use crate::synth::ScenarioError;
use crate::synth::canvas::Canvas;
use crate::synth::noise::{Ar1, Component, generator, normal};
use crate::synth::spatter::add_spatter;
use crate::units::{MmPerPx, PixelPoint, Travel};

/// What is true in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoolTruth {
    /// Where the seam runs and how far the pool reaches along it: the tip without the melt's own motion \[px\].
    pub tip: PixelPoint,
    /// The pool's width without the melt's own motion \[px\].
    pub width_px: f64,
    /// Whether the frame shows a pool.
    pub visible: bool,
}

/// A frame as the camera gives it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PoolPicture {
    /// Columns.
    pub width_px: usize,
    /// Rows.
    pub height_px: usize,
    /// Bits a pixel: 8 or 16.
    pub bits: u8,
    /// Grey values, row by row.
    pub greys: Vec<u16>,
}

impl PoolPicture {
    /// The same frame as intensities: 1 is the largest grey value.
    ///
    /// # Errors
    /// When the frame has no pixel.
    pub fn intensity(&self) -> Result<IntensityFrame, FrameSizeError> {
        let white = f32::from(if self.bits == 16 { u16::MAX } else { 255 });
        let light = self.greys.iter().map(|&grey| f32::from(grey) / white).collect();
        IntensityFrame::new(self.width_px, self.height_px, light)
    }
}

/// What the melt does in one frame, apart from the seam.
#[derive(Debug, Clone, Copy)]
struct Moment {
    tip_jitter_px: f64,
    width_jitter_px: f64,
    flicker: f64,
}

/// A scenario and a seed, ready to render any frame in any order from any thread.
#[derive(Debug, Clone)]
pub struct PoolScene {
    scenario: PoolScenario,
    seed: u64,
    /// Extent across and along the travel \[px\].
    across_px: usize,
    along_px: usize,
    moments: Vec<Moment>,
}

impl PoolScene {
    /// The scene of a scenario and a seed.
    ///
    /// # Errors
    /// When a number of the scenario lies outside its range.
    pub fn new(scenario: &PoolScenario, seed: u64) -> Result<Self, ScenarioError> {
        scenario.check()?;
        let (across_px, along_px) = match scenario.image.travel {
            Travel::Up | Travel::Down => (scenario.image.width_px, scenario.image.height_px),
            Travel::Left | Travel::Right => (scenario.image.height_px, scenario.image.width_px),
        };
        let pool = &scenario.pool;
        let mut rng = generator(seed, 0, Component::Timeline);
        let mut tip = Ar1::new(pool.tip_jitter_px, pool.jitter_correlation);
        let mut width = Ar1::new(pool.width_jitter_px, pool.jitter_correlation);
        let mut flicker = Ar1::new(scenario.emissivity.flicker, scenario.emissivity.correlation);
        let mut moment = || Moment {
            tip_jitter_px: tip.step(&mut rng),
            width_jitter_px: width.step(&mut rng),
            flicker: flicker.step(&mut rng),
        };
        let moments = (0..scenario.frames).map(|_| moment()).collect();
        Ok(Self { scenario: scenario.clone(), seed, across_px, along_px, moments })
    }

    /// Number of frames.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.moments.len()
    }

    /// The scenario.
    #[must_use]
    pub fn scenario(&self) -> &PoolScenario {
        &self.scenario
    }

    /// Scale of truth.csv.
    #[must_use]
    pub fn mm_per_px(&self) -> MmPerPx {
        self.scenario.mm_per_px
    }

    /// What is true in a frame.
    #[must_use]
    pub fn truth(&self, frame: usize) -> PoolTruth {
        let (seam_px, width_px) = self.course(frame);
        let tip = self.shape(seam_px, width_px).tip();
        let middle = self.middle();
        let size_px = (self.scenario.image.width_px, self.scenario.image.height_px);
        let point = [middle[0] + tip[0], middle[1] + tip[1]];
        let flaws = &self.scenario.flaws;
        PoolTruth {
            tip: self.scenario.image.travel.image_from_turned(point, size_px),
            width_px,
            visible: !within(&flaws.absent, frame) && !within(&flaws.flooded, frame),
        }
    }

    /// Renders a frame: the same grey values on any thread in any order.
    ///
    /// # Panics
    /// When `frame` is not below [`Self::frame_count`].
    #[must_use]
    pub fn render(&self, frame: usize) -> PoolPicture {
        let s = &self.scenario;
        let moment = self.moments[frame];
        let (seam_px, width_px) = self.course(frame);
        let width_px = width_px + moment.width_jitter_px;
        let middle = self.middle();
        let step = if (frame as f64) < s.emissivity.step_at * s.frames as f64 { 1.0 } else { s.emissivity.step };
        let mut canvas = Canvas::filled(self.across_px, self.along_px, 0.0);
        let painter = light::Scene {
            light: &s.light,
            shape: self.shape(seam_px + moment.tip_jitter_px, width_px),
            middle,
            length_px: s.pool.length_px,
            width_px,
            seam_px,
            raggedness: (s.pool.raggedness_px, s.pool.raggedness_length_px),
            emissivity: step * (1.0 + moment.flicker).max(0.0),
            seed: self.seed,
            frame,
        };
        let with_pool = !within(&s.flaws.absent, frame);
        painter.paint(&mut canvas, with_pool);
        if with_pool {
            let from = PixelPoint::new(middle[0], middle[1]);
            add_spatter(&s.spatter, false, from, self.seed, frame, &mut canvas);
        }
        if within(&s.flaws.flooded, frame) {
            canvas.change(|_, _, value| *value = f32::MAX);
        }
        self.read_out(frame, &canvas)
    }

    fn middle(&self) -> [f64; 2] {
        let [across, along] = self.scenario.image.pool_at;
        [across * (self.across_px as f64 - 1.0), along * (self.along_px as f64 - 1.0)]
    }

    /// Where the seam is across the travel from the pool's middle, and the width, without jitter \[px\].
    fn course(&self, frame: usize) -> (f64, f64) {
        let (s, frames) = (&self.scenario, self.scenario.frames as f64);
        let sum = |terms: &[crate::synth::scenario::PathTerm]| -> f64 {
            terms.iter().map(|term| term.at(frame as f64, frames)).sum()
        };
        // The path lies about the pool's middle.
        let at = |frame: f64| s.path.iter().map(|term| term.at(frame, frames)).sum::<f64>();
        let centre = 0.5 * (at(0.0) + at(frames - 1.0));
        (sum(&s.path) - centre, s.pool.width_px + sum(&s.width))
    }

    fn shape(&self, tip_px: f64, width_px: f64) -> Shape {
        let pool = &self.scenario.pool;
        Shape::new(pool.length_px, width_px.max(1.0), tip_px, pool.tip_height_px, pool.tip_half_base_px)
    }

    fn read_out(&self, frame: usize, canvas: &Canvas) -> PoolPicture {
        let (s, light) = (&self.scenario, &self.scenario.light);
        let (width_px, height_px) = (s.image.width_px, s.image.height_px);
        let white = if s.image.bits == 16 { f32::from(u16::MAX) } else { 255.0 };
        let read2 = (light.read_noise_grey * light.read_noise_grey) as f32;
        let shot = light.shot_noise_grey as f32;
        let mut rng = generator(self.seed, frame as u64, Component::Sensor);
        let mut greys = vec![0; width_px * height_px];
        for (i, &light) in canvas.light().iter().enumerate() {
            let turned = [(i % self.across_px) as f64, (i / self.across_px) as f64];
            let point = s.image.travel.image_from_turned(turned, (width_px, height_px));
            let deviation = (read2 + shot * light.clamp(0.0, 255.0)).sqrt();
            let grey = (light + deviation * normal(&mut rng)) / 255.0;
            greys[point.v_px as usize * width_px + point.u_px as usize] = (grey * white + 0.5).clamp(0.0, white) as u16;
        }
        PoolPicture { width_px, height_px, bits: s.image.bits, greys }
    }
}

fn within(stretches: &[[usize; 2]], frame: usize) -> bool {
    stretches.iter().any(|&[first, last]| (first..=last).contains(&frame))
}
