//! How far a point lies from a pool's outline.

/// A pool at one moment, travelling up, about the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    half_length_px: f64,
    half_width_px: f64,
    /// None with a round front.
    corner: Option<Corner>,
}

#[derive(Debug, Clone, Copy)]
struct Corner {
    tip: [f64; 2],
    /// Unit normals of the flanks.
    normals: [[f64; 2]; 2],
    /// Row at which both flanks are inside the ellipse, where the corner ends.
    base: f64,
}

/// Steps in which the corner's base is sought \[px\].
const BASE_STEP_PX: f64 = 0.25;

impl Shape {
    /// A body of that length and width with a corner that protrudes `height_px` from the ellipse at `tip_px` across.
    pub(super) fn new(length_px: f64, width_px: f64, tip_px: f64, height_px: f64, half_base_px: f64) -> Self {
        let (half_length_px, half_width_px) = (0.5 * length_px, 0.5 * width_px);
        let relative = (tip_px / half_width_px).clamp(-0.98, 0.98);
        let front = -half_length_px * (1.0 - relative * relative).sqrt();
        let corner = (height_px > 0.0).then(|| {
            let length = height_px.hypot(half_base_px);
            let (x, y) = (height_px / length, -half_base_px / length);
            let inside = |depth: &f64| {
                let half_px = half_base_px * (1.0 + depth / height_px);
                [tip_px - half_px, tip_px + half_px].iter().all(|side| {
                    (side / half_width_px).hypot((front + depth) / half_length_px) < 1.0
                })
            };
            let steps = (half_length_px / BASE_STEP_PX) as usize;
            let depth = (0..steps).map(|step| step as f64 * BASE_STEP_PX).find(inside).unwrap_or(0.0);
            Corner { tip: [tip_px, front - height_px], normals: [[-x, y], [x, y]], base: front + depth }
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
        // The flanks run on into the body, so that no notch is between them.
        let corner = self.corner.map(|corner| {
            let flank = |[nx, ny]: [f64; 2]| nx * (x - corner.tip[0]) + ny * (y - corner.tip[1]);
            flank(corner.normals[0]).max(flank(corner.normals[1])).max(y - corner.base)
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
        for y in -20..50 {
            for x in -60..60 {
                let (x, y) = (f64::from(x), f64::from(y));
                assert_eq!(with.distance_px(x, y) < 0.0, without.distance_px(x, y) < 0.0, "{x} {y}");
            }
        }
    }
}
