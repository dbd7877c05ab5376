//! A camera's intrinsics: the pinhole with five terms of distortion that OpenCV, ROS and Kalibr (`radtan`) share.
//!
//! A point (X, Y, Z) of the camera frame (x to the right, y down, z into the scene) has the normalised coordinates
//! x = X/Z, y = Y/Z, and with r² = x² + y² the pixel
//! ```text
//! x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)      u = fx x' + cx
//! y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y      v = fy y' + cy
//! ```
//! (OpenCV's documentation of the module calib3d; Brown 1971).

use nalgebra::{Matrix2, Matrix2x3, SMatrix, Vector2, Vector3};

use crate::units::PixelPoint;

/// Number of parameters.
pub const INTRINSICS: usize = 9;
/// Their names in files, in the order of [`Intrinsics::to_array`].
pub const INTRINSIC_NAMES: [&str; INTRINSICS] = ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];

/// Newton's steps that undo the distortion; three suffice for any lens that can be undone.
const UNDISTORT_STEPS: usize = 30;
/// A normalised coordinate is found when a step is shorter than this: a millionth of a pixel.
const UNDISTORT_STEP: f64 = 1e-12;
/// The distortion counts as undone when it leads back to within this of the pixel, in normalised coordinates.
const UNDISTORT_MISS: f64 = 1e-9;

/// Focal lengths, principal point and distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length along the rows \[px\].
    pub fx_px: f64,
    /// Focal length along the columns \[px\].
    pub fy_px: f64,
    /// Column of the principal point \[px\].
    pub cx_px: f64,
    /// Row of the principal point \[px\].
    pub cy_px: f64,
    /// Radial distortion, r².
    pub k1: f64,
    /// Radial distortion, r⁴.
    pub k2: f64,
    /// Tangential distortion.
    pub p1: f64,
    /// Tangential distortion.
    pub p2: f64,
    /// Radial distortion, r⁶.
    pub k3: f64,
}

/// A pixel with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projection {
    pub pixel: Vector2<f64>,
    pub by_point: Matrix2x3<f64>,
    pub by_intrinsics: SMatrix<f64, 2, INTRINSICS>,
}

impl Intrinsics {
    /// The parameters in the order of [`INTRINSIC_NAMES`].
    #[must_use]
    pub const fn to_array(self) -> [f64; INTRINSICS] {
        [self.fx_px, self.fy_px, self.cx_px, self.cy_px, self.k1, self.k2, self.p1, self.p2, self.k3]
    }

    /// The inverse of [`Self::to_array`].
    #[must_use]
    pub const fn from_array([fx_px, fy_px, cx_px, cy_px, k1, k2, p1, p2, k3]: [f64; INTRINSICS]) -> Self {
        Self { fx_px, fy_px, cx_px, cy_px, k1, k2, p1, p2, k3 }
    }

    /// Where a camera of `size_px` with a lens without distortion would start.
    #[must_use]
    pub(crate) fn pinhole(focal_px: f64, size_px: (usize, usize)) -> Self {
        let (cx_px, cy_px) = (0.5 * (size_px.0 as f64 - 1.0), 0.5 * (size_px.1 as f64 - 1.0));
        Self { fx_px: focal_px, fy_px: focal_px, cx_px, cy_px, k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 }
    }

    /// The same camera seen through a picture cut out at column and row `offset_px`.
    #[must_use]
    pub fn cropped_at(self, offset_px: (f64, f64)) -> Self {
        Self { cx_px: self.cx_px - offset_px.0, cy_px: self.cy_px - offset_px.1, ..self }
    }

    /// Normalised coordinates with distortion, and their derivatives by those without.
    fn distort(&self, n: Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let (x, y) = (n.x, n.y);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        let slope = self.k1 + r2 * (2.0 * self.k2 + 3.0 * r2 * self.k3);
        let distorted = Vector2::new(
            x * radial + 2.0 * self.p1 * x * y + self.p2 * (r2 + 2.0 * x * x),
            y * radial + self.p1 * (r2 + 2.0 * y * y) + 2.0 * self.p2 * x * y,
        );
        let mixed = 2.0 * x * y * slope + 2.0 * self.p1 * x + 2.0 * self.p2 * y;
        let jacobian = Matrix2::new(
            radial + 2.0 * x * x * slope + 2.0 * self.p1 * y + 6.0 * self.p2 * x,
            mixed,
            mixed,
            radial + 2.0 * y * y * slope + 6.0 * self.p1 * y + 2.0 * self.p2 * x,
        );
        (distorted, jacobian)
    }

