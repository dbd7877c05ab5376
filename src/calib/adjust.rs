//! The joint fit of intrinsics, laser plane and board poses to corners and stripes: a bundle adjustment by
//! Levenberg and Marquardt. Each pose touches its own picture only, so the poses are eliminated from the normal equations
//! (Schur complement; Triggs et al. 2000, section 6) and what is left has [`PARAMETERS`] unknowns.

use nalgebra::{Matrix6, SMatrix, SVector, Vector2, Vector6};

use super::intrinsics::{INTRINSICS, Intrinsics};
use super::laser_camera::{PARAMETERS, ParameterCovariance};
use super::plane::LaserPlane;
use super::pose::Pose;
use crate::units::PixelPoint;

/// Most rounds. A fit from Zhang's first guess takes 6 to 12.
const ROUNDS: usize = 60;
/// Damping at the start, and its factors after a worse and a better round.
const DAMPING: f64 = 1e-4;
const WORSE: f64 = 8.0;
const BETTER: f64 = 0.2;
/// The fit is done when a round improves the cost by less than this share.
const IMPROVEMENT: f64 = 1e-9;
/// Beyond this damping there is no way down.
const MOST_DAMPING: f64 = 1e12;
/// Steps of the stripe's derivatives: focal lengths and principal point, distortion; pose \[rad, mm\].
const INTRINSIC_STEPS: [f64; INTRINSICS] = [1e-2, 1e-2, 1e-2, 1e-2, 1e-5, 1e-5, 1e-6, 1e-6, 1e-5];
const POSE_STEPS: [f64; 6] = [1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4];
const PLANE_STEPS: [f64; 3] = [1e-6, 1e-6, 1e-4];

/// A place of the stripe's line in a picture, with its own σ across the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripeSupport {
    /// The place.
    pub pixel: PixelPoint,
    /// Unit vector across the stripe.
    pub across: Vector2<f64>,
    /// σ across the stripe \[px\].
    pub sigma_px: f64,
}

/// One picture's observations.
#[derive(Debug, Clone)]
pub struct Sighting {
    /// Corners: where they lie on the board \[mm\], and in the picture \[px\].
    pub corners: Vec<(Vector2<f64>, Vector2<f64>)>,
    /// Places of the stripe.
    pub stripe: Vec<StripeSupport>,
}

/// What is to be fitted.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The pictures.
    pub sightings: Vec<Sighting>,
    /// How often each picture counts; 0 leaves it out.
    pub weights: Vec<f64>,
    /// σ of a corner \[px\].
    pub corner_sigma_px: f64,
    /// Which of the parameters are fitted.
    pub free: [bool; PARAMETERS],
}

/// The unknowns.
#[derive(Debug, Clone)]
pub struct State {
    /// The camera.
    pub intrinsics: Intrinsics,
    /// The laser's plane, if there is one.
    pub plane: Option<LaserPlane>,
    /// The board's pose in each picture.
    pub poses: Vec<Pose>,
}

/// A fit that does not exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum AdjustError {
    /// The equations have no solution, or a board went behind the camera.
    #[error("the boards' poses do not determine the camera")]
    Singular,
}

type Globals = SVector<f64, PARAMETERS>;

struct View {
    pose: Matrix6<f64>,
    coupling: SMatrix<f64, PARAMETERS, 6>,
    gradient: Vector6<f64>,
}

struct Linear {
    cost: f64,
    normal: ParameterCovariance,
    gradient: Globals,
    views: Vec<Option<View>>,
}

/// Fits the free parameters and the poses, starting at `state`.
///
/// # Errors
/// When the observations do not determine them.
pub fn adjust(problem: &Problem, mut state: State) -> Result<State, AdjustError> {
    let mut linear = linearise(problem, &state).ok_or(AdjustError::Singular)?;
    let mut damping = DAMPING;
    for _ in 0..ROUNDS {
        let next = solve(problem, &linear, damping).map(|(globals, poses)| stepped(&state, &globals, &poses));
        let tried = next.and_then(|next| linearise(problem, &next).map(|linear| (next, linear)));
        match tried {
            Some((next, better)) if better.cost <= linear.cost => {
                let improvement = (linear.cost - better.cost) / linear.cost.max(f64::MIN_POSITIVE);
                (state, linear) = (next, better);
                damping = (damping * BETTER).max(1e-12);
                if improvement < IMPROVEMENT {
                    return Ok(state);
                }
            }
            _ => {
                damping *= WORSE;
                if damping > MOST_DAMPING {
                    break;
                }
            }
        }
    }
    // Out of rounds, or at the last digit of the cost: the place is a minimum if the equations hold there.
    solve(problem, &linear, 0.0).map(|_| state).ok_or(AdjustError::Singular)
}

