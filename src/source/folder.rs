//! A folder of images in the natural order of their names.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use super::gray::{Decoded, DecodedSource, SixteenBitScale, decode, file_name};
use super::{FrameSource, SourceError, SourceFrame, timestamps};

const EXTENSIONS: [&str; 6] = ["png", "jpg", "jpeg", "bmp", "tif", "tiff"];

/// Frames that a 16-bit recording's scale is taken from. Chosen: enough to meet the stripe, quick to read.
const SCALE_FRAMES: usize = 5;

/// The frames of a folder.
#[derive(Debug)]
pub struct Folder {
    files: VecDeque<(PathBuf, f64)>,
    count: usize,
    scale: Option<SixteenBitScale>,
}

impl Folder {
    /// Lists the images of `folder`, or of the folder `frames` in it; times come from `timestamps.csv` beside them,
    /// else one frame every `period_s`.
    pub fn open(folder: &Path, period_s: f64) -> Result<Self, SourceError> {
        let mut folder = folder.to_owned();
        let mut paths = images_in(&folder)?;
        if paths.is_empty() && folder.join("frames").is_dir() {
            folder.push("frames");
            paths = images_in(&folder)?;
        }
        if paths.is_empty() {
            return Err(SourceError::NoImages(folder));
        }
        let stamps = match timestamps::read(&folder)? {
            None => match folder.parent() {
                Some(parent) if folder.ends_with("frames") => timestamps::read(parent)?,
                _ => None,
            },
            found => found,
        };
        let times = match stamps {
            None => (0..paths.len()).map(|i| i as f64 * period_s).collect(),
            Some(stamps) => times_of(&paths, &stamps, &folder)?,
        };
        Ok(Self::of(paths.into_iter().zip(times).collect()))
    }

    /// A recording of one image.
    pub fn single(path: &Path) -> Self {
        Self::of(VecDeque::from([(path.to_owned(), 0.0)]))
    }

    fn of(files: VecDeque<(PathBuf, f64)>) -> Self {
        let first: Vec<Decoded> = match files.front().map(|(path, _)| decode(path)) {
            Some(Ok(Decoded::Gray16 { .. })) => {
                files.iter().take(SCALE_FRAMES).filter_map(|(path, _)| decode(path).ok()).collect()
            }
            _ => vec![],
        };
        Self { count: files.len(), files, scale: SixteenBitScale::from_first_frames(&first) }
    }
}

impl DecodedSource for Folder {
    fn next_decoded(&mut self) -> Option<SourceFrame<Decoded>> {
        let (path, time_s) = self.files.pop_front()?;
        Some(SourceFrame { file: file_name(&path), time_s, picture: decode(&path) })
    }
}

impl FrameSource for Folder {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        let scale = self.scale;
        self.next_decoded().map(|frame| frame.in_gray(scale))
    }

    fn frame_count(&self) -> Option<usize> {
        Some(self.count)
    }

    fn kind(&self) -> &'static str {
        "folder"
    }

    fn sixteen_bit_scale(&self) -> Option<SixteenBitScale> {
        self.scale
    }
}

fn images_in(folder: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let failed = |source| SourceError::Open { path: folder.to_owned(), source };
    let mut paths = vec![];
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_image = path.extension().is_some_and(|e| EXTENSIONS.iter().any(|known| e.eq_ignore_ascii_case(known)));
        if is_image && !file_name(&path).starts_with('.') && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort_by(|a, b| natord::compare(&file_name(a), &file_name(b)).then_with(|| a.cmp(b)));
    Ok(paths)
}

/// The stamp of each file; they must rise with the order of the names.
fn times_of(
    paths: &[PathBuf],
    stamps: &std::collections::BTreeMap<String, f64>,
    folder: &Path,
) -> Result<Vec<f64>, SourceError> {
    let wrong = |problem: String| SourceError::TimeStamps { path: folder.join(timestamps::FILE_NAME), problem };
    let mut times: Vec<f64> = Vec::with_capacity(paths.len());
    for path in paths {
        let name = file_name(path);
        let &time_s = stamps.get(&name).ok_or_else(|| wrong(format!("{name} has no time stamp: add its line")))?;
        if times.last().is_some_and(|&last| time_s <= last) {
            return Err(wrong(format!("the time stamp of {name} is not later than that of the frame before it")));
        }
        times.push(time_s);
    }
    Ok(times)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::open;

    fn names(folder: &Path) -> Vec<String> {
        let mut source = open(folder, 0.2).unwrap();
        std::iter::from_fn(|| source.next_frame()).map(|frame| frame.file).collect()
    }

    fn png(path: &Path, grey: u8) {
        image::GrayImage::from_pixel(12, 8, image::Luma([grey])).save(path).unwrap();
    }

    #[test]
    fn names_are_read_in_natural_order_and_a_truncated_file_does_not_end_the_recording() {
        let folder = tempfile::tempdir().unwrap();
        for n in [1, 2, 10] {
            png(&folder.path().join(format!("frame_{n}.png")), n);
        }
        std::fs::write(folder.path().join("frame_3.png"), b"").unwrap();
        std::fs::write(folder.path().join("notes.txt"), b"no image").unwrap();
        assert_eq!(names(folder.path()), ["frame_1.png", "frame_2.png", "frame_3.png", "frame_10.png"]);
        let mut source = open(folder.path(), 0.2).unwrap();
        let readable: Vec<bool> =
            std::iter::from_fn(|| source.next_frame()).map(|frame| frame.picture.is_ok()).collect();
        assert_eq!(readable, [true, true, false, true]);
    }

    #[test]
    fn time_stamps_are_read_and_must_rise() {
        let folder = tempfile::tempdir().unwrap();
        png(&folder.path().join("a.png"), 1);
        png(&folder.path().join("b.png"), 1);
        let stamps = folder.path().join("timestamps.csv");
        std::fs::write(&stamps, "#timestamp [ns],filename\n5000000000,a.png\n5250000000,b.png\n").unwrap();
        let mut source = open(folder.path(), 0.2).unwrap();
        let times: Vec<f64> = std::iter::from_fn(|| source.next_frame()).map(|frame| frame.time_s).collect();
        assert_eq!(times, [0.0, 0.25]);
        std::fs::write(&stamps, "5,a.png\n5,b.png\n").unwrap();
        assert!(open(folder.path(), 0.2).err().unwrap().to_string().contains("b.png is not later"));
        std::fs::write(&stamps, "5,a.png\n").unwrap();
        assert!(open(folder.path(), 0.2).err().unwrap().to_string().contains("b.png has no time stamp"));
    }

    #[test]
    fn a_folder_without_images_says_so() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(open(folder.path(), 0.2), Err(SourceError::NoImages(_))));
    }
}
