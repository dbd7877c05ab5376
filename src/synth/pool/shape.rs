//! How far a point lies from a pool's outline.

/// A pool at one moment, travelling up, about the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    half_length_px: f64,
    half_width_px: f64,
    /// None with a round front.
    corner: Option<Corner>,
}

/// A triangle with its base inside the ellipse.
#[derive(Debug, Clone, Copy)]
struct Corner {
    tip: [f64; 2],
    /// Of each side: the outward unit normal and its distance from the origin.
    sides: [([f64; 2], f64); 3],
}

/// The corner's base stays this far from the ellipse's sides, as a part of its half width.
const BASE_INSIDE: f64 = 0.98;

impl Shape {
    /// A body of that length and width with a corner that protrudes `height_px` from the ellipse at `tip_px` across; its
    /// flanks end on the ellipse `half_base_px` to both sides.
    pub(super) fn new(length_px: f64, width_px: f64, tip_px: f64, height_px: f64, half_base_px: f64) -> Self {
        let (half_length_px, half_width_px) = (0.5 * length_px, 0.5 * width_px);
        let on_ellipse = |x: f64| {
            let relative = (x / half_width_px).clamp(-BASE_INSIDE, BASE_INSIDE);
            [relative * half_width_px, -half_length_px * (1.0 - relative * relative).sqrt()]
        };
        let corner = (height_px > 0.0).then(|| {
            let tip = [tip_px, on_ellipse(tip_px)[1] - height_px];
            let (left, right) = (on_ellipse(tip_px - half_base_px), on_ellipse(tip_px + half_base_px));
            // In this order outward lies to the left of each side, as rows count downwards.
            let side = |from: [f64; 2], to: [f64; 2]| {
                let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
                let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
                let normal = [dy / length, -dx / length];
                (normal, normal[0] * from[0] + normal[1] * from[1])
            };
            Corner { tip, sides: [side(left, tip), side(tip, right), side(right, left)] }
        });
        Self { half_length_px, half_width_px, corner }
    }

    /// The corner; without one, the foremost point.
    pub(super) fn tip(&self) -> [f64; 2] {
        self.corner.map_or([0.0, -self.half_length_px], |corner| corner.tip)
    }

    /// Distance from the outline \[px\], negative inside; near the outline correct to first order.
    pub(super) fn distance_px(&self, x: f64, y: f64) -> f64 {
        let (a, b) = (x / self.half_width_px, y / self.half_length_px);
        let radius = a.hypot(b);
        let slope = (a / self.half_width_px).hypot(b / self.half_length_px);
        let body = if radius > 1e-9 { (radius - 1.0) * radius / slope } else { -self.half_width_px };
        let corner = self.corner.map(|corner| {
            let beyond = |(normal, distance): ([f64; 2], f64)| normal[0] * x + normal[1] * y - distance;
            corner.sides.map(beyond).into_iter().fold(f64::NEG_INFINITY, f64::max)
        });
        corner.map_or(body, |corner| body.min(corner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outline_passes_through_the_corner_and_the_widest_points() {
        let shape = Shape::new(100.0, 80.0, 12.0, 20.0, 10.0);
        let tip = shape.tip();
        assert!(shape.distance_px(tip[0], tip[1]).abs() < 1e-9);
        assert!(shape.distance_px(-40.0, 0.0).abs() < 1e-9 && shape.distance_px(0.0, 50.0).abs() < 1e-9);
        assert!((shape.distance_px(0.0, 53.0) - 3.0).abs() < 0.1);
        assert!(shape.distance_px(0.0, 0.0) < -30.0 && shape.distance_px(tip[0], tip[1] - 1.0) > 0.0);
    }

    #[test]
    fn the_corner_adds_nothing_beside_and_behind_the_front() {
        let (with, without) = (Shape::new(100.0, 80.0, 10.0, 12.0, 14.0), Shape::new(100.0, 80.0, 0.0, 0.0, 1.0));
        for y in -45..60 {
            for x in -60..60 {
                let (x, y) = (f64::from(x), f64::from(y));
                if y < -20.0 && (-4.0..=24.0).contains(&x) {
                    continue;
                }
                assert_eq!(with.distance_px(x, y) < 0.0, without.distance_px(x, y) < 0.0, "{x} {y}");
            }
        }
    }
}
