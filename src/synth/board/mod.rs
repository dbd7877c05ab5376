//! A made-up sensor of a camera and a laser plane, and what it sees: a chessboard with and without the stripe, a step, a flat
//! plate. The whole chain from board images to millimetres so has a truth.
//!
//! Every pixel is sampled [`SAMPLES`]² times along its ray, so that edges and stripe are as sharp as the lens lets them be.

pub mod recording;
mod surface;

use nalgebra::{Rotation3, Vector2, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg32;
use rayon::prelude::*;

use crate::calib::board::BoardSize;
use crate::calib::intrinsics::Intrinsics;
use crate::calib::laser_camera::LaserCamera;
use crate::calib::plane::LaserPlane;
use crate::calib::pose::Pose;
use crate::frame::GrayFrame;
use crate::units::PixelPoint;

pub use surface::{BoardSurface, StepSurface, Surface};

/// Samples a side of a pixel.
pub const SAMPLES: usize = 2;
/// Least distance of a corner from the picture's rim in a drawn pose \[px\].
const RIM_PX: f64 = 40.0;
/// Distance at which the documentation's laser meets the viewing direction \[mm\].
const DOCUMENTED_MM: f64 = 250.0;
/// Tries to draw a pose before giving up.
const TRIES: usize = 100_000;

/// The sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorScene {
    /// Columns and rows.
    pub size_px: (usize, usize),
    /// The camera.
    pub intrinsics: Intrinsics,
    /// The laser's plane.
    pub plane: LaserPlane,
    /// SD of the laser sheet's thickness \[mm\].
    pub sheet_sd_mm: f64,
    /// SD of the lens' blur \[px\].
    pub blur_sd_px: f64,
    /// SD of the camera's noise \[grey\].
    pub noise_grey: f64,
    /// Strength of the speckle: SD of the logarithm of the stripe's light.
    pub speckle: f64,
    /// Light of the stripe on white \[grey\].
    pub stripe_grey: f64,
}

impl SensorScene {
    /// The sensor of the documentation's figures: 1000 × 750 px, a focal length of 1250 px, the laser at 22° to the viewing
    /// direction, meeting it at 250 mm.
    #[must_use]
    pub fn documented() -> Option<Self> {
        let (sin, cos) = 22f64.to_radians().sin_cos();
        let normal = Vector3::new(0.02, cos, sin);
        let plane = LaserPlane::new(normal, normal.dot(&Vector3::new(0.0, 0.0, 250.0))).ok()?;
        let intrinsics = Intrinsics::from_array([1250.0, 1252.0, 507.0, 371.0, -0.11, 0.15, 0.0006, -0.0008, 0.0]);
        Some(Self::of(&LaserCamera::new((1000, 750), intrinsics, plane, None, None)))
    }

    /// The scene of a true sensor, its light that of the documentation's figures.
    #[must_use]
    pub fn of(sensor: &LaserCamera) -> Self {
        Self {
            size_px: sensor.size_px(),
            intrinsics: *sensor.intrinsics(),
            plane: *sensor.plane(),
            sheet_sd_mm: 0.25,
            blur_sd_px: 0.7,
            noise_grey: 1.5,
            speckle: 0.5,
            stripe_grey: 220.0,
        }
    }

    /// Where the laser meets the viewing direction \[mm\].
    fn distance_mm(&self) -> f64 {
        self.plane.meet(Vector2::zeros()).map_or(DOCUMENTED_MM, |point| point.z)
    }

    /// Poses of a board, drawn at random: tilted by 5° to 35° to any side, between .86 and 1.16 of the distance at which the laser
    /// meets the viewing direction, as a whole in the picture and crossed by the laser.
    #[must_use]
    pub fn draw_poses(&self, board: BoardSize, square_mm: f64, count: usize, random: &mut Pcg32) -> Vec<Pose> {
        let points = board.points_mm(square_mm);
        let mut poses = vec![];
        for _ in 0..TRIES {
            if poses.len() == count {
                break;
            }
            let direction: Vector3<f64> = Vector3::from_fn(|_, _| StandardNormal.sample(random));
            let mut turn = direction.normalize() * random.random_range(5f64..35.0).to_radians();
            turn.z = random.random_range(-0.4..0.4);
            let shift =
                [random.random_range(-25.0..25.0), random.random_range(-15.0..15.0), random.random_range(215.0..290.0)];
            let translation_mm = Vector3::from(shift) * (self.distance_mm() / DOCUMENTED_MM);
            let pose = Pose { rotation: Rotation3::new(turn), translation_mm };
            let in_camera: Vec<Vector3<f64>> = points.iter().map(|p| pose.camera_from_board(p)).collect();
            let is_seen = |p: &Vector3<f64>| {
                self.intrinsics.project(p).is_some_and(|pixel| {
                    let inside = |at: f64, side: usize| (RIM_PX..side as f64 - RIM_PX).contains(&at);
                    inside(pixel.u_px, self.size_px.0) && inside(pixel.v_px, self.size_px.1)
                })
            };
            let off: Vec<f64> = in_camera.iter().map(|p| self.plane.offset_mm(p)).collect();
            let crossed = off.iter().any(|o| *o < -square_mm) && off.iter().any(|o| *o > square_mm);
            if crossed && in_camera.iter().all(is_seen) {
                poses.push(pose);
            }
        }
        poses
    }

