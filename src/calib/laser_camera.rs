//! The sensor of a camera and a laser plane: what a pixel of the stripe means in millimetres, and how sure that is.

use nalgebra::{Matrix2, SMatrix, Vector3};

use super::intrinsics::{INTRINSICS, Intrinsics};
use super::plane::{LaserPlane, PlaneAxes};
use crate::units::{PixelPoint, StripeAxis};

/// Parameters of a calibration: the intrinsics, then the plane's three ([`LaserPlane::varied`]).
pub const PARAMETERS: usize = INTRINSICS + 3;

/// Steps for the derivatives by the parameters, about a thousandth of what a calibration leaves open: focal lengths and
/// principal point \[px\], distortion, angles \[rad\], distance \[mm\].
const STEPS: [f64; PARAMETERS] = [1e-2, 1e-2, 1e-2, 1e-2, 1e-5, 1e-5, 1e-6, 1e-6, 1e-5, 1e-7, 1e-7, 1e-4];

/// A point of the laser's plane; [`PlaneAxes`] says where its axes lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanePoint {
    /// Along the stripe \[mm\].
    pub lateral_mm: f64,
    /// Towards the camera \[mm\].
    pub height_mm: f64,
}

/// Where the calibration saw stripes; beyond it is extrapolation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibratedRange {
    /// Least and largest column \[px\].
    pub u_px: [f64; 2],
    /// Least and largest row \[px\].
    pub v_px: [f64; 2],
    /// Least and largest lateral position \[mm\].
    pub lateral_mm: [f64; 2],
    /// Least and largest height \[mm\].
    pub height_mm: [f64; 2],
}

/// Covariance of [`PARAMETERS`].
pub type ParameterCovariance = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// A calibrated camera and laser plane.
#[derive(Debug, Clone, PartialEq)]
pub struct LaserCamera {
    size_px: (usize, usize),
    intrinsics: Intrinsics,
    plane: LaserPlane,
    axes: PlaneAxes,
    range: Option<CalibratedRange>,
    covariance: Option<ParameterCovariance>,
    /// Column and row of the calibrated picture at which the recording's picture was cut out.
    offset_px: (f64, f64),
}

/// A recording whose pictures are not those that were calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the pictures have {} x {} pixels, the calibration {} x {}: calibrate at the recording's size",
    got_px.0, got_px.1, calibrated_px.0, calibrated_px.1
)]
pub struct OtherImageSize {
    /// Columns and rows of the recording.
    pub got_px: (usize, usize),
    /// Columns and rows that were calibrated.
    pub calibrated_px: (usize, usize),
}

impl LaserCamera {
    /// A sensor of `size_px` columns and rows. Without a `range` nothing counts as calibrated, without a `covariance`
    /// the calibration's error is unknown.
    #[must_use]
    pub fn new(
        size_px: (usize, usize),
        intrinsics: Intrinsics,
        plane: LaserPlane,
        range: Option<CalibratedRange>,
        covariance: Option<ParameterCovariance>,
    ) -> Self {
        Self { size_px, intrinsics, plane, axes: plane.axes(), range, covariance, offset_px: (0.0, 0.0) }
    }

    /// The same sensor for pictures of `size_px` that were cut out at column and row `offset_px`: pixels are those of
    /// the cut-out picture from now on.
    ///
    /// # Errors
    /// When the cut does not lie within the calibrated picture.
    pub fn cropped(&self, offset_px: (usize, usize), size_px: (usize, usize)) -> Result<Self, OtherImageSize> {
        let fits = offset_px.0 + size_px.0 <= self.size_px.0 && offset_px.1 + size_px.1 <= self.size_px.1;
        if !fits {
            return Err(OtherImageSize { got_px: size_px, calibrated_px: self.size_px });
        }
        let by = (offset_px.0 as f64, offset_px.1 as f64);
        Ok(Self {
            size_px,
            intrinsics: self.intrinsics.cropped_at(by),
            offset_px: (self.offset_px.0 + by.0, self.offset_px.1 + by.1),
            ..self.clone()
        })
    }

    /// Columns and rows of the pictures.
    #[must_use]
    pub const fn size_px(&self) -> (usize, usize) {
        self.size_px
    }

    /// An error unless the recording's pictures have this sensor's size.
    ///
    /// # Errors
    /// When they have another.
    pub fn expect_size(&self, got_px: (usize, usize)) -> Result<(), OtherImageSize> {
        if got_px == self.size_px { Ok(()) } else { Err(OtherImageSize { got_px, calibrated_px: self.size_px }) }
    }

