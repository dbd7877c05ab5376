//! A rendered sensor, calibrated from its board images and compared with its truth.
#![allow(dead_code, clippy::unwrap_used, reason = "shared by tests and an example; what cannot go on has failed")]

use std::fmt;

use nalgebra::{Matrix3, SMatrix, Vector2, Vector3};
use rand_pcg::Pcg32;
use seamtrack::calib::board::BoardSize;
use seamtrack::calib::camera::{CameraFit, fit_camera};
use seamtrack::calib::check::{check_step, stripe_points};
use seamtrack::calib::detect::{Picture, Pictures, detect};
use seamtrack::calib::laser::{KnownCamera, LaserFit, fit_laser};
use seamtrack::calib::laser_camera::LaserCamera;
use seamtrack::calib::pairs::Pair;
use seamtrack::calib::plane::PlaneAxes;
use seamtrack::calib::stripe::BAND_RATIO;
use seamtrack::calib::stripes::find_stripes;
use seamtrack::frame::GrayFrame;
use seamtrack::imgproc::{CentrelineSettings, extract_along, stripe_path};
use seamtrack::synth::board::{BoardSurface, Renderer, SensorScene, StepSurface};
use seamtrack::units::PixelPoint;

pub const SQUARE_MM: f64 = 15.0;
pub const STEP_MM: f64 = 5.0;
/// Columns on either side of the step's edge that are not measured.
const STEP_MARGIN_PX: f64 = 15.0;
/// Half the width of the normal's 95 %.
const Z_95: f64 = 1.96;

pub fn board() -> BoardSize {
    BoardSize::new(6, 7).unwrap()
}

/// Pictures in memory.
pub struct Memory(pub Vec<(String, GrayFrame)>);

impl Pictures for Memory {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn name(&self, index: usize) -> String {
        self.0[index].0.clone()
    }

    fn read(&self, index: usize) -> Result<Picture, String> {
        let (name, frame) = self.0[index].clone();
        Ok(Picture { sha256: seamtrack::calib::file::sha256_hex(frame.pixels()), name, frame })
    }
}

pub struct Bench {
    pub renderer: Renderer,
}

/// One seed's errors.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Error and stated σ of each point of the grid: lateral and height in the plane [mm].
    pub absolute: Vec<(Vector2<f64>, Vector2<f64>)>,
    /// Errors in the camera frame when the best rigid motion is taken off [mm].
    pub relative: Vec<Vector3<f64>>,
    /// From medians of the depth on either side: a tilt of the plane counts.
    pub step_error_mm: f64,
    /// From two levels with one slope, as `calibrate check --step` does: a tilt does not count.
    pub level_error_mm: f64,
    pub step_sigma_mm: f64,
    pub lateral_error_mm: f64,
    pub lateral_sigma_mm: f64,
    pub focal_error_px: f64,
    pub focal_sigma_px: f64,
    pub rms_px: f64,
    pub plane_rms_mm: f64,
}

impl Bench {
    pub fn new() -> Self {
        Self { renderer: Renderer::new(SensorScene::documented().unwrap()).unwrap() }
    }

    /// Boards with the laser off, then with the laser on.
    pub fn pictures(&self, seed: u64, views: usize) -> (Memory, Memory) {
        let mut random = Pcg32::new(seed, 77);
        let poses = self.renderer.scene().draw_poses(board(), SQUARE_MM, views, &mut random);
        let mut picture = |i: usize, laser_on: bool| {
            let surface = BoardSurface { size: board(), square_mm: SQUARE_MM, pose: poses[i] };
            let word = if laser_on { "on" } else { "off" };
            (format!("{word}_{i:02}.png"), self.renderer.render(&surface, laser_on, &mut random).unwrap())
        };
        let dark = (0..views).map(|i| picture(i, false)).collect();
        let lit = (0..views).map(|i| picture(i, true)).collect();
        (Memory(dark), Memory(lit))
    }

    pub fn calibrate(&self, dark: Memory, lit: Memory) -> Result<(CameraFit, LaserFit), String> {
        let views = dark.0.len();
        let detected = detect(&dark, Some(board())).map_err(|e| e.to_string())?;
        let camera = fit_camera(detected, SQUARE_MM).map_err(|e| e.to_string())?;
        let both = Memory(dark.0.into_iter().chain(lit.0).collect());
        let pairs: Vec<Pair> = (0..views).map(|i| Pair { lit: views + i, dark: Some(i) }).collect();
        let (stripes, left_out) =
            find_stripes(&both, &pairs, board(), &camera.intrinsics, camera.size_px).map_err(|e| e.to_string())?;
        let known = KnownCamera {
            size_px: camera.size_px,
            intrinsics: camera.intrinsics,
            covariance: None,
            views: camera.views.iter().map(|view| view.sighting.clone()).collect(),
            rms_px: Some(camera.rms_px),
        };
        let laser = fit_laser(&known, (board(), SQUARE_MM), stripes, left_out, views).map_err(|e| e.to_string())?;
        Ok((camera, laser))
    }

