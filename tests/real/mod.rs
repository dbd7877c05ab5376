//! Real recordings for tests, reached through `SEAMTRACK_REAL_DATA`; they are not part of the repository.

pub mod paint;

use std::path::{Path, PathBuf};

use seamtrack::frame::GrayFrame;

/// One frame of a scan, its stripe turned horizontal, with the reference along the stripe.
pub struct Shot {
    pub frame: GrayFrame,
    pub repeated: bool,
    /// u of the annotated seam \[px\], where the annotator saw one.
    pub reference_px: Option<f64>,
}

/// The folder of the recordings; says on stderr when it is not set.
pub fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("SEAMTRACK_REAL_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("SKIPPED: set SEAMTRACK_REAL_DATA to the folder of the real recordings to run this test");
    }
    folder
}

/// A grey image file.
pub fn read_gray(path: &Path) -> GrayFrame {
    let image = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).into_luma8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    GrayFrame::new(width, height, image.into_raw()).unwrap()
}

/// All frames of a scan with a vertical stripe, transposed.
pub fn scan(folder: &Path, name: &str) -> Vec<Shot> {
    let folder = folder.join(name);
    let mut table = csv::Reader::from_path(folder.join("seam_reference.csv")).unwrap();
    let mut shots: Vec<Shot> = Vec::new();
    for row in table.deserialize() {
        let row: std::collections::BTreeMap<String, String> = row.unwrap();
        let frame = read_gray(&folder.join("frames").join(&row["file"])).transposed();
        shots.push(Shot {
            repeated: shots.last().is_some_and(|last| last.frame == frame),
            frame,
            reference_px: row["seam_y"].parse().ok(),
        });
    }
    shots
}
