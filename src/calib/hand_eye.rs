//! From the camera to the robot's base: where the robot was, and how it holds the camera.

use nalgebra::{Matrix4, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Where the robot's flange was in its base, in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlangePose {
    base_from_flange: Matrix4<f64>,
}

impl FlangePose {
    /// From a position \[mm\] and angles \[°\] about x, y, z: R = Rz · Ry · Rx, as ABB's EulerZYX and most others have it.
    #[must_use]
    pub fn from_angles(position_mm: Vector3<f64>, [rx, ry, rz]: [f64; 3]) -> Self {
        let rotation = Rotation3::from_euler_angles(rx.to_radians(), ry.to_radians(), rz.to_radians());
        Self { base_from_flange: rotation.to_homogeneous().append_translation(&position_mm) }
    }

    /// From a position \[mm\] and a quaternion x, y, z, w. None when that has no direction.
    #[must_use]
    pub fn from_quaternion(position_mm: Vector3<f64>, [x, y, z, w]: [f64; 4]) -> Option<Self> {
        let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6)?;
        Some(Self { base_from_flange: rotation.to_homogeneous().append_translation(&position_mm) })
    }

    /// A point of the camera frame in the robot's base \[mm\]; `flange_from_camera` is the hand-eye matrix.
    #[must_use]
    pub fn base_point_mm(&self, flange_from_camera: &Matrix4<f64>, camera_mm: &Vector3<f64>) -> Vector3<f64> {
        (self.base_from_flange * flange_from_camera).transform_point(&Point3::from(*camera_mm)).coords
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_goes_through_hand_and_flange_into_the_base() {
        // The camera hangs 100 mm beyond the flange and looks the same way; the flange points down, at 500 mm.
        let hand_eye = Matrix4::new_translation(&Vector3::new(0.0, 0.0, 100.0));
        let pose = FlangePose::from_angles(Vector3::new(300.0, 20.0, 500.0), [180.0, 0.0, 0.0]);
        let at = pose.base_point_mm(&hand_eye, &Vector3::new(7.0, 3.0, 250.0));
        assert!((at - Vector3::new(307.0, 17.0, 150.0)).norm() < 1e-9, "{at}");
        let same = FlangePose::from_quaternion(Vector3::new(300.0, 20.0, 500.0), [2.0, 0.0, 0.0, 0.0]).unwrap();
        assert!((same.base_point_mm(&hand_eye, &Vector3::new(7.0, 3.0, 250.0)) - at).norm() < 1e-9);
        assert_eq!(FlangePose::from_quaternion(Vector3::zeros(), [0.0; 4]), None);
    }

    #[test]
    fn angles_turn_about_x_first_and_about_z_last() {
        let pose = FlangePose::from_angles(Vector3::zeros(), [90.0, 0.0, 90.0]);
        let at = pose.base_point_mm(&Matrix4::identity(), &Vector3::y());
        assert!((at - Vector3::z()).norm() < 1e-12, "{at}");
    }
}
