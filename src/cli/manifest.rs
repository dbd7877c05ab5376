//! The list of recordings: a CSV with the columns `input[,truth]`, with commas or semicolons.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

/// Inputs and truths in their order; paths count from the manifest's folder.
pub fn read(manifest: &Path) -> anyhow::Result<Vec<(PathBuf, Option<PathBuf>)>> {
    let context = || format!("cannot read the manifest {}", manifest.display());
    let bytes = std::fs::read(manifest).with_context(context)?;
    let heads = bytes.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let delimiter = if heads.contains(&b';') && !heads.contains(&b',') { b';' } else { b',' };
    // A line may end before its truth.
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(bytes.as_slice());
    let folder = manifest.parent().unwrap_or(Path::new("."));
    let headers = reader.headers().with_context(context)?.clone();
    let Some(input) = headers.iter().position(|name| name == "input") else {
        bail!("{}: the first line must name a column `input` (and may name `truth`)", manifest.display());
    };
    let truth = headers.iter().position(|name| name == "truth");
    reader
        .records()
        .map(|record| {
            let record = record.with_context(context)?;
            let line = record.position().map_or(0, csv::Position::line);
            let path = |column: usize| record.get(column).filter(|text| !text.is_empty()).map(|text| folder.join(text));
            let Some(input) = path(input) else {
                bail!("{}: line {line} has no input: name a recording", manifest.display())
            };
            Ok((input, truth.and_then(path)))
        })
        .collect()
}
