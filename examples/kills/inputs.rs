//! An older and a newer input of every command, by the program itself; and files and folders by their places.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Result, ensure};

/// Frames of the older and the newer recordings.
const FRAMES: [usize; 2] = [6, 30];
const BATCH_FRAMES: [usize; 2] = [3, 10];
const MADE_UP_FRAMES: [usize; 2] = [3, 12];
/// Views of the boards.
const VIEWS: [usize; 2] = [8, 9];
/// Lines of the series.
const LINES: [usize; 2] = [60, 400];

/// Makes them all in `folder`.
pub fn make(binary: &Path, folder: &Path) -> Result<()> {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let frame = |number: usize| demo.join(format!("demo-butt/frames/frame_{number:06}.png"));
    let recording = |place: PathBuf, frames: std::ops::Range<usize>| -> Result<()> {
        std::fs::create_dir_all(&place)?;
        for number in frames {
            let file = frame(number);
            std::fs::copy(&file, place.join(file.file_name().unwrap_or_default()))?;
        }
        Ok(())
    };
    let scene = std::fs::read_to_string(demo.join("scenarios/demo-butt.toml"))?;
    for (which, name) in ["old", "new"].into_iter().enumerate() {
        let at = |ending: &str| folder.join(format!("{name}{ending}"));
        recording(at(""), 0..FRAMES[which])?;
        for (start, part) in ["a", "b", "c"].into_iter().enumerate() {
            recording(at("").join(part), start..start + BATCH_FRAMES[which])?;
        }
        std::fs::write(at(".toml"), scene.replace("frames = 58", &format!("frames = {}", MADE_UP_FRAMES[which])))?;
        let say = |words: &[&str], place: &Path| run(binary, words, place);
        let frames = MADE_UP_FRAMES[which].to_string();
        say(&["synth", "pool-width", "--frames", &frames], &at("-pool"))?;
        let (views, seed) = (VIEWS[which].to_string(), (which + 1).to_string());
        say(&["synth", "sensor-butt", "--frames", "1", "--seed", &seed, "--boards", &views], &at("-sensor"))?;
        for part in ["boards", "stripes"] {
            std::fs::rename(at("-sensor").join(part), at(&format!("-{part}")))?;
        }
        std::fs::copy(at("-sensor").join("sensor.toml"), folder.join("known.toml"))?;
        let mut series = String::from("time_s,z1\n");
        let mut gauge = String::from("px,mm\n");
        for line in 0..LINES[which] {
            let wobble = ((line * 7) % 5) as f64;
            writeln!(series, "{:.1},{:.3}", 0.1 * line as f64, 300.0 + 0.2 * line as f64 + 0.1 * wobble)?;
            writeln!(gauge, "{:.2},{:.3}", 5.0 * line as f64 + 0.1 * wobble, 0.4 * line as f64)?;
        }
        std::fs::write(at(".csv"), series)?;
        std::fs::write(at("-gauge.csv"), gauge)?;
        for (run, method) in [("-run", "robust"), ("-other", "paper")] {
            let input = at("").to_string_lossy().into_owned();
            let words = ["track", &input, "--joint", "butt", "--quiet", "--mm-per-px", "0.073", "--preset", method];
            say(&words, &at(run))?;
        }
    }
    Ok(())
}

/// Runs the program into `place`; 3 is a verdict, no failure.
fn run(binary: &Path, words: &[&str], place: &Path) -> Result<()> {
    let ended = Command::new(binary).args(words).arg("-o").arg(place).stdout(Stdio::null()).output()?;
    let is_done = matches!(ended.status.code(), Some(0 | 3));
    ensure!(is_done, "{}: {}", words.join(" "), String::from_utf8_lossy(&ended.stderr).trim());
    Ok(())
}

/// Everything below `folder`.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let (mut found, mut folders) = (vec![], vec![folder.to_owned()]);
    while let Some(place) = folders.pop() {
        for entry in std::fs::read_dir(&place)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path.clone());
            }
            found.push(path);
        }
    }
    Ok(found)
}

/// The files below `place`, or `place` itself if it is one.
pub fn files(place: &Path) -> Result<Vec<PathBuf>> {
    if place.is_dir() {
        return Ok(entries(place)?.into_iter().filter(|path| path.is_file()).collect());
    }
    Ok(place.is_file().then(|| place.to_owned()).into_iter().collect())
}

/// What the files below `folder` take \[bytes\], each in whole pages of memory.
pub fn bytes(folder: &Path) -> Result<u64> {
    const PAGE_BYTES: u64 = 4096;
    let sizes = files(folder)?.into_iter().map(|file| Ok(std::fs::metadata(file)?.len().next_multiple_of(PAGE_BYTES)));
    sizes.sum::<std::io::Result<u64>>().map_err(Into::into)
}

/// Copies all that is in `from` into `to`.
pub fn copy(from: &Path, to: &Path) -> Result<()> {
    std::fs::create_dir_all(to)?;
    let mut places = entries(from)?;
    places.sort();
    for path in places {
        let target = to.join(path.strip_prefix(from)?);
        if path.is_dir() {
            std::fs::create_dir_all(target)?;
        } else {
            std::fs::copy(&path, target)?;
        }
    }
    Ok(())
}
