//! The commands that write, each with what it makes of an older and of a newer input, and what belongs together in it.

/// Files and folders that take their names in one step, by their places below the folder where a command works.
#[derive(Debug, Clone, Copy)]
pub enum Unit {
    /// A folder: all of it is of one run.
    Folder(&'static str),
    /// Files: those that are there are of one run, and the first one is.
    Files(&'static [&'static str]),
}

/// A command that is killed.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Its name in the table.
    pub name: &'static str,
    /// Its arguments; `INPUT` is the path of the older or newer input without its ending, `INPUTS` the folder of all.
    pub arguments: &'static [&'static str],
    /// What it writes.
    pub units: &'static [Unit],
    /// Its part of the runs.
    pub share: usize,
}

const fn case(name: &'static str, share: usize, arguments: &'static [&'static str], units: &'static [Unit]) -> Case {
    Case { name, arguments, units, share }
}

const OUT: Unit = Unit::Folder("out");

/// All of them.
pub const CASES: [Case; 12] = [
    case(
        "track",
        8,
        &["track", "INPUT", "-o", "out", "--joint", "butt", "--quiet", "--trace", "--max-unavailable", "100"],
        &[OUT],
    ),
    case(
        "track --overlay DIR",
        4,
        &[
            "track",
            "INPUT",
            "-o",
            "out",
            "--joint",
            "butt",
            "--quiet",
            "--max-unavailable",
            "100",
            "--overlay",
            "drawn",
        ],
        &[OUT, Unit::Folder("drawn")],
    ),
    case(
        "track --overlay FILE.mp4",
        4,
        &[
            "track",
            "INPUT",
            "-o",
            "out",
            "--joint",
            "butt",
            "--quiet",
            "--max-unavailable",
            "100",
            "--overlay",
            "a.mp4",
        ],
        &[OUT, Unit::Files(&["a.mp4"])],
    ),
    case(
        "track --mcap",
        4,
        &["track", "INPUT", "-o", "out", "--joint", "butt", "--quiet", "--max-unavailable", "100", "--mcap", "a.mcap"],
        &[OUT, Unit::Files(&["a.mcap"])],
    ),
    case(
        "track, a batch",
        8,
        &[
            "track",
            "INPUT/a",
            "INPUT/b",
            "INPUT/c",
            "-o",
            "out",
            "--joint",
            "butt",
            "--quiet",
            "--jobs",
            "2",
            "--max-unavailable",
            "100",
        ],
        &[
            Unit::Folder("out/a"),
            Unit::Folder("out/b"),
            Unit::Folder("out/c"),
            Unit::Files(&["out/batch.csv", "out/index.html"]),
        ],
    ),
    case("synth", 4, &["synth", "INPUT.toml", "-o", "out"], &[OUT]),
    case(
        "meltpool",
        4,
        &["meltpool", "INPUT-pool", "-o", "out", "--measure", "width", "--quiet", "--max-unavailable", "100"],
        &[OUT],
    ),
    case("filter", 4, &["filter", "INPUT.csv", "--model", "white", "--fit", "-o", "out"], &[OUT]),
    case(
        "calibrate camera",
        4,
        &["calibrate", "camera", "INPUT-boards", "--square", "15", "-o", "camera.toml"],
        &[Unit::Files(&["camera.toml", "camera.html"])],
    ),
    case(
        "calibrate laser",
        4,
        &["calibrate", "laser", "INPUT-stripes", "--camera", "INPUTS/known.toml", "--square", "15", "-o", "laser.toml"],
        &[Unit::Files(&["laser.toml", "laser.html"])],
    ),
    case(
        "calibrate scale",
        2,
        &["calibrate", "scale", "INPUT-gauge.csv", "-o", "scale.toml"],
        &[Unit::Files(&["scale.toml"])],
    ),
    case("compare", 4, &["compare", "INPUT-run", "INPUT-other", "-o", "two.html"], &[Unit::Files(&["two.html"])]),
];
