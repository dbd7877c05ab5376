//! Files that are either complete or absent: written under a temporary name, then renamed.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::output::unfinished::{self, Removal};

/// Why a result could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The file or folder could not be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file meant to be written.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file or folder could not be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file meant to be read.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The truth beside the results is none.
    #[error(transparent)]
    Truth(#[from] crate::eval::TruthFileError),
    /// The content does not fit the contract.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, where, and the remedy.
        problem: String,
    },
}

impl ResultsError {
    /// The content of `path` has `problem`.
    pub(crate) fn content(path: &Path, problem: impl ToString) -> Self {
        Self::Content { path: path.to_owned(), problem: problem.to_string() }
    }
}

/// Write `path` through `fill`: into a temporary file of the same folder, which then takes the name. A failure or a
/// killed process leaves the former file as it was.
///
/// # Errors
/// [`ResultsError::Write`] when the folder cannot be written or `fill` fails.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut std::fs::File>) -> std::io::Result<()>,
) -> Result<(), ResultsError> {
    let attempt = || -> std::io::Result<()> {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut file = temporary_file().tempfile_in(folder)?;
        let _noted = Noted::of(file.path());
        let mut writer = BufWriter::new(file.as_file_mut());
        fill(&mut writer)?;
        writer.flush()?;
        drop(writer);
        unfinished::undisturbed(|| file.persist(path))?;
        Ok(())
    };
    attempt().map_err(|source| ResultsError::Write { path: path.to_owned(), source })
}

/// A temporary file that goes when the program is told to end.
struct Noted(PathBuf);

impl Noted {
    fn of(path: &Path) -> Self {
        unfinished::note(path, Removal::Whole);
        Self(path.to_owned())
    }
}

impl Drop for Noted {
    fn drop(&mut self) {
        unfinished::forget(&self.0);
    }
}

/// A builder of temporary files that end up as readable as any other file (the crate's default is owner only).
fn temporary_file() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".").suffix(".part");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_former_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("path.csv");
        write_atomically(&path, |w| w.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |w| {
            w.write_all(b"half")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
