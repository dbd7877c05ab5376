//! The laser's plane in the camera frame, and its own axes.

use nalgebra::{SMatrix, Unit, Vector2, Vector3};

/// A plane whose normal is closer than this to the optical axis has no height \[cosine of the angle between them\].
const FACING: f64 = 0.999;
/// A plane nearer than this to the camera's centre cannot be triangulated \[mm\].
const LEAST_DISTANCE_MM: f64 = 1e-3;

/// The plane of all points X with normal · X = distance, camera frame, in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaserPlane {
    normal: Unit<Vector3<f64>>,
    distance_mm: f64,
}

/// The axes of a laser plane.
///
/// * The origin is the point of the plane nearest to the camera's centre.
/// * `height` is the direction in the plane that points most against the viewing direction: towards the camera. So a
///   height is below zero, −300 mm is a working distance of 300 mm measured in the plane, and a raised plate is higher.
/// * `lateral` is perpendicular to it, with the sign that makes it grow with the picture's coordinate along the stripe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneAxes {
    /// The origin \[mm\], camera frame.
    pub origin_mm: Vector3<f64>,
    /// Unit vector along the stripe.
    pub lateral: Vector3<f64>,
    /// Unit vector towards the camera.
    pub height: Vector3<f64>,
}

/// A plane that no sensor can have.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PlaneError {
    /// A normal of length zero, or numbers that are not finite.
    #[error("the laser plane's normal and distance must be finite numbers, and the normal longer than 0")]
    NotFinite,
    /// The plane is parallel to the image.
    #[error(
        "the laser plane faces the camera, so a stripe in it shows no height: it cannot be the plane of a stripe sensor"
    )]
    FacesCamera,
    /// The plane holds the camera's centre.
    #[error("the laser plane passes through the camera's centre, so nothing can be triangulated with it")]
    ThroughCamera,
}

impl LaserPlane {
    /// The plane normal · X = `distance_mm`; the normal may have any length. It is kept with its largest component
    /// above 0.
    ///
    /// # Errors
    /// When no stripe sensor can have this plane.
    pub fn new(normal: Vector3<f64>, distance_mm: f64) -> Result<Self, PlaneError> {
        let length = normal.norm();
        if !(length.is_finite() && length > 0.0 && distance_mm.is_finite()) {
            return Err(PlaneError::NotFinite);
        }
        let sign = if normal[normal.iamax()] < 0.0 { -1.0 } else { 1.0 };
        let plane = Self { normal: Unit::new_normalize(sign * normal), distance_mm: sign * distance_mm / length };
        if plane.normal.z.abs() > FACING {
            return Err(PlaneError::FacesCamera);
        }
        if plane.distance_mm.abs() < LEAST_DISTANCE_MM {
            return Err(PlaneError::ThroughCamera);
        }
        Ok(plane)
    }

    /// The unit normal.
    #[must_use]
    pub fn normal(&self) -> Vector3<f64> {
        self.normal.into_inner()
    }

    /// normal · X of the plane's points \[mm\].
    #[must_use]
    pub const fn distance_mm(&self) -> f64 {
        self.distance_mm
    }

    /// Signed distance of a point from the plane \[mm\].
    #[must_use]
    pub fn offset_mm(&self, point_mm: &Vector3<f64>) -> f64 {
        self.normal.dot(point_mm) - self.distance_mm
    }

    /// Where the ray (x, y, 1) of normalised coordinates meets the plane \[mm\]; none behind the camera.
    #[must_use]
    pub fn meet(&self, ray: Vector2<f64>) -> Option<Vector3<f64>> {
        let direction = Vector3::new(ray.x, ray.y, 1.0);
        let depth_mm = self.distance_mm / self.normal.dot(&direction);
        (depth_mm.is_finite() && depth_mm > 0.0).then(|| direction * depth_mm)
    }

    /// The plane's axes.
    #[must_use]
    pub fn axes(&self) -> PlaneAxes {
        let n = self.normal();
        let height = (n * n.z - Vector3::z()).normalize();
        let across = n.cross(&height);
        let along = if across.x.abs() >= across.y.abs() { across.x } else { across.y };
        PlaneAxes { origin_mm: n * self.distance_mm, lateral: across * along.signum(), height }
    }

