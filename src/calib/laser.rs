//! The laser's plane from stripes on boards, fitted together with the camera.

use nalgebra::{Matrix3, SMatrix, Vector2, Vector3};
use rayon::prelude::*;

use super::adjust::{Problem, Sighting, State, adjust, adjust_pose, stripe_offset_mm};
use super::board::BoardSize;
use super::error::{CalibrationError, LEAST_VIEWS};
use super::intrinsics::{INTRINSICS, Intrinsics};
use super::laser_camera::{CalibratedRange, LaserCamera, PARAMETERS, ParameterCovariance};
use super::plane::LaserPlane;
use super::pose::{Pose, first_pose};
use super::resample;
use super::sightings::{BoardSighting, poses_of};
use super::stripe::StripeLineSeen;

/// The heights must span this share of the distance. Chosen: at 10 % a speckle of .5 px tilts the plane by about 1 mm at
/// either end of the picture.
pub const LEAST_DEPTH_SHARE: f64 = 0.1;
/// Tukey's constant for whole views, in robust σ.
const VIEW_TUKEY: f64 = 4.685;
/// Rounds in which the views' weights settle.
const ROUNDS: usize = 6;
/// A view's weight never falls to nothing, or its equations would have no scale.
const LEAST_WEIGHT: f64 = 1e-3;
/// A view is flagged when, left out, its mean is off by this many robust σ of all views.
const FLAG_SIGMAS: f64 = 3.0;
/// σ of a corner for the balance of corners and stripes when the camera's views are not known \[px\].
const CORNER_SIGMA_PX: f64 = 0.1;
/// Triples of views tried for the first plane.
const TRIPLES: usize = 500;
/// Heights between these ranks are the depth that the stripes span.
const DEPTH_RANKS: (f64, f64) = (0.02, 0.98);

/// A camera as its file gives it.
#[derive(Debug, Clone)]
pub struct KnownCamera {
    /// Columns and rows of its pictures.
    pub size_px: (usize, usize),
    /// Its intrinsics.
    pub intrinsics: Intrinsics,
    /// Their covariance, where it is known.
    pub covariance: Option<SMatrix<f64, INTRINSICS, INTRINSICS>>,
    /// Its boards, where they are known: then camera and plane are fitted together.
    pub views: Vec<BoardSighting>,
    /// Root mean square reprojection error of those \[px\].
    pub rms_px: Option<f64>,
}

/// A board with a stripe on it.
#[derive(Debug, Clone)]
pub struct StripeView {
    /// The board in the picture with the laser on; corners near the stripe are not used.
    pub board: BoardSighting,
    /// The stripe.
    pub stripe: StripeLineSeen,
}

/// One view's result.
#[derive(Debug, Clone)]
pub struct LaserView {
    /// What was seen.
    pub seen: StripeView,
    /// Where the board stood.
    pub pose: Pose,
    /// Mean distance of the stripe's points from the plane \[mm\], and their scatter.
    pub mean_mm: f64,
    /// Root mean square distance of the stripe's points from the plane \[mm\].
    pub rms_mm: f64,
    /// The mean when all views of this pose took no part \[mm\].
    pub left_out_mm: f64,
    /// What a millimetre off the plane means in height here \[mm/mm\].
    pub height_per_mm: f64,
    /// Share of its full weight.
    pub weight: f64,
    /// Whether it contradicts the others.
    pub flagged: bool,
    /// Heights between which its stripe lies \[mm\].
    pub height_mm: [f64; 2],
}

/// A calibrated sensor.
#[derive(Debug, Clone)]
pub struct LaserFit {
    /// Camera and plane, with range and covariance.
    pub sensor: LaserCamera,
    /// Root mean square distance of all stripes' points from the plane \[mm\].
    pub rms_mm: f64,
    /// The views.
    pub views: Vec<LaserView>,
    /// Number of different poses with a stripe.
    pub poses: usize,
    /// Whether the camera was fitted along with the plane.
    pub jointly: bool,
    /// Pictures left out, and why.
    pub left_out: Vec<String>,
    /// What is weak.
    pub advice: Vec<String>,
}

