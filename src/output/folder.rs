//! A folder that appears complete, in one step.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::unfinished::{self, Removal};
use super::{Existing, OutputError, existing, listing, lock, places, system};

/// Times that making the private folder is tried: another job may take away the empty folder above it.
const GOES: usize = 5;

/// A folder in the making. Fill [`path`](Self::path), then [`finish`](Self::finish); dropped before, it leaves nothing
/// but what stood there already.
///
/// The private folder `.NAME.seamtrack-part` lies beside the target, so that the two can exchange their names in one
/// step: whoever looks sees the earlier result or the new one, whole, also after a kill. Where the target cannot be
/// exchanged (a mounted volume, the working directory, a folder above that must not be written), the private folder
/// lies in it and its entries are moved at the end; a kill among these moves is made good by the next run.
///
/// A lock beside it, which a process that ended no longer holds, keeps a second run out.
#[derive(Debug)]
pub struct WholeFolder {
    target: PathBuf,
    part: PathBuf,
    lock: PathBuf,
    /// Holds the lock as long as it is open.
    _locked: File,
    inside: bool,
    /// Folders made on the way, the deepest last.
    made: Vec<PathBuf>,
    made_from: Option<String>,
    finished: bool,
}

impl WholeFolder {
    /// Whether `target` could be begun now: it is absent, empty, or, to be replaced, proven ours.
    ///
    /// # Errors
    /// [`OutputError`] that says what stands there.
    pub fn check(target: &Path, existing: Existing) -> Result<(), OutputError> {
        existing::check(target, &places::resolve(target)?, existing)
    }

    /// Takes the target's lock, cleans up what a run that died left, and makes the private folder.
    ///
    /// # Errors
    /// When something stands there that is not to be replaced, another run writes there, or the system refuses.
    pub fn begin(target: &Path, existing: Existing) -> Result<Self, OutputError> {
        let resolved = places::resolve(target)?;
        if resolved.exists() && !resolved.is_dir() {
            return Err(OutputError::NotAFolder(target.to_owned()));
        }
        let beside = resolved.parent().filter(|_| can_be_exchanged(&resolved));
        let begun = match beside {
            Some(parent) => match Self::within(&resolved, parent, false, target) {
                // The folder above is not ours to write to, but this one may be.
                Err(OutputError::Write { .. }) if resolved.is_dir() => Self::within(&resolved, &resolved, true, target),
                begun => begun,
            },
            None => Self::within(&resolved, &resolved, true, target),
        }?;
        begun.clean()?;
        existing::check(target, &resolved, existing)?;
        unfinished::note(&begun.part, Removal::Whole);
        std::fs::create_dir(&begun.part).map_err(OutputError::write(target))?;
        Ok(begun)
    }

    /// The lock in `folder`, which is made if need be.
    fn within(resolved: &Path, folder: &Path, inside: bool, shown: &Path) -> Result<Self, OutputError> {
        let prefix = if inside { String::new() } else { places::hidden_name(resolved) };
        let lock_file = folder.join(format!("{prefix}.seamtrack-lock"));
        let mut made = vec![];
        let mut went = 0;
        let locked = loop {
            made.extend(make_folders(folder).map_err(OutputError::write(shown))?);
            went += 1;
            match lock::take(&lock_file) {
                Ok(Some(file)) => break file,
                Ok(None) => return Err(OutputError::Busy(shown.to_owned())),
                Err(error) if error.kind() == io::ErrorKind::NotFound && went < GOES => {}
                Err(error) => {
                    unmake(&made);
                    return Err(OutputError::write(shown)(error));
                }
            }
        };
        made.iter().for_each(|folder| unfinished::note(folder, Removal::IfEmpty));
        unfinished::note(&lock_file, Removal::Whole);
        let part = folder.join(format!("{prefix}.seamtrack-part"));
        Ok(Self {
            target: resolved.to_owned(),
            part,
            lock: lock_file,
            _locked: locked,
            inside,
            made,
            made_from: None,
            finished: false,
        })
    }

