//! What a live run leaves: an MCAP log of pictures, marks, path and states, which `track` reads as a recording.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;

use serde_json::json;

use super::guide::{Answer, Correction};
use crate::frame::GrayFrame;
use crate::report::foxglove::FoxgloveLog;
use crate::report::marks::FrameMarks;
use crate::report::results::PathRow;

/// One processed frame on its way to the log.
pub struct Entry {
    /// The picture.
    pub picture: GrayFrame,
    /// What was found in it.
    pub row: PathRow,
    /// What an overlay shows.
    pub marks: FrameMarks,
    /// The last answer to the robot.
    pub answer: Option<Answer>,
}

/// A log that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be made.
    #[error("cannot record into {}: choose a new file in a folder that may be written", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The log cannot be gone on with.
    #[error("recording into {} ended: what is there can be read", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// Makes a new file for the log; an old one stays.
pub fn create(path: &Path) -> Result<File, RecordError> {
    let failed = |source| RecordError::Create { path: path.to_owned(), source };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    File::create_new(path).map_err(failed)
}

/// Writes what comes until it ends or the log has `most_bytes`: the log's index is in memory, and so is bounded too. Gives the
/// number of frames.
pub fn record((path, mut file): (&Path, File), entries: &Receiver<Entry>, most_bytes: u64) -> Result<u64, RecordError> {
    let failed =
        |source: Box<dyn std::error::Error + Send + Sync>| RecordError::Write { path: path.to_owned(), source };
    let size_of = file.try_clone().map_err(|error| failed(error.into()))?;
    let mut log = FoxgloveLog::begin(&mut file).map_err(|error| failed(error.into()))?;
    let mut frames = 0;
    for entry in entries {
        log.add(&entry.row, Some((&entry.picture, &entry.marks))).map_err(|error| failed(error.into()))?;
        if let Some(answer) = &entry.answer {
            log.add_state(&entry.row, &state(answer)).map_err(|error| failed(error.into()))?;
        }
        frames += 1;
        if size_of.metadata().is_ok_and(|metadata| metadata.len() > most_bytes) {
            break;
        }
    }
    log.finish().map_err(|error| failed(error.into()))?;
    Ok(frames)
}

fn state(answer: &Answer) -> serde_json::Value {
    let step_mm = match answer.correction {
        Correction::Step(step_mm) => Some(step_mm),
        Correction::Hold => None,
    };
    json!({
        "state": answer.state.name(), "why": answer.why.name(), "step_mm": step_mm, "total_mm": answer.total_mm,
        "remaining_mm": answer.remaining_mm, "age_s": answer.age_s,
        "path_mm": answer.pose.path_mm, "lateral_mm": answer.pose.lateral_mm,
    })
}
