//! Disks that are full or must not be written.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::Tally;
use crate::program::{Found, Input, Program, lines};

/// What the small file system has beside the older results, as a part of what the newer ones take: less, by more or less.
const ROOM: [f64; 4] = [0.0, 0.3, 0.6, 0.85];
/// Room for folders \[kB\].
const DIRECTORIES_KB: u64 = 4;
/// Size of the one that must not be written \[kB\].
const READ_ONLY_KB: u64 = 20_000;

/// What is wrong with the disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Full,
    ReadOnly,
}

impl Kind {
    pub const ALL: [Self; 2] = [Self::Full, Self::ReadOnly];

    /// Its name in the table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Full => "full disk",
            Self::ReadOnly => "read-only disk",
        }
    }
}

/// A file system in memory, until it is dropped.
struct Mounted(tempfile::TempDir);

impl Mounted {
    fn new(size_kb: u64) -> Result<Self> {
        let folder = tempfile::tempdir()?;
        mount(&["-t", "tmpfs", "-o", &format!("size={size_kb}k"), "none"], folder.path())?;
        Ok(Self(folder))
    }
}

impl Drop for Mounted {
    fn drop(&mut self) {
        let _unmounted = Command::new("umount").arg(self.0.path()).status();
    }
}

fn mount(arguments: &[&str], folder: &Path) -> Result<()> {
    let said = Command::new("mount").args(arguments).arg(folder).output().context("mount cannot be started")?;
    ensure!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr).trim());
    Ok(())
}

/// Runs over older results on such disks.
pub fn tally(program: &Program<'_>, kind: Kind) -> Result<Tally> {
    let mut tally = Tally::default();
    let (old, new) = program.sizes()?;
    for share in ROOM {
        let room_kb = (old + (new as f64 * share) as u64) / 1024 + DIRECTORIES_KB;
        let disk = Mounted::new(if kind == Kind::Full { room_kb } else { READ_ONLY_KB })?;
        let there = program.writing_to(disk.0.path());
        there.prepare(true)?;
        if kind == Kind::ReadOnly {
            mount(&["-o", "remount,ro"], disk.0.path())?;
        }
        let ended = there.start(Input::New)?.wait_with_output()?;
        let has_failed = !matches!(ended.status.code(), Some(0 | 3));
        tally.lines += usize::from(has_failed && lines(&ended) > crate::most_lines(program));
        let found = there.found()?;
        // A run that says that it failed has changed nothing, or the parts that it says are done.
        let is_all_new = found.iter().all(|found| *found == Found::New);
        if has_failed == is_all_new {
            eprintln!("{}: {:?} after {}", program.case.name, found, String::from_utf8_lossy(&ended.stderr).trim());
            tally.mixed += 1;
        }
        tally.count(&found);
    }
    Ok(tally)
}
