//! Which view to add: what spread of tilt, depth and place the views so far lack.

use super::error::GOOD_VIEWS;
use super::pose::Pose;
use super::sightings::BoardSighting;

/// Tilts to aim at, to each side \[°\]. Chosen: 20° to 40° is what mrcal and Kalibr advise; below 12° a side is missing.
const TILT_DEG: f64 = 12.0;
/// The farthest board should stand at this multiple of the nearest one's distance.
const DEPTH_RATIO: f64 = 1.3;
/// The picture in this many parts a side; corners should be seen in each.
const PARTS: usize = 3;
/// Names of the parts, row by row.
const PLACES: [&str; PARTS * PARTS] =
    ["top left", "top", "top right", "left", "middle", "right", "bottom left", "bottom", "bottom right"];

/// What is missing, one sentence each; empty when nothing is.
#[must_use]
pub fn advice(size_px: (usize, usize), views: &[(&BoardSighting, Pose)]) -> Vec<String> {
    let mut advice = vec![];
    if views.len() < GOOD_VIEWS {
        advice.push(format!("{} views: {GOOD_VIEWS} are a good number", views.len()));
    }
    let normals = views.iter().map(|(_, pose)| if pose.normal().z < 0.0 { -pose.normal() } else { pose.normal() });
    let tilts: Vec<(f64, f64)> = normals.map(|n| (n.x.atan2(n.z).to_degrees(), n.y.atan2(n.z).to_degrees())).collect();
    type Tilt = fn(&(f64, f64)) -> f64;
    let sides: [(&str, Tilt); 4] = [
        ("left side away from the camera", |t| t.0),
        ("right side away from the camera", |t| -t.0),
        ("upper side away from the camera", |t| t.1),
        ("lower side away from the camera", |t| -t.1),
    ];
    for (side, tilt) in sides {
        let most = tilts.iter().map(tilt).fold(0.0, f64::max);
        if most < TILT_DEG {
            advice.push(format!(
                "no board has its {side} by {TILT_DEG:.0}° (most {most:.0}°): tilt one that way by 20° to 40°"
            ));
        }
    }
    let depths = || views.iter().map(|(_, pose)| pose.translation_mm.z);
    let (near, far) = (depths().fold(f64::INFINITY, f64::min), depths().fold(0.0, f64::max));
    if far < DEPTH_RATIO * near {
        advice.push(format!("all boards stand between {near:.0} and {far:.0} mm: bring some nearer or farther"));
    }
    let empty: Vec<&str> =
        (0..PARTS * PARTS).filter(|&part| !is_seen(size_px, views, part)).map(|part| PLACES[part]).collect();
    if !empty.is_empty() {
        advice.push(format!(
            "no corner was seen in the picture's {}: nothing is known of the lens there",
            empty.join(", ")
        ));
    }
    advice
}

fn is_seen(size_px: (usize, usize), views: &[(&BoardSighting, Pose)], part: usize) -> bool {
    let part_of = |at: f64, side: usize| ((at * PARTS as f64 / side as f64) as usize).min(PARTS - 1);
    let corners = views.iter().flat_map(|(sighting, _)| &sighting.corners);
    corners.into_iter().any(|c| part_of(c.y, size_px.1) * PARTS + part_of(c.x, size_px.0) == part)
}
