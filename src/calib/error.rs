//! What stops a calibration. Every text names what is wrong and what to do.

use super::board::BoardSize;
use crate::units::PixelPoint;

/// Fewest boards in different poses. Measured on real planes: the worst height is off by 1.4 mm with 5 views (90 % of
/// draws), .73 with 8, .41 with 12, .26 with 14.
pub const LEAST_VIEWS: usize = 8;
/// Views to aim at, by the same figures.
pub const GOOD_VIEWS: usize = 14;

/// Why there is no calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// A picture of another size.
    #[error("{name} has {} x {} pixels where the others have {} x {}: a calibration holds for one picture size, sort them out", got_px.0, got_px.1, expected_px.0, expected_px.1)]
    MixedSizes {
        /// The picture.
        name: String,
        /// Its columns and rows.
        got_px: (usize, usize),
        /// Those of the first picture.
        expected_px: (usize, usize),
    },
    /// Nothing is found anywhere.
    #[error(
        "no picture shows a chessboard of at least 3x3 inner corners as a whole ({names}): is the whole board in the picture, in focus and evenly lit?"
    )]
    NoBoard {
        /// Names of the pictures.
        names: String,
    },
    /// The board is larger than the one declared.
    #[error(
        "{name} shows a board of {found} inner corners, {declared} were declared: with a part of the board the fit looks better and is worse; give --board {found}, or leave it out"
    )]
    PartOfBoard {
        /// The picture.
        name: String,
        /// What was declared.
        declared: BoardSize,
        /// What is there.
        found: BoardSize,
    },
    /// Too few pictures can be used.
    #[error(
        "{usable} views in different poses are too few, {LEAST_VIEWS} is the least and {GOOD_VIEWS} a good number{}",
        listed(left_out)
    )]
    TooFewViews {
        /// Different poses with a readable board.
        usable: usize,
        /// Pictures left out, and why.
        left_out: Vec<String>,
    },
    /// All pictures show the board in one pose.
    #[error(
        "all {pictures} pictures show the board in one pose, which determines no camera whatever the residual: move and tilt the board between pictures{}",
        listed(left_out)
    )]
    OnePose {
        /// Number of pictures.
        pictures: usize,
        /// Pictures left out, and why.
        left_out: Vec<String>,
    },
    /// The boards are parallel.
    #[error(
        "the boards are nearly parallel: their tilts spread by {spread_deg:.1}°, {least_deg:.0}° is the least; the focal length could be anything. Tilt the board by 20° to 40° to all sides"
    )]
    ParallelBoards {
        /// Root mean square angle of the boards' normals from their mean \[°\].
        spread_deg: f64,
        /// The least \[°\].
        least_deg: f64,
    },
    /// The fit does not exist.
    #[error("the boards determine no camera: their poses are too much alike, or --board or --square is wrong")]
    Undetermined,
    /// The fit exists and is nonsense.
    #[error(
        "the fitted camera leaves {rms_px:.2} px: the corners are not those of a flat board of {board} inner corners"
    )]
    BadFit {
        /// Root mean square reprojection error \[px\].
        rms_px: f64,
        /// The board.
        board: BoardSize,
    },
    /// No stripe is seen on the boards.
    #[error(
        "only {found} of {pictures} pictures show a laser stripe on the board, {LEAST_VIEWS} are the least{}",
        listed(left_out)
    )]
    NoStripe {
        /// Pictures with a stripe.
        found: usize,
        /// Pictures.
        pictures: usize,
        /// Pictures left out, and why.
        left_out: Vec<String>,
    },
    /// The stripes lie at nearly one height.
    #[error(
        "too little depth: the stripes lie within {span_mm:.1} mm of height at {distance_mm:.0} mm, {least_mm:.0} mm is the least for a plane. Move the board nearer and farther, over the whole range you weld in"
    )]
    TooLittleDepth {
        /// Range of heights \[mm\].
        span_mm: f64,
        /// Mean distance \[mm\].
        distance_mm: f64,
        /// The least range \[mm\].
        least_mm: f64,
    },
    /// The fitted plane cannot be a sensor's.
    #[error("the stripes give no plane: {0}")]
    NoPlane(#[from] super::plane::PlaneError),
    /// A pixel outside what the lens model reaches.
    #[error("the lens' distortion cannot be undone at {:.0}, {:.0}: the camera's file does not belong to these pictures", .0.u_px, .0.v_px)]
    NotInvertible(PixelPoint),
    /// The camera of another picture size.
    #[error(transparent)]
    OtherImageSize(#[from] super::laser_camera::OtherImageSize),
}

fn listed(left_out: &[String]) -> String {
    const SHOWN: usize = 4;
    if left_out.is_empty() {
        return String::new();
    }
    let more = if left_out.len() > SHOWN { format!("; and {} more", left_out.len() - SHOWN) } else { String::new() };
    format!(". Left out: {}{more}", left_out[..left_out.len().min(SHOWN)].join("; "))
}
