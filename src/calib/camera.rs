//! A camera from pictures of a board: intrinsics, what each view leaves over, and what all views leave open.

use nalgebra::{SMatrix, Vector2, Vector3};
use rayon::prelude::*;

use super::adjust::{AdjustError, Problem, Sighting, State, adjust, adjust_pose, formal_covariance};
use super::board::BoardSize;
use super::error::{CalibrationError, LEAST_VIEWS};
use super::intrinsics::{INTRINSICS, Intrinsics};
use super::laser_camera::PARAMETERS;
use super::pose::{Pose, first_focal_px, first_pose, homography};
use super::resample;
use super::sightings::{BoardSighting, Detected, poses_of};

/// Least spread of the boards' tilts \[°\]: the root mean square angle of their normals from the mean one. Boards that are
/// parallel but for their noise have below 1°, tilts up to 15° to all sides 9°. Below it neither rms nor σ warn:
/// parallel boards gave a focal length of 3246 ± .2 px instead of 1432.
pub const LEAST_TILT_SPREAD_DEG: f64 = 5.0;
/// A corner that is off by more than this many robust σ, and by more than this \[px\], is left out.
const CORNER_SIGMAS: f64 = 6.0;
const CORNER_PX: f64 = 0.5;
/// A view that is off by more than this factor over the median one when it is left out, and by more than this \[px\], is bad.
const VIEW_FACTOR: f64 = 3.0;
const VIEW_PX: f64 = 0.3;
/// A fit above this \[px\] is no calibration.
const WORST_RMS_PX: f64 = 2.0;
/// k3 is fitted when it lowers the error of views left out by this share. Chosen: less is within what the draw of views
/// does, and a term too many widens the uncertainty at the picture's rim.
const K3_GAIN: f64 = 0.03;
/// The index of k3 among the parameters.
const K3: usize = 8;
/// σ of a corner before the first fit \[px\].
const FIRST_CORNER_SIGMA_PX: f64 = 0.1;

/// One view's result.
#[derive(Debug, Clone)]
pub struct CameraView {
    /// The board.
    pub sighting: BoardSighting,
    /// Where it stood.
    pub pose: Pose,
    /// Root mean square distance of the used corners from the fit \[px\], both coordinates together.
    pub rms_px: f64,
    /// The same when this view, and all of its pose, took no part in the fit.
    pub left_out_rms_px: f64,
    /// Angle between the board's normal and the optical axis \[°\].
    pub tilt_deg: f64,
    /// Number of its pose.
    pub pose_number: usize,
}

/// A calibrated camera.
#[derive(Debug, Clone)]
pub struct CameraFit {
    /// Columns and rows of the pictures.
    pub size_px: (usize, usize),
    /// The board.
    pub board: BoardSize,
    /// Side of a square \[mm\].
    pub square_mm: f64,
    /// The intrinsics.
    pub intrinsics: Intrinsics,
    /// Their covariance by a jackknife over poses.
    pub covariance: SMatrix<f64, INTRINSICS, INTRINSICS>,
    /// What independent corners would give, σ of each parameter; far too small on real boards.
    pub formal_sigma: [f64; INTRINSICS],
    /// [`resample::replicates`] of the intrinsics.
    pub replicates: Vec<[f64; INTRINSICS]>,
    /// Root mean square reprojection error over the views used \[px\].
    pub rms_px: f64,
    /// The same over views left out one by one.
    pub left_out_rms_px: f64,
    /// The views used.
    pub views: Vec<CameraView>,
    /// Pictures left out, and why.
    pub left_out: Vec<String>,
    /// Number of different poses.
    pub poses: usize,
    /// Root mean square angle of the normals from their mean \[°\].
    pub tilt_spread_deg: f64,
    /// What is weak, and which view to add.
    pub advice: Vec<String>,
}