/// Covariance of the parameters when every observation has its stated σ and all are independent. Parameters that are not
/// free have none.
///
/// # Errors
/// When the observations do not determine them.
pub fn formal_covariance(problem: &Problem, state: &State) -> Result<ParameterCovariance, AdjustError> {
    let linear = linearise(problem, state).ok_or(AdjustError::Singular)?;
    let (reduced, _) = reduce(problem, &linear, 0.0).ok_or(AdjustError::Singular)?;
    let mut covariance = reduced.try_inverse().ok_or(AdjustError::Singular)?;
    for i in (0..PARAMETERS).filter(|&i| !problem.free[i]) {
        covariance.row_mut(i).fill(0.0);
        covariance.column_mut(i).fill(0.0);
    }
    Ok(covariance)
}

/// The pose of one picture under a fixed camera.
pub(super) fn adjust_pose(camera: &Intrinsics, sighting: &Sighting, start: Pose) -> Result<Pose, AdjustError> {
    let problem = Problem {
        sightings: vec![Sighting { stripe: vec![], ..sighting.clone() }],
        weights: vec![1.0],
        corner_sigma_px: 1.0,
        free: [false; PARAMETERS],
    };
    let state = State { intrinsics: *camera, plane: None, poses: vec![start] };
    Ok(adjust(&problem, state)?.poses[0])
}

/// The stripe's distance from the plane at a place \[mm\].
pub(super) fn stripe_offset_mm(camera: &Intrinsics, plane: &LaserPlane, pose: &Pose, pixel: PixelPoint) -> Option<f64> {
    Some(plane.offset_mm(&pose.meet(camera.ray(pixel)?)?))
}

fn stepped(state: &State, globals: &Globals, poses: &[Vector6<f64>]) -> State {
    let mut intrinsics = state.intrinsics.to_array();
    intrinsics.iter_mut().zip(globals.iter()).for_each(|(value, by)| *value += by);
    let plane =
        state.plane.map(|plane| plane.varied([globals[INTRINSICS], globals[INTRINSICS + 1], globals[INTRINSICS + 2]]));
    let poses = state.poses.iter().zip(poses).map(|(pose, by)| pose.varied(by)).collect();
    State { intrinsics: Intrinsics::from_array(intrinsics), plane, poses }
}

/// Cost, gradient and normal equations at `state`; none when a board lies behind the camera.
fn linearise(problem: &Problem, state: &State) -> Option<Linear> {
    let mut linear =
        Linear { cost: 0.0, normal: ParameterCovariance::zeros(), gradient: Globals::zeros(), views: vec![] };
    for ((sighting, &weight), pose) in problem.sightings.iter().zip(&problem.weights).zip(&state.poses) {
        if weight <= 0.0 {
            linear.views.push(None);
            continue;
        }
        let mut view = View { pose: Matrix6::zeros(), coupling: SMatrix::zeros(), gradient: Vector6::zeros() };
        let mut add = |residual: f64, by_globals: &Globals, by_pose: &Vector6<f64>, weight: f64| {
            linear.cost += weight * residual * residual;
            linear.normal.ger(weight, by_globals, by_globals, 1.0);
            linear.gradient.axpy(weight * residual, by_globals, 1.0);
            view.pose.ger(weight, by_pose, by_pose, 1.0);
            view.coupling.ger(weight, by_globals, by_pose, 1.0);
            view.gradient.axpy(weight * residual, by_pose, 1.0);
        };
        let corner_weight = weight / problem.corner_sigma_px.powi(2);
        for (board, seen) in &sighting.corners {
            let turned = pose.rotation * nalgebra::Vector3::new(board.x, board.y, 0.0);
            let at = state.intrinsics.project_with_derivatives(&(turned + pose.translation_mm))?;
            let mut by_pose = SMatrix::<f64, 2, 6>::zeros();
            by_pose.fixed_columns_mut::<3>(0).copy_from(&(-at.by_point * turned.cross_matrix()));
            by_pose.fixed_columns_mut::<3>(3).copy_from(&at.by_point);
            let residual = at.pixel - seen;
            for axis in 0..2 {
                let mut by_globals = Globals::zeros();
                by_globals.fixed_rows_mut::<INTRINSICS>(0).copy_from(&at.by_intrinsics.row(axis).transpose());
                add(residual[axis], &by_globals, &by_pose.row(axis).transpose(), corner_weight);
            }
        }
        if let Some(plane) = &state.plane {
            for support in &sighting.stripe {
                let (residual, by_globals, by_pose) = stripe_row(&state.intrinsics, plane, pose, support)?;
                add(residual, &by_globals, &by_pose, weight / support.sigma_px.powi(2));
            }
        }
        linear.views.push(Some(view));
    }
    linear.cost.is_finite().then_some(linear)
}

