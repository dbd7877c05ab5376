//! The path in the robot's base frame.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Args;
use nalgebra::{Matrix4, Vector3};
use seamtrack::calib::KnownSensor;
use seamtrack::calib::hand_eye::FlangePose;
use seamtrack::report::results::{Estimator, PathRow};
use seamtrack::report::tum::write_points;

use super::calibrate::read_hand_eye;

/// Where the robot was.
#[derive(Debug, Args)]
pub struct BaseFrame {
    /// The robot's flange for each frame: x, y, z [mm] and rx, ry, rz [°] (R = Rz·Ry·Rx) or qx, qy, qz, qw; with a calibration the
    /// path is also written in the robot's base frame (base-filtered.tum, base-smoothed.tum)
    #[arg(long, value_name = "CSV", requires = "calibration")]
    poses: Option<PathBuf>,
    /// The camera in the flange's frame, 4 x 4 in mm [default: the calibration's]
    #[arg(long, value_name = "FILE", requires = "poses")]
    hand_eye: Option<PathBuf>,
}

/// What leads from the picture to the robot's base.
pub struct Robot {
    poses: Vec<FlangePose>,
    flange_from_camera: Matrix4<f64>,
    name: String,
}

impl BaseFrame {
    /// The files that are read.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.poses.iter().chain(&self.hand_eye)
    }

    /// The robot, where its poses are given.
    pub fn robot(&self, known: &KnownSensor) -> anyhow::Result<Option<Robot>> {
        let Some(path) = &self.poses else { return Ok(None) };
        ensure!(
            known.sensor.laser_camera().is_some(),
            "{} is one scale: a path in the robot's base needs camera and laser plane (`seamtrack calibrate laser`)",
            known.source
        );
        let given = self.hand_eye.as_deref().map(read_hand_eye).transpose()?;
        let given = given.map(|rows| Matrix4::from_fn(|i, j| rows[i][j]));
        let from_file = || known.file.as_ref().and_then(|file| file.hand_eye());
        let Some(flange_from_camera) = given.or_else(from_file) else {
            bail!("{} has no [hand_eye]: give --hand-eye FILE, the camera in the flange's frame", known.source)
        };
        Ok(Some(Robot { poses: read_flange_poses(path)?, flange_from_camera, name: path.display().to_string() }))
    }
}

impl Robot {
    /// Writes the filtered and the smoothed path into `folder`.
    pub fn write(&self, folder: &Path, rows: &[PathRow], known: &KnownSensor) -> anyhow::Result<()> {
        let Some(sensor) = known.sensor.laser_camera() else { return Ok(()) };
        ensure!(
            self.poses.len() >= rows.len(),
            "{} has {} poses for {} frames: one a frame is needed",
            self.name,
            self.poses.len(),
            rows.len()
        );
        for (estimator, name) in
            [(Estimator::Filtered, "base-filtered.tum"), (Estimator::Smoothed, "base-smoothed.tum")]
        {
            let point = |(row, pose): (&PathRow, &FlangePose)| {
                let camera_mm = sensor.camera_point_mm(row.point(estimator)?)?;
                Some((row.time_s, pose.base_point_mm(&self.flange_from_camera, &camera_mm)))
            };
            write_points(&folder.join(name), rows.iter().zip(&self.poses).filter_map(point))?;
        }
        Ok(())
    }
}

/// The numbers of a line: six with angles, seven with a quaternion; a line of names before them may order its four.
fn read_flange_poses(path: &Path) -> anyhow::Result<Vec<FlangePose>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut poses = vec![];
    let mut w_first = false;
    for (i, line) in text.lines().enumerate() {
        let line = line.trim().trim_start_matches('\u{feff}');
        let cells: Vec<&str> =
            line.split([',', ';', '\t', ' ']).map(str::trim).filter(|cell| !cell.is_empty()).collect();
        if cells.is_empty() || line.starts_with('#') {
            continue;
        }
        let numbers: Option<Vec<f64>> =
            cells.iter().map(|cell| cell.parse().ok().filter(|number: &f64| number.is_finite())).collect();
        let pose = match numbers.as_deref() {
            Some([x, y, z, rx, ry, rz]) => Some(FlangePose::from_angles(Vector3::new(*x, *y, *z), [*rx, *ry, *rz])),
            Some([x, y, z, a, b, c, d]) => {
                let quaternion = if w_first { [*b, *c, *d, *a] } else { [*a, *b, *c, *d] };
                FlangePose::from_quaternion(Vector3::new(*x, *y, *z), quaternion)
            }
            None if poses.is_empty() && cells.iter().all(|cell| cell.parse::<f64>().is_err()) => {
                w_first = cells.get(3).is_some_and(|cell| cell.to_lowercase().ends_with('w'));
                continue;
            }
            _ => None,
        };
        poses.push(pose.with_context(|| {
            format!(
                "{}: line {} is no pose: x, y, z in mm, then rx, ry, rz in degrees or qx, qy, qz, qw",
                path.display(),
                i + 1
            )
        })?);
    }
    Ok(poses)
}