    /// The plane turned by small angles \[rad\] towards its lateral and its height axis and moved along its normal \[mm\]:
    /// the three parameters in which its covariance is given.
    #[must_use]
    pub fn varied(&self, [towards_lateral, towards_height, moved_mm]: [f64; 3]) -> Self {
        let axes = self.axes();
        let normal = self.normal() + towards_lateral * axes.lateral + towards_height * axes.height;
        Self { normal: Unit::new_normalize(normal), distance_mm: self.distance_mm + moved_mm }
    }

    /// The inverse of [`Self::varied`], to first order.
    #[must_use]
    pub(crate) fn variation_to(&self, other: &Self) -> [f64; 3] {
        let axes = self.axes();
        let sign = if self.normal.dot(&other.normal) < 0.0 { -1.0 } else { 1.0 };
        let n = sign * other.normal();
        [n.dot(&axes.lateral), n.dot(&axes.height), sign * other.distance_mm - self.distance_mm]
    }
}

impl PlaneAxes {
    /// Lateral and height of a point \[mm\].
    #[must_use]
    pub fn plane_from_camera(&self, point_mm: &Vector3<f64>) -> Vector2<f64> {
        let from_origin = point_mm - self.origin_mm;
        Vector2::new(from_origin.dot(&self.lateral), from_origin.dot(&self.height))
    }

    /// The point of the camera frame at a lateral position and a height \[mm\].
    #[must_use]
    pub fn camera_from_plane(&self, lateral_mm: f64, height_mm: f64) -> Vector3<f64> {
        self.origin_mm + lateral_mm * self.lateral + height_mm * self.height
    }

    /// Rows: the lateral and the height axis.
    pub(crate) fn matrix(&self) -> SMatrix<f64, 2, 3> {
        SMatrix::from_rows(&[self.lateral.transpose(), self.height.transpose()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_grow_towards_the_camera_and_laterals_along_the_stripe() {
        // The laser 22° from above in a picture with a horizontal stripe.
        let (sin, cos) = 22f64.to_radians().sin_cos();
        let plane = LaserPlane::new(Vector3::new(0.0, cos, sin), sin * 250.0).unwrap();
        let axes = plane.axes();
        let near = axes.plane_from_camera(&plane.meet(Vector2::new(0.1, -0.02)).unwrap());
        let far = axes.plane_from_camera(&plane.meet(Vector2::new(0.1, 0.02)).unwrap());
        assert!(
            (near.y > far.y)
                == (plane.meet(Vector2::new(0.1, -0.02)).unwrap().z < plane.meet(Vector2::new(0.1, 0.02)).unwrap().z)
        );
        approx::assert_relative_eq!(axes.lateral.x, 1.0, epsilon = 1e-12);
        assert!(near.y < 0.0 && near.x > 0.0);
        let back = axes.camera_from_plane(near.x, near.y);
        assert!(plane.offset_mm(&back).abs() < 1e-9);
    }

    #[test]
    fn a_variation_is_read_back_and_the_sign_of_the_normal_does_not_matter() {
        let plane = LaserPlane::new(Vector3::new(-0.9995, 0.0178, 0.025), 48.0).unwrap();
        assert!(plane.normal().x > 0.0 && plane.distance_mm() < 0.0);
        let by = [1e-4, -2e-4, 0.3];
        let read = plane.variation_to(&plane.varied(by));
        for i in 0..3 {
            assert!((read[i] - by[i]).abs() < 1e-7);
        }
    }

    #[test]
    fn planes_that_no_sensor_can_have_are_refused() {
        assert_eq!(LaserPlane::new(Vector3::zeros(), 1.0), Err(PlaneError::NotFinite));
        assert_eq!(LaserPlane::new(Vector3::x(), f64::NAN), Err(PlaneError::NotFinite));
        assert_eq!(LaserPlane::new(Vector3::z(), 300.0), Err(PlaneError::FacesCamera));
        assert_eq!(LaserPlane::new(Vector3::x(), 0.0), Err(PlaneError::ThroughCamera));
    }
}