/// The distance of a stripe's place from the plane, in pixels across the stripe, and its derivatives.
fn stripe_row(
    camera: &Intrinsics,
    plane: &LaserPlane,
    pose: &Pose,
    support: &StripeSupport,
) -> Option<(f64, Globals, Vector6<f64>)> {
    let beside = |by_px: f64| {
        let at = PixelPoint::new(
            support.pixel.u_px + by_px * support.across.x,
            support.pixel.v_px + by_px * support.across.y,
        );
        stripe_offset_mm(camera, plane, pose, at)
    };
    let mm_per_px = (beside(0.5)? - beside(-0.5)?).abs();
    let residual = |camera: &Intrinsics, plane: &LaserPlane, pose: &Pose| {
        Some(stripe_offset_mm(camera, plane, pose, support.pixel)? / mm_per_px)
    };
    let mut by_globals = Globals::zeros();
    let mut by_pose = Vector6::zeros();
    for (i, step) in INTRINSIC_STEPS.into_iter().enumerate() {
        let at = |by: f64| {
            let mut all = camera.to_array();
            all[i] += by;
            residual(&Intrinsics::from_array(all), plane, pose)
        };
        by_globals[i] = (at(step)? - at(-step)?) / (2.0 * step);
    }
    for (i, step) in PLANE_STEPS.into_iter().enumerate() {
        let at = |by: f64| {
            let mut varied = [0.0; 3];
            varied[i] = by;
            residual(camera, &plane.varied(varied), pose)
        };
        by_globals[INTRINSICS + i] = (at(step)? - at(-step)?) / (2.0 * step);
    }
    for (i, step) in POSE_STEPS.into_iter().enumerate() {
        let at = |by: f64| {
            let mut varied = Vector6::zeros();
            varied[i] = by;
            residual(camera, plane, &pose.varied(&varied))
        };
        by_pose[i] = (at(step)? - at(-step)?) / (2.0 * step);
    }
    Some((residual(camera, plane, pose)?, by_globals, by_pose))
}

/// The equations of the parameters alone, and for each view its damped pose matrix inverted.
fn reduce(
    problem: &Problem,
    linear: &Linear,
    damping: f64,
) -> Option<(ParameterCovariance, Vec<Option<Matrix6<f64>>>)> {
    let mut reduced = linear.normal;
    for i in 0..PARAMETERS {
        reduced[(i, i)] *= 1.0 + damping;
    }
    let mut inverses = Vec::with_capacity(linear.views.len());
    for view in &linear.views {
        let inverse = match view {
            None => None,
            Some(view) => {
                let mut pose = view.pose;
                for i in 0..6 {
                    pose[(i, i)] *= 1.0 + damping;
                }
                let inverse = pose.cholesky()?.inverse();
                reduced -= view.coupling * inverse * view.coupling.transpose();
                Some(inverse)
            }
        };
        inverses.push(inverse);
    }
    for i in (0..PARAMETERS).filter(|&i| !problem.free[i]) {
        reduced.row_mut(i).fill(0.0);
        reduced.column_mut(i).fill(0.0);
        reduced[(i, i)] = 1.0;
    }
    Some((reduced, inverses))
}

/// The step of the damped equations. They are solved in parameters of unit curvature: a focal length in pixels and a
/// distortion of r⁶ differ by ten orders.
fn solve(problem: &Problem, linear: &Linear, damping: f64) -> Option<(Globals, Vec<Vector6<f64>>)> {
    let (reduced, inverses) = reduce(problem, linear, damping)?;
    let mut right = -linear.gradient;
    for (view, inverse) in linear.views.iter().zip(&inverses) {
        if let (Some(view), Some(inverse)) = (view, inverse) {
            right += view.coupling * inverse * view.gradient;
        }
    }
    for i in (0..PARAMETERS).filter(|&i| !problem.free[i]) {
        right[i] = 0.0;
    }
    let scale = reduced.diagonal().map(|d| 1.0 / d.sqrt());
    if !scale.iter().all(|s| s.is_finite()) {
        return None;
    }
    let scaled = ParameterCovariance::from_fn(|i, j| reduced[(i, j)] * scale[i] * scale[j]);
    let globals: Globals = scaled.cholesky()?.solve(&right.component_mul(&scale)).component_mul(&scale);
    let poses = linear.views.iter().zip(&inverses).map(|pair| match pair {
        (Some(view), Some(inverse)) => -(inverse * (view.gradient + view.coupling.transpose() * globals)),
        _ => Vector6::zeros(),
    });
    let poses: Vec<Vector6<f64>> = poses.collect();
    globals.iter().chain(poses.iter().flatten()).all(|x| x.is_finite()).then_some((globals, poses))
}
