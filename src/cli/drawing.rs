//! Where `--overlay` draws: in the results, in a folder of its own, or into a video.

use std::path::{Path, PathBuf};

use anyhow::bail;
use seamtrack::output::{Existing, OutputError, WholeFolder, resolve};
use seamtrack::report::overlay::{OverlayWriter, is_video};

use super::say::shown;

/// Endings of videos that are not written.
const OTHER_VIDEOS: [&str; 8] = ["avi", "mkv", "mov", "webm", "m4v", "wmv", "mpg", "mpeg"];

/// Refuses an overlay that could not be drawn there: an existing video or folder that is not to be replaced, or is not
/// proven ours; a folder above the results; the ending of a video that is not written.
pub fn check(overlay: &Path, results: &Path, existing: Existing) -> anyhow::Result<()> {
    let (place, results) = (resolve(overlay)?, resolve(results)?);
    let ending = overlay.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    if OTHER_VIDEOS.contains(&ending.as_str()) {
        bail!("--overlay {}: videos are written as .mp4: name one, or a folder", shown(overlay));
    }
    if results.starts_with(&place) {
        bail!("--overlay {} would hold the results: choose another place for it", shown(overlay));
    }
    if is_video(overlay) {
        if place.is_dir() {
            bail!("--overlay {} is a folder: name another file", shown(overlay));
        }
        // One within the results is replaced with them.
        if existing == Existing::Keep && place.exists() && !place.starts_with(&results) {
            bail!("--overlay {} exists: name another file, or overwrite it with --force", shown(overlay));
        }
        return Ok(());
    }
    if place.starts_with(&results) {
        return Ok(());
    }
    match WholeFolder::check(overlay, existing) {
        Err(OutputError::Results(_)) => {
            bail!("--overlay {} exists: name another folder, or overwrite it with --force", shown(overlay))
        }
        checked => Ok(checked?),
    }
}

/// Refuses a log that could not be written there: another ending than Foxglove opens, a folder, or an existing file that is not
/// to be replaced.
pub fn check_log(log: &Path, results: &Path, existing: Existing) -> anyhow::Result<()> {
    let (place, results) = (resolve(log)?, resolve(results)?);
    if !log.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap")) {
        bail!("--mcap {}: logs are written as .mcap: name one", shown(log));
    }
    if place.is_dir() || results.starts_with(&place) {
        bail!("--mcap {} is a folder: name another file", shown(log));
    }
    if existing == Existing::Keep && place.exists() && !place.starts_with(&results) {
        bail!("--mcap {} exists: name another file, or overwrite it with --force", shown(log));
    }
    Ok(())
}

/// The place of one drawing while it is made.
pub struct Drawing {
    path: PathBuf,
    own: Option<WholeFolder>,
    within_results: bool,
}

impl Drawing {
    /// Begins the drawing of `overlay`, beside or in the folder of the results.
    pub fn begin(overlay: &Path, results: &WholeFolder, existing: Existing) -> anyhow::Result<Self> {
        let place = resolve(overlay)?;
        if let Ok(within) = place.strip_prefix(results.target()) {
            return Ok(Self { path: results.path().join(within), own: None, within_results: true });
        }
        if is_video(overlay) {
            return Ok(Self { path: place, own: None, within_results: false });
        }
        let own = WholeFolder::begin(overlay, existing)?;
        Ok(Self { path: own.path().to_owned(), own: Some(own), within_results: false })
    }

    /// Where to draw.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Puts what was drawn and the results where they were asked for: the results in one step, with a drawing in them; a
    /// drawing elsewhere after them.
    pub fn finish(self, writer: OverlayWriter, results: WholeFolder) -> anyhow::Result<()> {
        if self.within_results {
            writer.finish()?;
            return Ok(results.finish()?);
        }
        results.finish()?;
        writer.finish()?;
        Ok(self.own.map_or(Ok(()), WholeFolder::finish)?)
    }
}
