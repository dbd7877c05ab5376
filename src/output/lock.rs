//! A lock that a process which ended no longer holds.

use std::fs::File;
use std::io;
use std::path::Path;

use super::system;

/// Times that a file is opened anew which was removed in the meantime.
const GOES: usize = 5;

/// Opens and locks the file; none when another process or thread holds it. A lock on a file that was removed in the
/// meantime is none.
pub fn take(path: &Path) -> io::Result<Option<File>> {
    for _ in 0..GOES {
        let file = File::options().create(true).truncate(false).write(true).open(path)?;
        if !system::lock(&file) {
            return Ok(None);
        }
        if is_still_at(&file, path) {
            return Ok(Some(file));
        }
    }
    Ok(None)
}

#[cfg(unix)]
fn is_still_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::symlink_metadata(path)) {
        (Ok(open), Ok(named)) => (open.dev(), open.ino()) == (named.dev(), named.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_still_at(_: &File, path: &Path) -> bool {
    path.exists()
}