    /// The pixel of a point of the camera frame \[mm\]; none behind the camera.
    #[must_use]
    pub fn project(&self, point_mm: &Vector3<f64>) -> Option<PixelPoint> {
        (point_mm.z > 0.0).then(|| {
            let (d, _) = self.distort(Vector2::new(point_mm.x / point_mm.z, point_mm.y / point_mm.z));
            PixelPoint::new(self.fx_px * d.x + self.cx_px, self.fy_px * d.y + self.cy_px)
        })
    }

    /// As [`Self::project`], with the derivatives by the point \[px/mm\] and by the intrinsics.
    pub(crate) fn project_with_derivatives(&self, point_mm: &Vector3<f64>) -> Option<Projection> {
        if point_mm.z <= 0.0 {
            return None;
        }
        let depth = point_mm.z;
        let n = Vector2::new(point_mm.x / depth, point_mm.y / depth);
        let (d, jacobian) = self.distort(n);
        let focal = Matrix2::new(self.fx_px, 0.0, 0.0, self.fy_px);
        let by_normalised = focal * jacobian;
        let normalise = Matrix2x3::new(1.0, 0.0, -n.x, 0.0, 1.0, -n.y) / depth;
        let (x, y, r2) = (n.x, n.y, n.norm_squared());
        let (fx, fy) = (self.fx_px, self.fy_px);
        #[rustfmt::skip]
        let by_intrinsics = SMatrix::<f64, 2, INTRINSICS>::from_row_slice(&[
            d.x, 0.0, 1.0, 0.0, fx * x * r2, fx * x * r2 * r2, fx * 2.0 * x * y, fx * (r2 + 2.0 * x * x), fx * x * r2.powi(3),
            0.0, d.y, 0.0, 1.0, fy * y * r2, fy * y * r2 * r2, fy * (r2 + 2.0 * y * y), fy * 2.0 * x * y, fy * y * r2.powi(3),
        ]);
        Some(Projection {
            pixel: Vector2::new(fx * d.x + self.cx_px, fy * d.y + self.cy_px),
            by_point: by_normalised * normalise,
            by_intrinsics,
        })
    }

    /// The direction (x, y, 1) in which a pixel looks, as its normalised coordinates (x, y). None where the distortion
    /// cannot be undone: too far outside the picture for this lens.
    #[must_use]
    pub fn ray(&self, pixel: PixelPoint) -> Option<Vector2<f64>> {
        let target = Vector2::new((pixel.u_px - self.cx_px) / self.fx_px, (pixel.v_px - self.cy_px) / self.fy_px);
        let mut n = target;
        for _ in 0..UNDISTORT_STEPS {
            let (d, jacobian) = self.distort(n);
            // A lens that folds the picture over has no inverse there.
            if jacobian.determinant() <= 0.0 {
                return None;
            }
            let step = jacobian.try_inverse()? * (target - d);
            n += step;
            if step.norm() < UNDISTORT_STEP {
                break;
            }
        }
        let (d, jacobian) = self.distort(n);
        (n.iter().all(|x| x.is_finite()) && (d - target).norm() < UNDISTORT_MISS && jacobian.determinant() > 0.0)
            .then_some(n)
    }