    pub fn trial(&self, seed: u64, views: usize) -> Result<Trial, String> {
        let (dark, lit) = self.pictures(seed, views);
        let (camera, laser) = self.calibrate(dark, lit)?;
        self.compare(seed, &camera, &laser)
    }

    /// Points of the true plane, at five depths and five places along the stripe.
    fn grid(&self) -> Vec<Vector3<f64>> {
        let plane = self.renderer.scene().plane;
        let (n, d) = (plane.normal(), plane.distance_mm());
        let point = |z: f64, x: f64| Vector3::new(x, (d - n.x * x - n.z * z) / n.y, z);
        [225.0, 240.0, 250.0, 260.0, 275.0]
            .into_iter()
            .flat_map(|z| [-50.0, -20.0, 0.0, 20.0, 50.0].map(|x| point(z, x)))
            .collect()
    }

    pub fn compare(&self, seed: u64, camera: &CameraFit, laser: &LaserFit) -> Result<Trial, String> {
        let scene = self.renderer.scene();
        let sensor = &laser.sensor;
        let truth = self.grid();
        let true_axes: PlaneAxes = scene.plane.axes();
        let pixels: Vec<PixelPoint> = truth.iter().map(|p| scene.intrinsics.project(p).unwrap()).collect();
        let found: Vec<Vector3<f64>> = pixels.iter().map(|p| sensor.camera_point_mm(*p).unwrap()).collect();
        let absolute = truth.iter().zip(&pixels).map(|(truth, pixel)| {
            let point = sensor.point(*pixel).unwrap();
            let covariance = sensor.calibration_covariance_mm2(*pixel).unwrap();
            let error = Vector2::new(point.lateral_mm, point.height_mm) - true_axes.plane_from_camera(truth);
            (error, covariance.diagonal().map(f64::sqrt))
        });
        let apart = |a: usize, b: usize| {
            let by = sensor.parameter_jacobian(pixels[b]).unwrap() - sensor.parameter_jacobian(pixels[a]).unwrap();
            let along = (found[b] - found[a]).normalize();
            let direction = Vector2::new(along.dot(&sensor.axes().lateral), along.dot(&sensor.axes().height));
            let variance = direction.transpose() * by * sensor.covariance().unwrap() * by.transpose() * direction;
            variance[0].sqrt()
        };
        let mut random = Pcg32::new(seed, 78);
        let step =
            self.renderer.render(&StepSurface { distance_mm: 250.0, step_mm: STEP_MM }, true, &mut random).unwrap();
        let lean = scene.plane.axes().height.z.abs();
        let seen = stripe_points(sensor, &step).ok_or("no stripe on the step")?;
        let levels = check_step(sensor, &[seen], STEP_MM / lean, 1.0).map_err(|e| e.to_string())?;
        let measured_mm = self.step_in(&step, sensor).ok_or("no stripe on the step")?;
        Ok(Trial {
            absolute: absolute.collect(),
            relative: without_motion(&found, &truth),
            step_error_mm: measured_mm - STEP_MM,
            level_error_mm: levels.figures[0].value * lean,
            step_sigma_mm: apart(7, 17) * STEP_MM / (found[17] - found[7]).norm(),
            lateral_error_mm: (found[14] - found[10]).norm() - (truth[14] - truth[10]).norm(),
            lateral_sigma_mm: apart(10, 14),
            focal_error_px: camera.intrinsics.fx_px - scene.intrinsics.fx_px,
            focal_sigma_px: camera.covariance[(0, 0)].sqrt(),
            rms_px: camera.rms_px,
            plane_rms_mm: laser.rms_mm,
        })
    }

    /// What the speckle of a single frame makes of the step when the sensor is known exactly: root mean square [mm].
    pub fn step_alone_mm(&self, frames: u64) -> f64 {
        let scene = self.renderer.scene();
        let sensor = LaserCamera::new(scene.size_px, scene.intrinsics, scene.plane, None, None);
        let error = |seed: u64| {
            let surface = StepSurface { distance_mm: 250.0, step_mm: STEP_MM };
            let frame = self.renderer.render(&surface, true, &mut Pcg32::new(seed, 78)).unwrap();
            self.step_in(&frame, &sensor).unwrap() - STEP_MM
        };
        rms((1..=frames).map(error))
    }

