//! Small JPEGs of a bounded number of frames, chosen while the recording streams by.
//!
//! Every k-th frame is kept, and always the frames that may turn out worst: the largest NIS, the lowest PSR, the
//! first of every stretch without an observation. When the JPEGs outgrow their budget, k doubles. What is kept
//! depends on the frames and their order alone.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::thread::JoinHandle;

use image::{ImageBuffer, Luma};
use jpeg_encoder::{ColorType, Encoder};
use serde::{Deserialize, Serialize};

use super::atomic::{ResultsError, write_atomically};
use super::marks::FrameMarks;
use super::results::{PathRow, Status};
use crate::frame::GrayFrame;

/// Folder beside `path.csv` that holds the JPEGs and their index.
pub const FOLDER: &str = "thumbnails";
/// Bytes of JPEG kept by default: as base64 they fill a page of 10 MB.
pub const DEFAULT_BUDGET_BYTES: usize = 7_000_000;
/// Widest thumbnail \[px\]: a 640 × 480 frame keeps its resolution.
const MAX_WIDTH_PX: usize = 640;
/// JPEG quality: speckle is visible, a 640 × 480 frame takes 10 to 30 kB.
const JPEG_QUALITY: u8 = 60;
/// What most frames take at that quality: the first guess of k.
const TYPICAL_JPEG_BYTES: usize = 15_000;
/// Kept per reason, above what [`places`](super::places::places) lists: it skips neighbours.
const WORST_KEPT: usize = 24;
/// First frames of stretches without an observation that are kept.
const EPISODES_KEPT: usize = 48;

/// A stored frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Thumbnail {
    /// Number of the frame.
    pub frame: usize,
    /// What the tracker saw in it.
    pub marks: FrameMarks,
    /// Chosen for itself, not as every k-th.
    pub worst: bool,
    /// The JPEG file; beside the index on disk.
    #[serde(skip)]
    pub jpeg: Vec<u8>,
}

/// Collects thumbnails during a run: [`offer`](Self::offer) every frame, then [`write`](Self::write).
#[derive(Debug)]
pub struct ThumbnailStore {
    budget_bytes: usize,
    bytes: usize,
    every: usize,
    encoding: Option<(usize, JoinHandle<Vec<u8>>)>,
    kept: BTreeMap<usize, Thumbnail>,
    highest_nis: Ranking,
    lowest_psr: Ranking,
    episodes: Vec<usize>,
    last_status: Status,
}

impl ThumbnailStore {
    /// A store of `budget_bytes` of JPEG. Knowing the number of frames saves encoding what is thinned out later.
    #[must_use]
    pub fn new(budget_bytes: usize, expected_frames: Option<usize>) -> Self {
        let fitting = (budget_bytes / TYPICAL_JPEG_BYTES).max(1);
        let every = expected_frames.unwrap_or(0).div_ceil(fitting).next_power_of_two();
        Self {
            budget_bytes,
            bytes: 0,
            every,
            encoding: None,
            kept: BTreeMap::new(),
            highest_nis: Ranking::default(),
            lowest_psr: Ranking::default(),
            episodes: Vec::new(),
            last_status: Status::Seeking,
        }
    }

    /// Consider one frame with its row and marks; frames come in order. A frame that is kept is copied and encoded
    /// on a thread of its own, one at a time, while the next one is tracked.
    pub fn offer(&mut self, row: &PathRow, frame: &GrayFrame, marks: &FrameMarks) {
        let begins_episode = row.status != self.last_status && row.status != Status::Tracked;
        self.last_status = row.status;
        let mut wanted = row.frame.is_multiple_of(self.every);
        if begins_episode && self.episodes.len() < EPISODES_KEPT {
            self.episodes.push(row.frame);
            wanted = true;
        }
        wanted |= row.nis.is_some_and(|nis| self.highest_nis.enter(row.frame, nis));
        wanted |= row.psr.is_some_and(|psr| self.lowest_psr.enter(row.frame, -psr));
        if !wanted {
            return;
        }
        self.finish_encoding();
        if self.bytes > self.budget_bytes {
            self.thin();
        }
        let (marks, frame) = (marks.clone(), frame.clone());
        self.kept.insert(row.frame, Thumbnail { frame: row.frame, marks, worst: false, jpeg: Vec::new() });
        self.encoding = Some((row.frame, std::thread::spawn(move || encode(&frame))));
    }

