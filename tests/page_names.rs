//! Names of files are a stranger's text: on every page they are shown, and none is taken for markup or a script.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test that cannot do its part must fail")]

#[expect(dead_code, reason = "another test moves the mouse and takes pictures")]
mod browser;

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use browser::{Page, chromium};

/// What a folder, a picture and a truth may be called.
const FOLDER: &str = "<img src=x onerror=window.hit=1>";
const PICTURE: &str = "'\"><svg onload=window.hit=1><script>window.hit=1;<!--";
const TRUTH: &str = "]]>&lt;<style onload=window.hit=1>.csv";

/// A recording of the demonstration's first frames under such names, with a truth.
fn recording(folder: &Path) -> (PathBuf, PathBuf) {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/demo-butt");
    let recording = folder.join(FOLDER);
    fs::create_dir(&recording).unwrap();
    for frame in 0..6 {
        fs::copy(demo.join(format!("frames/frame_{frame:06}.png")), recording.join(format!("{PICTURE}{frame}.png")))
            .unwrap();
    }
    let truth = folder.join(TRUTH);
    let rows: String = fs::read_to_string(demo.join("truth.csv"))
        .unwrap()
        .lines()
        .take(7)
        .fold(String::new(), |text, line| text + line + "\n");
    fs::write(&truth, rows).unwrap();
    (recording, truth)
}

fn run(command: &str, arguments: &[&dyn AsRef<std::ffi::OsStr>]) {
    let mut program = Command::cargo_bin("seamtrack").unwrap();
    program.arg(command).args(arguments.iter().map(|argument| argument.as_ref())).assert().success();
}

/// The pages of a run, of two beside each other, and of a melt pool.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let (input, truth) = recording(folder);
    let at = |name: &str| folder.join(name);
    for name in ["<b>a", "b\"onmouseover=window.hit=1"] {
        run(
            "track",
            &[
                &input,
                &"--joint",
                &"butt",
                &"--quiet",
                &"--truth",
                &truth,
                &"--max-unavailable",
                &"100",
                &"-o",
                &at(name),
            ],
        );
    }
    let two: [&dyn AsRef<std::ffi::OsStr>; 4] =
        [&at("<b>a"), &at("b\"onmouseover=window.hit=1"), &"-o", &at("two.html")];
    run("compare", &two);
    let pool = at("<i>pool");
    let made = at("made");
    run("synth", &[&"pool-width", &"-o", &made]);
    let frames = at("<u onclick=window.hit=1>");
    fs::rename(made.join("frames"), &frames).unwrap();
    run("meltpool", &[&frames, &"--measure", &"width", &"--quiet", &"--max-unavailable", &"100", &"-o", &pool]);
    vec![at("<b>a").join("report.html"), at("two.html"), pool.join("report.html")]
}

#[test]
fn every_page_has_a_policy_and_shows_names_with_markup_as_text() {
    let folder = tempfile::tempdir().unwrap();
    let pages = pages(folder.path());
    let mut browser = chromium().map(|program| Page::open(&program));
    if browser.is_none() {
        eprintln!("SKIPPED in part: no chromium on PATH, so the pages were read, not opened");
    }
    for page in &pages {
        let text = fs::read_to_string(page).unwrap();
        let policy = text.find("Content-Security-Policy").unwrap();
        assert!(policy < text.find("<style").unwrap() && text[policy..].contains("default-src 'none'"));
        for markup in
            ["<img src=x", "<svg onload", "<script>window.hit", "<style onload", "<u onclick", "<b>a", "<i>pool"]
        {
            assert!(!text.contains(markup), "{}: {markup}", page.display());
        }
        let Some(browser) = &mut browser else { continue };
        browser.show(page, (1366, 768), "light");
        assert_eq!(browser.evaluate("typeof window.hit"), "undefined", "{}", page.display());
        assert_eq!(browser.complaints(), Vec::<String>::new(), "{}", page.display());
        let elements = "document.querySelectorAll('img[src=x], [onload], [onerror], [onclick], [onmouseover]').length";
        assert_eq!(browser.evaluate(elements), 0, "{}", page.display());
    }
    let shown = fs::read_to_string(&pages[0]).unwrap();
    assert!(shown.contains("&lt;img src=x onerror=window.hit=1&gt;"), "the recording is named");
}
