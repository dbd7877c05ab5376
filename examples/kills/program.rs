//! The program, and which results it left: the older ones, the newer ones, or neither whole.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use crate::case::{Case, Unit};
use crate::inputs;

/// What is in the place of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Found {
    Old,
    New,
    Nothing,
    /// Neither of them whole.
    Mixed,
}

/// Files by their place, with what each holds, but for what tells how long things took.
type Contents = BTreeMap<PathBuf, Vec<u8>>;

/// A command, where it works, and what it makes of its two inputs when nothing happens to it.
pub struct Program<'a> {
    binary: &'a Path,
    pub case: &'a Case,
    inputs: &'a Path,
    folder: PathBuf,
    old: Vec<Contents>,
    new: Vec<Contents>,
    /// A copy of the older results.
    kept: PathBuf,
    /// How long the command takes on the newer input.
    pub whole: Duration,
}

/// Which input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    Old,
    New,
}

impl<'a> Program<'a> {
    /// Runs the command undisturbed on either input, twice: the same must come of it.
    pub fn new(binary: &'a Path, case: &'a Case, inputs: &'a Path, folder: &Path) -> Result<Self> {
        let (work, kept) = (folder.join("work"), folder.join("kept"));
        let mut program =
            Self { binary, case, inputs, folder: work, old: vec![], new: vec![], kept, whole: Duration::ZERO };
        for input in [Input::New, Input::Old] {
            let mut seen = vec![];
            for _ in 0..2 {
                program.clear()?;
                let began = Instant::now();
                let ended = program.start(input)?.wait_with_output()?;
                // 3 is a verdict.
                let is_done = matches!(ended.status.code(), Some(0 | 3));
                ensure!(is_done, "{} fails by itself: {}", case.name, String::from_utf8_lossy(&ended.stderr));
                program.whole = if input == Input::New { began.elapsed() } else { program.whole };
                seen.push(program.units()?);
            }
            for (once, again) in seen[0].iter().zip(&seen[1]) {
                let differing = once.iter().find(|(file, bytes)| again.get(*file) != Some(bytes));
                ensure!(differing.is_none(), "{}: {:?} is not the same twice", case.name, differing.map(|pair| pair.0));
            }
            match input {
                Input::Old => program.old = seen.swap_remove(0),
                Input::New => program.new = seen.swap_remove(0),
            }
        }
        inputs::copy(&program.folder, &program.kept)?;
        Ok(program)
    }

    /// The same with its results in another folder.
    pub fn writing_to(&self, folder: &Path) -> Self {
        let (old, new, kept) = (self.old.clone(), self.new.clone(), self.kept.clone());
        Self { folder: folder.to_owned(), old, new, kept, ..*self }
    }

    /// A run under way, which replaces what is there.
    pub fn start(&self, input: Input) -> Result<Child> {
        let stem = self.inputs.join(if input == Input::Old { "old" } else { "new" });
        let place = |argument: &&str| match argument.strip_prefix("INPUTS") {
            Some(rest) => format!("{}{rest}", self.inputs.display()),
            None => argument.replace("INPUT", &stem.to_string_lossy()),
        };
        let mut command = Command::new(self.binary);
        command.args(self.case.arguments.iter().map(place)).arg("--force").current_dir(&self.folder);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().with_context(|| format!("{} cannot be started", self.binary.display()))
    }

    /// The place of the results empty, or with the older ones in it.
    pub fn prepare(&self, with_old: bool) -> Result<()> {
        self.clear()?;
        if with_old { inputs::copy(&self.kept, &self.folder) } else { Ok(()) }
    }

