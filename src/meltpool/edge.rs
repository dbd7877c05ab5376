//! Where the pool ends, to a fraction of a pixel: the half level between just inside and just outside.
//!
//! The level is taken anew at each place. So neither a plume that brightens one side nor a change of emissivity moves
//! the edge, and a blurred step is found where it was before the blur.

use super::travel::Turned;

/// Longest ray, each way \[px\]. Chosen: an edge is blurred over a few pixels.
const LONGEST_REACH_PX: usize = 5;
/// Most samples of a ray.
const MOST_SAMPLES: usize = 2 * LONGEST_REACH_PX + 1;
/// Samples at each end of a ray that give the levels inside and outside.
const LEVEL_SAMPLES: usize = 2;

/// An edge on a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// Distance from the ray's middle, positive outwards \[px\].
    pub(super) offset_px: f64,
    /// Light inside less light outside.
    pub(super) contrast: f32,
}

/// How far rays reach across the outline of a pool of `area_px2` \[px\]: a quarter of its radius, within 2 to 5.
pub(super) fn reach_px(area_px2: f64) -> usize {
    let radius = (area_px2 / std::f64::consts::PI).sqrt();
    ((0.25 * radius).round() as usize).clamp(2, LONGEST_REACH_PX)
}

/// The edge nearest to `middle` on the ray along the unit vector `outwards`; none when the ray leaves the picture or
/// the light does not fall along it.
pub(super) fn edge(picture: &Turned<'_>, middle: [f64; 2], outwards: [f64; 2], reach_px: usize) -> Option<Edge> {
    let count = 2 * reach_px + 1;
    let mut ray = [0.0_f32; MOST_SAMPLES];
    for (i, light) in ray[..count].iter_mut().enumerate() {
        let t = i as f64 - reach_px as f64;
        *light = picture.at(middle[0] + t * outwards[0], middle[1] + t * outwards[1])?;
    }
    let ray = &ray[..count];
    let mean = |ends: &[f32]| ends.iter().sum::<f32>() / LEVEL_SAMPLES as f32;
    let (inside, outside) = (mean(&ray[..LEVEL_SAMPLES]), mean(&ray[count - LEVEL_SAMPLES..]));
    let contrast = inside - outside;
    if contrast <= 0.0 {
        return None;
    }
    let level = 0.5 * (inside + outside);
    let crossings = ray.windows(2).enumerate().filter(|(_, pair)| pair[0] >= level && pair[1] < level);
    let offsets = crossings.map(|(i, pair)| {
        let fraction = f64::from((pair[0] - level) / (pair[0] - pair[1]));
        i as f64 + fraction - reach_px as f64
    });
    let offset_px = offsets.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some(Edge { offset_px, contrast })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::IntensityFrame;
    use crate::units::Travel;

    /// A step at column `place`, blurred, on a slope of light.
    fn step(place: f64, slope: f64) -> IntensityFrame {
        let light = |u: f64| 0.2 + slope * u + 0.5 / (1.0 + ((u - place) / 0.8).exp());
        let pixels = (0..5 * 40).map(|i| light(f64::from(i % 40)) as f32).collect();
        IntensityFrame::new(40, 5, pixels).unwrap()
    }

    fn edge_in(frame: &IntensityFrame, middle: [f64; 2], outwards: [f64; 2], reach_px: usize) -> Option<Edge> {
        edge(&Turned::new(frame, Travel::Up, &mut vec![]), middle, outwards, reach_px)
    }

    #[test]
    fn a_blurred_step_is_found_to_a_thirtieth_of_a_pixel_wherever_it_lies_and_whatever_light_lies_over_it() {
        for tenth in 0..10 {
            let place = 20.0 + 0.1 * f64::from(tenth);
            // A straight line between samples of this step, a pixel apart, errs by up to 0.026 px.
            for slope in [0.0, 0.01] {
                let found = edge_in(&step(place, slope), [20.0, 2.0], [1.0, 0.0], 5).unwrap();
                assert!((20.0 + found.offset_px - place).abs() < 1.0 / 30.0 + 4.0 * slope, "{place} {slope} {found:?}");
            }
        }
    }

    #[test]
    fn light_that_rises_outwards_or_a_ray_that_leaves_the_picture_gives_no_edge() {
        assert_eq!(edge_in(&step(20.0, 0.0), [20.0, 2.0], [-1.0, 0.0], 5), None);
        assert_eq!(edge_in(&step(20.0, 0.0), [37.0, 2.0], [1.0, 0.0], 5), None);
    }
}
