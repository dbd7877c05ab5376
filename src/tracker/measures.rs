//! What a welder buys: gap, mismatch, width, depth, angle and area of the joint, each with its σ.
//!
//! All is measured in the plane of the laser, on the lines that the frame shows, so a sensor that looks at an angle measures no
//! slanted lengths. Lengths are along and across the plates' own mean direction. A measure has a value where the frame shows
//! what it is measured on, and none otherwise.

use nalgebra::{Matrix1, Matrix2, SVector, Vector2};

use super::profile::{Profile, SeenLine};
use crate::calib::Sensor;
use crate::imgproc::geometry::JointKind;
use crate::units::{PixelPoint, StripeAxis};

/// A value and its σ: the noise of the picture and ragged edges, without the calibration's own error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// The value.
    pub value: f64,
    /// One σ of it.
    pub std: f64,
}

/// The measures of a frame, each where the joint has it and the frame shows it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measures {
    /// Between the edges of a butt joint; the shadow of a lap joint \[mm\].
    pub gap_mm: Option<Measure>,
    /// Height of the plate behind the seam above that before it, where the seam is \[mm\].
    pub hi_lo_mm: Option<Measure>,
    /// Between a groove's shoulders \[mm\].
    pub groove_width_mm: Option<Measure>,
    /// From a groove's plates down to where its flanks meet \[mm\].
    pub depth_mm: Option<Measure>,
    /// Between the flanks of a groove, or the legs of a fillet \[°\].
    pub opening_angle_deg: Option<Measure>,
    /// Between the plates at the root: the gap of a square butt joint \[mm\]. What a groove is open by at its root is not measured.
    pub root_opening_mm: Option<Measure>,
    /// Between a groove's flanks and the line from shoulder to shoulder \[mm²\].
    pub area_mm2: Option<Measure>,
}

/// Number of measures.
const MEASURES: usize = 6;
/// What the lines may be off by: the two points of each side and each plate across the stripe \[px\], each side along it
/// \[px\], and the gap \[px\].
const OFFSETS: usize = 11;
type Offsets = SVector<f64, OFFSETS>;
/// Step of the derivatives \[px\]: far below the noise, far above rounding.
const STEP_PX: f64 = 0.01;

impl Measures {
    /// The measures of `profile` by a sensor that knows millimetres; none by one that does not.
    #[must_use]
    pub fn of(profile: &Profile, sensor: &Sensor, axis: StripeAxis) -> Self {
        let section = Section { profile, sensor, axis };
        let values = match sensor.has_millimetres() {
            true => section.values(&Offsets::zeros()),
            false => None,
        };
        let Some(values) = values else { return Self::default() };
        let variances = section.variances();
        let [gap_mm, hi_lo_mm, groove_width_mm, depth_mm, opening_angle_deg, area_mm2] = std::array::from_fn(|i| {
            let variance = variances[i]?;
            Some(Measure { value: values[i]?, std: variance.sqrt() })
        });
        let root_opening_mm = gap_mm.filter(|_| profile.kind == JointKind::Butt);
        Self { gap_mm, hi_lo_mm, groove_width_mm, depth_mm, opening_angle_deg, root_opening_mm, area_mm2 }
    }
}

/// A profile in the plane of the laser.
struct Section<'a> {
    profile: &'a Profile,
    sensor: &'a Sensor,
    axis: StripeAxis,
}

/// A line in the plane \[mm\]: a point of it, and its direction away from the seam.
#[derive(Clone, Copy)]
struct PlaneLine {
    at: Vector2<f64>,
    along: Vector2<f64>,
}

impl PlaneLine {
    fn meets(&self, other: &Self) -> Option<Vector2<f64>> {
        let apart = cross(self.along, other.along);
        let way = cross(other.at - self.at, other.along) / apart;
        way.is_finite().then(|| self.at + way * self.along)
    }

    /// The point of the line that lies off `from` in the direction of `normal`.
    fn beside(&self, from: Vector2<f64>, normal: Vector2<f64>) -> Option<Vector2<f64>> {
        self.meets(&Self { at: from, along: normal })
    }
}

