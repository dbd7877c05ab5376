//! What the plates' finish and the marks on them do to the stripe: brightness and height at a place of the plates.

use rand::Rng;

use super::noise::{Component, SmoothNoise, generator};
use super::profile::{Branch, edge};
use super::scenario::{Finish, MarkForm, Marks, Plates};

/// A mark's own size lies between these parts of what the scenario says (chosen).
const SIZES: std::ops::Range<f64> = 0.6..1.5;
/// Raggedness of a patch's outline relative to its half width, and of a bar's edges \[px\] (chosen).
const RAGGED_OUTLINE: f64 = 0.2;
const RAGGED_BAR_PX: f64 = 0.8;
/// The most that a drop's flank is dimmed.
const LEAST_COSINE: f64 = 0.3;

/// One mark on the plates.
#[derive(Debug, Clone)]
struct Mark {
    /// Which of the scenario's scatters it belongs to.
    kind: usize,
    number: u64,
    /// Its middle on the plates \[px\]: along the stripe, and along the travel.
    x_px: f64,
    y_px: f64,
    /// \[px\].
    half_width_px: f64,
    half_length_px: f64,
    slant: f64,
}

/// The plates' surface, ready for any frame.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    finish: Finish,
    scatters: Vec<Marks>,
    placed: Vec<Mark>,
    travel_px: f64,
    seed: u64,
}

/// The plates at one place: brightness relative to clean ones, light added by glints, height \[px\].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Spot {
    brightness: f64,
    glint: f64,
    height_px: f64,
}

/// Where the stripe lies on the plates in one frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnPlates {
    /// How far the plates have travelled, in camera frames.
    pub(super) tick: f64,
    /// How far vibration has shifted the plates along the stripe \[px\].
    pub(super) shake_px: f64,
    /// The joint's line in the picture, with the shake \[px\].
    pub(super) seam_px: f64,
}

impl Surface {
    /// Scatters the marks of a recording of `ticks` camera frames whose image is `along_px` long; `line` is the joint's
    /// line on the plates at a camera frame \[px\].
    pub(super) fn new(
        plates: &Plates,
        travel_px: f64,
        seed: u64,
        ticks: usize,
        along_px: usize,
        line: impl Fn(f64) -> f64,
    ) -> Self {
        let mut placed = Vec::new();
        for (kind, scatter) in plates.marks.iter().enumerate() {
            if scatter.form == MarkForm::Bar {
                continue;
            }
            let mut rng = generator(seed, kind as u64, Component::Marks);
            // Of a mark longer than the recording's way the middle may lie beyond it.
            let beyond = if travel_px > 0.0 { (0.5 * scatter.length_px / travel_px).min(ticks as f64) } else { 0.0 };
            let span = ticks as f64 + 2.0 * beyond;
            let mean = scatter.per_100_frames / 100.0 * span;
            let count = mean.floor() as usize + usize::from(rng.random::<f64>() < mean.fract());
            for number in 0..count {
                let tick = rng.random_range(-beyond..ticks as f64 + beyond);
                let (anywhere, beside): (f64, f64) = (rng.random(), rng.random_range(-1.0..=1.0));
                let size = rng.random_range(SIZES);
                let slant = if rng.random_bool(0.5) { scatter.slant } else { -scatter.slant };
                let half_width_px = 0.5 * size * scatter.width_px;
                placed.push(Mark {
                    kind,
                    number: 1000 * kind as u64 + number as u64,
                    x_px: scatter
                        .near_seam_px
                        .map_or(anywhere * along_px as f64, |near| line(tick.clamp(0.0, ticks as f64)) + near * beside),
                    y_px: tick * travel_px,
                    half_width_px,
                    half_length_px: match scatter.form {
                        MarkForm::Drop => half_width_px,
                        _ => 0.5 * rng.random_range(SIZES) * scatter.length_px,
                    },
                    slant,
                });
            }
        }
        let (finish, scatters) = (plates.finish.clone(), plates.marks.clone());
        Self { finish, scatters, placed, travel_px, seed }
    }

