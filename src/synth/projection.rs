//! A scene in the plane of a laser, as a camera sees it: the section is drawn in a raster of equal steps, and every line of
//! light goes through lens and plane into the picture.

use super::profile::Branch;
use super::scenario::{Scenario, ScenarioError};
use crate::calib::PlanePoint;
use crate::calib::intrinsics::Intrinsics;
use crate::calib::laser_camera::LaserCamera;
use crate::calib::plane::LaserPlane;
use crate::units::{MmPerPx, PixelPoint, StripeAxis};

/// The raster's step may differ from what a pixel shows in the middle of the picture by these factors: a coarser one would leave
/// out what the camera sees, a finer one would not reach the picture's ends. Chosen.
const STEPS: std::ops::RangeInclusive<f64> = 0.8..=1.25;

/// From the section's raster into the picture.
#[derive(Debug, Clone)]
pub(super) struct Projection {
    sensor: LaserCamera,
    axis: StripeAxis,
    step_mm: f64,
    /// The raster's middle, which lies where the picture's middle shows the plane.
    middle: (f64, f64),
    middle_mm: PlanePoint,
}

/// The true sensor of a scenario with `[camera]` and `[laser]`; none without them.
///
/// # Errors
/// When one of the two is missing, or they make no stripe sensor.
pub fn true_sensor(scenario: &Scenario) -> Result<Option<LaserCamera>, ScenarioError> {
    let invalid = |problem: String| ScenarioError::Invalid { description: scenario.description.clone(), problem };
    match (&scenario.camera, &scenario.laser) {
        (None, None) => Ok(None),
        (Some(c), Some(laser)) => {
            let numbers = [c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3];
            if !(numbers.iter().all(|number| number.is_finite()) && c.fx > 0.0 && c.fy > 0.0) {
                return Err(invalid("camera: all numbers are finite, fx and fy above 0".into()));
            }
            let plane = LaserPlane::new(laser.normal.into(), laser.distance_mm)
                .map_err(|problem| invalid(format!("laser: {problem}")))?;
            let size_px = (scenario.image.width_px, scenario.image.height_px);
            Ok(Some(LaserCamera::new(size_px, Intrinsics::from_array(numbers), plane, None, None)))
        }
        _ => Err(invalid("[camera] and [laser] belong together".into())),
    }
}

impl Projection {
    /// The projection of a scenario that has a sensor, for a raster of `along` by `across` steps.
    pub(super) fn new(scenario: &Scenario, along: usize, across: usize) -> Result<Option<Self>, ScenarioError> {
        let Some(sensor) = true_sensor(scenario)? else { return Ok(None) };
        let invalid = |problem: String| ScenarioError::Invalid { description: scenario.description.clone(), problem };
        let axis = scenario.image.stripe;
        if sensor.stripe_axis() != axis {
            return Err(invalid(format!("image: the stripe of this laser is {}", sensor.stripe_axis())));
        }
        let middle = (0.5 * along as f64, 0.5 * across as f64);
        let pixel = axis.image_from_stripe(PixelPoint::new(middle.0, middle.1));
        let seen = sensor.point(pixel).zip(sensor.jacobian(pixel));
        let Some((middle_mm, jacobian)) = seen else {
            return Err(invalid("laser: its plane is not to be seen in the middle of the picture".into()));
        };
        let step_mm = scenario.mm_per_px.get();
        let shown_mm = match axis {
            StripeAxis::Horizontal => jacobian[(0, 0)],
            StripeAxis::Vertical => jacobian[(0, 1)],
        };
        if !STEPS.contains(&(step_mm / shown_mm)) {
            return Err(invalid(format!(
                "mm_per_px is the step in which the section is drawn: the middle of this picture shows {shown_mm:.4} mm a pixel, take about that"
            )));
        }
        Ok(Some(Self { sensor, axis, step_mm, middle, middle_mm }))
    }

    /// The point of the plane at a place of the raster. Its rows go down, away from the camera.
    pub(super) fn plane(&self, place: PixelPoint) -> PlanePoint {
        PlanePoint {
            lateral_mm: self.middle_mm.lateral_mm + self.step_mm * (place.u_px - self.middle.0),
            height_mm: self.middle_mm.height_mm - self.step_mm * (place.v_px - self.middle.1),
        }
    }

    /// The pixel, in the stripe's frame, that shows a place of the raster. None behind the camera.
    pub(super) fn stripe_frame(&self, place: PixelPoint) -> Option<PixelPoint> {
        self.sensor.pixel(self.plane(place)).map(|pixel| self.axis.stripe_from_image(pixel))
    }