fn cross(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

impl Section<'_> {
    fn point(&self, pixel: PixelPoint, along_px: f64, across_px: f64) -> Option<Vector2<f64>> {
        let by = self.axis.image_from_stripe(PixelPoint::new(along_px, across_px));
        let moved = PixelPoint::new(pixel.u_px + by.u_px, pixel.v_px + by.v_px);
        let point = self.sensor.plane_from_pixel(moved, self.axis)?;
        Some(Vector2::new(point.lateral_mm, point.height_mm))
    }

    fn line(&self, line: &SeenLine, along_px: f64, across_px: [f64; 2]) -> Option<PlaneLine> {
        let [near, far] = [0, 1].map(|i| self.point(line.ends[i], along_px, across_px[i]));
        let (near, far) = (near?, far?);
        Some(PlaneLine { at: near, along: (far - near).try_normalize(1e-12)? })
    }

    /// The point of a side \[px\] at `along_px` from the seam, along its chord.
    fn on_side(&self, line: &SeenLine, along_px: f64, across_px: [f64; 2]) -> Option<Vector2<f64>> {
        let [near, far] = line.ends.map(|end| self.axis.stripe_from_image(end));
        let share = (self.axis.along_px(self.profile.seam) + along_px - near.u_px) / (far.u_px - near.u_px);
        let v_px = near.v_px + across_px[0] + share * (far.v_px + across_px[1] - near.v_px - across_px[0]);
        let place = PixelPoint::new(near.u_px + share * (far.u_px - near.u_px), v_px);
        self.point(self.axis.image_from_stripe(place), 0.0, 0.0)
    }

    /// Gap, hi-lo, width, depth, angle and area, with the lines off by `off`.
    fn values(&self, off: &Offsets) -> Option<[Option<f64>; MEASURES]> {
        let profile = self.profile;
        let ends = |i: usize| [off[2 * i], off[2 * i + 1]];
        let side = |i: usize| self.line(&profile.sides[i], off[8 + i], ends(i));
        let (before, behind) = (side(0)?, side(1)?);
        if let Some(gap_px) = profile.gap_px {
            let half_px = 0.5 * (gap_px + off[10]);
            let edge = |i: usize, along_px: f64| self.on_side(&profile.sides[i], along_px, ends(i));
            let along = (behind.along - before.along).try_normalize(1e-12)?;
            let gap = (edge(1, half_px)? - edge(0, -half_px)?).dot(&along);
            let hi_lo = (edge(1, 0.0)? - edge(0, 0.0)?).dot(&normal(along));
            return Some([Some(gap), Some(hi_lo), None, None, None, None]);
        }
        let cosine = before.along.dot(&behind.along).clamp(-1.0, 1.0);
        let angle_deg = cosine.acos().to_degrees();
        let groove = (profile.kind == JointKind::VGroove).then(|| {
            let plate = |i: usize| self.line(profile.plates[i].as_ref()?, 0.0, ends(2 + i));
            groove([before, behind], [plate(0), plate(1)])
        });
        let [hi_lo, width, depth, area] = groove.flatten().unwrap_or_default();
        Some([None, hi_lo, width, depth, Some(angle_deg), area])
    }

    /// Variances of the measures by the lines' covariances.
    fn variances(&self) -> [Option<f64>; MEASURES] {
        let mut variances = [Some(0.0); MEASURES];
        let mut add = |first: usize, covariance: &[&[f64]]| {
            let n = covariance.len();
            let slopes: Vec<_> = (0..n).map(|i| self.derivative(first + i)).collect();
            for (m, variance) in variances.iter_mut().enumerate() {
                let sum = || {
                    let mut sum = 0.0;
                    for i in 0..n {
                        for j in 0..n {
                            sum += slopes[i].as_ref()?[m]? * covariance[i][j] * slopes[j].as_ref()?[m]?;
                        }
                    }
                    Some(sum)
                };
                *variance = variance.and_then(|variance| Some(variance + sum()?));
            }
        };
        let profile = self.profile;
        let rows = |m: Matrix2<f64>| [[m[(0, 0)], m[(0, 1)]], [m[(1, 0)], m[(1, 1)]]];
        let [a, b] = profile.sides.map(|side| rows(side.covariance_px2));
        add(0, &[&a[0], &a[1]]);
        add(2, &[&b[0], &b[1]]);
        for (i, plate) in profile.plates.iter().enumerate() {
            if let Some(plate) = plate {
                let c = rows(plate.covariance_px2);
                add(4 + 2 * i, &[&c[0], &c[1]]);
            }
        }
        let single = |variance: f64| Matrix1::new(variance);
        if profile.gap_px.is_some() {
            add(10, &[single(profile.gap_variance_px2).as_slice()]);
        } else if profile.kind == JointKind::VGroove {
            add(8, &[single(profile.ragged_px2).as_slice()]);
            add(9, &[single(profile.ragged_px2).as_slice()]);
        }
        variances
    }

    fn derivative(&self, of: usize) -> Option<[Option<f64>; MEASURES]> {
        let mut off = Offsets::zeros();
        off[of] = STEP_PX;
        let (ahead, back) = (self.values(&off)?, self.values(&-off)?);
        // A measure that is absent has no derivative to add.
        Some(std::array::from_fn(|m| Some(ahead[m].zip(back[m]).map_or(0.0, |(a, b)| (a - b) / (2.0 * STEP_PX)))))
    }
}

/// Perpendicular to the plates, towards growing height where they lie level.
fn normal(along: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-along.y, along.x)
}

/// Hi-lo, width, depth and area of a groove with these flanks, each with its plate where that is seen.
fn groove(flanks: [PlaneLine; 2], plates: [Option<PlaneLine>; 2]) -> Option<[Option<f64>; 4]> {
    let root = flanks[0].meets(&flanks[1])?;
    let along = match plates {
        [Some(before), Some(behind)] => (behind.along - before.along).try_normalize(1e-12)?,
        [Some(before), None] => -before.along,
        [None, Some(behind)] => behind.along,
        [None, None] => return None,
    };
    let normal = normal(along);
    let above = plates.map(|plate| plate?.beside(root, normal));
    let depths = above.map(|point| Some((point? - root).dot(&normal).abs()));
    let depth = match depths {
        [Some(a), Some(b)] => 0.5 * (a + b),
        [a, b] => a.or(b)?,
    };
    let shoulders = [0, 1].map(|i| flanks[i].meets(plates[i].as_ref()?));
    let both = shoulders[0].zip(shoulders[1]);
    Some([
        above[0].zip(above[1]).map(|(before, behind)| (behind - before).dot(&normal)),
        both.map(|(before, behind)| (behind - before).dot(&along)),
        Some(depth),
        both.map(|(before, behind)| 0.5 * cross(before - root, behind - root).abs()),
    ])
}
