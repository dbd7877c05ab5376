//! A folder of images in the natural order of their names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::gray::{Decoded, DecodedSource, SixteenBitScale, decode, file_name, is_sixteen_bit, scale_frames};
use super::{FrameSource, NextFrame, Period, SourceError, SourceFrame, timestamps};

const EXTENSIONS: [&str; 6] = ["png", "jpg", "jpeg", "bmp", "tif", "tiff"];

/// The frames of a folder.
#[derive(Debug, Clone)]
pub struct Folder {
    /// Each frame's file and time \[s\].
    files: Arc<[(PathBuf, f64)]>,
    next: usize,
    scale: Option<SixteenBitScale>,
    period_s: f64,
    notes: Vec<String>,
}

impl Folder {
    /// Lists the images of `folder`, or of the folder `frames` in it; times come from `timestamps.csv` beside them,
    /// else one frame every `period`. What has an image's name and is none, such as a link that leads nowhere, is a frame
    /// that cannot be read: leaving it out would number the others anew.
    pub fn open(folder: &Path, period: Period) -> Result<Self, SourceError> {
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
        let period_s = period.without_own_s();
        let (times, notes) = match stamps {
            None => ((0..paths.len()).map(|i| i as f64 * period_s).collect(), vec![]),
            Some(stamps) => times_of(&paths, &stamps, &folder)?,
        };
        Ok(Self { notes, ..Self::of(paths.into_iter().zip(times).collect(), period_s) })
    }

    /// A recording of one image.
    pub fn single(path: &Path, period: Period) -> Self {
        Self::of([(path.to_owned(), 0.0)].into(), period.without_own_s())
    }

    fn of(files: Arc<[(PathBuf, f64)]>, period_s: f64) -> Self {
        Self { next: 0, scale: scale_of(&files), files, period_s, notes: vec![] }
    }
}

fn decoded((path, time_s): &(PathBuf, f64)) -> SourceFrame<Decoded> {
    SourceFrame { file: file_name(path), time_s: *time_s, picture: decode(path) }
}

impl DecodedSource for Folder {
    fn next_decoded(&mut self) -> Option<SourceFrame<Decoded>> {
        let file = self.files.get(self.next)?;
        self.next += 1;
        Some(decoded(file))
    }

    fn rewound(&self) -> Result<Self, SourceError> {
        Ok(Self { next: 0, ..self.clone() })
    }
}

impl FrameSource for Folder {
    fn next_frame(&mut self) -> Option<SourceFrame> {
        self.next_encoded().map(NextFrame::decoded)
    }

    fn next_encoded(&mut self) -> Option<NextFrame> {
        let (files, number, scale) = (Arc::clone(&self.files), self.next, self.scale);
        files.get(number)?;
        self.next += 1;
        Some(NextFrame::Encoded(Box::new(move || decoded(&files[number]).in_gray(scale))))
    }

    fn skip(&mut self, frames: usize) {
        self.next = self.next.saturating_add(frames).min(self.files.len());
    }

    fn frame_count(&self) -> Option<usize> {
        Some(self.files.len())
    }

    fn kind(&self) -> &'static str {
        "folder"
    }

    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn sixteen_bit_scale(&self) -> Option<SixteenBitScale> {
        self.scale
    }

    fn again(&self) -> Result<Box<dyn FrameSource>, SourceError> {
        Ok(Box::new(self.rewound()?))
    }
}

/// The scale of a recording of 16 bits, from frames spread over it; where none of these can be read, from the first one
/// that can.
fn scale_of(files: &[(PathBuf, f64)]) -> Option<SixteenBitScale> {
    let depth = |path: &PathBuf| is_sixteen_bit(path).map(|is_deep| (path.clone(), is_deep));
    let mut sample: Vec<(PathBuf, bool)> = scale_frames(files.len()).filter_map(|i| depth(&files[i].0)).collect();
    if sample.is_empty() {
        sample.extend(files.iter().find_map(|(path, _)| depth(path)));
    }
    let deep = sample.into_iter().filter(|(_, is_deep)| *is_deep);
    SixteenBitScale::of_frames(deep.filter_map(|(path, _)| decode(&path).ok()))
}

fn images_in(folder: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let failed = |source| SourceError::Open { path: folder.to_owned(), source };
    let mut paths = vec![];
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_image = path.extension().is_some_and(|e| EXTENSIONS.iter().any(|known| e.eq_ignore_ascii_case(known)));
        if is_image && !file_name(&path).starts_with('.') {
            paths.push(path);
        }
    }
    paths.sort_by(|a, b| natord::compare(&file_name(a), &file_name(b)).then_with(|| a.cmp(b)));
    Ok(paths)
}