/// Fits the plane, and the camera with it where its views are known.
///
/// # Errors
/// When the views are too few, or the stripes lie too nearly at one height.
pub fn fit_laser(
    camera: &KnownCamera,
    (board, square_mm): (BoardSize, f64),
    views: Vec<StripeView>,
    left_out: Vec<String>,
    pictures: usize,
) -> Result<LaserFit, CalibrationError> {
    let board_mm = board.points_mm(square_mm);
    let boards: Vec<&BoardSighting> = views.iter().map(|view| &view.board).collect();
    let stripe_poses = poses_of(&boards).iter().max().map_or(0, |last| last + 1);
    if stripe_poses < LEAST_VIEWS {
        return Err(CalibrationError::NoStripe { found: stripe_poses, pictures, left_out });
    }
    let all: Vec<&BoardSighting> = camera.views.iter().chain(boards).collect();
    let pose_of = poses_of(&all);
    let first = camera.views.len();
    let mut sightings: Vec<Sighting> =
        all.iter().map(|s| Sighting { corners: s.pairs(&board_mm), stripe: vec![] }).collect();
    for (sighting, view) in sightings[first..].iter_mut().zip(&views) {
        sighting.stripe = view.stripe.supports.to_vec();
    }
    let jointly = !camera.views.is_empty();
    let mut free = [jointly; PARAMETERS];
    free[INTRINSICS - 1] = jointly && camera.intrinsics.k3 != 0.0;
    free[INTRINSICS..].fill(true);
    let corner_sigma_px = camera.rms_px.map_or(CORNER_SIGMA_PX, |rms_px| rms_px / 2f64.sqrt());
    let mut problem = Problem { weights: vec![1.0; sightings.len()], sightings, corner_sigma_px, free };
    let poses =
        all.iter().zip(&problem.sightings).map(|(s, sighting)| board_pose(&camera.intrinsics, &board_mm, s, sighting));
    let poses: Vec<Pose> = poses.collect::<Result<_, _>>()?;
    let plane = first_plane(&camera.intrinsics, &poses[first..], &views)?;
    let mut state = State { intrinsics: camera.intrinsics, plane: Some(plane), poses };
    let mut weights = vec![1.0; views.len()];
    for _ in 0..ROUNDS {
        state = adjust(&problem, state)?;
        weights = reweighted(&mut problem, &state, first, &views);
    }
    state = adjust(&problem, state)?;
    let mut plane = state.plane.unwrap_or(plane);
    // The sign of the normal may have turned on the way.
    plane = LaserPlane::new(plane.normal(), plane.distance_mm())?;
    state.plane = Some(plane);
    let covariance = covariance(camera, &problem, &state, &pose_of)?;
    let left_out_mm = left_out_means(&problem, &state, &pose_of, first, &views);
    let flagged = flags(&left_out_mm);
    let bare = LaserCamera::new(camera.size_px, state.intrinsics, plane, None, None);
    let range = range_of(&bare, &views)?;
    expect_depth(&bare, &views)?;
    let mut squares = (0.0, 0.0);
    let mut results = vec![];
    for (i, seen) in views.into_iter().enumerate() {
        let pose = state.poses[first + i];
        let offsets = offsets_mm(&state.intrinsics, &plane, &pose, &seen.stripe);
        let count = offsets.len() as f64;
        let sum: f64 = offsets.iter().map(|o| o * o).sum();
        squares = (squares.0 + sum, squares.1 + count);
        let heights = seen.stripe.pixels.iter().filter_map(|p| Some(bare.point(*p)?.height_mm));
        let height_mm = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], h| [a.min(h), b.max(h)]);
        results.push(LaserView {
            mean_mm: offsets.iter().sum::<f64>() / count,
            rms_mm: (sum / count).sqrt(),
            left_out_mm: left_out_mm[i],
            height_per_mm: height_per_mm(&bare, &seen.stripe),
            weight: weights[i],
            flagged: flagged[i],
            height_mm,
            pose,
            seen,
        });
    }
    let sensor = LaserCamera::new(camera.size_px, state.intrinsics, plane, Some(range), Some(covariance));
    let advice = advice(&sensor, &results, stripe_poses, jointly, camera);
    Ok(LaserFit {
        sensor,
        rms_mm: (squares.0 / squares.1).sqrt(),
        views: results,
        poses: stripe_poses,
        jointly,
        left_out,
        advice,
    })
}

/// The pose of a board under a known camera.
pub fn board_pose(
    camera: &Intrinsics,
    board_mm: &[Vector2<f64>],
    board: &BoardSighting,
    sighting: &Sighting,
) -> Result<Pose, CalibrationError> {
    let start = first_pose(camera, board_mm, &board.corners).ok_or(CalibrationError::Undetermined)?;
    Ok(adjust_pose(camera, sighting, start)?)
}

/// Distances of a stripe's points from the plane \[mm\].
#[must_use]
pub fn offsets_mm(camera: &Intrinsics, plane: &LaserPlane, pose: &Pose, stripe: &StripeLineSeen) -> Vec<f64> {
    stripe.pixels.iter().filter_map(|p| stripe_offset_mm(camera, plane, pose, *p)).collect()
}