    /// Where to write.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.part
    }

    /// The target without links: what the folder will be.
    #[must_use]
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Notes from what the folder is made ([`listing::is_whole`]).
    pub fn made_from(&mut self, made_from: String) {
        self.made_from = Some(made_from);
    }

    /// Lists what was written as ours, and puts it in the place of what stood there.
    ///
    /// # Errors
    /// When the system refuses; what stood there is then still there.
    pub fn finish(mut self) -> Result<(), OutputError> {
        let failed = |source| OutputError::Write { path: self.target.clone(), source };
        listing::write(&self.part, self.made_from.take()).map_err(failed)?;
        if !self.inside && self.target.is_dir() {
            let permissions = std::fs::metadata(&self.target).map_err(failed)?.permissions();
            std::fs::set_permissions(&self.part, permissions).map_err(failed)?;
        }
        unfinished::undisturbed(|| if self.inside { self.move_in() } else { self.take_the_name() }).map_err(failed)?;
        self.finished = true;
        self.clean()
    }

    fn take_the_name(&self) -> io::Result<()> {
        if !self.target.exists() || is_empty(&self.target)? {
            return std::fs::rename(&self.part, &self.target);
        }
        if !system::exchange(&self.part, &self.target)? {
            let aside = self.aside();
            std::fs::rename(&self.target, &aside)?;
            std::fs::rename(&self.part, &self.target)
                .inspect_err(|_| std::fs::rename(&aside, &self.target).unwrap_or_default())?;
        }
        Ok(())
    }

    /// Where the earlier result waits, where names cannot be exchanged in one step.
    fn aside(&self) -> PathBuf {
        self.part.with_extension("seamtrack-old")
    }

    fn move_in(&self) -> io::Result<()> {
        listing::remove_listed(&self.target)?;
        for entry in std::fs::read_dir(&self.part)? {
            let entry = entry?;
            if entry.file_name() != listing::FILE_NAME {
                std::fs::rename(entry.path(), self.target.join(entry.file_name()))?;
            }
        }
        std::fs::rename(self.part.join(listing::FILE_NAME), self.target.join(listing::FILE_NAME))
    }

    /// Removes what this run, or one that died, left beside the target: an unfinished folder, or an earlier result that
    /// was exchanged; finishes moves that were begun.
    fn clean(&self) -> Result<(), OutputError> {
        let failed = |source| OutputError::Write { path: self.part.clone(), source };
        let aside = self.aside();
        if !self.inside && aside.exists() {
            if self.target.exists() {
                remove_ours(&aside)?;
            } else {
                std::fs::rename(&aside, &self.target).map_err(failed)?;
            }
        }
        if !self.part.exists() {
            return Ok(());
        }
        if self.inside && listing::is_in(&self.part) {
            unfinished::undisturbed(|| self.move_in()).map_err(failed)?;
        }
        remove_ours(&self.part)
    }
}

impl Drop for WholeFolder {
    fn drop(&mut self) {
        // Moves that were begun are finished by the next run: what they still have to move stays.
        let is_moving = self.inside && listing::is_in(&self.part);
        if !self.finished && !is_moving {
            let _ = std::fs::remove_dir_all(&self.part);
        }
        // While the lock is held: who opens the file afterwards finds that it is gone, and makes a new one.
        let _ = std::fs::remove_file(&self.lock);
        if !self.finished {
            unmake(&self.made);
        }
        for path in self.made.iter().chain([&self.part, &self.lock]) {
            unfinished::forget(path);
        }
    }
}

/// Removes a private folder. One without a listing was never finished: all in it was written by the run that made it. One
/// with a listing was a result: what is not proven ours in it stays, and is named.
fn remove_ours(folder: &Path) -> Result<(), OutputError> {
    if listing::is_in(folder)
        && let Some(foreign) = listing::first_foreign(folder).map_err(OutputError::write(folder))?
    {
        return Err(OutputError::Foreign(foreign));
    }
    std::fs::remove_dir_all(folder).map_err(OutputError::write(folder))
}

/// Whether `resolved` can take part in an exchange of names: no mounted volume, nor where a process of the user stands.
fn can_be_exchanged(resolved: &Path) -> bool {
    let Some(parent) = resolved.parent() else { return false };
    let holds_us = std::env::current_dir().is_ok_and(|here| here.starts_with(resolved));
    !resolved.is_dir() || (!holds_us && system::on_one_device(resolved, parent))
}

fn is_empty(folder: &Path) -> io::Result<bool> {
    Ok(std::fs::read_dir(folder)?.next().is_none())
}

/// Makes a folder and those above it; gives back the ones that were not there, the deepest last.
fn make_folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let missing: Vec<PathBuf> = folder.ancestors().take_while(|path| !path.exists()).map(Path::to_owned).collect();
    std::fs::create_dir_all(folder)?;
    Ok(missing.into_iter().rev().collect())
}

