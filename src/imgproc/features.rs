//! The seam's two feature points from the differences of neighbouring ordinates (Du 2022, section 3.1), and the ROI.

use super::centreline::Centreline;
use crate::units::PixelPoint;

/// What counts as a seam in a clean frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeedSettings {
    /// Least difference of neighbouring ordinates at a feature point \[px\]. Chosen: above the ridge noise of a
    /// speckled stripe (under 1 px after the median), below half of any joint's step.
    pub least_jump_px: f32,
    /// Least break of the stripe that counts as a feature by itself \[px\]. Chosen as wide as the stripe is thick.
    pub least_break_px: usize,
    /// Stretch at each end of the stripe that is not looked at \[px\]: its ends are not the seam.
    pub end_margin_px: usize,
    /// Shortest stripe \[px\].
    pub least_stripe_px: usize,
    /// Widest joint, from feature point to feature point \[px\]; also the widest break that the stripe bridges.
    pub widest_joint_px: usize,
    /// Columns of the median over the ordinates: wild columns go, and so do joints narrower than half of it.
    pub median_columns: usize,
    /// By how much the strongest place must exceed the next one. Chosen: a second candidate of like strength means
    /// that the frame does not say which is the seam.
    pub least_dominance: f32,
}

impl Default for SeedSettings {
    fn default() -> Self {
        Self {
            least_jump_px: 3.0,
            least_break_px: 6,
            end_margin_px: 20,
            least_stripe_px: 80,
            widest_joint_px: 60,
            median_columns: 5,
            least_dominance: 1.5,
        }
    }
}

/// The two feature points beside the seam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamFeatures {
    /// Last point of the stripe before the joint.
    pub before: PixelPoint,
    /// First point of the stripe behind the joint.
    pub behind: PixelPoint,
}

impl SeamFeatures {
    /// The seam centre: midpoint of the two feature points.
    #[must_use]
    pub fn centre(&self) -> PixelPoint {
        PixelPoint::new(0.5 * (self.before.u_px + self.behind.u_px), 0.5 * (self.before.v_px + self.behind.v_px))
    }
}

/// The region that the KCF learns: 80 × 60 px round the seam centre (Du 2022, section 3.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamRoi {
    /// The seam centre.
    pub centre: PixelPoint,
    /// Extent along u \[px\].
    pub width_px: f64,
    /// Extent along v \[px\].
    pub height_px: f64,
}

impl SeamRoi {
    /// The paper's ROI round `centre`.
    #[must_use]
    pub const fn du_2022(centre: PixelPoint) -> Self {
        Self { centre, width_px: 80.0, height_px: 60.0 }
    }
}

/// A place where the connected centreline jumps or breaks.
#[derive(Debug, Clone, Copy)]
struct Feature {
    before: (usize, f32),
    behind: (usize, f32),
    strength_px: f32,
}

/// Finds the joint as the strongest cluster of jumps and breaks of the centreline, well inside the stripe.
///
/// Returns nothing when there is no jump, or two places of like strength: a seam is never invented.
#[must_use]
pub fn find(line: &Centreline, settings: &SeedSettings) -> Option<SeamFeatures> {
    match candidates(line, settings).as_slice() {
        [] => None,
        [(best, _)] => Some(*best),
        [(best, strength), (_, rival), ..] => (*strength >= settings.least_dominance * rival).then_some(*best),
    }
}

/// Every cluster of jumps and breaks well inside the stripe with its strength \[px\], the strongest first.
#[must_use]
pub fn candidates(line: &Centreline, settings: &SeedSettings) -> Vec<(SeamFeatures, f32)> {
    let Some((first, end)) = line.extent(settings.widest_joint_px) else { return vec![] };
    if end - first < settings.least_stripe_px.max(2 * settings.end_margin_px + 2) {
        return vec![];
    }
    let inner = first + settings.end_margin_px..end - settings.end_margin_px;
    let points: Vec<(usize, f32)> = inner.filter_map(|u| line.at(u).map(|v| (u, v))).collect();
    let features = features(&median_of(&points, settings.median_columns), settings);
    let point = |(u, v): (usize, f32)| PixelPoint::new(u as f64, f64::from(v));
    let mut found: Vec<(SeamFeatures, f32)> = clusters(&features, settings)
        .into_iter()
        .filter_map(|cluster| {
            let strength = cluster.iter().map(|f| f.strength_px).fold(0.0f32, f32::max);
            let (before, behind) = (cluster.first()?.before, cluster.last()?.behind);
            Some((SeamFeatures { before: point(before), behind: point(behind) }, strength))
        })
        .collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    found
}

/// The ordinates through a median: single wild columns go, jumps stay where they are.
fn median_of(points: &[(usize, f32)], columns: usize) -> Vec<(usize, f32)> {
    let half = columns / 2;
    (0..points.len())
        .map(|i| {
            let window = &points[i.saturating_sub(half)..(i + half + 1).min(points.len())];
            let mut values: Vec<f32> = window.iter().map(|p| p.1).collect();
            values.sort_unstable_by(f32::total_cmp);
            (points[i].0, values[values.len() / 2])
        })
        .collect()
}

fn features(points: &[(usize, f32)], settings: &SeedSettings) -> Vec<Feature> {
    points
        .windows(2)
        .filter_map(|pair| {
            let (before, behind) = (pair[0], pair[1]);
            let jump_px = (behind.1 - before.1).abs();
            let break_px = behind.0 - before.0 - 1;
            let is_break = break_px >= settings.least_break_px;
            (jump_px >= settings.least_jump_px || is_break).then_some(Feature {
                before,
                behind,
                strength_px: if is_break { jump_px + break_px as f32 } else { jump_px },
            })
        })
        .collect()
}

/// Groups features that lie within one joint's width of each other.
fn clusters<'a>(features: &'a [Feature], settings: &SeedSettings) -> Vec<&'a [Feature]> {
    features.chunk_by(|a, b| b.before.0 - a.behind.0.min(b.before.0) <= settings.widest_joint_px).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(width: usize, v: impl Fn(usize) -> Option<f32>) -> Centreline {
        Centreline { v_px: (0..width).map(v).collect() }
    }

    #[test]
    fn a_butt_joint_is_the_middle_between_its_two_edges() {
        let butt = line(640, |u| Some(if (310..324).contains(&u) { 264.0 } else { 240.0 + 0.01 * u as f32 }));
        let centre = find(&butt, &SeedSettings::default()).unwrap().centre();
        assert!((centre.u_px - 316.5).abs() < 0.6, "{centre:?}");
    }

    #[test]
    fn a_lap_joint_with_a_shadow_is_the_middle_of_the_shadow() {
        let lap = line(640, |u| match u {
            0..300 => Some(200.0),
            300..306 => None,
            _ => Some(224.0),
        });
        let found = find(&lap, &SeedSettings::default()).unwrap();
        assert_eq!((found.before.u_px, found.behind.u_px), (299.0, 306.0));
        assert!((found.centre().v_px - 212.0).abs() < 0.1);
    }

    #[test]
    fn the_ends_of_a_short_stripe_are_not_the_seam() {
        let plate = line(448, |u| (60..390).contains(&u).then_some(200.0 + if u > 386 { 8.0 } else { 0.0 }));
        assert_eq!(find(&plate, &SeedSettings::default()), None);
    }

    #[test]
    fn two_joints_of_like_strength_are_no_answer() {
        let two = line(640, |u| Some(if (150..160).contains(&u) || (450..460).contains(&u) { 225.0 } else { 200.0 }));
        assert_eq!(find(&two, &SeedSettings::default()), None);
    }
}