    /// A line of light as the camera sees it. Where the section folds over itself the part nearer to its end is seen.
    pub(super) fn branch(&self, branch: &Branch) -> Branch {
        let columns = branch.row_px.len();
        let mut seen =
            Branch { gain: vec![0.0; columns], width: vec![1.0; columns], row_px: branch.row_px.clone(), ..*branch };
        let place = |x: usize| self.stripe_frame(PixelPoint::new(x as f64, f64::from(branch.row_px[x])));
        let mut from = place(0);
        for x in 1..columns {
            let to = place(x);
            if let (Some(a), Some(b)) = (from, to) {
                let (low, high) = (a.u_px.min(b.u_px).max(0.0), a.u_px.max(b.u_px));
                for column in low.ceil() as usize..(high.floor() as usize + 1).min(columns) {
                    let share = (column as f64 - a.u_px) / (b.u_px - a.u_px);
                    let between = |values: &[f32]| {
                        let (before, behind) = (f64::from(values[x - 1]), f64::from(values[x]));
                        (before + share * (behind - before)) as f32
                    };
                    seen.row_px[column] = (a.v_px + share * (b.v_px - a.v_px)) as f32;
                    seen.gain[column] = between(&branch.gain);
                    seen.width[column] = between(&branch.width);
                }
            }
            from = to;
        }
        seen
    }
}

/// The scale at which lengths given in millimetres are steps of the raster.
pub(super) fn step_of(table: &toml::Table) -> f64 {
    let given = table.get("mm_per_px").and_then(number);
    given.filter(|step| *step > 0.0).unwrap_or(MmPerPx::DU_2022.get())
}

/// Sections whose lengths may be given in millimetres.
const IN_MM: [&str; 5] = ["joint", "path", "height", "edges", "plates"];

/// Turns lengths called `…_mm` into those called `…_px`, in the sections that lie in the plane of the laser.
///
/// # Errors
/// Naming a length that is given twice, or is none.
pub(super) fn lengths_in_px(table: &mut toml::Table) -> Result<(), String> {
    let step_mm = step_of(table);
    for section in IN_MM {
        table.get_mut(section).map_or(Ok(()), |value| convert(value, step_mm))?;
    }
    Ok(())
}

fn convert(value: &mut toml::Value, step_mm: f64) -> Result<(), String> {
    match value {
        toml::Value::Array(list) => list.iter_mut().try_for_each(|value| convert(value, step_mm)),
        toml::Value::Table(table) => {
            let in_mm = |key: &String| key.ends_with("_mm") || key == "mm_per_frame";
            let keys: Vec<String> = table.keys().filter(|key| in_mm(key)).cloned().collect();
            for key in keys {
                let in_px = if key == "mm_per_frame" { "px_per_frame".into() } else { key.replace("_mm", "_px") };
                let length = table.remove(&key).unwrap_or(toml::Value::Boolean(false));
                let length = scaled(length, step_mm).ok_or_else(|| format!("{key} is no length"))?;
                if table.insert(in_px.clone(), length).is_some() {
                    return Err(format!("both {key} and {in_px} are given: give one"));
                }
            }
            table.iter_mut().try_for_each(|(_, value)| convert(value, step_mm))
        }
        _ => Ok(()),
    }
}

/// A length, or several, in steps.
fn scaled(value: toml::Value, step_mm: f64) -> Option<toml::Value> {
    match value {
        toml::Value::Array(list) => {
            Some(toml::Value::Array(list.into_iter().map(|value| scaled(value, step_mm)).collect::<Option<_>>()?))
        }
        value => number(&value).map(|length| toml::Value::Float(length / step_mm)),
    }
}

fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_in_millimetres_become_steps_of_the_raster() {
        let mut table: toml::Table = "mm_per_px = 0.2\n[joint]\nkind = \"butt\"\ngap_mm = [1.0, 3]\n\
            [[path]]\nkind = \"straight\"\nmm_per_frame = 0.1\n[image]\nwidth_px = 5\n"
            .parse()
            .unwrap();
        lengths_in_px(&mut table).unwrap();
        let text = toml::to_string(&table).unwrap();
        let gap = &table["joint"]["gap_px"];
        assert!((gap[0].as_float().unwrap() - 5.0).abs() < 1e-9 && (gap[1].as_float().unwrap() - 15.0).abs() < 1e-9);
        assert!(text.contains("px_per_frame = 0.5") && !text.contains("gap_mm"), "{text}");
        let mut twice: toml::Table = "[joint]\ngap_mm = 1\ngap_px = 2\n".parse().unwrap();
        assert!(lengths_in_px(&mut twice).unwrap_err().contains("gap_mm"));
    }
}