/// Removes folders that were made, where they are still empty.
fn unmake(made: &[PathBuf]) {
    for folder in made.iter().rev() {
        let _ = std::fs::remove_dir(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(target: &Path, existing: Existing, file: &str) -> Result<(), OutputError> {
        let folder = WholeFolder::begin(target, existing)?;
        std::fs::write(folder.path().join(file), file).unwrap();
        folder.finish()
    }

    /// The names in a folder, hidden ones too.
    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_appears_complete_and_an_earlier_one_of_ours_is_replaced_whole() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("results/a");
        write(&target, Existing::Keep, "old.csv").unwrap();
        assert!(matches!(write(&target, Existing::Keep, "new.csv"), Err(OutputError::Results(_))));
        assert_eq!(names(&target), [listing::FILE_NAME, "old.csv"]);
        write(&target, Existing::Replace, "new.csv").unwrap();
        assert_eq!(names(&target), [listing::FILE_NAME, "new.csv"]);
        assert_eq!(names(&folder.path().join("results")), ["a"], "nothing else stays");
    }

    #[test]
    fn one_that_is_dropped_leaves_nothing_not_even_the_folders_above() {
        let folder = tempfile::tempdir().unwrap();
        let begun = WholeFolder::begin(&folder.path().join("results/a"), Existing::Keep).unwrap();
        std::fs::write(begun.path().join("path.csv"), "half").unwrap();
        drop(begun);
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn what_is_not_ours_stays_and_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        write(&target, Existing::Keep, "path.csv").unwrap();
        std::fs::write(target.join("notes.txt"), "mine").unwrap();
        for existing in [Existing::Keep, Existing::Replace] {
            assert!(write(&target, existing, "new.csv").is_err());
            assert_eq!(names(&target), [listing::FILE_NAME, "notes.txt", "path.csv"]);
        }
        let error = write(&target, Existing::Replace, "new.csv").unwrap_err();
        assert!(error.to_string().contains("a/notes.txt is not of an earlier run"), "{error}");
    }

    #[test]
    fn the_longest_name_that_a_folder_can_have_will_do() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("n".repeat(255));
        write(&target, Existing::Keep, "old.csv").unwrap();
        write(&target, Existing::Replace, "new.csv").unwrap();
        assert_eq!(
            (names(folder.path()).len(), names(&target)),
            (1, vec![listing::FILE_NAME.into(), "new.csv".into()])
        );
    }

    #[test]
    fn a_second_run_is_kept_out_while_the_first_one_writes() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let begun = WholeFolder::begin(&target, Existing::Keep).unwrap();
        assert!(matches!(WholeFolder::begin(&target, Existing::Replace), Err(OutputError::Busy(_))));
        drop(begun);
        write(&target, Existing::Keep, "path.csv").unwrap();
    }

    #[test]
    fn what_a_run_that_died_left_is_cleaned_up_by_the_next() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        write(&target, Existing::Keep, "old.csv").unwrap();
        // It died while it wrote.
        std::fs::create_dir(folder.path().join(".a.seamtrack-part")).unwrap();
        std::fs::write(folder.path().join(".a.seamtrack-part/path.csv"), "half").unwrap();
        std::fs::write(folder.path().join(".a.seamtrack-lock"), "").unwrap();
        write(&target, Existing::Replace, "new.csv").unwrap();
        assert_eq!((names(folder.path()), names(&target).len()), (vec!["a".to_owned()], 2));
        // It died between two renamings.
        std::fs::rename(&target, folder.path().join(".a.seamtrack-old")).unwrap();
        assert!(matches!(write(&target, Existing::Keep, "x"), Err(OutputError::Results(_))));
        assert_eq!(names(&target), [listing::FILE_NAME, "new.csv"]);
    }

    #[test]
    fn moves_into_a_folder_that_keeps_its_name_are_finished_by_the_next_run() {
        let folder = tempfile::tempdir().unwrap();
        let inside = || {
            let path = folder.path().canonicalize().unwrap();
            WholeFolder::within(&path, &path, true, &path).unwrap()
        };
        std::fs::write(folder.path().join("old.csv"), "old").unwrap();
        listing::write(folder.path(), None).unwrap();
        let part = folder.path().join(".seamtrack-part");
        std::fs::create_dir(&part).unwrap();
        for file in ["a.csv", "b.csv"] {
            std::fs::write(part.join(file), file).unwrap();
        }
        listing::write(&part, None).unwrap();
        // It died after the first move.
        listing::remove_listed(folder.path()).unwrap();
        std::fs::rename(part.join("a.csv"), folder.path().join("a.csv")).unwrap();
        inside().clean().unwrap();
        assert_eq!(names(folder.path()), [listing::FILE_NAME, "a.csv", "b.csv"]);
        assert_eq!(listing::first_foreign(folder.path()).unwrap(), None);
    }
}