    /// The step along the viewing direction: medians of the depth on either side, away from the edge.
    fn step_in(&self, frame: &GrayFrame, sensor: &LaserCamera) -> Option<f64> {
        let path = stripe_path(frame)?;
        let settings = CentrelineSettings { band_ratio: BAND_RATIO, ..CentrelineSettings::default() };
        let line = extract_along(frame, &settings, &path);
        let edge = self.renderer.scene().intrinsics.cx_px;
        let side = |sign: f64| {
            let seen = line.v_px.iter().enumerate().filter(|(u, _)| sign * (*u as f64 - edge) > STEP_MARGIN_PX);
            let depth = |(u, v): (usize, &Option<f32>)| {
                let pixel = PixelPoint::new(u as f64, f64::from((*v)?));
                Some(sensor.camera_point_mm(pixel)?.z)
            };
            let mut depths: Vec<f64> = seen.filter_map(depth).collect();
            depths.sort_by(f64::total_cmp);
            depths.get(depths.len() / 2).copied()
        };
        Some(side(1.0)? - side(-1.0)?)
    }
}

/// What is left of `found` − `truth` when `found` is moved rigidly as near as it goes (Kabsch 1976).
fn without_motion(found: &[Vector3<f64>], truth: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mean = |all: &[Vector3<f64>]| all.iter().sum::<Vector3<f64>>() / all.len() as f64;
    let (a, b) = (mean(found), mean(truth));
    let cross: Matrix3<f64> = found.iter().zip(truth).map(|(f, t)| (t - b) * (f - a).transpose()).sum();
    let svd: nalgebra::SVD<f64, nalgebra::U3, nalgebra::U3> = cross.svd(true, true);
    let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
    let sign = SMatrix::<f64, 3, 3>::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
    let rotation = u * sign * v_t;
    found.iter().zip(truth).map(|(f, t)| rotation * (f - a) + b - t).collect()
}

fn rms(all: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = all.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "camera {:.3} px, fx {:+.2} ± {:.2}; plane {:.4} mm; relative {:.4} {:.4} {:.4} mm; absolute height {:.4} mm (stated {:.4}); step {:+.4}, as levels {:+.4} ± {:.4}; 100 mm {:+.4} ± {:.4}",
            self.rms_px,
            self.focal_error_px,
            self.focal_sigma_px,
            self.plane_rms_mm,
            rms(self.relative.iter().map(|e| e.x)),
            rms(self.relative.iter().map(|e| e.y)),
            rms(self.relative.iter().map(|e| e.z)),
            rms(self.absolute.iter().map(|(e, _)| e.y)),
            rms(self.absolute.iter().map(|(_, s)| s.y)),
            self.step_error_mm,
            self.level_error_mm,
            self.step_sigma_mm,
            self.lateral_error_mm,
            self.lateral_sigma_mm
        )
    }
}

/// All seeds together.
#[derive(Debug, Clone)]
pub struct Summary {
    pub seeds: usize,
    pub relative_mm: [f64; 3],
    pub step_mm: f64,
    pub level_mm: f64,
    pub lateral_mm: f64,
    /// Share of 95 % intervals that hold the truth: lateral and height of points, a distance of 100 mm, the focal length.
    pub coverage: [f64; 4],
}

impl Summary {
    pub fn of(trials: &[Trial]) -> Self {
        let share = |inside: Vec<bool>| inside.iter().filter(|x| **x).count() as f64 / inside.len().max(1) as f64;
        let points = || trials.iter().flat_map(|t| &t.absolute);
        let relative = |axis: usize| rms(trials.iter().flat_map(|t| t.relative.iter().map(move |e| e[axis])));
        Self {
            seeds: trials.len(),
            relative_mm: [relative(0), relative(1), relative(2)],
            step_mm: rms(trials.iter().map(|t| t.step_error_mm)),
            level_mm: rms(trials.iter().map(|t| t.level_error_mm)),
            lateral_mm: rms(trials.iter().map(|t| t.lateral_error_mm)),
            coverage: [
                share(points().map(|(e, s)| e.x.abs() < Z_95 * s.x).collect()),
                share(points().map(|(e, s)| e.y.abs() < Z_95 * s.y).collect()),
                share(trials.iter().map(|t| t.lateral_error_mm.abs() < Z_95 * t.lateral_sigma_mm).collect()),
                share(trials.iter().map(|t| t.focal_error_px.abs() < Z_95 * t.focal_sigma_px).collect()),
            ],
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.relative_mm;
        let [lateral, height, distance, focal] = self.coverage;
        write!(
            f,
            "{} seeds: points without rigid motion {x:.4} {y:.4} {z:.4} mm rms; step of {STEP_MM} mm {:.4} mm rms, as levels {:.4}; 100 mm {:.4} mm rms; 95 % intervals hold lateral {lateral:.3}, height {height:.3}, 100 mm {distance:.3}, fx {focal:.3}",
            self.seeds, self.step_mm, self.level_mm, self.lateral_mm
        )
    }
}
