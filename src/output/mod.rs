//! Folders and files that are wholly there or wholly absent, and places that must not be written to.
//!
//! * [`WholeFolder`]: a command writes into a private folder beside its target, which takes the target's name in one
//!   step when it is complete. What stood there before is replaced only if it is proven ours.
//! * [`WholeFile`]: the same for one file.
//! * [`listing`]: the proof: `.seamtrack.json` names each file a command left in a folder, with its length and check
//!   sum. What is not listed, or was changed since, is the user's and is never replaced or deleted.
//! * [`Reads`]: what a command reads, so that nothing is written into or over it.
//! * [`unfinished`]: what is being written now, so that a program that is told to end leaves nothing of it behind.

mod existing;
mod file;
mod folder;
pub mod listing;
mod lock;
mod places;
mod system;
pub mod unfinished;

use std::path::{Path, PathBuf};

pub use existing::Existing;
pub use file::WholeFile;
pub use folder::WholeFolder;
pub use places::{Claims, Reads, resolve};

/// Why something is not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The system refused.
    #[error("cannot write {}", path.display())]
    Write {
        /// What was to be written.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file stands where a folder is to be.
    #[error("{} is a file where a folder for results is needed: choose another place", .0.display())]
    NotAFolder(PathBuf),
    /// There are results.
    #[error("{} already holds results: choose another folder with -o, or overwrite with --force", .0.display())]
    Results(PathBuf),
    /// There is something that no run left there.
    #[error("{} is not of an earlier run, or was changed since: move it away, or choose another folder", .0.display())]
    Foreign(PathBuf),
    /// Another run writes there now.
    #[error("{} is being written by another run: wait until it ends, or choose another folder", .0.display())]
    Busy(PathBuf),
    /// The target is read, or lies within what is read.
    #[error("{} would be written into {}, which is read: choose another place with {option}", target.display(), read.display())]
    IntoSource {
        /// Where it would be written.
        target: PathBuf,
        /// What is read.
        read: PathBuf,
        /// The option that names the target.
        option: &'static str,
    },
    /// The target holds what is read.
    #[error("{} holds {}, which is read: choose another place with {option}", target.display(), read.display())]
    OverSource {
        /// Where it would be written.
        target: PathBuf,
        /// What is read.
        read: PathBuf,
        /// The option that names the target.
        option: &'static str,
    },
    /// Two would be written to one place, or one within the other.
    #[error("{first} and {second} would both write to {}: do them one by one with -o", target.display())]
    Shared {
        /// The one.
        first: String,
        /// The other.
        second: String,
        /// The place.
        target: PathBuf,
    },
}

impl OutputError {
    /// `path` could not be written.
    pub(crate) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Write { path, source }
    }
}