/// Calibrates a camera from the boards found in its pictures.
///
/// # Errors
/// When the views are too few, too much alike, or do not fit a flat board.
pub fn fit_camera(detected: Detected, square_mm: f64) -> Result<CameraFit, CalibrationError> {
    let Detected { board, size_px, sightings, mut left_out } = detected;
    let mut sightings: Vec<BoardSighting> = sightings.into_iter().flatten().collect();
    let board_mm = board.points_mm(square_mm);
    expect_poses(&sightings, &left_out)?;
    let mut state = first_state(&sightings, &board_mm, size_px)?;
    expect_tilts(&state)?;
    let mut free_k3 = false;
    // Corners and then views that contradict the others are left out, a few at a time.
    loop {
        let problem = problem(&sightings, &board_mm, free_k3, FIRST_CORNER_SIGMA_PX);
        state = adjust(&problem, state)?;
        expect_tilts(&state)?;
        if drop_corners(&mut sightings, &board_mm, &state) > 0 {
            continue;
        }
        let numbers = poses_of(&sightings.iter().collect::<Vec<_>>());
        let apart = left_out_rms_px(&problem, &state, &numbers);
        if let Some(bad) = worst_view(&apart) {
            let rms_px = apart[bad];
            left_out
                .push(format!("{} does not fit the others: {rms_px:.2} px when it is left out", sightings[bad].name));
            sightings.remove(bad);
            state.poses.remove(bad);
            expect_poses(&sightings, &left_out)?;
            continue;
        }
        if !free_k3 && gains_k3(&problem, &state, &numbers, &apart) {
            free_k3 = true;
            continue;
        }
        return finished(sightings, left_out, (board, square_mm), size_px, &problem, state, &apart);
    }
}

impl From<AdjustError> for CalibrationError {
    fn from(AdjustError::Singular: AdjustError) -> Self {
        Self::Undetermined
    }
}

fn finished(
    sightings: Vec<BoardSighting>,
    left_out: Vec<String>,
    (board, square_mm): (BoardSize, f64),
    size_px: (usize, usize),
    problem: &Problem,
    state: State,
    apart: &[f64],
) -> Result<CameraFit, CalibrationError> {
    let numbers = poses_of(&sightings.iter().collect::<Vec<_>>());
    let poses = numbers.iter().max().map_or(0, |last| last + 1);
    let residuals = residuals(problem, &state);
    let rms =
        |all: &[Vector2<f64>]| (all.iter().map(Vector2::norm_squared).sum::<f64>() / all.len().max(1) as f64).sqrt();
    let rms_px = rms(&residuals.concat());
    if rms_px > WORST_RMS_PX {
        return Err(CalibrationError::BadFit { rms_px, board });
    }
    let replicates = resample::replicates(problem, &state, &numbers)?;
    let covariance = resample::covariance(&replicates);
    let formal = formal_covariance(&Problem { corner_sigma_px: rms_px / 2f64.sqrt(), ..problem.clone() }, &state)?;
    let weights: Vec<f64> = sightings.iter().map(|s| s.used_corners() as f64).collect();
    let squares: f64 = apart.iter().zip(&weights).map(|(rms, n)| rms * rms * n).sum();
    let tilt_spread_deg = tilt_spread_deg(&state.poses);
    let views: Vec<CameraView> = sightings
        .into_iter()
        .zip(&state.poses)
        .zip(residuals.iter().zip(apart))
        .zip(numbers)
        .map(|(((sighting, pose), (residuals, apart)), pose_number)| CameraView {
            sighting,
            pose: *pose,
            rms_px: rms(residuals),
            left_out_rms_px: *apart,
            tilt_deg: pose.normal().z.abs().min(1.0).acos().to_degrees(),
            pose_number,
        })
        .collect();
    let advice = super::guidance::advice(size_px, &views.iter().map(|v| (&v.sighting, v.pose)).collect::<Vec<_>>());
    Ok(CameraFit {
        size_px,
        board,
        square_mm,
        intrinsics: state.intrinsics,
        covariance: covariance.fixed_view::<INTRINSICS, INTRINSICS>(0, 0).into_owned(),
        formal_sigma: std::array::from_fn(|i| formal[(i, i)].max(0.0).sqrt()),
        replicates: replicates.iter().map(|d| std::array::from_fn(|i| d[i])).collect(),
        rms_px,
        left_out_rms_px: (squares / weights.iter().sum::<f64>()).sqrt(),
        views,
        left_out,
        poses,
        tilt_spread_deg,
        advice,
    })
}

