//! What is asked of the file system beyond the standard library.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// What a name stands for, whatever the name: equal through links, mounts and letter case.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Identity {
    /// Device and number on it.
    #[cfg_attr(not(unix), expect(dead_code, reason = "other systems compare paths"))]
    Number(u64, u64),
    /// The path without links.
    #[cfg_attr(unix, expect(dead_code, reason = "Unix compares numbers"))]
    Path(PathBuf),
}

/// The identity of what stands at `path`, links followed.
#[cfg(unix)]
pub fn identity(path: &Path) -> io::Result<Identity> {
    use std::os::unix::fs::MetadataExt;
    let metadata = std::fs::metadata(path)?;
    Ok(Identity::Number(metadata.dev(), metadata.ino()))
}

/// The identity of what stands at `path`, links followed.
#[cfg(not(unix))]
pub fn identity(path: &Path) -> io::Result<Identity> {
    path.canonicalize().map(Identity::Path)
}

/// Whether both lie on one device, so that one can take the other's name.
pub fn on_one_device(a: &Path, b: &Path) -> bool {
    match (identity(a), identity(b)) {
        (Ok(Identity::Number(a, _)), Ok(Identity::Number(b, _))) => a == b,
        _ => true,
    }
}

/// Exchanges the names of two folders in one step; false where the system cannot.
#[cfg(target_os = "linux")]
pub fn exchange(a: &Path, b: &Path) -> io::Result<bool> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    match renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE) {
        Ok(()) => Ok(true),
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// Exchanges the names of two folders in one step; false where the system cannot.
#[cfg(not(target_os = "linux"))]
pub fn exchange(_: &Path, _: &Path) -> io::Result<bool> {
    Ok(false)
}

/// Takes the lock of an open file, which a process that ended no longer holds; false when another has it. A file
/// system without locks grants every one.
#[cfg(unix)]
pub fn lock(file: &File) -> bool {
    use rustix::fs::{FlockOperation, flock};
    !matches!(flock(file, FlockOperation::NonBlockingLockExclusive), Err(rustix::io::Errno::WOULDBLOCK))
}

/// Takes the lock of an open file: granted, as there are none.
#[cfg(not(unix))]
pub fn lock(_: &File) -> bool {
    true
}