/// What a millimetre off the plane means in height, at the middle of a stripe \[mm/mm\].
#[must_use]
pub fn height_per_mm(sensor: &LaserCamera, stripe: &StripeLineSeen) -> f64 {
    let Some(point) = stripe.pixels.get(stripe.pixels.len() / 2).and_then(|p| sensor.camera_point_mm(*p)) else {
        return 0.0;
    };
    // A plane moved by 1 mm moves its meeting with the ray by 1/(n · ray) along the ray.
    let ray = point.normalize();
    (ray.dot(&sensor.axes().height) / ray.dot(&sensor.plane().normal())).abs()
}

/// A plane through the supports of three views that most views agree with.
fn first_plane(camera: &Intrinsics, poses: &[Pose], views: &[StripeView]) -> Result<LaserPlane, CalibrationError> {
    let mut points: Vec<[Vector3<f64>; 2]> = vec![];
    for (pose, view) in poses.iter().zip(views) {
        let point = |i: usize| {
            let pixel = view.stripe.supports[i].pixel;
            camera.ray(pixel).and_then(|ray| pose.meet(ray)).ok_or(CalibrationError::NotInvertible(pixel))
        };
        points.push([point(0)?, point(1)?]);
    }
    let mut best: Option<(f64, LaserPlane)> = None;
    let n = points.len();
    for i in 0..TRIPLES {
        let view = |k: usize| (i * (2 * k + 1) + k * (i / n + 1) + k) % n;
        let corners = [points[view(0)][i % 2], points[view(1)][(i / 2) % 2], points[view(2)][(i / 4) % 2]];
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let Ok(plane) = LaserPlane::new(normal, normal.dot(&corners[0])) else { continue };
        let mut off: Vec<f64> = points.iter().flatten().map(|p| plane.offset_mm(p).abs()).collect();
        off.sort_by(f64::total_cmp);
        let median = off[off.len() / 2];
        if best.as_ref().is_none_or(|(least, _)| median < *least) {
            best = Some((median, plane));
        }
    }
    let (median, rough) = best.ok_or(CalibrationError::Undetermined)?;
    let near: Vec<Vector3<f64>> =
        points.into_iter().flatten().filter(|p| rough.offset_mm(p).abs() <= 4.0 * median).collect();
    let mean = near.iter().sum::<Vector3<f64>>() / near.len() as f64;
    let scatter: Matrix3<f64> = near.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    Ok(LaserPlane::new(normal, normal.dot(&mean))?)
}

