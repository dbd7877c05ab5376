//! The recordings of a command: what each is called, and by what a finished one is known again.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::time::UNIX_EPOCH;

use anyhow::Context;
use seamtrack::report::batch;
use seamtrack::source;
use sha2::{Digest, Sha256};

/// The folder's or file's own name, without the extension of a file; of a folder called `frames`, that of the one above.
pub fn name_of(input: &Path) -> PathBuf {
    let parts = parts_of(input);
    let name = parts.last().cloned().unwrap_or_else(|| "recording".into());
    match Path::new(&name).file_stem() {
        Some(stem) if !input.is_dir() => PathBuf::from(stem),
        _ => PathBuf::from(name),
    }
}

/// Columns and rows of a recording's first readable picture.
pub fn size_of(input: &Path) -> anyhow::Result<(usize, usize)> {
    let mut source = source::open(input, 1.0)?;
    let first = std::iter::from_fn(|| source.next_frame()).find_map(|frame| frame.picture.ok());
    let picture = first.with_context(|| format!("{} has no readable frame", input.display()))?;
    Ok((picture.width_px(), picture.height_px()))
}

/// A name for each recording, no two alike: its own, where that is taken its whole file name, then with as many of the
/// folders above as it takes. The same recording twice keeps one name twice.
pub fn names_of(inputs: &[&Path]) -> Vec<PathBuf> {
    let choices: Vec<Vec<PathBuf>> = inputs.iter().map(|input| choices_of(input)).collect();
    let mut chosen = vec![0; inputs.len()];
    loop {
        let name = |i: usize| -> &PathBuf { &choices[i][chosen[i].min(choices[i].len() - 1)] };
        let mut by_name: BTreeMap<&PathBuf, Vec<usize>> = BTreeMap::new();
        (0..inputs.len()).for_each(|i| by_name.entry(name(i)).or_default().push(i));
        let is_taken = |(name, of): (&&PathBuf, &Vec<usize>)| {
            of.len() > 1 || [batch::PAGE, batch::TABLE].iter().any(|taken| name.as_os_str() == *taken)
        };
        let alike: BTreeSet<usize> =
            by_name.iter().filter(|(name, of)| is_taken((name, of))).flat_map(|(_, of)| of.clone()).collect();
        let longer: Vec<usize> = alike.into_iter().filter(|&i| chosen[i] + 1 < choices[i].len()).collect();
        if longer.is_empty() {
            return (0..inputs.len()).map(|i| name(i).clone()).collect();
        }
        longer.into_iter().for_each(|i| chosen[i] += 1);
    }
}

fn choices_of(input: &Path) -> Vec<PathBuf> {
    let parts = parts_of(input);
    let with_parents = (1..=parts.len()).map(|count| PathBuf::from(parts[parts.len() - count..].join("-")));
    std::iter::once(name_of(input)).chain(with_parents).collect()
}

/// The parts of a path, without a last one called `frames`.
fn parts_of(input: &Path) -> Vec<String> {
    let absolute = input.canonicalize().or_else(|_| std::path::absolute(input)).unwrap_or_else(|_| input.to_owned());
    let normal = |part: Component<'_>| match part {
        Component::Normal(part) => Some(part.to_string_lossy().into_owned()),
        _ => None,
    };
    let mut parts: Vec<String> = absolute.components().filter_map(normal).collect();
    if parts.len() > 1 && parts.last().is_some_and(|last| last == "frames") && absolute.is_dir() {
        parts.pop();
    }
    parts
}

/// The truth that lies beside a recording's frames, as `synth` leaves it.
pub fn truth_beside(input: &Path) -> Option<PathBuf> {
    let folder = if input.join("frames").is_dir() {
        input.to_owned()
    } else if input.canonicalize().ok()?.ends_with("frames") {
        input.join("..")
    } else {
        return None;
    };
    let truth = folder.join("truth.csv");
    let shown = if folder.ends_with("..") { input.with_file_name("truth.csv") } else { truth.clone() };
    truth.is_file().then(|| if shown.is_file() { shown } else { truth })
}

/// A check sum of all that decides on a recording's results: the program's version, the recording's files (names, sizes,
/// times), the truth, and `settings`. None where these cannot be read.
pub fn made_from(input: &Path, truth: Option<&Path>, settings: &str) -> Option<String> {
    let mut hash = Sha256::new();
    let mut add = |text: &str| {
        hash.update(text.len().to_le_bytes());
        hash.update(text);
    };
    add(env!("CARGO_PKG_VERSION"));
    add(settings);
    // The summary names the recording as the user did.
    add(&input.to_string_lossy());
    for file in files_of(input)? {
        let metadata = std::fs::metadata(&file).ok();
        let modified = metadata.as_ref().and_then(|file| file.modified().ok()?.duration_since(UNIX_EPOCH).ok());
        add(&format!("{} {:?} {modified:?}", file.display(), metadata.map(|file| file.len())));
    }
    if let Some(truth) = truth {
        let bytes = std::fs::read(truth).ok()?;
        hash.update(bytes);
    }
    Some(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

fn files_of(input: &Path) -> Option<Vec<PathBuf>> {
    let input = input.canonicalize().ok()?;
    if !input.is_dir() {
        return Some(vec![input]);
    }
    let mut files = vec![];
    for folder in [input.join("frames"), input.clone()].iter().filter(|folder| folder.is_dir()) {
        for entry in std::fs::read_dir(folder).ok()? {
            files.push(entry.ok()?.path());
        }
    }
    files.extend(
        input
            .parent()
            .map(|above| above.join("timestamps.csv"))
            .filter(|file| input.ends_with("frames") && file.is_file()),
    );
    files.sort();
    Some(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(inputs: &[&str]) -> Vec<String> {
        let inputs: Vec<PathBuf> = inputs.iter().map(|input| Path::new("/nowhere").join(input)).collect();
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        names_of(&inputs).into_iter().map(|name| name.display().to_string()).collect()
    }

    #[test]
    fn names_are_short_and_no_two_alike() {
        assert_eq!(names(&["a.mp4", "b.mp4"]), ["a", "b"]);
        assert_eq!(names(&["a.mp4", "a.avi", "b.mp4"]), ["a.mp4", "a.avi", "b"]);
        assert_eq!(names(&["mon/a", "tue/a", "tue/b"]), ["mon-a", "tue-a", "b"]);
        assert_eq!(names(&["x/mon/a", "y/mon/a"]), ["x-mon-a", "y-mon-a"]);
        assert_eq!(names(&["a", "a"]).into_iter().collect::<BTreeSet<_>>().len(), 1);
        assert_eq!(names(&["index.html", "b"])[0], "index");
    }
}
