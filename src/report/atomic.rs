//! Files that are either complete or absent: written under a temporary name, then renamed.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::output::{WholeFile, unfinished};

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
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
) -> Result<(), ResultsError> {
    let mut file = Together::default();
    file.add(path, fill)?;
    file.finish()
}

/// Files that belong together, in any folders: all are written before the first one takes its name, so a failure leaves the
/// former ones; and the former later ones go before that, so a process killed in between leaves files missing, but never
/// those of two occasions side by side.
#[derive(Default)]
pub struct Together(Vec<WholeFile>);

impl Together {
    /// Writes one more through `fill`.
    ///
    /// # Errors
    /// [`ResultsError::Write`] when the folder cannot be written or `fill` fails.
    pub fn add(
        &mut self,
        path: &Path,
        fill: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
    ) -> Result<(), ResultsError> {
        let attempt = || -> std::io::Result<()> {
            let mut file = WholeFile::begin(path)?;
            let mut writer = BufWriter::new(file.file());
            fill(&mut writer)?;
            writer.flush()?;
            drop(writer);
            self.0.push(file);
            Ok(())
        };
        attempt().map_err(failed(path))
    }

    /// Gives them their names.
    ///
    /// # Errors
    /// [`ResultsError::Write`] when the system refuses.
    pub fn finish(self) -> Result<(), ResultsError> {
        unfinished::undisturbed(|| -> Result<(), ResultsError> {
            for path in self.0.iter().skip(1).map(WholeFile::target).filter(|path| path.is_file()) {
                std::fs::remove_file(path).map_err(failed(path))?;
            }
            Ok(())
        })?;
        for file in self.0 {
            let path = file.target().to_owned();
            file.finish().map_err(failed(&path))?;
        }
        Ok(())
    }
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> ResultsError {
    let path = path.to_owned();
    move |source| ResultsError::Write { path, source }
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

    #[test]
    fn of_files_that_belong_together_all_are_new_or_all_old() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.toml", "a.html"].map(|name| folder.path().join(name));
        let write = |text: &str, second_fails: bool| {
            let mut files = Together::default();
            files.add(&paths[0], |file| file.write_all(text.as_bytes()))?;
            files.add(&paths[1], |file| {
                file.write_all(text.as_bytes())?;
                if second_fails { Err(std::io::Error::other("disk full")) } else { Ok(()) }
            })?;
            files.finish()
        };
        let read = || paths.each_ref().map(|path| std::fs::read_to_string(path).unwrap());
        write("old", false).unwrap();
        assert!(write("new", true).is_err());
        assert_eq!(read(), ["old", "old"]);
        write("new", false).unwrap();
        assert_eq!(read(), ["new", "new"]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
