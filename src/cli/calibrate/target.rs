//! Where a calibration is written: over nothing that is read, over nothing of the user's, its page beside it in the same step.

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{anyhow, bail, ensure};
use seamtrack::calib::file::{CalibrationFile, day_of};
use seamtrack::output::Reads;
use seamtrack::report::atomic::Together;

use crate::cli::say::shown;

/// A file to be written, and its page.
pub struct Target<'a> {
    file: &'a Path,
    page: Option<PathBuf>,
}

impl<'a> Target<'a> {
    /// A file alone. An error, before the work begins, when it exists and may not be overwritten, when it is one of those that
    /// are `read`, or when there is no folder for it.
    pub fn new<'b>(file: &'a Path, force: bool, read: impl IntoIterator<Item = &'b PathBuf>) -> anyhow::Result<Self> {
        if file.symlink_metadata().is_ok() && !force {
            bail!("{} exists: give another -o, or --force to overwrite it", shown(file));
        }
        ensure!(!file.is_dir(), "{} is a folder: name a file with -o", shown(file));
        if let Some(folder) = file.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
            bail!("there is no folder {}: make it, or give another -o", shown(folder));
        }
        let mut reads = Reads::default();
        read.into_iter().for_each(|path| reads.add(path));
        reads.refuse(file, "-o")?;
        Ok(Self { file, page: None })
    }

    /// The same with a page beside it; what stands there must be one of this program's, as nobody names it.
    pub fn with_page<'b>(
        file: &'a Path,
        force: bool,
        read: impl IntoIterator<Item = &'b PathBuf>,
    ) -> anyhow::Result<Self> {
        let target = Self::new(file, force, read)?;
        let page = file.with_extension("html");
        ensure!(page != file, "-o {}: the report goes there: name a .toml", shown(file));
        if page.symlink_metadata().is_ok() {
            ensure!(force, "{} exists: give another -o, or --force to overwrite it", shown(&page));
            let is_ours = std::fs::read_to_string(&page).is_ok_and(|text| text.contains("seamtrack</title>"));
            ensure!(is_ours, "{} is no page of this program: move it away, or give another -o", shown(&page));
        }
        Ok(Self { page: Some(page), ..target })
    }

    /// Seals and writes a calibration, and the page that is made of it.
    pub fn write(
        &self,
        file: &mut CalibrationFile,
        page: impl FnOnce(&CalibrationFile) -> String,
    ) -> anyhow::Result<()> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        file.seal(day_of(now));
        let text = file.to_toml().map_err(|problem| anyhow!(problem))?;
        self.write_text(&text, || page(file))
    }

    /// Writes a text, and its page.
    pub fn write_text(&self, text: &str, page: impl FnOnce() -> String) -> anyhow::Result<()> {
        let mut files = Together::default();
        files.add(self.file, |file| file.write_all(text.as_bytes()))?;
        if let Some(path) = &self.page {
            files.add(path, |file| file.write_all(page().as_bytes()))?;
        }
        Ok(files.finish()?)
    }
}

/// The names of the files.
impl fmt::Display for Target<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", shown(self.file))?;
        self.page.as_ref().map_or(Ok(()), |page| write!(f, ", {}", shown(page)))
    }
}