    fn finish_encoding(&mut self) {
        if let Some((frame, encoding)) = self.encoding.take()
            && let Some(thumbnail) = self.kept.get_mut(&frame)
        {
            thumbnail.jpeg = encoding.join().unwrap_or_default();
            self.bytes += thumbnail.jpeg.len();
        }
    }

    fn is_worst(&self, frame: usize) -> bool {
        self.episodes.contains(&frame) || self.highest_nis.holds(frame) || self.lowest_psr.holds(frame)
    }

    /// Drop former worst frames, then double k, until the budget is met or only worst frames are left.
    fn thin(&mut self) {
        loop {
            let mut kept = std::mem::take(&mut self.kept);
            kept.retain(|&frame, _| frame.is_multiple_of(self.every) || self.is_worst(frame));
            self.bytes = kept.values().map(|thumbnail| thumbnail.jpeg.len()).sum();
            self.kept = kept;
            if self.bytes <= self.budget_bytes || self.kept.keys().all(|&frame| self.is_worst(frame)) {
                return;
            }
            self.every *= 2;
        }
    }

    /// The thumbnails in the order of their frames.
    #[must_use]
    pub fn into_thumbnails(mut self) -> Vec<Thumbnail> {
        self.finish_encoding();
        self.thin();
        let worst: Vec<bool> = self.kept.keys().map(|&frame| self.is_worst(frame)).collect();
        self.kept.into_values().zip(worst).map(|(thumbnail, worst)| Thumbnail { worst, ..thumbnail }).collect()
    }

    /// Write `dir/thumbnails`, which must not exist.
    ///
    /// # Errors
    /// When the folder exists or cannot be written.
    pub fn write(self, dir: &Path) -> Result<(), ResultsError> {
        let folder = dir.join(FOLDER);
        std::fs::create_dir(&folder).map_err(|source| ResultsError::Write { path: folder.clone(), source })?;
        let thumbnails = self.into_thumbnails();
        for thumbnail in &thumbnails {
            write_atomically(&folder.join(file_name(thumbnail.frame)), |file| file.write_all(&thumbnail.jpeg))?;
        }
        write_atomically(&folder.join("index.json"), |file| Ok(serde_json::to_writer(file, &thumbnails)?))
    }
}

/// Read `dir/thumbnails`; none when the run stored none.
///
/// # Errors
/// When the index or a JPEG cannot be read.
pub fn read_thumbnails(dir: &Path) -> Result<Vec<Thumbnail>, ResultsError> {
    let index = dir.join(FOLDER).join("index.json");
    if !index.exists() {
        return Ok(Vec::new());
    }
    let read = |path: &Path| std::fs::read(path).map_err(|source| ResultsError::Read { path: path.to_owned(), source });
    let mut thumbnails: Vec<Thumbnail> =
        serde_json::from_slice(&read(&index)?).map_err(|error| ResultsError::content(&index, error))?;
    for thumbnail in &mut thumbnails {
        thumbnail.jpeg = read(&dir.join(FOLDER).join(file_name(thumbnail.frame)))?;
    }
    Ok(thumbnails)
}

fn file_name(frame: usize) -> String {
    format!("{frame:06}.jpg")
}