    /// Speckle of mean 1, log-normal, with grains of 1.2 px.
    fn speckle_field(&self, width: usize, height: usize, random: &mut Pcg32) -> Vec<f32> {
        let mut field: Vec<f32> = (0..width * height).map(|_| StandardNormal.sample(random)).collect();
        blur(&mut field, width, height, 1.2 * SAMPLES as f64);
        let variance = field.iter().map(|x| f64::from(x * x)).sum::<f64>() / field.len() as f64;
        let scale = (self.speckle / variance.sqrt()) as f32;
        let shift = (0.5 * self.speckle * self.speckle) as f32;
        field.iter_mut().for_each(|x| *x = (*x * scale - shift).exp());
        field
    }

    /// The true pixel of a point of the camera frame.
    #[must_use]
    pub fn pixel(&self, point_mm: &Vector3<f64>) -> Option<Vector2<f64>> {
        self.intrinsics.project(point_mm).map(|p| Vector2::new(p.u_px, p.v_px))
    }
}

/// Renders pictures of one sensor; it keeps the rays of all samples.
pub struct Renderer {
    scene: SensorScene,
    rays: Vec<Vector2<f64>>,
}

impl Renderer {
    /// A renderer of `scene`. None where its lens has no ray for a pixel, or it has none.
    #[must_use]
    pub fn new(scene: SensorScene) -> Option<Self> {
        let (width, height) = (scene.size_px.0 * SAMPLES, scene.size_px.1 * SAMPLES);
        let at = |i: usize| (i as f64 + 0.5) / SAMPLES as f64 - 0.5;
        let ray = |i: usize| scene.intrinsics.ray(PixelPoint::new(at(i % width), at(i / width)));
        let rays: Option<Vec<Vector2<f64>>> = (0..width * height).into_par_iter().map(ray).collect();
        Some(Self { rays: rays.filter(|rays| !rays.is_empty())?, scene })
    }

    /// The sensor.
    #[must_use]
    pub const fn scene(&self) -> &SensorScene {
        &self.scene
    }

    /// The picture of a surface with the laser on or off.
    #[must_use]
    pub fn render(&self, surface: &dyn Surface, laser_on: bool, random: &mut Pcg32) -> Option<GrayFrame> {
        let scene = &self.scene;
        let (width, height) = (scene.size_px.0 * SAMPLES, scene.size_px.1 * SAMPLES);
        let speckle = laser_on.then(|| scene.speckle_field(width, height, random));
        let mut light = vec![0.0f32; width * height];
        light.par_chunks_exact_mut(width).enumerate().for_each(|(row, out)| {
            for (column, out) in out.iter_mut().enumerate() {
                let Some((point, albedo)) = surface.meet(self.rays[row * width + column]) else { continue };
                *out = (surface.ambient_grey() * albedo) as f32;
                if let Some(speckle) = &speckle {
                    let off = scene.plane.offset_mm(&point) / scene.sheet_sd_mm;
                    if off.abs() < 5.0 {
                        let grey = scene.stripe_grey * surface.stripe_albedo(albedo) * (-0.5 * off * off).exp();
                        *out += grey as f32 * speckle[row * width + column];
                    }
                }
            }
        });
        blur(&mut light, width, height, scene.blur_sd_px * SAMPLES as f64);
        let mut frame = GrayFrame::filled(scene.size_px.0, scene.size_px.1, 0).ok()?;
        for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
            let (u, v) = (i % scene.size_px.0 * SAMPLES, i / scene.size_px.0 * SAMPLES);
            let samples = (0..SAMPLES * SAMPLES).map(|k| light[(v + k / SAMPLES) * width + u + k % SAMPLES]);
            let mean = f64::from(samples.sum::<f32>()) / (SAMPLES * SAMPLES) as f64;
            let noise: f64 = StandardNormal.sample(random);
            *pixel = (mean + scene.noise_grey * noise).round().clamp(0.0, 255.0) as u8;
        }
        Some(frame)
    }
}

/// A Gaussian blur by rows and then by columns.
fn blur(values: &mut [f32], width: usize, height: usize, sd: f64) {
    let reach = (3.0 * sd).ceil() as usize;
    let weights: Vec<f32> =
        (0..=2 * reach).map(|i| (-0.5 * ((i as f64 - reach as f64) / sd).powi(2)).exp() as f32).collect();
    let total: f32 = weights.iter().sum();
    values.par_chunks_exact_mut(width).for_each(|row| {
        let before = row.to_vec();
        for (u, out) in row.iter_mut().enumerate() {
            let sum: f32 = weights
                .iter()
                .enumerate()
                .map(|(i, weight)| weight * before[(u + i).saturating_sub(reach).min(width - 1)])
                .sum();
            *out = sum / total;
        }
    });
    let before = values.to_vec();
    values.par_chunks_exact_mut(width).enumerate().for_each(|(v, row)| {
        row.fill(0.0);
        for (i, weight) in weights.iter().enumerate() {
            let from = (v + i).saturating_sub(reach).min(height - 1);
            let share = weight / total;
            row.iter_mut().zip(&before[from * width..(from + 1) * width]).for_each(|(out, x)| *out += share * x);
        }
    });
}
