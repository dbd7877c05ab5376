//! Boards with their stripes, from pictures with the laser off and on, or on alone.

use nalgebra::Vector2;
use rayon::prelude::*;

use super::board::BoardSize;
use super::corners::{Corners, find_near, find_sized};
use super::detect::{BoardSighting, Picture, Pictures, STRIPE_REACH_PX};
use super::error::CalibrationError;
use super::intrinsics::Intrinsics;
use super::laser::StripeView;
use super::laser_camera::OtherImageSize;
use super::pairs::Pair;
use super::stripe::find_stripe;

/// A pose needs this many corners away from the stripe.
const LEAST_USED: usize = 8;

/// Views with a stripe, and which pictures are left out and why.
pub type StripeViews = (Vec<StripeView>, Vec<String>);

/// Reads every pair and finds board and stripe.
///
/// # Errors
/// When a picture has not the camera's size.
pub fn find_stripes(
    pictures: &dyn Pictures,
    pairs: &[Pair],
    board: BoardSize,
    camera: &Intrinsics,
    size_px: (usize, usize),
) -> Result<StripeViews, CalibrationError> {
    let found: Vec<Result<Result<StripeView, String>, OtherImageSize>> =
        pairs.par_iter().map(|pair| view(pictures, *pair, board, camera, size_px)).collect();
    let (mut views, mut left_out): StripeViews = (vec![], vec![]);
    for found in found {
        match found? {
            Err(reason) => left_out.push(reason),
            Ok(view) => match views.iter().find(|other| other.board.sha256 == view.board.sha256) {
                Some(other) => {
                    left_out.push(format!("{} is the same picture as {}", view.board.name, other.board.name))
                }
                None => views.push(view),
            },
        }
    }
    Ok((views, left_out))
}

fn view(
    pictures: &dyn Pictures,
    pair: Pair,
    board: BoardSize,
    camera: &Intrinsics,
    size_px: (usize, usize),
) -> Result<Result<StripeView, String>, OtherImageSize> {
    let read = |index: usize| pictures.read(index);
    let lit = match read(pair.lit) {
        Ok(picture) => picture,
        Err(reason) => return Ok(Err(reason)),
    };
    let dark = match pair.dark.map(read).transpose() {
        Ok(picture) => picture,
        Err(reason) => return Ok(Err(reason)),
    };
    for picture in [Some(&lit), dark.as_ref()].into_iter().flatten() {
        let got_px = (picture.frame.width_px(), picture.frame.height_px());
        if got_px != size_px {
            return Err(OtherImageSize { got_px, calibrated_px: size_px });
        }
    }
    Ok(seen(&lit, dark.as_ref(), board, camera))
}

fn seen(lit: &Picture, dark: Option<&Picture>, board: BoardSize, camera: &Intrinsics) -> Result<StripeView, String> {
    let lit_corners = find_sized(&lit.frame, board);
    let dark_corners = match (&lit_corners, dark) {
        (Some(lit), Some(dark)) => find_near(&dark.frame, lit),
        (None, Some(dark)) => find_sized(&dark.frame, board),
        (_, None) => None,
    };
    let shift_px = match (&lit_corners, &dark_corners) {
        (Some(lit), Some(dark)) => median_shift(lit, dark),
        _ => Vector2::zeros(),
    };
    let Some(corners) = lit_corners.or(dark_corners) else {
        return Err(format!("{} does not show the whole board of {board} inner corners", lit.name));
    };
    let with_dark = dark.map(|dark| (&dark.frame, shift_px));
    let Some(stripe) = find_stripe(camera, board, &corners.pixels, &lit.frame, with_dark) else {
        return Err(format!("{} shows no straight laser stripe on the board", lit.name));
    };
    let near = |c: &Vector2<f64>| {
        stripe.pixels.iter().any(|p| (c - Vector2::new(p.u_px, p.v_px)).norm_squared() < STRIPE_REACH_PX.powi(2))
    };
    let used: Vec<bool> = corners.pixels.iter().map(|c| !near(c)).collect();
    let board = BoardSighting { name: lit.name.clone(), sha256: lit.sha256.clone(), corners: corners.pixels, used };
    if board.used_corners() < LEAST_USED {
        return Err(format!("{} has fewer than {LEAST_USED} corners away from the stripe", lit.name));
    }
    Ok(StripeView { board, stripe })
}

/// How far the board moved from the dark picture to the lit one \[px\].
fn median_shift(lit: &Corners, dark: &Corners) -> Vector2<f64> {
    let median = |axis: usize| {
        let mut moved: Vec<f64> = lit.pixels.iter().zip(&dark.pixels).map(|(a, b)| a[axis] - b[axis]).collect();
        moved.sort_by(f64::total_cmp);
        moved[moved.len() / 2]
    };
    Vector2::new(median(0), median(1))
}
