//! `.seamtrack.json`: what a command left in a folder, as the proof that it is ours.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::file::{WholeFile, is_part};

/// Name of the listing in its folder.
pub const FILE_NAME: &str = ".seamtrack.json";
/// Version of the listing; keys may be added under the same one.
const SCHEMA_VERSION: u32 = 1;
/// Longest listing that is read \[bytes\]: that of a million frames.
const LONGEST_BYTES: u64 = 200_000_000;

/// Files by their path within the folder, with `/` between its parts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Listing {
    schema_version: u32,
    program: String,
    folders: BTreeSet<String>,
    files: BTreeMap<String, Proof>,
    /// From what it was made, as a check sum of everything that decides on the result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    made_from: Option<String>,
}

/// By what a file is known again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Proof {
    bytes: u64,
    crc32: u32,
}

impl Proof {
    fn of(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let (mut hasher, mut buffer, mut bytes) = (crc32fast::Hasher::new(), vec![0; 1 << 16], 0);
        loop {
            match file.read(&mut buffer)? {
                0 => return Ok(Self { bytes, crc32: hasher.finalize() }),
                read => {
                    hasher.update(&buffer[..read]);
                    bytes += read as u64;
                }
            }
        }
    }

    /// Whether `path` still holds the same; its length is asked first.
    fn holds(self, path: &Path) -> bool {
        std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() == self.bytes)
            && Self::of(path).is_ok_and(|proof| proof == self)
    }
}

/// Lists everything that `folder` holds as ours; `made_from` says from what, so that [`is_whole`] knows it again.
///
/// # Errors
/// When a file cannot be read, or the listing not be written.
pub fn write(folder: &Path, made_from: Option<String>) -> io::Result<()> {
    let mut listing = Listing { made_from, ..empty() };
    walk(folder, "", &mut |name, path, is_folder| {
        if is_folder {
            listing.folders.insert(name.to_owned());
        } else {
            listing.files.insert(name.to_owned(), Proof::of(path)?);
        }
        Ok(true)
    })?;
    save(folder, &listing)
}

/// Lists the file `name` of `folder` as ours beside what is listed already; nothing to do in a folder without a listing.
///
/// # Errors
/// When the file cannot be read, or the listing not be written.
pub fn add(folder: &Path, name: &str) -> io::Result<()> {
    let Some(mut listing) = read(folder) else { return Ok(()) };
    listing.files.insert(name.to_owned(), Proof::of(&folder.join(name))?);
    save(folder, &listing)
}

/// Whether a command left a listing in `folder`.
#[must_use]
pub fn is_in(folder: &Path) -> bool {
    read(folder).is_some()
}

/// Whether `folder` holds all that was made from `made_from`, unchanged, and nothing else.
#[must_use]
pub fn is_whole(folder: &Path, made_from: &str) -> bool {
    read(folder).filter(|listing| listing.made_from.as_deref() == Some(made_from)).is_some_and(|listing| {
        // All that is there is listed and unchanged; so, by their number, all that is listed is there.
        let mut files = 0;
        let only_ours = first_unlisted(folder, &listing, &mut files).is_ok_and(|foreign| foreign.is_none());
        only_ours && files == listing.files.len()
    })
}

/// Whether `name` in `folder` is listed and unchanged since.
#[must_use]
pub fn proves(folder: &Path, name: &str) -> bool {
    read(folder)
        .and_then(|listing| listing.files.get(name).copied())
        .is_some_and(|proof| proof.holds(&folder.join(name)))
}

/// The first thing in `folder` that is not proven ours: not listed, changed since, a link, or anything but a file or
/// folder. None when all is ours, or there is nothing.
///
/// # Errors
/// When the folder cannot be read.
pub fn first_foreign(folder: &Path) -> io::Result<Option<PathBuf>> {
    first_unlisted(folder, &read(folder).unwrap_or_else(empty), &mut 0)
}

/// As [`first_foreign`] by this listing; counts the files that are ours.
fn first_unlisted(folder: &Path, listing: &Listing, files: &mut usize) -> io::Result<Option<PathBuf>> {
    let mut foreign = None;
    walk(folder, "", &mut |name, path, is_folder| {
        let is_ours = if is_folder {
            listing.folders.contains(name)
        } else {
            *files += 1;
            listing.files.get(name).is_some_and(|proof| !path.is_symlink() && proof.holds(path))
        };
        if !is_ours {
            foreign = Some(path.to_owned());
        }
        Ok(is_ours)
    })?;
    Ok(foreign)
}

/// Removes what is listed in `folder` and unchanged since, then the listing. What else there is stays.
///
/// # Errors
/// When something cannot be removed.
pub(super) fn remove_listed(folder: &Path) -> io::Result<()> {
    let Some(listing) = read(folder) else { return Ok(()) };
    for (name, proof) in &listing.files {
        let path = folder.join(name);
        if proof.holds(&path) {
            std::fs::remove_file(path)?;
        }
    }
    // The deepest first; a folder with something of the user's in it stays.
    for name in listing.folders.iter().rev() {
        let _ = std::fs::remove_dir(folder.join(name));
    }
    std::fs::remove_file(folder.join(FILE_NAME))
}