fn expect_poses(sightings: &[BoardSighting], left_out: &[String]) -> Result<(), CalibrationError> {
    let poses = poses_of(&sightings.iter().collect::<Vec<_>>()).iter().max().map_or(0, |last| last + 1);
    match poses {
        1 => Err(CalibrationError::OnePose {
            pictures: sightings.len() + same_pictures(left_out),
            left_out: left_out.to_vec(),
        }),
        poses if poses < LEAST_VIEWS => {
            let mut reasons = left_out.to_vec();
            if sightings.len() > poses {
                reasons.push(format!("{} pictures repeat the pose of another", sightings.len() - poses));
            }
            Err(CalibrationError::TooFewViews { usable: poses, left_out: reasons })
        }
        _ => Ok(()),
    }
}

fn same_pictures(left_out: &[String]) -> usize {
    left_out.iter().filter(|reason| reason.contains("is the same picture as")).count()
}

/// A pinhole camera and poses to start from.
fn first_state(
    sightings: &[BoardSighting],
    board_mm: &[Vector2<f64>],
    size_px: (usize, usize),
) -> Result<State, CalibrationError> {
    let homographies: Vec<_> = sightings.iter().filter_map(|s| homography(board_mm, &s.corners)).collect();
    // Boards that lie flat give no focal length; any will do to see that they are flat.
    let focal_px = first_focal_px(&homographies, size_px).unwrap_or(1.2 * size_px.0.max(size_px.1) as f64);
    let intrinsics = Intrinsics::pinhole(focal_px, size_px);
    let poses: Option<Vec<Pose>> = sightings.iter().map(|s| first_pose(&intrinsics, board_mm, &s.corners)).collect();
    Ok(State { intrinsics, plane: None, poses: poses.ok_or(CalibrationError::Undetermined)? })
}

fn problem(sightings: &[BoardSighting], board_mm: &[Vector2<f64>], free_k3: bool, corner_sigma_px: f64) -> Problem {
    let mut free = [false; PARAMETERS];
    free[..INTRINSICS].fill(true);
    free[K3] = free_k3;
    Problem {
        sightings: sightings.iter().map(|s| Sighting { corners: s.pairs(board_mm), stripe: vec![] }).collect(),
        weights: vec![1.0; sightings.len()],
        corner_sigma_px,
        free,
    }
}

/// What the fit leaves over at each corner \[px\], view by view.
#[must_use]
pub fn residuals(problem: &Problem, state: &State) -> Vec<Vec<Vector2<f64>>> {
    let views = problem.sightings.iter().zip(&state.poses);
    views.map(|(sighting, pose)| view_residuals(&state.intrinsics, sighting, pose)).collect()
}

fn view_residuals(camera: &Intrinsics, sighting: &Sighting, pose: &Pose) -> Vec<Vector2<f64>> {
    let residual = |(board, seen): &(Vector2<f64>, Vector2<f64>)| {
        let pixel = camera.project(&pose.camera_from_board(board))?;
        Some(seen - Vector2::new(pixel.u_px, pixel.v_px))
    };
    sighting.corners.iter().filter_map(residual).collect()
}

