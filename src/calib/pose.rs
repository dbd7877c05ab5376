//! Where a board stood, and a first guess of it and of the focal length from the board's homographies (Zhang 2000).

use nalgebra::{Matrix3, Rotation3, SMatrix, Vector2, Vector3, Vector6};

use super::intrinsics::Intrinsics;
use crate::units::PixelPoint;

/// From the board's frame to the camera's: X = R (x, y, 0) + t, in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation.
    pub rotation: Rotation3<f64>,
    /// The board's middle in the camera frame \[mm\].
    pub translation_mm: Vector3<f64>,
}

impl Pose {
    /// A point of the board in the camera frame \[mm\].
    #[must_use]
    pub fn camera_from_board(&self, point_mm: &Vector2<f64>) -> Vector3<f64> {
        self.rotation * Vector3::new(point_mm.x, point_mm.y, 0.0) + self.translation_mm
    }

    /// The board's normal in the camera frame.
    #[must_use]
    pub fn normal(&self) -> Vector3<f64> {
        self.rotation * Vector3::z()
    }

    /// Where a ray (x, y, 1) meets the board \[mm\], camera frame.
    #[must_use]
    pub fn meet(&self, ray: Vector2<f64>) -> Option<Vector3<f64>> {
        let direction = Vector3::new(ray.x, ray.y, 1.0);
        let n = self.normal();
        let depth = n.dot(&self.translation_mm) / n.dot(&direction);
        (depth.is_finite() && depth > 0.0).then(|| direction * depth)
    }

    /// The pose turned by a small rotation vector \[rad\] about the camera's axes and moved \[mm\].
    #[must_use]
    pub fn varied(&self, by: &Vector6<f64>) -> Self {
        Self {
            rotation: Rotation3::new(by.fixed_rows::<3>(0).into_owned()) * self.rotation,
            translation_mm: self.translation_mm + by.fixed_rows::<3>(3),
        }
    }
}

/// The homography from the board \[mm\] to the picture, by the normalised direct linear transform (Hartley 1997).
pub(super) fn homography(board_mm: &[Vector2<f64>], pixels: &[Vector2<f64>]) -> Option<Matrix3<f64>> {
    if board_mm.len() < 4 {
        return None;
    }
    let (from, to) = (normaliser(board_mm)?, normaliser(pixels)?);
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (b, p) in board_mm.iter().zip(pixels) {
        let (b, p) = (from * Vector3::new(b.x, b.y, 1.0), to * Vector3::new(p.x, p.y, 1.0));
        let rows = [
            [b.x, b.y, 1.0, 0.0, 0.0, 0.0, -p.x * b.x, -p.x * b.y, -p.x],
            [0.0, 0.0, 0.0, b.x, b.y, 1.0, -p.y * b.x, -p.y * b.y, -p.y],
        ];
        for row in rows {
            let row = SMatrix::<f64, 9, 1>::from(row);
            normal += row * row.transpose();
        }
    }
    let eigen = normal.symmetric_eigen();
    let solution = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let normalised = Matrix3::from_row_slice(solution.as_slice());
    Some(to.try_inverse()? * normalised * from)
}

/// The similarity that brings points to their mean and a distance of √2.
fn normaliser(points: &[Vector2<f64>]) -> Option<Matrix3<f64>> {
    let count = points.len() as f64;
    let mean = points.iter().sum::<Vector2<f64>>() / count;
    let spread = points.iter().map(|p| (p - mean).norm()).sum::<f64>() / count;
    let scale = std::f64::consts::SQRT_2 / spread;
    let matrix = Matrix3::new(scale, 0.0, -scale * mean.x, 0.0, scale, -scale * mean.y, 0.0, 0.0, 1.0);
    (scale.is_finite() && scale > 0.0).then_some(matrix)
}