    /// The camera.
    #[must_use]
    pub const fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// The laser's plane.
    #[must_use]
    pub const fn plane(&self) -> &LaserPlane {
        &self.plane
    }

    /// Origin and axes of the points in the plane, camera frame.
    #[must_use]
    pub const fn axes(&self) -> &PlaneAxes {
        &self.axes
    }

    /// Where stripes were seen when it was calibrated.
    #[must_use]
    pub const fn range(&self) -> Option<&CalibratedRange> {
        self.range.as_ref()
    }

    /// Covariance of the parameters, where it is known.
    #[must_use]
    pub const fn covariance(&self) -> Option<&ParameterCovariance> {
        self.covariance.as_ref()
    }

    /// How the stripe of a flat plate runs through the picture.
    #[must_use]
    pub fn stripe_axis(&self) -> StripeAxis {
        if self.axes.lateral.x.abs() >= self.axes.lateral.y.abs() {
            StripeAxis::Horizontal
        } else {
            StripeAxis::Vertical
        }
    }

    /// The point of the camera frame that a pixel of the stripe shows \[mm\]. None where its ray does not meet the plane
    /// in front of the camera.
    #[must_use]
    pub fn camera_point_mm(&self, pixel: PixelPoint) -> Option<Vector3<f64>> {
        self.plane.meet(self.intrinsics.ray(pixel)?)
    }

    /// The point of the plane that a pixel of the stripe shows.
    #[must_use]
    pub fn point(&self, pixel: PixelPoint) -> Option<PlanePoint> {
        let at = self.axes.plane_from_camera(&self.camera_point_mm(pixel)?);
        Some(PlanePoint { lateral_mm: at.x, height_mm: at.y })
    }

    /// The pixel that shows a point of the plane. None behind the camera.
    #[must_use]
    pub fn pixel(&self, point: PlanePoint) -> Option<PixelPoint> {
        self.intrinsics.project(&self.axes.camera_from_plane(point.lateral_mm, point.height_mm))
    }

    /// Derivatives of (lateral, height) by (u, v) \[mm/px\].
    #[must_use]
    pub fn jacobian(&self, pixel: PixelPoint) -> Option<Matrix2<f64>> {
        let (ray, by_pixel) = self.intrinsics.ray_with_derivatives(pixel)?;
        let point = self.plane.meet(ray)?;
        let n = self.plane.normal();
        let direction = point / point.z;
        // X = z (x, y, 1) with n · X constant: dX = z (I − direction nᵀ / n·direction) (dx, dy, 0).
        let slide = SMatrix::<f64, 3, 3>::identity() - direction * n.transpose() / n.dot(&direction);
        let by_ray = point.z * slide.fixed_columns::<2>(0);
        Some(self.axes.matrix() * by_ray * by_pixel)
    }

    /// Whether a pixel, and the point that it shows, lie where stripes were calibrated.
    #[must_use]
    pub fn is_calibrated(&self, pixel: PixelPoint) -> bool {
        let Some(range) = &self.range else { return false };
        let within = |[least, most]: [f64; 2], value: f64| (least..=most).contains(&value);
        let full = PixelPoint::new(pixel.u_px + self.offset_px.0, pixel.v_px + self.offset_px.1);
        within(range.u_px, full.u_px)
            && within(range.v_px, full.v_px)
            && self.point(pixel).is_some_and(|point| {
                within(range.lateral_mm, point.lateral_mm) && within(range.height_mm, point.height_mm)
            })
    }

    /// Derivatives of (lateral, height) by the calibration's parameters. With the difference of two points' derivatives
    /// and [`Self::covariance`] a distance gets its own uncertainty, which is far below that of either point.
    #[must_use]
    pub fn parameter_jacobian(&self, pixel: PixelPoint) -> Option<SMatrix<f64, 2, PARAMETERS>> {
        let mut jacobian = SMatrix::<f64, 2, PARAMETERS>::zeros();
        for (i, step) in STEPS.into_iter().enumerate() {
            let at = |by: f64| {
                let mut varied = [0.0; PARAMETERS];
                varied[i] = by;
                let sensor = self.varied(&varied);
                let point = sensor.camera_point_mm(pixel)?;
                Some(sensor.axes.plane_from_camera(&point))
            };
            jacobian.set_column(i, &((at(step)? - at(-step)?) / (2.0 * step)));
        }
        Some(jacobian)
    }

