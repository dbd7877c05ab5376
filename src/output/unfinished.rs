//! What is being written at the moment.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// What is to become of a path when the program is told to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Removal {
    /// It goes, with all that is in it.
    Whole,
    /// It was made for others, such as `results`, and goes if nothing is in it.
    IfEmpty,
}

static UNFINISHED: Mutex<Vec<(PathBuf, Removal)>> = Mutex::new(Vec::new());
/// Removing a folder that another thread still writes into may take several goes.
const GOES: usize = 20;
const BETWEEN_GOES: Duration = Duration::from_millis(5);

fn list() -> MutexGuard<'static, Vec<(PathBuf, Removal)>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Notes a file or folder that is to go when the program is told to end.
pub fn note(path: &Path, removal: Removal) {
    list().push((path.to_owned(), removal));
}

/// Forgets it: it is finished, or gone.
pub fn forget(path: &Path) {
    list().retain(|(other, _)| other != path);
}

/// Does `step` without being ended in the middle of it by [`remove_all`].
pub fn undisturbed<T>(step: impl FnOnce() -> T) -> T {
    let _list = list();
    step()
}

/// Removes everything that is unfinished. As long as the answer is kept, nothing can be finished any more and
/// [`undisturbed`] waits: end the program with it.
#[must_use]
pub fn remove_all() -> impl Drop {
    let list = list();
    for (path, _) in list.iter().filter(|(_, removal)| *removal == Removal::Whole) {
        for _ in 0..GOES {
            let gone = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
            if gone.is_ok() || !path.exists() {
                break;
            }
            std::thread::sleep(BETWEEN_GOES);
        }
    }
    for (path, _) in list.iter().rev().filter(|(_, removal)| *removal == Removal::IfEmpty) {
        let _ = std::fs::remove_dir(path);
    }
    list
}
