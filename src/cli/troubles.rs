//! What is wrong with a recording, on standard error: a line each, and not more than a person reads.

use std::path::{Path, PathBuf};

use seamtrack::source::FrameError;

use super::say::{one_line, tell};

/// Frames that are named one by one; the others are counted. Chosen: they fit on a screen beside the results.
const NAMED_FRAMES: usize = 8;

/// The troubles of one recording.
pub struct Troubles {
    recording: PathBuf,
    unreadable: usize,
}

impl Troubles {
    /// None yet.
    pub fn of(recording: &Path) -> Self {
        Self { recording: recording.to_owned(), unreadable: 0 }
    }

    /// Says what is to be known of the recording as a whole.
    pub fn note(&self, note: &str) {
        tell(&format!("{}: {note}", self.recording.display()));
    }

    /// Says why a frame cannot be used.
    pub fn unreadable(&mut self, frame: usize, error: &FrameError) {
        self.unreadable += 1;
        if self.unreadable <= NAMED_FRAMES {
            self.note(&format!("frame {frame}: {}", one_line(error)));
        }
    }

    /// Says how many more frames there were.
    pub fn end(&self) {
        if self.unreadable > NAMED_FRAMES {
            let more = self.unreadable - NAMED_FRAMES;
            self.note(&format!("{more} more frames could not be read; path.csv says which"));
        }
    }
}