/// The focal length that makes the boards' axes perpendicular and equally long, the principal point being the picture's
/// middle (Zhang 2000, equations 3 and 4). None where the boards lie too flat to tell.
pub(super) fn first_focal_px(homographies: &[Matrix3<f64>], size_px: (usize, usize)) -> Option<f64> {
    let middle = Intrinsics::pinhole(1.0, size_px);
    let shift = Matrix3::new(1.0, 0.0, -middle.cx_px, 0.0, 1.0, -middle.cy_px, 0.0, 0.0, 1.0);
    let (mut numerator, mut denominator) = (0.0, 0.0);
    for homography in homographies {
        let h = shift * homography;
        let (a, b) = (h.column(0) / h.column(0).norm(), h.column(1) / h.column(0).norm());
        // h1ᵀ ω h2 = 0 and h1ᵀ ω h1 = h2ᵀ ω h2 with ω = diag(1/f², 1/f², 1).
        let pairs = [
            (a.x * b.x + a.y * b.y, a.z * b.z),
            (a.x * a.x + a.y * a.y - b.x * b.x - b.y * b.y, a.z * a.z - b.z * b.z),
        ];
        for (planar, deep) in pairs {
            numerator -= planar * deep;
            denominator += planar * planar;
        }
    }
    let inverse_square = numerator / denominator;
    let focal_px = (1.0 / inverse_square).sqrt();
    let side = size_px.0.max(size_px.1) as f64;
    (focal_px.is_finite() && (0.2 * side..30.0 * side).contains(&focal_px)).then_some(focal_px)
}

/// A first pose from a board's corners, by the homography of their rays.
pub(super) fn first_pose(camera: &Intrinsics, board_mm: &[Vector2<f64>], pixels: &[Vector2<f64>]) -> Option<Pose> {
    let rays: Option<Vec<Vector2<f64>>> = pixels.iter().map(|p| camera.ray(PixelPoint::new(p.x, p.y))).collect();
    let h = homography(board_mm, &rays?)?;
    let scale = 0.5 * (h.column(0).norm() + h.column(1).norm());
    let h = h * (h[(2, 2)].signum() / scale);
    let (a, b) = (h.column(0).into_owned(), h.column(1).into_owned());
    let near = Matrix3::from_columns(&[a, b, a.cross(&b)]);
    let svd = near.svd(true, true);
    let rotation = svd.u? * svd.v_t?;
    let pose = Pose { rotation: Rotation3::from_matrix_unchecked(rotation), translation_mm: h.column(2).into_owned() };
    (rotation.determinant() > 0.0 && pose.translation_mm.z > 0.0).then_some(pose)
}

#[cfg(test)]
mod tests {
    use super::super::board::BoardSize;
    use super::super::intrinsics::tests::LENS;
    use super::*;

    #[test]
    fn focal_length_and_pose_are_found_from_corners_without_noise() {
        let camera =
            Intrinsics { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0, ..Intrinsics::pinhole(1250.0, (1000, 750)) };
        let board = BoardSize::new(6, 7).unwrap().points_mm(15.0);
        let pose = Pose {
            rotation: Rotation3::new(Vector3::new(0.3, -0.4, 0.2)),
            translation_mm: Vector3::new(5.0, -8.0, 260.0),
        };
        let seen = |camera: &Intrinsics| -> Vec<Vector2<f64>> {
            let pixel = |p| camera.project(&pose.camera_from_board(p)).unwrap();
            board.iter().map(pixel).map(|p| Vector2::new(p.u_px, p.v_px)).collect()
        };
        let h = homography(&board, &seen(&camera)).unwrap();
        approx::assert_relative_eq!(first_focal_px(&[h], (1000, 750)).unwrap(), 1250.0, epsilon = 1e-3);
        let found = first_pose(&LENS, &board, &seen(&LENS)).unwrap();
        assert!((found.translation_mm - pose.translation_mm).norm() < 1e-6, "{found:?}");
        // Not by the angle between them: an arc cosine near 1 has no more than half of the digits.
        assert!((found.rotation.matrix() - pose.rotation.matrix()).norm() < 1e-8);
    }
}
