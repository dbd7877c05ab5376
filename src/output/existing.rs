//! What stands where a folder is to be, and what may become of it.

use std::io;
use std::path::{Path, PathBuf};

use super::file::is_part;
use super::{OutputError, listing};

/// What is to become of an earlier result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// It stays, and nothing is written.
    Keep,
    /// It is replaced, if all of it is proven ours.
    Replace,
}

impl Existing {
    /// What `--force` says.
    #[must_use]
    pub const fn forced(force: bool) -> Self {
        if force { Self::Replace } else { Self::Keep }
    }
}

/// Whether a folder may be put at `resolved`, which the user knows as `shown`.
pub fn check(shown: &Path, resolved: &Path, existing: Existing) -> Result<(), OutputError> {
    if !resolved.exists() {
        return Ok(());
    }
    if !resolved.is_dir() {
        return Err(OutputError::NotAFolder(shown.to_owned()));
    }
    let foreign = match existing {
        Existing::Replace => listing::first_foreign(resolved),
        Existing::Keep if listing::is_in(resolved) => return Err(OutputError::Results(shown.to_owned())),
        Existing::Keep => first_entry(resolved),
    };
    match foreign.map_err(OutputError::write(shown))? {
        None => Ok(()),
        Some(path) => {
            let name = path.strip_prefix(resolved).unwrap_or(&path);
            Err(OutputError::Foreign(shown.join(name)))
        }
    }
}

/// The first entry of a folder by name, but for what runs keep for themselves.
fn first_entry(folder: &Path) -> io::Result<Option<PathBuf>> {
    let paths =
        std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<Vec<_>>>()?;
    let is_private = |path: &PathBuf| {
        listing::PRIVATE.iter().any(|name| path.ends_with(name)) || path.file_name().is_some_and(is_part)
    };
    Ok(paths.into_iter().filter(|path| !is_private(path)).min())
}
