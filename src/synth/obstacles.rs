//! What lies between plates and picture: gaps and shadows of the laser's line, cables, dirt on the glass, dead pixels.

use rand::Rng;

use super::canvas::Canvas;
use super::noise::{Component, generator};
use super::profile::{Branch, edge};
use super::scenario::{Cable, View};
use crate::frame::GrayFrame;
use crate::units::StripeAxis;

/// Period of a swinging cable \[frames\].
const SWING_FRAMES: f64 = 40.0;
/// Distance in radii beyond which a spot of dirt is nothing: e⁻⁸.
const SPOT_REACH: f64 = 2.0;
/// Blur of a cable's edges \[px\] (chosen: it hangs out of focus).
const CABLE_BLUR_PX: f64 = 2.0;

/// The view in this seed's numbers: where everything lies.
#[derive(Debug, Clone)]
pub(super) struct Obstacles {
    view: View,
    along_px: f64,
    /// The stripe's mean row \[px\].
    row_px: f64,
    /// Dirt: along, across, radius \[px\].
    spots: Vec<[f64; 3]>,
    dead_px: Vec<f64>,
    line_gaps_px: Vec<f64>,
    shadows_px: Vec<f64>,
}

/// The middle line of a cable in one frame.
#[derive(Debug, Clone, Copy)]
struct CableAxis {
    /// Where it crosses `row_px` \[px\].
    crossing_px: f64,
    row_px: f64,
    tangent: f64,
    cos: f64,
}

impl CableAxis {
    fn column_at(&self, row_px: f64) -> f64 {
        self.crossing_px + self.tangent * (row_px - self.row_px)
    }
}

impl Obstacles {
    /// Places the obstacles in a picture of `along_px` × `across_px`, whose stripe lies at `row_px`.
    pub(super) fn new(view: &View, seed: u64, along_px: usize, across_px: usize, row_px: f64) -> Self {
        let mut rng = generator(seed, 0, Component::View);
        let (along, across) = (along_px as f64, across_px as f64);
        let mut inside = |given: Option<f64>| {
            let drawn = rng.random_range(0.25..0.75);
            along * given.unwrap_or(drawn)
        };
        let dead_px = view.dead.iter().map(|dead| inside(dead.along)).collect();
        let line_gaps_px = view.line_gaps.iter().map(|gap| inside(gap.along)).collect();
        let shadows_px = view.shadows.iter().map(|shadow| inside(shadow.along)).collect();
        let spots = view.dirt.iter().flat_map(|dirt| (0..dirt.spots).map(|i| (i, dirt.radius_px)));
        let spots = spots
            .map(|(i, radius_px)| {
                let (x, y): (f64, f64) = (rng.random(), rng.random());
                let radius = radius_px * rng.random_range(0.5..1.5);
                if i == 0 { [along * (0.25 + 0.5 * x), row_px, radius] } else { [along * x, across * y, radius] }
            })
            .collect();
        Self { view: view.clone(), along_px: along, row_px, spots, dead_px, line_gaps_px, shadows_px }
    }

    /// Dims the stripe where the laser's line has gaps or lies in a shadow.
    pub(super) fn dim(&self, branches: &mut [Branch], tick: f64) {
        if self.view.line_gaps.is_empty() && self.view.shadows.is_empty() {
            return;
        }
        let columns = branches.first().map_or(0, |branch| branch.gain.len());
        for column in 0..columns {
            let x = column as f64;
            let mut light = 1.0;
            for (gap, middle) in self.view.line_gaps.iter().zip(&self.line_gaps_px) {
                light *= 1.0 - (1.0 - gap.transmission) * edge(0.5 * gap.width_px - (x - middle).abs(), gap.edge_px);
            }
            for (shadow, first) in self.view.shadows.iter().zip(&self.shadows_px) {
                let beyond = x - first - shadow.px_per_frame * tick;
                light *= 1.0 - (1.0 - shadow.transmission) * edge(beyond, shadow.edge_px);
            }
            branches.iter_mut().for_each(|branch| branch.gain[column] *= light as f32);
        }
    }

    /// Whether a cable hides the place `along_px`, `across_px`.
    pub(super) fn hide(&self, along_px: f64, across_px: f64, tick: f64) -> bool {
        self.view.cables.iter().any(|cable| {
            let axis = self.axis_of(cable, tick);
            (along_px - axis.column_at(across_px)).abs() * axis.cos < 0.5 * cable.width_px
        })
    }

    /// Hangs the cables before the plates.
    pub(super) fn hang(&self, tick: f64, canvas: &mut Canvas) {
        for cable in &self.view.cables {
            let axis = self.axis_of(cable, tick);
            for row in 0..canvas.height_px() {
                let y = row as f64;
                let reach_px = (0.5 * cable.width_px + 4.0 * CABLE_BLUR_PX) / axis.cos;
                let middle = axis.column_at(y);
                let columns = (middle - reach_px).max(0.0) as usize..=(middle + reach_px).max(0.0) as usize;
                for column in columns {
                    let inside = 0.5 * cable.width_px - (column as f64 - middle).abs() * axis.cos;
                    let share = edge(inside, CABLE_BLUR_PX) as f32;
                    canvas.mix(column, row, cable.grey as f32, share);
                }
            }
        }
    }

    fn axis_of(&self, cable: &Cable, tick: f64) -> CableAxis {
        let (sin, cos) = cable.angle_deg.to_radians().sin_cos();
        let swing = cable.swing_px * (std::f64::consts::TAU * tick / SWING_FRAMES).sin();
        let crossing_px = cable.along * self.along_px + cable.px_per_frame * tick + swing;
        CableAxis { crossing_px, row_px: self.row_px, tangent: sin / cos, cos }
    }

    /// The glass before the picture: spots dim what is behind and glow by `glare_grey`.
    pub(super) fn soil(&self, glare_grey: f64, canvas: &mut Canvas) {
        let Some(dirt) = &self.view.dirt else { return };
        for &[along, across, radius] in &self.spots {
            canvas.change_around(along, across, SPOT_REACH * radius, |x, y, light| {
                let r = (x as f64 - along).hypot(y as f64 - across) / radius;
                // Far out of focus: a smooth spot.
                let share = (-(r * r * r)).exp();
                let passed = 1.0 - (1.0 - dirt.transmission) * share;
                *light = *light * passed as f32 + (dirt.glow * glare_grey * share) as f32;
            });
        }
    }

    /// Overwrites the dead pixels of a picture that has been read out.
    pub(super) fn kill(&self, axis: StripeAxis, frame: &mut GrayFrame) {
        let width = frame.width_px();
        for (dead, &middle) in self.view.dead.iter().zip(&self.dead_px) {
            let from = (middle - 0.5 * dead.along_px as f64).max(0.0) as usize;
            let along = from..from + dead.along_px;
            let rows = dead.across_px.map(|px| self.row_px - 0.5 * px as f64..self.row_px + 0.5 * px as f64);
            for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
                let (u, v) = (i % width, i / width);
                let (x, y) = match axis {
                    StripeAxis::Horizontal => (u, v),
                    StripeAxis::Vertical => (v, u),
                };
                if along.contains(&x) && rows.as_ref().is_none_or(|rows| rows.contains(&(y as f64))) {
                    *pixel = dead.grey;
                }
            }
        }
    }
}
