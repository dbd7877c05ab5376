//! A file that appears complete, in one step.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::unfinished::{self, Removal};
use super::{lock, places};

/// End of the names under which files and folders are written.
const PART: &str = ".seamtrack-part";

/// A file in the making: `.NAME.seamtrack-part` beside its place, whose name it takes when it is complete. Dropped before, it
/// leaves nothing; what a process that died left is written over. It is locked meanwhile, which keeps a second run out.
#[derive(Debug)]
pub struct WholeFile {
    target: PathBuf,
    part: PathBuf,
    file: File,
    finished: bool,
}

impl WholeFile {
    /// Begins the file that will be at `target`.
    ///
    /// # Errors
    /// When another run writes it at the moment, or the system refuses.
    pub fn begin(target: &Path) -> io::Result<Self> {
        let part = target.with_file_name(format!("{}{PART}", places::hidden_name(target)));
        let busy = || io::Error::new(io::ErrorKind::ResourceBusy, "another run writes it: wait until that ends");
        let file = lock::take(&part)?.ok_or_else(busy)?;
        unfinished::note(&part, Removal::Whole);
        let begun = Self { target: target.to_owned(), part, file, finished: false };
        begun.file.set_len(0)?;
        Ok(begun)
    }

    /// What to write into.
    pub const fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// Where it will be.
    #[must_use]
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Gives it its name.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(mut self) -> io::Result<()> {
        unfinished::undisturbed(|| std::fs::rename(&self.part, &self.target))?;
        self.finished = true;
        Ok(())
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if !self.finished {
            let _ = std::fs::remove_file(&self.part);
        }
        unfinished::forget(&self.part);
    }
}

/// Whether a file of this name is one in the making, or one that a process which died left.
pub fn is_part(name: &std::ffi::OsStr) -> bool {
    name.as_encoded_bytes().starts_with(b".") && name.as_encoded_bytes().ends_with(PART.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_file_appears_whole_over_what_a_dead_process_left_and_one_that_is_dropped_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let (target, left) = (folder.path().join("a.csv"), folder.path().join(".a.csv.seamtrack-part"));
        std::fs::write(&left, "of a longer file that was never finished").unwrap();
        let mut file = WholeFile::begin(&target).unwrap();
        file.file().write_all(b"new").unwrap();
        assert!(!target.exists());
        file.finish().unwrap();
        assert_eq!(std::fs::read(&target).unwrap(), b"new");
        drop(WholeFile::begin(&target).unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_second_run_is_refused_and_a_link_in_the_way_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.csv");
        let first = WholeFile::begin(&target).unwrap();
        assert_eq!(WholeFile::begin(&target).unwrap_err().kind(), io::ErrorKind::ResourceBusy);
        drop(first);
        let users = folder.path().join("users");
        std::fs::write(&users, "mine").unwrap();
        std::os::unix::fs::symlink(&users, folder.path().join(".a.csv.seamtrack-part")).unwrap();
        assert!(WholeFile::begin(&target).is_err());
        assert_eq!(std::fs::read(&users).unwrap(), b"mine");
    }
}
