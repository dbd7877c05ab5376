//! Contact sheets of the built-in scenes, for docs/scenes.md.
//!
//! `cargo run --example contact_sheets -- docs/pictures`, or with scene names behind the folder for these only, each
//! written as SCENE.png at full size.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use image::codecs::png::{CompressionType, FilterType as PngFilter, PngEncoder};
use image::imageops::{FilterType, overlay, resize};
use image::{ExtendedColorType, GrayImage, ImageEncoder};
use rayon::prelude::*;
use seamtrack::synth::{Scene, builtin};

/// Width and height of one picture in a sheet \[px\].
const CELL_PX: (u32, u32) = (280, 210);
/// Grey levels of a sheet are multiples of this: sensor noise makes large files and shows nothing at this size.
const GREY_STEP: u8 = 6;
/// Pictures in a row: before arc-on, then under it.
const COLUMNS: usize = 4;

/// One picture each of plates that fight back.
const PLATES: [&str; 28] = [
    "marks-dark-butt-severe",
    "marks-bright-lap-severe",
    "slag-vgroove-severe",
    "hole-flat-severe",
    "bar-dark-butt-severe",
    "scratch-butt-severe",
    "spatter-stuck-fillet-severe",
    "grinding-butt-severe",
    "mill-scale-lap-severe",
    "dark-plate-vgroove-severe",
    "pipe-butt-severe",
    "dished-vgroove-medium",
    "pipe-on-plate-fillet-medium",
    "bead-root-vgroove-medium",
    "bead-fill-vgroove-severe",
    "bead-side-vgroove-severe",
    "bead-cap-vgroove-severe",
    "change-bevel-butt-mild",
    "reflection-fillet-severe",
    "reflection-vgroove-severe",
    "other-stripe-lap-severe",
    "two-seams-lap-medium",
    "dirt-butt-severe",
    "dead-columns-flat-severe",
    "line-gap-flat-severe",
    "cable-fillet-severe",
    "shadow-butt-medium",
    "corrugated-flat-severe",
];

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().context("usage: contact_sheets FOLDER [SCENE]...")?);
    std::fs::create_dir_all(&folder)?;
    let names: Vec<String> = arguments.collect();
    if names.is_empty() {
        let sheets: [(&str, &[&str]); 5] = [
            ("scenes-paper", &["A-butt", "B-lap", "C-butt-severe"]),
            ("scenes-joints", &["D-vgroove-sine", "E-fillet", "F-lap-false-stripe"]),
            ("scenes-heavy", &["G-butt-widening", "H-butt-covers", "I-butt-heavy"]),
            ("scenes-special", &["K-butt-narrow", "tack", "flat"]),
            ("scenes-hairline", &["hairline", "hairline-arc"]),
        ];
        for (sheet, scenes) in sheets {
            write_sheet(&folder.join(format!("{sheet}.png")), scenes)?;
        }
        write_gallery(&folder.join("scenes-plates.png"), &PLATES)?;
    }
    for name in &names {
        let pictures = pictures(name, 1, None)?;
        save(&folder.join(format!("{name}.png")), &tiled(&[pictures]))?;
    }
    Ok(())
}

/// One picture of each scene, under the arc.
fn write_gallery(file: &Path, scenes: &[&str]) -> Result<()> {
    let cells = scenes
        .iter()
        .zip(1..)
        .map(|(name, seed)| Ok(pictures(name, seed, Some(CELL_PX))?.swap_remove(2)))
        .collect::<Result<Vec<_>>>()?;
    let rows: Vec<Vec<GrayImage>> = cells.chunks(COLUMNS).map(<[GrayImage]>::to_vec).collect();
    write_coarse(file, tiled(&rows))
}

fn write_sheet(file: &Path, scenes: &[&str]) -> Result<()> {
    let rows =
        scenes.iter().zip(1..).map(|(name, seed)| pictures(name, seed, Some(CELL_PX))).collect::<Result<Vec<_>>>()?;
    write_coarse(file, tiled(&rows))
}

fn write_coarse(file: &Path, mut sheet: GrayImage) -> Result<()> {
    let coarse =
        |grey: &mut u8| *grey = ((f32::from(*grey) / f32::from(GREY_STEP)).round() as u8).saturating_mul(GREY_STEP);
    sheet.iter_mut().for_each(coarse);
    save(file, &sheet)
}

fn save(file: &Path, sheet: &GrayImage) -> Result<()> {
    let writer = BufWriter::new(File::create(file).with_context(|| format!("cannot write {}", file.display()))?);
    PngEncoder::new_with_quality(writer, CompressionType::Best, PngFilter::Adaptive)
        .write_image(sheet.as_raw(), sheet.width(), sheet.height(), ExtendedColorType::L8)
        .with_context(|| format!("cannot write {}", file.display()))
}

/// A scene's pictures: one early, the others spread over the recording, a covered one where there is any.
fn pictures(name: &str, seed: u64, size: Option<(u32, u32)>) -> Result<Vec<GrayImage>> {
    let scene = Scene::new(&builtin::scenario(name)?, seed)?;
    let frames = scene.frame_count();
    let mut chosen = vec![4.min(frames - 1), frames * 3 / 10, frames * 6 / 10, frames * 9 / 10];
    if let Some(covered) = (0..frames).find(|&i| scene.truth(i).occluded) {
        chosen[2] = covered;
    }
    chosen
        .into_par_iter()
        .map(|i| {
            let frame = scene.render(i);
            let picture =
                GrayImage::from_raw(frame.width_px() as u32, frame.height_px() as u32, frame.pixels().to_vec())
                    .context("a frame holds as many bytes as pixels")?;
            Ok(match size {
                Some((width, height)) if picture.height() > picture.width() => {
                    let scaled = height * picture.width() / picture.height();
                    let mut cell = GrayImage::new(width, height);
                    overlay(
                        &mut cell,
                        &resize(&picture, scaled, height, FilterType::Triangle),
                        ((width - scaled) / 2).into(),
                        0,
                    );
                    cell
                }
                Some((width, height)) => resize(&picture, width, height, FilterType::Triangle),
                None => picture,
            })
        })
        .collect()
}

fn tiled(rows: &[Vec<GrayImage>]) -> GrayImage {
    const GAP_PX: u32 = 3;
    let (width, height) = rows[0][0].dimensions();
    let (columns, lines) = (COLUMNS.min(rows[0].len()) as u32, rows.len() as u32);
    let size = ((width + GAP_PX) * columns - GAP_PX, (height + GAP_PX) * lines - GAP_PX);
    let mut sheet = GrayImage::from_pixel(size.0, size.1, image::Luma([128]));
    for (j, row) in rows.iter().enumerate() {
        for (i, picture) in row.iter().enumerate() {
            let at = (i as i64 * i64::from(width + GAP_PX), j as i64 * i64::from(height + GAP_PX));
            overlay(&mut sheet, picture, at.0, at.1);
        }
    }
    sheet
}
