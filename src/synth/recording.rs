//! A scene written to a folder: `frames/`, `truth.csv`, `scenario.toml`, and `timestamps.csv` where time is irregular.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use rayon::prelude::*;

use super::board::recording::{Boards, BoardsError, render_boards, true_calibration};
use super::pool::{PoolScenario, PoolScene};
use super::true_sensor;
use super::{Scenario, ScenarioError, Scene};
use crate::output::{Existing, OutputError, WholeFolder};

/// Why a recording could not be written.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The scenario cannot be rendered.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The boards cannot be rendered.
    #[error(transparent)]
    Boards(#[from] BoardsError),
    /// The folder cannot be written, or holds something that is not to be replaced.
    #[error(transparent)]
    Folder(#[from] OutputError),
    /// A file could not be written.
    #[error("cannot write {}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A picture could not be encoded.
    #[error("cannot write {}", file.display())]
    Encode {
        /// The file.
        file: PathBuf,
        /// Why.
        source: image::ImageError,
    },
    /// The scenario does not fit into a TOML file.
    #[error("cannot write the scenario as TOML")]
    Toml(#[from] toml::ser::Error),
}

/// Renders the recording of `scenario` (with its own seed) into the folder `target`, which appears when it is complete.
/// `progress` is called after each frame, from several threads.
///
/// With `boards` also `boards/` and `stripes/`, from which the scenario's sensor can be calibrated, and that sensor itself,
/// `sensor.toml`. Frames are rendered in parallel, each dropped once written.
///
/// # Errors
/// When the scenario cannot be rendered, something stands at `target` that is not to be replaced, or a file cannot be
/// written.
pub fn write_recording(
    scenario: &Scenario,
    target: &Path,
    existing: Existing,
    boards: Option<&Boards>,
    progress: impl Fn() + Sync,
) -> Result<(), RecordingError> {
    let scene = Scene::new(scenario, scenario.seed)?;
    into_folder(target, existing, |folder| {
        if let Some(boards) = boards {
            write_boards(scenario, boards, folder)?;
        }
        write_text(&folder.join("scenario.toml"), &scenario.to_toml()?)?;
        write_truth(&scene, scenario, &folder.join("truth.csv"))?;
        if scenario.recorder.is_irregular() {
            write_timestamps(&scene, &folder.join("timestamps.csv"))?;
        }
        let frames = folder.join("frames");
        (0..scene.frame_count()).into_par_iter().try_for_each(|i| {
            let frame = scene.render(i);
            let size = (frame.width_px(), frame.height_px());
            write_png(frame.pixels(), size, image::ExtendedColorType::L8, &frames.join(frame_name(i)))?;
            progress();
            Ok(())
        })
    })
}

fn write_boards(scenario: &Scenario, boards: &Boards, folder: &Path) -> Result<(), RecordingError> {
    let sensor = true_sensor(scenario)?.ok_or(BoardsError::NoSensor)?;
    for name in ["boards", "stripes"] {
        let place = folder.join(name);
        std::fs::create_dir(&place).map_err(failed(&place))?;
    }
    write_text(&folder.join("sensor.toml"), &true_calibration(&sensor).to_toml().map_err(BoardsError::Toml)?)?;
    render_boards(&sensor, boards, scenario.seed, |name, frame| {
        let size = (frame.width_px(), frame.height_px());
        write_png(frame.pixels(), size, image::ExtendedColorType::L8, &folder.join(name))
    })
}

/// Renders the recording of a melt pool, as [`write_recording`] does that of a stripe.
///
/// # Errors
/// As [`write_recording`].
pub fn write_pool_recording(
    scenario: &PoolScenario,
    target: &Path,
    existing: Existing,
    progress: impl Fn() + Sync,
) -> Result<(), RecordingError> {
    let scene = PoolScene::new(scenario, scenario.seed)?;
    into_folder(target, existing, |folder| {
        write_text(&folder.join("scenario.toml"), &scenario.to_toml()?)?;
        write_pool_truth(&scene, &folder.join("truth.csv"))?;
        let frames = folder.join("frames");
        (0..scene.frame_count()).into_par_iter().try_for_each(|i| {
            let picture = scene.render(i);
            let (bytes, depth): (Vec<u8>, _) = if picture.bits == 16 {
                (picture.greys.iter().flat_map(|grey| grey.to_ne_bytes()).collect(), image::ExtendedColorType::L16)
            } else {
                (picture.greys.iter().map(|&grey| grey as u8).collect(), image::ExtendedColorType::L8)
            };
            write_png(&bytes, (picture.width_px, picture.height_px), depth, &frames.join(frame_name(i)))?;
            progress();
            Ok(())
        })
    })
}

/// Fills a private folder with an empty `frames` in it, and gives it the name `target` when it is complete.
fn into_folder(
    target: &Path,
    existing: Existing,
    fill: impl FnOnce(&Path) -> Result<(), RecordingError>,
) -> Result<(), RecordingError> {
    let folder = WholeFolder::begin(target, existing)?;
    let frames = folder.path().join("frames");
    std::fs::create_dir(&frames).map_err(failed(&frames))?;
    fill(folder.path())?;
    Ok(folder.finish()?)
}

/// Name of a frame's file.
fn frame_name(frame: usize) -> String {
    format!("frame_{frame:06}.png")
}

fn failed(file: &Path) -> impl FnOnce(std::io::Error) -> RecordingError {
    let file = file.to_owned();
    move |source| RecordingError::Write { file, source }
}

fn write_png(
    bytes: &[u8],
    (width, height): (usize, usize),
    depth: image::ExtendedColorType,
    file: &Path,
) -> Result<(), RecordingError> {
    let mut writer = BufWriter::new(File::create(file).map_err(failed(file))?);
    PngEncoder::new_with_quality(&mut writer, CompressionType::Fast, FilterType::Sub)
        .write_image(bytes, width as u32, height as u32, depth)
        .map_err(|source| RecordingError::Encode { file: file.to_owned(), source })?;
    writer.flush().map_err(failed(file))
}

fn write_text(file: &Path, text: &str) -> Result<(), RecordingError> {
    std::fs::write(file, text).map_err(failed(file))
}

fn write_truth(scene: &Scene, scenario: &Scenario, file: &Path) -> Result<(), RecordingError> {
    // Further columns only where there is something to say: older recordings keep their bytes.
    let (beads, second) = (!scenario.plates.beads.is_empty(), scenario.rivals.second_seam.is_some());
    let mut text = String::from("frame,u_px,v_px,x_mm,occluded,gap_px");
    text += if beads { ",bead_left_px,bead_right_px" } else { "" };
    text += if second { ",second_px" } else { "" };
    text += if scenario.camera.is_some() { ",lateral_mm,height_mm\n" } else { "\n" };
    let along = |i: usize| scene.truth(i).seam.map(|seam| scene.axis().along_px(seam));
    let origin_px = (0..scene.frame_count()).find_map(along).unwrap_or(0.0);
    let origin = (0..scene.frame_count()).find_map(|i| scene.truth(i).plane);
    for i in 0..scene.frame_count() {
        let truth = scene.truth(i);
        let seam = truth.seam.map_or_else(
            || ",,".to_owned(),
            |seam| {
                let x_mm = match truth.plane.zip(origin) {
                    Some((plane, origin)) => plane.lateral_mm - origin.lateral_mm,
                    None => scenario.mm_per_px.get() * (scene.axis().along_px(seam) - origin_px),
                };
                format!("{:.4},{:.4},{x_mm:.5}", seam.u_px, seam.v_px)
            },
        );
        let gap = truth.gap_px.map_or_else(String::new, |gap_px| format!("{gap_px:.3}"));
        text += &format!("{i},{seam},{},{gap}", u8::from(truth.occluded));
        if beads {
            text +=
                &truth.bead_toes_px.map_or_else(|| ",,".to_owned(), |[left, right]| format!(",{left:.3},{right:.3}"));
        }
        if second {
            text += &truth.second.map_or_else(|| ",".to_owned(), |p| format!(",{:.4}", scene.axis().along_px(p)));
        }
        if scenario.camera.is_some() {
            text +=
                &truth.plane.map_or_else(|| ",,".to_owned(), |p| format!(",{:.5},{:.5}", p.lateral_mm, p.height_mm));
        }
        text.push('\n');
    }
    write_text(file, &text)
}

/// `frame,u_px,v_px,x_mm,occluded,width_px,width_mm`: the tip and its distance from where it is first, whether no pool is
/// to be seen, and the width; both without the melt's own motion.
fn write_pool_truth(scene: &PoolScene, file: &Path) -> Result<(), RecordingError> {
    let mut text = String::from("frame,u_px,v_px,x_mm,occluded,width_px,width_mm\n");
    let scale = scene.mm_per_px().get();
    let across = |i: usize| scene.scenario().image.travel.across_px(scene.truth(i).tip);
    for i in 0..scene.frame_count() {
        let truth = scene.truth(i);
        let (x_mm, hidden) = (scale * (across(i) - across(0)), u8::from(!truth.visible));
        let (tip, width_px) = (truth.tip, truth.width_px);
        text +=
            &format!("{i},{:.4},{:.4},{x_mm:.5},{hidden},{width_px:.4},{:.5}\n", tip.u_px, tip.v_px, scale * width_px);
    }
    write_text(file, &text)
}

fn write_timestamps(scene: &Scene, file: &Path) -> Result<(), RecordingError> {
    let mut text = String::from("#timestamp [ns],filename\n");
    let first_s = scene.timestamp_s(0);
    for i in 0..scene.frame_count() {
        let nanoseconds = ((scene.timestamp_s(i) - first_s) * 1e9).round() as i64;
        text += &format!("{nanoseconds},{}\n", frame_name(i));
    }
    write_text(file, &text)
}
