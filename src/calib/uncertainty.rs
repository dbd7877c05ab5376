//! How sure a projection is over the picture: what mrcal calls the projection uncertainty.
//!
//! σ of single parameters says little, since a shifted principal point and a turned camera look alike. So points in
//! space are projected with the parameters of each replicate of the fit, the rigid motion that best explains the
//! difference is taken off, and what is left is the uncertainty at that place of the picture.

use nalgebra::{Matrix6, SMatrix, Vector2, Vector3, Vector6};

use super::intrinsics::{INTRINSICS, Intrinsics};
use crate::units::PixelPoint;

/// Places a side of the map.
pub const COLUMNS: usize = 17;
/// See [`COLUMNS`].
pub const ROWS: usize = 13;

/// σ of the projection over the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertaintyMap {
    /// [`ROWS`] × [`COLUMNS`] values from the top left to the bottom right corner: root mean square shift \[px\].
    pub sigma_px: Vec<f64>,
}

/// A point in space, and how its pixel moves with a rigid motion.
struct Probe {
    /// Its place of the map; none for the nearer and the farther points, which only hold the rigid motion.
    place: Option<usize>,
    is_seen: bool,
    point: Vector3<f64>,
    pixel: Vector2<f64>,
    by_motion: SMatrix<f64, 2, 6>,
}

/// The map of a camera from [`replicates`](super::resample::replicates) of its parameters, for points between `depths_mm`. The
/// rigid motion is fitted where corners were `seen` (least and largest column and row).
#[must_use]
pub fn uncertainty_map(
    camera: &Intrinsics,
    replicates: &[[f64; INTRINSICS]],
    size_px: (usize, usize),
    depths_mm: [f64; 2],
    seen: [[f64; 2]; 2],
) -> Option<UncertaintyMap> {
    let place = |i: usize| {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        let u = column as f64 / (COLUMNS - 1) as f64 * (size_px.0 as f64 - 1.0);
        PixelPoint::new(u, row as f64 / (ROWS - 1) as f64 * (size_px.1 as f64 - 1.0))
    };
    let middle_mm = 0.5 * (depths_mm[0] + depths_mm[1]);
    let mut probes: Vec<Probe> = vec![];
    for i in 0..COLUMNS * ROWS {
        let pixel = place(i);
        let Some(ray) = camera.ray(pixel) else { continue };
        let is_seen =
            (seen[0][0]..=seen[0][1]).contains(&pixel.u_px) && (seen[1][0]..=seen[1][1]).contains(&pixel.v_px);
        for depth in [depths_mm[0], middle_mm, depths_mm[1]] {
            let point = Vector3::new(ray.x, ray.y, 1.0) * depth;
            let at = camera.project_with_derivatives(&point)?;
            let mut by_motion = SMatrix::<f64, 2, 6>::zeros();
            by_motion.fixed_columns_mut::<3>(0).copy_from(&(-at.by_point * point.cross_matrix()));
            by_motion.fixed_columns_mut::<3>(3).copy_from(&at.by_point);
            let place = (depth == middle_mm).then_some(i);
            probes.push(Probe { place, is_seen, point, pixel: at.pixel, by_motion });
        }
    }
    let normal: Matrix6<f64> = probes.iter().filter(|p| p.is_seen).map(|p| p.by_motion.transpose() * p.by_motion).sum();
    let inverse = normal.try_inverse()?;
    let mut squares = vec![0.0; COLUMNS * ROWS];
    for replicate in replicates {
        let mut varied = camera.to_array();
        varied.iter_mut().zip(replicate).for_each(|(value, by)| *value += by);
        let varied = Intrinsics::from_array(varied);
        let shift = |probe: &Probe| {
            let seen = varied.project(&probe.point);
            seen.map_or(Vector2::zeros(), |p| Vector2::new(p.u_px, p.v_px) - probe.pixel)
        };
        let seen = probes.iter().filter(|probe| probe.is_seen);
        let right: Vector6<f64> = seen.map(|probe| probe.by_motion.transpose() * shift(probe)).sum();
        let motion = inverse * right;
        for (place, probe) in probes.iter().filter_map(|probe| Some((probe.place?, probe))) {
            squares[place] += (shift(probe) - probe.by_motion * motion).norm_squared();
        }
    }
    let count = replicates.len().max(1) as f64;
    Some(UncertaintyMap { sigma_px: squares.into_iter().map(|sum| (sum / count).sqrt()).collect() })
}

impl UncertaintyMap {
    /// The largest value in the middle half of the picture, and in all of it \[px\].
    #[must_use]
    pub fn middle_and_worst_px(&self) -> (f64, f64) {
        let is_middle = |i: usize| {
            let (column, row) = (i % COLUMNS, i / COLUMNS);
            (COLUMNS / 4..=COLUMNS - 1 - COLUMNS / 4).contains(&column)
                && (ROWS / 4..=ROWS - 1 - ROWS / 4).contains(&row)
        };
        let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0, f64::max);
        let middle = largest(&mut self.sigma_px.iter().enumerate().filter(|(i, _)| is_middle(*i)).map(|(_, s)| *s));
        (middle, largest(&mut self.sigma_px.iter().copied()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::intrinsics::tests::LENS;
    use super::*;

    #[test]
    fn a_shifted_principal_point_is_hardly_an_error_and_a_changed_distortion_is_one_at_the_rim() {
        let draw = |index: usize, by: f64| {
            let mut draw = [0.0; INTRINSICS];
            draw[index] = by;
            vec![draw]
        };
        let seen = [[0.0, 999.0], [0.0, 749.0]];
        let map =
            |draws: &[[f64; INTRINSICS]]| uncertainty_map(&LENS, draws, (1000, 750), [220.0, 280.0], seen).unwrap();
        let (_, shifted) = map(&draw(2, 1.0)).middle_and_worst_px();
        assert!(shifted < 0.25, "{shifted}: a pixel of the principal point is a turn of the camera");
        let (middle, rim) = map(&draw(4, 0.01)).middle_and_worst_px();
        assert!(rim > 2.0 * middle, "{middle} {rim}");
    }
}
