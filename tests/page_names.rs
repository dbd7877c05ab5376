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

/// The pages of a run, of two beside each other, of a melt pool, of a calibration, of a batch.
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
    let mut pages = vec![at("<b>a").join("report.html"), at("two.html"), pool.join("report.html")];
    pages.extend(calibration_pages(folder));
    pages.push(batch_page(folder, &input));
    pages
}

/// The pages of a camera and of a laser plane, of pictures under such names.
fn calibration_pages(folder: &Path) -> [PathBuf; 2] {
    let at = |name: &str| folder.join(name);
    let made = at("sensor");
    run("synth", &[&"sensor-butt", &"--frames", &"1", &"--boards", &"9", &"-o", &made]);
    // Of pairs the names stand in a list.
    let mut pairs = String::from("dark,lit\n");
    for part in ["boards", "stripes"] {
        for picture in fs::read_dir(made.join(part)).unwrap().map(|entry| entry.unwrap().path()) {
            let own = picture.file_name().unwrap().to_string_lossy().into_owned();
            let name = format!("<svg onload=window.hit=1>{own}");
            fs::rename(&picture, picture.with_file_name(&name)).unwrap();
            if own.starts_with("on") {
                pairs += &format!("{},{name}\n", name.replace(">on", ">off"));
            }
        }
    }
    fs::write(at("pairs.csv"), pairs).unwrap();
    let camera = at("<b>camera.toml");
    let (boards, stripes) = (at("<img src=x onerror=window.hit=1>boards"), at("<u onclick=window.hit=1>stripes"));
    fs::rename(made.join("boards"), &boards).unwrap();
    fs::rename(made.join("stripes"), &stripes).unwrap();
    run("calibrate", &[&"camera", &boards, &"--square", &"15", &"-o", &camera]);
    let laser = at("<i>laser.toml");
    run("calibrate", &[&"laser", &stripes, &"--camera", &camera, &"--pairs", &at("pairs.csv"), &"-o", &laser]);
    [camera, laser].map(|file| file.with_extension("html"))
}

/// The index of two recordings, of which one has no results.
fn batch_page(folder: &Path, input: &Path) -> PathBuf {
    let broken = folder.join("<style onload=window.hit=1>broken.tif");
    fs::write(&broken, "no picture").unwrap();
    let output = folder.join("<b>batch");
    let mut program = Command::cargo_bin("seamtrack").unwrap();
    program.arg("track").arg(input).arg(&broken).args(["--joint", "butt", "--quiet"]).arg("-o").arg(&output);
    program.assert().code(1);
    output.join("index.html")
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
        if text.contains("<script") {
            browser.show(page, (1366, 768), "light");
        } else {
            browser.show_static(page, (1366, 768), "light");
        }
        assert_eq!(browser.evaluate("typeof window.hit"), "undefined", "{}", page.display());
        assert_eq!(browser.complaints(), Vec::<String>::new(), "{}", page.display());
        let elements = "document.querySelectorAll('img[src=x], [onload], [onerror], [onclick], [onmouseover]').length";
        assert_eq!(browser.evaluate(elements), 0, "{}", page.display());
    }
    let shown = fs::read_to_string(&pages[0]).unwrap();
    assert!(shown.contains("&lt;img src=x onerror=window.hit=1&gt;"), "the recording is named");
}
