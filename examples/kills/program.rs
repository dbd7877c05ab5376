//! The program, two recordings, and which of them the results are of.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use seamtrack::report::results::read_path_csv;
use seamtrack::report::run::Run;

/// Frames of the recordings whose results are there before, and are to come.
const FRAMES: (usize, usize) = (6, 40);

/// What is in the place of the results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Found {
    Old,
    New,
    Nothing,
    /// Neither of them whole.
    Mixed,
}

/// The program and where it works.
pub struct Program {
    binary: PathBuf,
    folder: PathBuf,
    pub old_input: PathBuf,
    pub new_input: PathBuf,
    pub output: PathBuf,
}

impl Program {
    /// The program that was built beside this example, and its recordings in `folder`.
    pub fn new(folder: &Path) -> Result<Self> {
        let own = std::env::current_exe().context("this program has no path")?;
        let binary = own.ancestors().nth(2).context("this program has no folder")?.join("seamtrack");
        ensure!(binary.is_file(), "{} is missing: build the program first", binary.display());
        let frames = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/demo-butt/frames");
        let recording = |name: &str, count: usize| {
            let input = folder.join(name);
            std::fs::create_dir(&input)?;
            for frame in 0..count {
                let name = format!("frame_{frame:06}.png");
                std::fs::copy(frames.join(&name), input.join(&name))?;
            }
            Ok::<_, std::io::Error>(input)
        };
        Ok(Self {
            binary,
            folder: folder.to_owned(),
            old_input: recording("old", FRAMES.0)?,
            new_input: recording("new", FRAMES.1)?,
            output: folder.join("out"),
        })
    }

    /// The same program with its results in another folder.
    pub fn writing_to(&self, folder: &Path) -> Self {
        Self {
            binary: self.binary.clone(),
            folder: folder.to_owned(),
            old_input: self.old_input.clone(),
            new_input: self.new_input.clone(),
            output: folder.join("out"),
        }
    }

    /// `seamtrack track`, to be started.
    pub fn command(&self, input: &Path, more: &[&str]) -> Command {
        let mut command = Command::new(&self.binary);
        command.arg("track").arg(input).arg("-o").arg(&self.output).args(["--joint", "butt", "--quiet", "--trace"]);
        command.args(["--max-unavailable", "100"]).args(more).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    /// A run under way.
    pub fn start(&self, input: &Path, more: &[&str]) -> Result<Child> {
        self.command(input, more).spawn().with_context(|| format!("{} cannot be started", self.binary.display()))
    }

    /// How long a run takes that nothing happens to.
    pub fn time_of_a_run(&self) -> Result<Duration> {
        self.prepare(false)?;
        let began = Instant::now();
        let ended = self.start(&self.new_input, &[])?.wait_with_output()?;
        ensure!(ended.status.success(), "a run fails by itself: {}", String::from_utf8_lossy(&ended.stderr));
        Ok(began.elapsed())
    }

    /// The place of the results empty, or with the older ones in it.
    pub fn prepare(&self, with_old: bool) -> Result<()> {
        if self.output.exists() {
            std::fs::remove_dir_all(&self.output)?;
        }
        if with_old {
            let ended = self.start(&self.old_input, &[])?.wait_with_output()?;
            ensure!(ended.status.success(), "no older result: {}", String::from_utf8_lossy(&ended.stderr));
        }
        Ok(())
    }

    /// Which results are there: all files of one run, and no other.
    pub fn found(&self) -> Result<Found> {
        if !self.output.exists() {
            return Ok(Found::Nothing);
        }
        let whole = |frames: usize| {
            let rows = read_path_csv(&self.output.join("path.csv")).is_ok_and(|rows| rows.len() == frames);
            let summary = Run::read(&self.output).is_ok_and(|run| run.summary.frames.total == frames);
            let trace = std::fs::read_to_string(self.output.join("trace.csv"));
            let page = std::fs::read_to_string(self.output.join("report.html"));
            let page = page.is_ok_and(|page| page.trim_end().ends_with("</html>"));
            rows && summary && page && trace.is_ok_and(|trace| trace.lines().count() == frames + 1)
        };
        Ok(match (whole(FRAMES.0), whole(FRAMES.1)) {
            (true, false) => Found::Old,
            (false, true) => Found::New,
            _ => Found::Mixed,
        })
    }

    /// Where results are written before they are whole.
    pub fn unfinished(&self) -> PathBuf {
        self.folder.join(".out.seamtrack-part")
    }

    /// Whether anything unfinished is left.
    pub fn has_leftovers(&self) -> Result<bool> {
        let names = std::fs::read_dir(&self.folder)?.map(|entry| Ok(entry?.file_name()));
        let names: Vec<std::ffi::OsString> = names.collect::<std::io::Result<_>>()?;
        Ok(names.iter().any(|name| name.to_string_lossy().starts_with('.')))
    }
}

/// Lines that a run said.
pub fn lines(ended: &Output) -> usize {
    String::from_utf8_lossy(&ended.stderr).lines().count()
}
