//! `timestamps.csv` of a recorded folder: `#timestamp [ns],filename`.

use std::collections::BTreeMap;
use std::path::Path;

use super::SourceError;

/// Name of the file in the recording's folder.
pub const FILE_NAME: &str = "timestamps.csv";

/// Characters of a wrong line that are shown.
const SHOWN_CHARACTERS: usize = 80;

/// Reads the time stamps \[s\] by file name, counted from the earliest; none when the folder has no such file.
///
/// # Errors
/// When the file cannot be read, or a line is not `nanoseconds,name`.
pub fn read(folder: &Path) -> Result<Option<BTreeMap<String, f64>>, SourceError> {
    let path = folder.join(FILE_NAME);
    // Opening a named pipe would wait for whoever writes into it.
    let text = match std::fs::metadata(&path) {
        Ok(metadata) if !metadata.is_file() => return Err(SourceError::NotAFile(path)),
        Ok(_) => std::fs::read_to_string(&path),
        Err(error) => Err(error),
    };
    let text = match text {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(SourceError::Open { path, source }),
    };
    let mut nanoseconds = BTreeMap::new();
    let without_mark = text.strip_prefix('\u{feff}').unwrap_or(&text);
    for (number, line) in without_mark.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let entry = line.split_once(',').and_then(|(ns, name)| Some((ns.trim().parse::<i64>().ok()?, name.trim())));
        let Some((ns, name)) = entry else {
            let start: String = line.chars().take(SHOWN_CHARACTERS).collect();
            let problem = format!("line {} is not `nanoseconds,filename`: {start:?}", number + 1);
            return Err(SourceError::TimeStamps { path, problem });
        };
        nanoseconds.insert(name.to_owned(), ns);
    }
    let first = nanoseconds.values().copied().min().unwrap_or(0);
    Ok(Some(
        nanoseconds.into_iter().map(|(name, ns)| (name, (i128::from(ns) - i128::from(first)) as f64 * 1e-9)).collect(),
    ))
}