    /// Applies brightness and height to the branches that lie on the plates.
    pub(super) fn mark(&self, branches: &mut [Branch], on: OnPlates) {
        let y_px = on.tick * self.travel_px;
        let near: Vec<&Mark> = self
            .placed
            .iter()
            .filter(|mark| {
                (y_px - mark.y_px).abs() < 1.5 * mark.half_length_px + 3.0 * self.scatters[mark.kind].edge_px
            })
            .collect();
        let bars = self.scatters.iter().any(|scatter| scatter.form == MarkForm::Bar);
        let f = &self.finish;
        let finished = f.scale > 0.0 || f.grinding > 0.0 || f.grinding_relief_px > 0.0;
        if near.is_empty() && !bars && !finished {
            return;
        }
        let columns = branches.first().map_or(0, |branch| branch.gain.len());
        for x in 0..columns {
            let spot = self.at(x as f64, y_px, on, &near);
            for branch in branches.iter_mut().filter(|branch| branch.on_plates) {
                branch.row_px[x] -= spot.height_px as f32;
                // A glint is light of the same stripe: where there is none, nothing shines.
                let lit = f64::from(branch.gain[x]);
                branch.gain[x] = (lit * spot.brightness + lit.min(1.0) * spot.glint) as f32;
            }
        }
    }

    fn at(&self, column: f64, y_px: f64, on: OnPlates, near: &[&Mark]) -> Spot {
        let x_px = column - on.shake_px;
        let mut spot = self.finished(x_px, y_px);
        for mark in near {
            let scatter = &self.scatters[mark.kind];
            let (dx, dy) = (x_px - mark.x_px, y_px - mark.y_px);
            match scatter.form {
                MarkForm::Patch => {
                    let outline = SmoothNoise::new(self.seed, Component::Marks, mark.number);
                    let ragged = f64::from(outline.cloud(
                        dx / (0.7 * mark.half_width_px).max(4.0),
                        dy / (0.7 * mark.half_length_px).max(4.0),
                        0.0,
                    ));
                    let r = (dx / mark.half_width_px).hypot(dy / mark.half_length_px) + RAGGED_OUTLINE * ragged;
                    spot.cover(scatter, (1.0 - r) * mark.half_width_px);
                }
                MarkForm::Drop => {
                    let r = dx.hypot(dy) / mark.half_width_px;
                    spot.cover(&Marks { relief_px: 0.0, ..scatter.clone() }, (1.0 - r) * mark.half_width_px);
                    let cosine = (1.0 - r * r).max(0.0).sqrt();
                    spot.height_px += scatter.relief_px * cosine;
                    if r < 1.0 {
                        spot.brightness *= cosine.max(LEAST_COSINE);
                        spot.glint += scatter.glint * (-(r / 0.3).powi(2)).exp();
                    }
                }
                MarkForm::Scratch => {
                    let inside = mark.half_length_px - dy.abs();
                    let across = (dx - mark.slant * dy).abs() / mark.slant.hypot(1.0);
                    spot.cover(scatter, (mark.half_width_px - across).min(inside));
                }
                MarkForm::Bar => {}
            }
        }
        for (kind, scatter) in self.scatters.iter().enumerate().filter(|(_, s)| s.form == MarkForm::Bar) {
            let edge = SmoothNoise::new(self.seed, Component::Marks, 1_000_000 + kind as u64);
            let from_middle = column - on.seam_px - scatter.beside_px;
            let ragged = RAGGED_BAR_PX * f64::from(edge.at(y_px / 8.0, from_middle.signum(), 0.0));
            spot.cover(scatter, 0.5 * scatter.width_px - from_middle.abs() + ragged);
        }
        spot
    }

    /// The plates between the marks.
    fn finished(&self, x_px: f64, y_px: f64) -> Spot {
        let f = &self.finish;
        let (mut logarithm, mut height_px) = (0.0, 0.0);
        if f.scale > 0.0 {
            let patches = SmoothNoise::new(self.seed, Component::Finish, 0);
            let cloud = f64::from(patches.cloud(x_px / f.scale_patch_px, y_px / f.scale_patch_px, 0.0));
            // Scale flakes off with an edge: a steep, bounded course.
            logarithm += f.scale * (1.8 * cloud).tanh();
        }
        if f.grinding > 0.0 || f.grinding_relief_px > 0.0 {
            let marks = SmoothNoise::new(self.seed, Component::Finish, 1);
            let (sin, cos) = f.grinding_angle_deg.to_radians().sin_cos();
            let (across, along) = (x_px * cos - y_px * sin, x_px * sin + y_px * cos);
            let value = f64::from(marks.at(across / f.grinding_pitch_px, along / (25.0 * f.grinding_pitch_px), 0.0));
            logarithm += f.grinding * value;
            height_px += f.grinding_relief_px * value;
        }
        Spot { brightness: logarithm.exp(), glint: 0.0, height_px }
    }
}

impl Spot {
    /// Covers the spot by a mark whose outline is `inside_px` away, inwards positive.
    fn cover(&mut self, mark: &Marks, inside_px: f64) {
        let share = edge(inside_px, mark.edge_px);
        self.brightness *= 1.0 + (mark.reflectance - 1.0) * share;
        self.height_px += mark.relief_px * share;
    }
}
