//! Disks that are full or must not be written.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::Tally;
use crate::program::{Program, lines};

/// What the small file system has beside the older results \[kB\]: less than the new ones take, by more or less.
const ROOM_KB: [u32; 8] = [0, 8, 40, 80, 120, 200, 300, 400];
/// What the older results take \[kB\].
const OLD_RESULTS_KB: u32 = 128;

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
    fn new(size_kb: u32) -> Result<Self> {
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
pub fn tally(program: &Program, kind: Kind) -> Result<Tally> {
    let mut tally = Tally::default();
    for room_kb in ROOM_KB {
        let disk = Mounted::new(if kind == Kind::Full { OLD_RESULTS_KB + room_kb } else { 10_000 })?;
        let there = program.writing_to(disk.0.path());
        there.prepare(true)?;
        if kind == Kind::ReadOnly {
            mount(&["-o", "remount,ro"], disk.0.path())?;
        }
        let ended = there.start(&there.new_input, &["--force"])?.wait_with_output()?;
        tally.lines += usize::from(!ended.status.success() && lines(&ended) != 1);
        let found = there.found()?;
        // A run that says that it failed has changed nothing.
        tally.mixed += usize::from(ended.status.success() != (found == crate::program::Found::New));
        tally.count(found);
    }
    Ok(tally)
}