/// Gives each view's stripe the σ of its speckle and of what differs from view to view, and views that contradict the
/// others less weight. Returns the weights.
fn reweighted(problem: &mut Problem, state: &State, first: usize, views: &[StripeView]) -> Vec<f64> {
    let Some(plane) = &state.plane else { return vec![1.0; views.len()] };
    let mut off_px: Vec<[f64; 2]> = vec![];
    for (pose, view) in state.poses[first..].iter().zip(views) {
        off_px.push(view.stripe.supports.map(|support| {
            let beside = |by: f64| {
                let (u, v) = (support.pixel.u_px + by * support.across.x, support.pixel.v_px + by * support.across.y);
                stripe_offset_mm(&state.intrinsics, plane, pose, crate::units::PixelPoint::new(u, v)).unwrap_or(0.0)
            };
            beside(0.0) / (beside(0.5) - beside(-0.5)).abs().max(f64::MIN_POSITIVE)
        }));
    }
    let median = |mut all: Vec<f64>| {
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let scatter_px = 1.4826 * median(off_px.iter().flatten().map(|o| o.abs()).collect());
    let speckle_px2 = median(views.iter().map(|v| v.stripe.supports[0].sigma_px.powi(2)).collect());
    let between_px2 = (scatter_px.powi(2) - speckle_px2).max(0.0);
    let mut weights = vec![];
    for ((sighting, view), off) in problem.sightings[first..].iter_mut().zip(views).zip(&off_px) {
        let sigma_px = (view.stripe.supports[0].sigma_px.powi(2) + between_px2).sqrt();
        let worst = off[0].abs().max(off[1].abs());
        let weight = (1.0 - (worst / (VIEW_TUKEY * sigma_px)).powi(2)).max(0.0).powi(2).max(LEAST_WEIGHT);
        sighting.stripe.iter_mut().for_each(|support| support.sigma_px = sigma_px / weight.sqrt());
        weights.push(weight);
    }
    weights
}

/// What the poses leave open, and what the covariance of a camera adds that is given without its views.
fn covariance(
    camera: &KnownCamera,
    problem: &Problem,
    state: &State,
    pose_of: &[usize],
) -> Result<ParameterCovariance, CalibrationError> {
    let by_poses = resample::covariance(&resample::replicates(problem, state, pose_of)?);
    match camera.covariance.filter(|_| camera.views.is_empty()) {
        Some(covariance) => Ok(by_poses + resample::covariance_by_camera(problem, state, &covariance)?),
        None => Ok(by_poses),
    }
}

/// For each view the mean distance of its stripe from the plane that the other poses give \[mm\].
fn left_out_means(problem: &Problem, state: &State, pose_of: &[usize], first: usize, views: &[StripeView]) -> Vec<f64> {
    (0..views.len())
        .into_par_iter()
        .map(|i| {
            let weight = |k: usize| if pose_of[k] == pose_of[first + i] { 0.0 } else { 1.0 };
            let weights = (0..problem.weights.len()).map(weight).collect();
            let others = adjust(&Problem { weights, ..problem.clone() }, state.clone()).ok()?;
            let pose = adjust_pose(&others.intrinsics, &problem.sightings[first + i], state.poses[first + i]).ok()?;
            let offsets = offsets_mm(&others.intrinsics, &others.plane?, &pose, &views[i].stripe);
            Some(offsets.iter().sum::<f64>() / offsets.len() as f64)
        })
        .map(|mean: Option<f64>| mean.unwrap_or(f64::INFINITY))
        .collect()
}

/// Which views are off by more than their own number explains.
fn flags(left_out_mm: &[f64]) -> Vec<bool> {
    let mut sorted: Vec<f64> = left_out_mm.iter().map(|m| m.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    let sigma = 1.4826 * sorted[sorted.len() / 2];
    left_out_mm.iter().map(|mean| mean.abs() > FLAG_SIGMAS * sigma).collect()
}

fn range_of(sensor: &LaserCamera, views: &[StripeView]) -> Result<CalibratedRange, CalibrationError> {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let mut range = CalibratedRange { u_px: none, v_px: none, lateral_mm: none, height_mm: none };
    let widen = |range: &mut [f64; 2], value: f64| *range = [range[0].min(value), range[1].max(value)];
    for &pixel in views.iter().flat_map(|view| &view.stripe.pixels) {
        let point = sensor.point(pixel).ok_or(CalibrationError::NotInvertible(pixel))?;
        widen(&mut range.u_px, pixel.u_px);
        widen(&mut range.v_px, pixel.v_px);
        widen(&mut range.lateral_mm, point.lateral_mm);
        widen(&mut range.height_mm, point.height_mm);
    }
    Ok(range)
}

fn expect_depth(sensor: &LaserCamera, views: &[StripeView]) -> Result<(), CalibrationError> {
    let pixels = views.iter().flat_map(|view| &view.stripe.pixels);
    let mut heights: Vec<f64> = pixels.filter_map(|p| Some(sensor.point(*p)?.height_mm)).collect();
    heights.sort_by(f64::total_cmp);
    let rank = |share: f64| heights[(share * (heights.len() - 1) as f64) as usize];
    let span_mm = rank(DEPTH_RANKS.1) - rank(DEPTH_RANKS.0);
    let distance_mm = -rank(0.5);
    let least_mm = LEAST_DEPTH_SHARE * distance_mm.abs();
    if span_mm < least_mm { Err(CalibrationError::TooLittleDepth { span_mm, distance_mm, least_mm }) } else { Ok(()) }
}

fn advice(sensor: &LaserCamera, views: &[LaserView], poses: usize, jointly: bool, camera: &KnownCamera) -> Vec<String> {
    let mut advice = vec![];
    if poses < super::error::GOOD_VIEWS {
        advice.push(format!("{poses} poses with a stripe: {} are a good number", super::error::GOOD_VIEWS));
    }
    for view in views.iter().filter(|view| view.flagged) {
        advice.push(format!(
            "{} contradicts the others: its stripe lies {:+.2} mm from the plane that they give; take it again or leave it out",
            view.seen.board.name, view.left_out_mm
        ));
    }
    if !jointly {
        let known =
            if camera.covariance.is_some() { "was not fitted again" } else { "is taken as exact, which no camera is" };
        advice.push(format!("the camera's own views are not in its file, so it {known}"));
    }
    // The part of the range in which fewest stripes lie.
    if let Some(range) = sensor.range() {
        const PARTS: usize = 4;
        let step = (range.height_mm[1] - range.height_mm[0]) / PARTS as f64;
        for part in 0..PARTS {
            let (from, to) = (range.height_mm[0] + part as f64 * step, range.height_mm[0] + (part as f64 + 1.0) * step);
            let crossing = views.iter().filter(|v| v.height_mm[0] < to && v.height_mm[1] > from).count();
            if crossing < 2 {
                advice.push(format!(
                    "only {crossing} stripe lies between {from:.0} and {to:.0} mm of height: add a board there"
                ));
            }
        }
    }
    advice
}