    /// [`Self::ray`] and its derivatives by the pixel \[1/px\].
    pub(crate) fn ray_with_derivatives(&self, pixel: PixelPoint) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let n = self.ray(pixel)?;
        let (_, jacobian) = self.distort(n);
        let focal = Matrix2::new(self.fx_px, 0.0, 0.0, self.fy_px);
        Some((n, (focal * jacobian).try_inverse()?))
    }

    /// What is wrong with these numbers, if anything.
    pub(crate) fn problem(&self) -> Option<String> {
        let wrong = self.to_array().into_iter().zip(INTRINSIC_NAMES).find(|(value, _)| !value.is_finite());
        if let Some((value, name)) = wrong {
            return Some(format!("{name} = {value} is not a finite number"));
        }
        (self.fx_px <= 0.0 || self.fy_px <= 0.0).then(|| "fx and fy must be above 0".into())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    pub(crate) const LENS: Intrinsics = Intrinsics {
        fx_px: 1250.0,
        fy_px: 1252.0,
        cx_px: 507.0,
        cy_px: 371.0,
        k1: -0.11,
        k2: 0.15,
        p1: 0.0006,
        p2: -0.0008,
        k3: 0.02,
    };

    #[test]
    fn a_point_on_the_axis_is_seen_at_the_principal_point_and_none_behind_the_camera() {
        let pixel = LENS.project(&Vector3::new(0.0, 0.0, 300.0)).unwrap();
        approx::assert_relative_eq!(pixel.u_px, 507.0);
        approx::assert_relative_eq!(pixel.v_px, 371.0);
        assert!(LENS.project(&Vector3::new(0.0, 0.0, -1.0)).is_none());
    }

    #[test]
    fn the_projection_is_that_of_opencv() {
        // cv2.projectPoints of OpenCV 4.6's formula by hand: x = .2, y = -.1, r² = .05.
        let pixel = LENS.project(&Vector3::new(60.0, -30.0, 300.0)).unwrap();
        let radial = 1.0 - 0.11 * 0.05 + 0.15 * 0.0025 + 0.02 * 0.000125;
        let x = 0.2 * radial + 2.0 * 0.0006 * 0.2 * -0.1 - 0.0008 * (0.05 + 2.0 * 0.04);
        let y = -0.1 * radial + 0.0006 * (0.05 + 2.0 * 0.01) + 2.0 * -0.0008 * 0.2 * -0.1;
        approx::assert_relative_eq!(pixel.u_px, 1250.0 * x + 507.0, epsilon = 1e-9);
        approx::assert_relative_eq!(pixel.v_px, 1252.0 * y + 371.0, epsilon = 1e-9);
    }

    #[test]
    fn a_lens_that_folds_the_picture_over_has_no_ray_there() {
        let folded = Intrinsics { k1: -0.6, k2: 0.0, k3: 0.0, ..LENS };
        assert!(folded.ray(PixelPoint::new(2300.0, 371.0)).is_none());
    }

    proptest! {
        #[test]
        fn a_ray_leads_back_to_its_pixel(u in -50.0f64..1050.0, v in -50.0f64..800.0, z in 50.0f64..2000.0) {
            let n = LENS.ray(PixelPoint::new(u, v)).unwrap();
            let pixel = LENS.project(&Vector3::new(n.x * z, n.y * z, z)).unwrap();
            prop_assert!((pixel.u_px - u).abs() < 1e-6 && (pixel.v_px - v).abs() < 1e-6);
        }

        #[test]
        fn the_derivatives_are_those_of_small_differences(x in -80.0f64..80.0, y in -60.0f64..60.0, z in 200.0f64..400.0) {
            let point = Vector3::new(x, y, z);
            let exact = LENS.project_with_derivatives(&point).unwrap();
            let uv = |lens: Intrinsics, point: Vector3<f64>| lens.project(&point).map(|p| Vector2::new(p.u_px, p.v_px)).unwrap();
            for i in 0..3 {
                let mut step = Vector3::zeros();
                step[i] = 1e-4;
                let slope = (uv(LENS, point + step) - uv(LENS, point - step)) / 2e-4;
                prop_assert!((slope - exact.by_point.column(i)).norm() < 1e-5);
            }
            for i in 0..INTRINSICS {
                let shifted = |by: f64| { let mut all = LENS.to_array(); all[i] += by; Intrinsics::from_array(all) };
                let slope = (uv(shifted(1e-4), point) - uv(shifted(-1e-4), point)) / 2e-4;
                prop_assert!((slope - exact.by_intrinsics.column(i)).norm() < 1e-4, "{i}");
            }
            let pixel = uv(LENS, point);
            let (_, jacobian) = LENS.ray_with_derivatives(PixelPoint::new(pixel.x, pixel.y)).unwrap();
            let ahead = LENS.ray(PixelPoint::new(pixel.x + 0.01, pixel.y)).unwrap();
            let behind = LENS.ray(PixelPoint::new(pixel.x - 0.01, pixel.y)).unwrap();
            prop_assert!(((ahead - behind) / 0.02 - jacobian.column(0)).norm() < 1e-9);
        }
    }
}
