//! What stands before the sensor.

use nalgebra::{Vector2, Vector3};

use crate::calib::board::BoardSize;
use crate::calib::pose::Pose;

/// Light of white and of black, as shares of the ambient light, and of what lies around the board.
const WHITE: f64 = 1.0;
const BLACK: f64 = 0.2;
const AROUND: f64 = 0.3;
/// How much of the laser's light black gives back, compared with white.
const BLACK_STRIPE: f64 = 0.25;
/// White around the board's squares \[squares\].
const RIM_SQUARES: f64 = 0.6;

/// Something the camera's rays meet.
pub trait Surface: Sync {
    /// Where the ray (x, y, 1) meets it, and which share of the ambient light it gives back there.
    fn meet(&self, ray: Vector2<f64>) -> Option<(Vector3<f64>, f64)>;
    /// Grey of white under the ambient light.
    fn ambient_grey(&self) -> f64;
    /// Share of the laser's light that a place of this albedo gives back.
    fn stripe_albedo(&self, albedo: f64) -> f64;
}

/// A chessboard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardSurface {
    /// Its size in inner corners.
    pub size: BoardSize,
    /// Side of a square \[mm\].
    pub square_mm: f64,
    /// Where it stands.
    pub pose: Pose,
}

impl Surface for BoardSurface {
    fn meet(&self, ray: Vector2<f64>) -> Option<(Vector3<f64>, f64)> {
        let point = self.pose.meet(ray)?;
        let on_board = self.pose.rotation.inverse() * (point - self.pose.translation_mm);
        // Squares from the outer corner of the first one.
        let half = |corners: usize| 0.5 * (corners as f64 + 1.0);
        let (a, b) =
            (on_board.x / self.square_mm + half(self.size.columns), on_board.y / self.square_mm + half(self.size.rows));
        let (columns, rows) = (self.size.columns as f64 + 1.0, self.size.rows as f64 + 1.0);
        let within = |margin: f64| a > -margin && a < columns + margin && b > -margin && b < rows + margin;
        let albedo = if within(0.0) {
            // The first inner square, whose place in the order of corners is the first, is black.
            if (a.floor() + b.floor()).rem_euclid(2.0) < 0.5 { BLACK } else { WHITE }
        } else if within(RIM_SQUARES) {
            WHITE
        } else {
            AROUND
        };
        Some((point, albedo))
    }

    fn ambient_grey(&self) -> f64 {
        150.0
    }

    fn stripe_albedo(&self, albedo: f64) -> f64 {
        if albedo == BLACK { BLACK_STRIPE } else { WHITE }
    }
}

/// Two plates square to the viewing direction, the left one nearer by a step; a step of 0 is a flat plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSurface {
    /// Distance of the right plate \[mm\].
    pub distance_mm: f64,
    /// By how much the left one is nearer \[mm\].
    pub step_mm: f64,
}

impl Surface for StepSurface {
    fn meet(&self, ray: Vector2<f64>) -> Option<(Vector3<f64>, f64)> {
        let depth = if ray.x < 0.0 { self.distance_mm - self.step_mm } else { self.distance_mm };
        Some((Vector3::new(ray.x, ray.y, 1.0) * depth, WHITE))
    }

    fn ambient_grey(&self) -> f64 {
        60.0
    }

    fn stripe_albedo(&self, _albedo: f64) -> f64 {
        190.0 / 220.0
    }
}
