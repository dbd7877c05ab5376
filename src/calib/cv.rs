//! The only file of this folder that knows OpenCV: finding a chessboard's corners.
#![expect(clippy::disallowed_types, reason = "the folder's one door to OpenCV")]

use nalgebra::Vector2;
use opencv::calib3d::{CALIB_CB_ACCURACY, CALIB_CB_EXHAUSTIVE, CALIB_CB_LARGER, find_chessboard_corners_sb_with_meta};
use opencv::core::{Mat, MatTraitConst, Point2f, Size, TermCriteria, Vector};
use opencv::imgproc::corner_sub_pix;

use crate::frame::GrayFrame;

/// Rounds and least step \[px\] of the refinement, as in OpenCV's examples.
const REFINE_ROUNDS: i32 = 60;
const REFINE_STEP_PX: f64 = 1e-3;

/// A grid of corners as OpenCV found it.
pub(super) struct Grid {
    pub columns: usize,
    pub rows: usize,
    /// Row by row \[px\].
    pub corners: Vec<Vector2<f64>>,
}

/// How to search.
#[derive(Clone, Copy)]
pub(super) struct Search {
    /// A larger board counts too.
    pub or_larger: bool,
    /// Try more places; several times slower.
    pub thorough: bool,
}

/// The chessboard of at least `columns` × `rows` inner corners in the frame, or of just as many. OpenCV's sector-based
/// detector (Duda & Frese 2018) also finds boards in dark pictures without a bright margin, where the classic one fails.
pub(super) fn find_grid(
    frame: &GrayFrame,
    (columns, rows): (usize, usize),
    search: Search,
) -> opencv::Result<Option<Grid>> {
    let image = Mat::new_rows_cols_with_data(frame.height_px() as i32, frame.width_px() as i32, frame.pixels())?;
    let mut corners = Vector::<Point2f>::new();
    let mut meta = Mat::default();
    let larger = if search.or_larger { CALIB_CB_LARGER } else { 0 };
    let thorough = if search.thorough { CALIB_CB_EXHAUSTIVE } else { 0 };
    let flags = CALIB_CB_ACCURACY | thorough | larger;
    let size = Size::new(columns as i32, rows as i32);
    if !find_chessboard_corners_sb_with_meta(&image, size, &mut corners, flags, &mut meta)? {
        return Ok(None);
    }
    let found = if search.or_larger { (meta.cols() as usize, meta.rows() as usize) } else { (columns, rows) };
    let grid = Grid { columns: found.0, rows: found.1, corners: corners.iter().map(to_vector).collect() };
    Ok((grid.corners.len() == grid.columns * grid.rows).then_some(grid))
}

/// The corners moved to where the gradients of their surroundings cross, within `half_window_px`.
pub(super) fn refine(
    frame: &GrayFrame,
    corners: &[Vector2<f64>],
    half_window_px: i32,
) -> opencv::Result<Vec<Vector2<f64>>> {
    let image = Mat::new_rows_cols_with_data(frame.height_px() as i32, frame.width_px() as i32, frame.pixels())?;
    let mut refined: Vector<Point2f> = corners.iter().map(|c| Point2f::new(c.x as f32, c.y as f32)).collect();
    let window = Size::new(half_window_px, half_window_px);
    let criteria = TermCriteria::new(
        opencv::core::TermCriteria_EPS + opencv::core::TermCriteria_COUNT,
        REFINE_ROUNDS,
        REFINE_STEP_PX,
    )?;
    corner_sub_pix(&image, &mut refined, window, Size::new(-1, -1), criteria)?;
    Ok(refined.iter().map(to_vector).collect())
}

fn to_vector(point: Point2f) -> Vector2<f64> {
    Vector2::new(f64::from(point.x), f64::from(point.y))
}
