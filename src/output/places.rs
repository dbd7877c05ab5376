//! Places that are read, and places that are written to.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use super::OutputError;
use super::system::{Identity, identity};

/// Longest name that leaves room for `.seamtrack-part` within the 255 bytes of most file systems.
const LONGEST_NAME_BYTES: usize = 230;

/// The path without links and without `..`, also where its end does not exist yet.
///
/// # Errors
/// When a link on the way leads nowhere, or the working directory is gone.
pub fn resolve(path: &Path) -> Result<PathBuf, OutputError> {
    let failed = OutputError::write;
    let mut resolved =
        if path.is_absolute() { PathBuf::new() } else { std::env::current_dir().map_err(failed(path))? };
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                resolved.pop();
            }
            part => {
                resolved.push(part);
                if resolved.is_symlink() {
                    resolved = resolved.canonicalize().map_err(failed(path))?;
                }
            }
        }
    }
    Ok(resolved)
}

/// The target's name with a dot before it; of one that is too long for what comes behind it, or no UTF-8, its check sum.
pub(super) fn hidden_name(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default();
    match name.to_str() {
        Some(name) if name.len() <= LONGEST_NAME_BYTES => format!(".{name}"),
        _ => format!(".{:08x}", crc32fast::hash(name.as_encoded_bytes())),
    }
}

/// What a command reads: recordings, truths, configurations.
#[derive(Debug, Default)]
pub struct Reads {
    /// As the user named it.
    named: HashMap<Identity, PathBuf>,
    /// Every folder above one that is read, with the first that is.
    above: HashMap<Identity, PathBuf>,
}

impl Reads {
    /// Notes a file or folder. One that does not exist needs no protection.
    pub fn add(&mut self, path: &Path) {
        // A recording's frames may lie in a folder of that name, which may be a link.
        for place in [path.to_owned(), path.join("frames")] {
            let (Ok(canonical), Ok(own)) = (place.canonicalize(), identity(&place)) else { continue };
            self.named.entry(own).or_insert_with(|| path.to_owned());
            for folder in canonical.ancestors().skip(1).filter_map(|folder| identity(folder).ok()) {
                self.above.entry(folder).or_insert_with(|| path.to_owned());
            }
        }
    }

    /// Refuses a target that is read, lies in a folder that is, or holds something that is; `option` named it.
    ///
    /// # Errors
    /// [`OutputError::IntoSource`] or [`OutputError::OverSource`].
    pub fn refuse(&self, target: &Path, option: &'static str) -> Result<(), OutputError> {
        let resolved = resolve(target)?;
        for place in resolved.ancestors().filter_map(|place| identity(place).ok()) {
            if let Some(read) = self.named.get(&place) {
                return Err(OutputError::IntoSource { target: target.to_owned(), read: read.clone(), option });
            }
        }
        match identity(&resolved).ok().and_then(|own| self.above.get(&own)) {
            None => Ok(()),
            Some(read) => Err(OutputError::OverSource { target: target.to_owned(), read: read.clone(), option }),
        }
    }
}

/// The places that the jobs of a command will write to: each belongs to one job.
#[derive(Debug, Default)]
pub struct Claims(HashMap<PathBuf, String>);

impl Claims {
    /// Claims `target` for `job`.
    ///
    /// # Errors
    /// When another has it.
    pub fn claim(&mut self, target: &Path, job: &str) -> Result<(), OutputError> {
        match self.0.insert(resolve(target)?, job.to_owned()) {
            Some(first) => Err(OutputError::Shared { first, second: job.to_owned(), target: target.to_owned() }),
            None => Ok(()),
        }
    }

    /// Refuses places that lie in one of another job.
    ///
    /// # Errors
    /// When there is one.
    pub fn check_apart(&self) -> Result<(), OutputError> {
        for (target, job) in &self.0 {
            let above = target.ancestors().skip(1).find_map(|place| self.0.get(place).filter(|other| *other != job));
            if let Some(other) = above {
                let (first, second) = (other.clone(), job.clone());
                return Err(OutputError::Shared { first, second, target: target.clone() });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_resolved_through_links_and_beyond_what_exists() {
        let folder = tempfile::tempdir().unwrap();
        let real = folder.path().canonicalize().unwrap();
        std::fs::create_dir(real.join("a")).unwrap();
        assert_eq!(resolve(&real.join("a/../new/./x")).unwrap(), real.join("new/x"));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(real.join("a"), real.join("link")).unwrap();
            assert_eq!(resolve(&real.join("link/x")).unwrap(), real.join("a/x"));
            std::os::unix::fs::symlink(real.join("nowhere"), real.join("dangling")).unwrap();
            assert!(resolve(&real.join("dangling/x")).is_err());
        }
    }

    #[test]
    fn what_is_read_is_protected_from_all_sides() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("recs/a/frames")).unwrap();
        std::fs::create_dir_all(at("recs/b")).unwrap();
        let mut reads = Reads::default();
        reads.add(&at("recs/a"));
        for target in ["recs/a", "recs/a/out", "recs/a/frames/x/y", "recs", "recs/b/../a"] {
            assert!(reads.refuse(&at(target), "-o").is_err(), "{target}");
        }
        for target in ["recs/b", "recs/new", "out/a"] {
            reads.refuse(&at(target), "-o").unwrap();
        }
    }

    #[test]
    fn one_place_belongs_to_one_job_and_none_lies_in_anothers() {
        let mut claims = Claims::default();
        claims.claim(Path::new("out/a"), "a").unwrap();
        claims.claim(Path::new("out/a/overlay"), "a").unwrap();
        claims.check_apart().unwrap();
        assert!(claims.claim(Path::new("out/./a"), "b").is_err());
        claims.claim(Path::new("out/a/b"), "c").unwrap();
        assert!(claims.check_apart().is_err());
    }
}