/// The frame as a grey JPEG of at most [`MAX_WIDTH_PX`] columns.
fn encode(frame: &GrayFrame) -> Vec<u8> {
    let mut jpeg = Vec::new();
    let (width, height) = (frame.width_px() as u32, frame.height_px() as u32);
    let shrink = frame.width_px().div_ceil(MAX_WIDTH_PX) as u32;
    let encoder = Encoder::new(&mut jpeg, JPEG_QUALITY);
    let encode = |pixels: &[u8], (width, height): (u32, u32)| {
        let side = |px: u32| u16::try_from(px).unwrap_or(u16::MAX);
        encoder.encode(pixels, side(width), side(height), ColorType::Luma)
    };
    let encoded = match ImageBuffer::<Luma<u8>, &[u8]>::from_raw(width, height, frame.pixels()) {
        Some(full) if shrink > 1 => {
            let small = image::imageops::thumbnail(&full, (width / shrink).max(1), (height / shrink).max(1));
            encode(small.as_raw(), small.dimensions())
        }
        _ => encode(frame.pixels(), (width, height)),
    };
    // Encoding into memory fails only for a side that JPEG has no number for: such a frame has no thumbnail.
    if encoded.is_err() {
        jpeg.clear();
    }
    jpeg
}

/// The frames of the [`WORST_KEPT`] largest scores so far.
#[derive(Debug, Default)]
struct Ranking(Vec<(usize, f64)>);

impl Ranking {
    /// Whether `frame` belongs to the largest now that it is known.
    fn enter(&mut self, frame: usize, score: f64) -> bool {
        let place = self.0.partition_point(|&(_, other)| other >= score);
        self.0.insert(place, (frame, score));
        self.0.truncate(WORST_KEPT);
        place < WORST_KEPT
    }

    fn holds(&self, frame: usize) -> bool {
        self.0.iter().any(|&(other, _)| other == frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offered(frames: usize, budget_bytes: usize, expected: Option<usize>) -> Vec<Thumbnail> {
        let mut store = ThumbnailStore::new(budget_bytes, expected);
        for frame in 0..frames {
            let image = GrayFrame::filled(64, 48, (frame % 256) as u8).unwrap();
            let status = if frame == 777 { Status::Lost } else { Status::Tracked };
            let row = PathRow {
                nis: Some(if frame == 501 { 99.0 } else { 1.0 - frame as f64 * 1e-6 }),
                psr: Some(if frame == 303 { 2.0 } else { 10.0 + frame as f64 * 1e-6 }),
                ..PathRow::empty(frame, String::new(), 0.0, status)
            };
            store.offer(&row, &image, &FrameMarks::default());
        }
        store.into_thumbnails()
    }

    #[test]
    fn a_budget_is_kept_with_every_kth_and_the_worst_frames() {
        let kept = offered(1000, 100_000, None);
        assert!(kept.iter().map(|t| t.jpeg.len()).sum::<usize>() <= 100_000);
        for frame in [501, 303, 777] {
            assert!(kept.iter().any(|t| t.frame == frame && t.worst), "frame {frame} is kept");
        }
        let regular: Vec<_> = kept.iter().filter(|t| !t.worst).map(|t| t.frame).collect();
        let every = regular[1] - regular[0];
        assert!(every > 1 && every.is_power_of_two());
        assert!(regular.iter().all(|frame| frame.is_multiple_of(every)));
    }

    #[test]
    fn a_budget_that_suffices_keeps_every_frame() {
        assert_eq!(offered(100, DEFAULT_BUDGET_BYTES, None).len(), 100);
    }

    #[test]
    fn reading_gives_back_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = ThumbnailStore::new(1_000_000, Some(2));
        let marks = FrameMarks { stripe: vec![crate::units::PixelPoint::new(1.0, 2.5)], roi: None };
        let image = GrayFrame::filled(1300, 4, 7).unwrap();
        store.offer(&PathRow::empty(0, String::new(), 0.0, Status::Tracked), &image, &marks);
        store.write(folder.path()).unwrap();
        let read = read_thumbnails(folder.path()).unwrap();
        assert_eq!((read.len(), &read[0].marks), (1, &marks));
        assert_eq!(image::load_from_memory(&read[0].jpeg).unwrap().width(), 433);
    }

    #[test]
    fn a_run_without_thumbnails_has_none() {
        assert!(read_thumbnails(tempfile::tempdir().unwrap().path()).unwrap().is_empty());
    }
}