    fn clear(&self) -> Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        for entry in std::fs::read_dir(&self.folder)? {
            let path = entry?.path();
            if path.is_dir() { std::fs::remove_dir_all(path)? } else { std::fs::remove_file(path)? }
        }
        Ok(())
    }

    /// The size of what the older and the newer input make \[bytes\].
    pub fn sizes(&self) -> Result<(u64, u64)> {
        let old = inputs::bytes(&self.kept)?;
        let new: usize = self.new.iter().flat_map(BTreeMap::values).map(Vec::len).sum();
        Ok((old, new as u64))
    }

    /// Which results are there, unit by unit.
    pub fn found(&self) -> Result<Vec<Found>> {
        let units = self.units()?;
        let found = |(place, unit): (usize, &Unit)| {
            let there = &units[place];
            let is = |whole: &Contents| match unit {
                Unit::Folder(_) => there == whole,
                Unit::Files(names) => {
                    there.contains_key(Path::new(names[0])) && there.iter().all(|(f, b)| whole.get(f) == Some(b))
                }
            };
            match (there.is_empty(), is(&self.old[place]), is(&self.new[place])) {
                (true, ..) => Found::Nothing,
                (_, true, _) => Found::Old,
                (_, _, true) => Found::New,
                _ => Found::Mixed,
            }
        };
        Ok(self.case.units.iter().enumerate().map(found).collect())
    }

    fn units(&self) -> Result<Vec<Contents>> {
        let contents = |unit: &Unit| {
            let mut contents = Contents::new();
            let places: &[&str] = match unit {
                Unit::Folder(name) => &[*name],
                Unit::Files(names) => names,
            };
            for place in places {
                for file in inputs::files(&self.folder.join(place))? {
                    let name = file.strip_prefix(&self.folder)?.to_owned();
                    contents.insert(name, content(&file)?);
                }
            }
            Ok(contents)
        };
        self.case.units.iter().map(contents).collect()
    }

    /// One of the places where the command writes.
    pub fn target(&self) -> PathBuf {
        match self.case.units[0] {
            Unit::Folder(name) => self.folder.join(name),
            Unit::Files(names) => self.folder.join(names[0]),
        }
    }

    /// Where that is written before it is whole.
    pub fn unfinished(&self) -> PathBuf {
        let name = self.target().file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.target().with_file_name(format!(".{name}.seamtrack-part"))
    }

    /// Whether anything unfinished is left.
    pub fn has_leftovers(&self) -> Result<bool> {
        let is_left = |file: &PathBuf| {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with('.') && name != ".seamtrack.json"
        };
        Ok(inputs::entries(&self.folder)?.iter().any(is_left))
    }
}

/// What a file holds, without what differs from run to run.
fn content(file: &Path) -> Result<Vec<u8>> {
    let bytes = std::fs::read(file)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    Ok(match &*name {
        "summary.json" => {
            let mut summary: serde_json::Value = serde_json::from_slice(&bytes).unwrap_or_default();
            summary.as_object_mut().map(|summary| summary.remove("timing"));
            summary.to_string().into_bytes()
        }
        // The time a frame took stands on it: its title names the input.
        "report.html" => {
            let text = String::from_utf8_lossy(&bytes);
            let title = text.split("</title>").next().and_then(|head| head.split("<title>").nth(1)).unwrap_or_default();
            format!("{title} {}", text.trim_end().ends_with("</html>")).into_bytes()
        }
        // Of a batch of which a recording failed both say so: what counts is that they are of the same recordings.
        "batch.csv" => {
            let text = String::from_utf8_lossy(&bytes);
            let mut names: Vec<&str> = text.lines().filter_map(|line| line.split(',').next()).collect();
            names.sort_unstable();
            names.join(" ").into_bytes()
        }
        "index.html" => {
            let text = String::from_utf8_lossy(&bytes);
            let head = text.split("</title>").next().unwrap_or_default();
            format!("{head} {}", text.trim_end().ends_with("</html>")).into_bytes()
        }
        // Check sums of those: what counts is that they are right.
        ".seamtrack.json" => {
            let listing: serde_json::Value = serde_json::from_slice(&bytes).unwrap_or_default();
            let files = listing["files"].as_object().cloned().unwrap_or_default();
            let folder = file.parent().unwrap_or(Path::new(""));
            let is_true = |(name, proof): (&String, &serde_json::Value)| {
                let bytes = std::fs::read(folder.join(name)).unwrap_or_default();
                proof["bytes"] == bytes.len() && proof["crc32"] == crc32fast::hash(&bytes)
            };
            format!("{:?} {}", files.keys(), files.iter().all(is_true)).into_bytes()
        }
        _ => bytes,
    })
}

/// Lines that a run said.
pub fn lines(ended: &Output) -> usize {
    String::from_utf8_lossy(&ended.stderr).lines().count()
}
