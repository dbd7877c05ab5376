//! Composites a built-in scene's arc, smoke and spatter on recorded frames:
//! `cargo run --example composite_arc -- FRAMES_DIR SCENE SEED OUT_DIR [horizontal|vertical]`
//!
//! SCENE is a name from `seamtrack synth --list`, such as `hairline-medium`; only its light is used, in the size of the
//! recording. A frame that repeats the one before stays a repetition. Files keep their names' stems, as PNG.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use seamtrack::frame::GrayFrame;
use seamtrack::synth::{Scene, builtin};
use seamtrack::units::StripeAxis;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, scene, seed, out, axis) = match arguments.as_slice() {
        [folder, scene, seed, out] => (folder, scene, seed, out, StripeAxis::Horizontal),
        [folder, scene, seed, out, axis] if axis == "vertical" => (folder, scene, seed, out, StripeAxis::Vertical),
        [folder, scene, seed, out, axis] if axis == "horizontal" => (folder, scene, seed, out, StripeAxis::Horizontal),
        _ => bail!("usage: composite_arc FRAMES_DIR SCENE SEED OUT_DIR [horizontal|vertical]"),
    };
    let files = images(Path::new(folder))?;
    let first = read(&files[0])?;
    let mut scenario = builtin::scenario(scene)?;
    scenario.image.stripe = axis;
    (scenario.image.width_px, scenario.image.height_px) = (first.width_px(), first.height_px());
    scenario.path.clear();
    scenario.recorder = seamtrack::synth::scenario::Recorder::default();
    scenario.frames = files.len();
    let light = Scene::new(&scenario, seed.parse().context("SEED is a whole number")?)?;
    std::fs::create_dir_all(out).with_context(|| format!("cannot create {out}"))?;

    let mut previous: Option<(GrayFrame, GrayFrame)> = None;
    let mut moment = 0;
    for file in &files {
        let frame = read(file)?;
        ensure!(
            (frame.width_px(), frame.height_px()) == (first.width_px(), first.height_px()),
            "{}: its size differs from the first image's",
            file.display()
        );
        let composited = match previous.take() {
            Some((original, composited)) if original == frame => composited,
            _ => {
                moment += 1;
                light.composite(moment - 1, &frame)
            }
        };
        let target = Path::new(out).join(file.with_extension("png").file_name().context("a file without a name")?);
        image::save_buffer(
            &target,
            composited.pixels(),
            frame.width_px() as u32,
            frame.height_px() as u32,
            image::ExtendedColorType::L8,
        )
        .with_context(|| format!("cannot write {}", target.display()))?;
        previous = Some((frame, composited));
    }
    println!("{} frames in {out}", files.len());
    Ok(())
}

/// The folder's images in natural order.
fn images(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .with_context(|| format!("cannot read {}", folder.display()))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<_>>()?;
    files.retain(|file| image::ImageFormat::from_path(file).is_ok());
    files.sort_by(|a, b| natord::compare(&a.to_string_lossy(), &b.to_string_lossy()));
    ensure!(!files.is_empty(), "{} holds no image", folder.display());
    Ok(files)
}

fn read(file: &Path) -> Result<GrayFrame> {
    let image = image::open(file).with_context(|| format!("cannot read {}", file.display()))?.into_luma8();
    Ok(GrayFrame::new(image.width() as usize, image.height() as usize, image.into_raw())?)
}