/// The stamp of each file, and a note where they do not rise with the order of the names.
fn times_of(
    paths: &[PathBuf],
    stamps: &std::collections::BTreeMap<String, f64>,
    folder: &Path,
) -> Result<(Vec<f64>, Vec<String>), SourceError> {
    let wrong = |problem: String| SourceError::TimeStamps { path: folder.join(timestamps::FILE_NAME), problem };
    let mut times: Vec<f64> = Vec::with_capacity(paths.len());
    let mut not_later = vec![];
    for path in paths {
        let name = file_name(path);
        let &time_s = stamps.get(&name).ok_or_else(|| wrong(format!("{name} has no time stamp: add its line")))?;
        if times.last().is_some_and(|&last| time_s <= last) {
            not_later.push(name);
        }
        times.push(time_s);
    }
    let note = not_later.first().map(|first| {
        let (count, file) = (not_later.len(), timestamps::FILE_NAME);
        format!("{file}: frames that are not later than the one before: {count}, first {first}; used as they are")
    });
    Ok((times, note.into_iter().collect()))
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
    fn time_stamps_are_read_and_said_when_they_do_not_rise() {
        let folder = tempfile::tempdir().unwrap();
        png(&folder.path().join("a.png"), 1);
        png(&folder.path().join("b.png"), 1);
        let stamps = folder.path().join("timestamps.csv");
        std::fs::write(&stamps, "#timestamp [ns],filename\n5000000000,a.png\n5250000000,b.png\n").unwrap();
        let mut source = open(folder.path(), 0.2).unwrap();
        let times: Vec<f64> = std::iter::from_fn(|| source.next_frame()).map(|frame| frame.time_s).collect();
        assert_eq!(times, [0.0, 0.25]);
        assert!(source.notes().is_empty());
        for (text, times_s) in [("5,a.png\n5,b.png\n", [0.0, 0.0]), ("1000000005,a.png\n5,b.png\n", [1.0, 0.0])] {
            std::fs::write(&stamps, text).unwrap();
            let mut source = open(folder.path(), 0.2).unwrap();
            assert!(source.notes()[0].contains("first b.png") && source.notes().len() == 1);
            let times: Vec<f64> = std::iter::from_fn(|| source.next_frame()).map(|frame| frame.time_s).collect();
            assert_eq!(times, times_s);
        }
        std::fs::write(
            &stamps,
            "\u{feff}#timestamp [ns],filename\r\n-9223372036854775808,a.png\r\n9223372036854775807,b.png\r\n",
        )
        .unwrap();
        assert!(open(folder.path(), 0.2).unwrap().notes().is_empty(), "a byte order mark and any number of 64 bits");
        std::fs::write(&stamps, "5,a.png\nnan,b.png\n").unwrap();
        let error = open(folder.path(), 0.2).err().unwrap().to_string();
        assert!(error.contains("timestamps.csv: line 2 is not"), "{error}");
        std::fs::write(&stamps, "5,a.png\n").unwrap();
        assert!(open(folder.path(), 0.2).err().unwrap().to_string().contains("b.png has no time stamp"));
    }

    #[test]
    fn the_scale_of_sixteen_bits_comes_from_the_whole_recording() {
        let folder = tempfile::tempdir().unwrap();
        for n in 0..40_u16 {
            let grey = if n < 20 { 4_u16 } else { 4000 };
            let deep = image::ImageBuffer::from_pixel(12, 8, image::Luma([grey]));
            deep.save(folder.path().join(format!("{n:02}.png"))).unwrap();
        }
        std::fs::write(folder.path().join("00.png"), b"").unwrap();
        assert_eq!(open(folder.path(), 0.2).unwrap().sixteen_bit_scale(), Some(SixteenBitScale { white: 4095 }));
        // Of the frames that are sampled none can be read.
        for n in scale_frames(40) {
            std::fs::write(folder.path().join(format!("{n:02}.png")), b"").unwrap();
        }
        assert!(open(folder.path(), 0.2).unwrap().sixteen_bit_scale().is_some());
    }

    #[cfg(unix)]
    #[test]
    fn what_has_an_images_name_and_is_none_is_an_unreadable_frame() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        png(&at("0.png"), 1);
        std::os::unix::fs::symlink(at("gone"), at("1.png")).unwrap();
        std::fs::create_dir(at("2.png")).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(at("3.png")).status().unwrap().success());
        png(&at("4.png"), 1);
        let mut source = open(folder.path(), 0.2).unwrap();
        let frames: Vec<_> = std::iter::from_fn(|| source.next_frame()).collect();
        let readable: Vec<bool> = frames.iter().map(|frame| frame.picture.is_ok()).collect();
        assert_eq!(readable, [true, false, false, false, true]);
        assert_eq!(frames[4].time_s, 0.8);
        assert!(matches!(open(&at("3.png"), 0.2), Err(SourceError::NotAFile(_))));
    }

    #[test]
    fn a_folder_without_images_says_so() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(open(folder.path(), 0.2), Err(SourceError::NoImages(_))));
    }
}