    /// Covariance of (lateral, height) that the calibration's own error gives \[mm²\]. It is the same error in every
    /// frame, so it does not average out.
    #[must_use]
    pub fn calibration_covariance_mm2(&self, pixel: PixelPoint) -> Option<Matrix2<f64>> {
        let jacobian = self.parameter_jacobian(pixel)?;
        Some(jacobian * self.covariance? * jacobian.transpose())
    }

    /// The sensor with its parameters moved by `by`.
    #[must_use]
    pub fn varied(&self, by: &[f64; PARAMETERS]) -> Self {
        let mut intrinsics = self.intrinsics.to_array();
        intrinsics.iter_mut().zip(by).for_each(|(value, by)| *value += by);
        let plane = self.plane.varied([by[INTRINSICS], by[INTRINSICS + 1], by[INTRINSICS + 2]]);
        Self { intrinsics: Intrinsics::from_array(intrinsics), plane, axes: plane.axes(), ..self.clone() }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::intrinsics::tests::LENS;
    use super::*;
    use proptest::prelude::*;

    pub fn sensor() -> LaserCamera {
        let (sin, cos) = 22f64.to_radians().sin_cos();
        let normal = Vector3::new(0.02, cos, sin);
        let plane = LaserPlane::new(normal, normal.dot(&Vector3::new(0.0, 0.0, 250.0))).unwrap();
        let range = CalibratedRange {
            u_px: [100.0, 900.0],
            v_px: [100.0, 700.0],
            lateral_mm: [-60.0, 60.0],
            height_mm: [-300.0, -180.0],
        };
        let mut covariance = ParameterCovariance::zeros();
        covariance[(11, 11)] = 0.04;
        LaserCamera::new((1000, 750), LENS, plane, Some(range), Some(covariance))
    }

    proptest! {
        #[test]
        fn pixels_and_points_lead_to_one_another(u in 0.0f64..1000.0, v in 150.0f64..700.0) {
            let pixel = PixelPoint::new(u, v);
            let back = sensor().pixel(sensor().point(pixel).unwrap()).unwrap();
            prop_assert!((back.u_px - u).abs() < 1e-6 && (back.v_px - v).abs() < 1e-6);
        }

        #[test]
        fn the_jacobian_is_that_of_small_differences(u in 10.0f64..990.0, v in 150.0f64..700.0) {
            let sensor = sensor();
            let exact = sensor.jacobian(PixelPoint::new(u, v)).unwrap();
            let at = |du: f64, dv: f64| sensor.point(PixelPoint::new(u + du, v + dv)).unwrap();
            for (column, (du, dv)) in [(0.01, 0.0), (0.0, 0.01)].into_iter().enumerate() {
                let (ahead, behind) = (at(du, dv), at(-du, -dv));
                prop_assert!(((ahead.lateral_mm - behind.lateral_mm) / 0.02 - exact[(0, column)]).abs() < 1e-6);
                prop_assert!(((ahead.height_mm - behind.height_mm) / 0.02 - exact[(1, column)]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn the_range_holds_in_pixels_and_in_millimetres_and_survives_a_crop() {
        let sensor = sensor();
        let inside = PixelPoint::new(500.0, 371.0);
        assert!(sensor.is_calibrated(inside));
        assert!(!sensor.is_calibrated(PixelPoint::new(950.0, 371.0)));
        let cropped = sensor.cropped((300, 200), (400, 300)).unwrap();
        let same = PixelPoint::new(200.0, 171.0);
        assert!(cropped.is_calibrated(same));
        let (a, b) = (sensor.point(inside).unwrap(), cropped.point(same).unwrap());
        assert!((a.lateral_mm - b.lateral_mm).abs() < 1e-9 && (a.height_mm - b.height_mm).abs() < 1e-9);
        assert!(sensor.cropped((700, 0), (400, 300)).is_err());
        assert!(sensor.expect_size((640, 480)).unwrap_err().to_string().contains("640 x 480"));
        assert_eq!(sensor.stripe_axis(), StripeAxis::Horizontal);
    }

    #[test]
    fn a_plane_known_to_two_tenths_gives_heights_known_to_as_much_over_the_sine_of_the_angle() {
        let sensor = sensor();
        let pixel = PixelPoint::new(507.0, 371.0);
        let covariance = sensor.calibration_covariance_mm2(pixel).unwrap();
        // The axis' ray meets the plane at n·X = d: z = d/n_z, so dz = .2/n_z; the height runs along the plane.
        let axes = sensor.axes();
        let expected = (0.2 / sensor.plane().normal().z) * axes.height.z.abs();
        assert!((covariance[(1, 1)].sqrt() - expected).abs() < 0.02 * expected, "{covariance}");
    }
}
