//! Pictures of boards in a folder, as somebody would take them to calibrate the sensor of a scene.

use std::path::Path;

use rand_pcg::Pcg32;

use super::{BoardSurface, Renderer, SensorScene};
use crate::calib::board::BoardSize;
use crate::calib::file::{CalibrationFile, ImageSection, LaserSection};
use crate::calib::laser_camera::LaserCamera;
use crate::frame::GrayFrame;

/// The boards to make up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boards {
    /// How many views of the board, once for the camera and once more for the laser.
    pub views: usize,
    /// Its size in inner corners.
    pub size: BoardSize,
    /// Side of a square \[mm\].
    pub square_mm: f64,
}

/// Boards that cannot be made up.
#[derive(Debug, thiserror::Error)]
pub enum BoardsError {
    /// The scenario has no sensor.
    #[error("the scenario has no [camera] and [laser]: only a sensor of these two can look at boards")]
    NoSensor,
    /// The board does not fit in.
    #[error(
        "{0} poses of the board were found in which the whole of it is in the picture and crossed by the laser, {1} are asked for: take a smaller board"
    )]
    TooLarge(usize, usize),
    /// The lens shows no picture.
    #[error("[camera]: the lens' distortion cannot be undone over the whole picture")]
    NoPicture,
    /// The sensor cannot be written.
    #[error("the sensor cannot be written as TOML: {0}")]
    Toml(String),
}

/// Renders `boards/board_01.png` … and `stripes/off_01.png`, `on_01.png` … by `write`.
///
/// # Errors
/// When the board does not fit into the picture, the lens has no picture, or `write` fails.
pub fn render_boards<E: From<BoardsError>>(
    sensor: &LaserCamera,
    boards: &Boards,
    seed: u64,
    mut write: impl FnMut(&Path, &GrayFrame) -> Result<(), E>,
) -> Result<(), E> {
    let scene = SensorScene::of(sensor);
    let mut random = Pcg32::new(seed, 77);
    let poses = scene.draw_poses(boards.size, boards.square_mm, 2 * boards.views, &mut random);
    if poses.len() < 2 * boards.views {
        return Err(BoardsError::TooLarge(poses.len(), 2 * boards.views).into());
    }
    let renderer = Renderer::new(scene).ok_or(BoardsError::NoPicture)?;
    for (i, pose) in poses.into_iter().enumerate() {
        let surface = BoardSurface { size: boards.size, square_mm: boards.square_mm, pose };
        let mut take = |laser_on, name: String| {
            let frame = renderer.render(&surface, laser_on, &mut random).ok_or(BoardsError::NoPicture)?;
            write(Path::new(&name), &frame)
        };
        if i < boards.views {
            take(false, format!("boards/board_{:02}.png", i + 1))?;
        } else {
            let number = i - boards.views + 1;
            take(false, format!("stripes/off_{number:02}.png"))?;
            take(true, format!("stripes/on_{number:02}.png"))?;
        }
    }
    Ok(())
}

/// The sensor as a calibration file that knows no error.
#[must_use]
pub fn true_calibration(sensor: &LaserCamera) -> CalibrationFile {
    let (normal, (width, height)) = (sensor.plane().normal(), sensor.size_px());
    let mut file = CalibrationFile::default();
    file.set_camera((width, height), sensor.intrinsics());
    file.image = Some(ImageSection { width, height });
    file.laser = Some(LaserSection {
        normal: [normal.x, normal.y, normal.z],
        distance_mm: sensor.plane().distance_mm(),
        rms_mm: None,
        views: None,
    });
    file.seal(String::new());
    file
}