/// Leaves out corners that are far off; their number.
fn drop_corners(sightings: &mut [BoardSighting], board_mm: &[Vector2<f64>], state: &State) -> usize {
    let mut distances: Vec<(usize, usize, f64)> = vec![];
    for (view, (sighting, pose)) in sightings.iter().zip(&state.poses).enumerate() {
        for (corner, (board, seen)) in board_mm.iter().zip(&sighting.corners).enumerate() {
            if let Some(pixel) =
                state.intrinsics.project(&pose.camera_from_board(board)).filter(|_| sighting.used[corner])
            {
                distances.push((view, corner, (seen - Vector2::new(pixel.u_px, pixel.v_px)).norm()));
            }
        }
    }
    let mut sorted: Vec<f64> = distances.iter().map(|d| d.2).collect();
    sorted.sort_by(f64::total_cmp);
    // The median of a Rayleigh distance is 1.18 σ.
    let sigma_px = sorted.get(sorted.len() / 2).map_or(0.0, |median| median / 1.18);
    let limit_px = (CORNER_SIGMAS * sigma_px).max(CORNER_PX);
    // Only the worst of a view at a time, since one wrong corner pulls its neighbours' residuals up.
    let mut dropped = 0;
    for (view, sighting) in sightings.iter_mut().enumerate() {
        let worst = distances.iter().filter(|d| d.0 == view).max_by(|a, b| a.2.total_cmp(&b.2));
        if let Some(&(_, corner, _)) = worst.filter(|d| d.2 > limit_px) {
            // A view of which half must go is a bad view, not one with bad corners.
            if 2 * sighting.used_corners() > sighting.corners.len() {
                sighting.used[corner] = false;
                dropped += 1;
            }
        }
    }
    dropped
}

/// For each view the reprojection error when all views of its pose take no part \[px\].
fn left_out_rms_px(problem: &Problem, state: &State, pose_of: &[usize]) -> Vec<f64> {
    (0..problem.sightings.len())
        .into_par_iter()
        .map(|view| {
            let weight = |i: usize| if pose_of[i] == pose_of[view] { 0.0 } else { 1.0 };
            let weights = (0..problem.weights.len()).map(weight).collect();
            let others = adjust(&Problem { weights, ..problem.clone() }, state.clone()).ok()?;
            let pose = adjust_pose(&others.intrinsics, &problem.sightings[view], state.poses[view]).ok()?;
            let residuals = view_residuals(&others.intrinsics, &problem.sightings[view], &pose);
            Some((residuals.iter().map(Vector2::norm_squared).sum::<f64>() / residuals.len().max(1) as f64).sqrt())
        })
        .map(|rms: Option<f64>| rms.unwrap_or(f64::INFINITY))
        .collect()
}

fn worst_view(apart: &[f64]) -> Option<usize> {
    let mut sorted = apart.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    let worst = (0..apart.len()).max_by(|a, b| apart[*a].total_cmp(&apart[*b]))?;
    (apart[worst] > (VIEW_FACTOR * median).max(VIEW_PX)).then_some(worst)
}

fn gains_k3(problem: &Problem, state: &State, pose_of: &[usize], without: &[f64]) -> bool {
    let mut with_k3 = problem.clone();
    with_k3.free[K3] = true;
    let Ok(state) = adjust(&with_k3, state.clone()) else { return false };
    let squares = |rms: &[f64]| rms.iter().map(|rms| rms * rms).sum::<f64>();
    let with = left_out_rms_px(&with_k3, &state, pose_of);
    (squares(&with) / squares(without)).sqrt() < 1.0 - K3_GAIN
}

/// Root mean square angle of the boards' normals from their mean \[°\].
fn tilt_spread_deg(poses: &[Pose]) -> f64 {
    let mean = poses.iter().map(Pose::normal).sum::<Vector3<f64>>().normalize();
    let angle = |pose: &Pose| pose.normal().dot(&mean).clamp(-1.0, 1.0).acos().to_degrees();
    (poses.iter().map(|pose| angle(pose).powi(2)).sum::<f64>() / poses.len().max(1) as f64).sqrt()
}

fn expect_tilts(state: &State) -> Result<(), CalibrationError> {
    let spread_deg = tilt_spread_deg(&state.poses);
    if spread_deg < LEAST_TILT_SPREAD_DEG {
        return Err(CalibrationError::ParallelBoards { spread_deg, least_deg: LEAST_TILT_SPREAD_DEG });
    }
    Ok(())
}