/// The names a run keeps for itself in a folder.
pub(super) const PRIVATE: [&str; 3] = [FILE_NAME, ".seamtrack-part", ".seamtrack-lock"];

fn empty() -> Listing {
    let program = format!("seamtrack {}", env!("CARGO_PKG_VERSION"));
    Listing {
        schema_version: SCHEMA_VERSION,
        program,
        folders: BTreeSet::new(),
        files: BTreeMap::new(),
        made_from: None,
    }
}

fn read(folder: &Path) -> Option<Listing> {
    let path = folder.join(FILE_NAME);
    if !std::fs::symlink_metadata(&path).is_ok_and(|file| file.is_file() && file.len() <= LONGEST_BYTES) {
        return None;
    }
    let listing: Listing = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    (listing.schema_version == SCHEMA_VERSION).then_some(listing)
}

fn save(folder: &Path, listing: &Listing) -> io::Result<()> {
    let mut file = WholeFile::begin(&folder.join(FILE_NAME))?;
    serde_json::to_writer(io::BufWriter::new(file.file()), listing)?;
    file.finish()
}

/// Hands name, path and whether it is a folder to `visit`, in the order of the names, until that says false.
fn walk(
    folder: &Path,
    prefix: &str,
    visit: &mut impl FnMut(&str, &Path, bool) -> io::Result<bool>,
) -> io::Result<bool> {
    let mut entries = std::fs::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let own_name = entry.file_name();
        let is_private = prefix.is_empty() && PRIVATE.iter().any(|private| own_name == *private);
        if is_private || (is_part(&own_name) && entry.file_type()?.is_file()) {
            continue;
        }
        // A name that is no UTF-8 is none of ours: it cannot be listed, so its replacement characters stand for it.
        let name = format!("{prefix}{}", own_name.to_string_lossy());
        let is_folder = entry.file_type()?.is_dir();
        if !visit(&name, &entry.path(), is_folder)? || (is_folder && !walk(&entry.path(), &format!("{name}/"), visit)?)
        {
            return Ok(false);
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("thumbnails")).unwrap();
        std::fs::write(folder.path().join("path.csv"), "frame\n").unwrap();
        std::fs::write(folder.path().join("thumbnails/000000.jpg"), "jpeg").unwrap();
        write(folder.path(), Some("abc".into())).unwrap();
        folder
    }

    #[test]
    fn what_was_listed_is_ours_until_it_is_changed() {
        let folder = listed();
        let at = |name: &str| folder.path().join(name);
        assert_eq!(first_foreign(folder.path()).unwrap(), None);
        assert!(proves(folder.path(), "path.csv") && !proves(folder.path(), "truth.csv"));
        std::fs::write(at("path.csv"), "fRame\n").unwrap();
        assert_eq!(first_foreign(folder.path()).unwrap(), Some(at("path.csv")));
        add(folder.path(), "path.csv").unwrap();
        assert_eq!(first_foreign(folder.path()).unwrap(), None);
        std::fs::write(at("thumbnails/mine.jpg"), "").unwrap();
        assert_eq!(first_foreign(folder.path()).unwrap(), Some(at("thumbnails/mine.jpg")));
    }

    #[test]
    fn a_folder_is_whole_as_long_as_nothing_in_it_is_missing_changed_or_added() {
        let folder = listed();
        assert!(is_whole(folder.path(), "abc") && !is_whole(folder.path(), "abd"));
        std::fs::rename(folder.path().join("path.csv"), folder.path().join("mine.csv")).unwrap();
        assert!(!is_whole(folder.path(), "abc"));
        std::fs::copy(folder.path().join("mine.csv"), folder.path().join("path.csv")).unwrap();
        assert!(!is_whole(folder.path(), "abc"));
        std::fs::remove_file(folder.path().join("mine.csv")).unwrap();
        assert!(is_whole(folder.path(), "abc"));
    }

    #[test]
    fn only_what_is_listed_and_unchanged_is_removed() {
        let folder = listed();
        std::fs::write(folder.path().join("thumbnails/mine.jpg"), "mine").unwrap();
        std::fs::write(folder.path().join("path.csv"), "edited").unwrap();
        remove_listed(folder.path()).unwrap();
        assert!(folder.path().join("thumbnails/mine.jpg").is_file() && folder.path().join("path.csv").is_file());
        assert!(!folder.path().join("thumbnails/000000.jpg").exists() && !folder.path().join(FILE_NAME).exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_under_a_listed_name_is_not_ours() {
        let folder = listed();
        let elsewhere = folder.path().with_extension("elsewhere");
        std::fs::rename(folder.path().join("path.csv"), &elsewhere).unwrap();
        std::os::unix::fs::symlink(&elsewhere, folder.path().join("path.csv")).unwrap();
        assert_eq!(first_foreign(folder.path()).unwrap(), Some(folder.path().join("path.csv")));
        std::fs::remove_file(elsewhere).unwrap();
    }
}
