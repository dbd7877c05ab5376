//! The page in headless Chromium: drawn, quiet, offline, alive under the mouse, nothing cut off.
#![expect(clippy::unwrap_used, reason = "a test that cannot do its part must fail")]

mod browser;
mod report_run;

use std::path::{Path, PathBuf};

use browser::{Page, chromium};
use report_run::{GOOD, Noise, write_run};
use seamtrack::report::compare::comparison_rows;
use seamtrack::report::page::{DEFAULT_MAX_BYTES, write_comparison, write_report};
use seamtrack::report::run::Run;

const WINDOWS: [(u32, u32); 3] = [(1366, 768), (1920, 1080), (390, 844)];

/// The browser, or a loud word that the test was skipped.
fn page() -> Option<Page> {
    let found = chromium();
    if found.is_none() {
        eprintln!("SKIPPED: no chromium on PATH, so the report was not opened; on Debian: apt-get install chromium");
    }
    found.map(|program| Page::open(&program))
}

/// Where screenshots go, to be looked at.
fn screenshot(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report-screenshots");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(format!("{name}.png"))
}

/// Elements that reach out of the window or whose text is clipped.
const CUT_OFF: &str = "(() => {
  const found = [];
  if (document.documentElement.scrollWidth > innerWidth) found.push(`page ${document.documentElement.scrollWidth} wide`);
  for (const node of document.querySelectorAll('body *:not(script)')) {
    const box = node.getBoundingClientRect();
    if (node.closest('.picture, clipPath, [clip-path]') || !box.width) continue;
    if (box.left < -1 || box.right > innerWidth + 1) found.push(`${node.tagName}.${node.className?.baseVal ?? node.className} ${box.left}..${box.right}`);
    const style = getComputedStyle(node);
    if (style.overflowX === 'hidden' && node.scrollWidth > node.clientWidth + 1) found.push(`${node.tagName}#${node.id} clipped`);
  }
  for (const text of document.querySelectorAll('.chart text')) {
    const box = text.getBoundingClientRect(), around = text.ownerSVGElement.getBoundingClientRect();
    if (box.left < around.left - 1 || box.right > around.right + 1 || box.top < around.top - 2 || box.bottom > around.bottom + 2)
      found.push(`text '${text.textContent}' leaves its plot`);
  }
  return found;
})()";

fn centre_of(page: &mut Page, selector: &str, share: f64) -> (f64, f64) {
    let script = format!(
        "(() => {{ const b = document.querySelector('{selector}').getBoundingClientRect();
           return [b.left + {share} * b.width, b.top + b.height / 2]; }})()"
    );
    let place = page.evaluate(&script);
    (place[0].as_f64().unwrap(), place[1].as_f64().unwrap())
}

fn shown_frame(page: &mut Page) -> String {
    page.evaluate("document.querySelector('#viewer b').textContent").as_str().unwrap().to_owned()
}

/// The page of a made-up run of so many frames, in a folder of its own.
fn report(frames: usize) -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    write_run(dir.path(), frames, GOOD, true);
    let file = dir.path().join("report.html");
    write_report(&file, &Run::read(dir.path()).unwrap(), DEFAULT_MAX_BYTES).unwrap();
    (dir, file)
}

fn assert_quiet_and_offline(page: &Page, file: &Path) {
    assert_eq!(page.complaints(), Vec::<String>::new());
    let own = format!("file://{}", file.display());
    assert!(page.requests().iter().all(|url| *url == own), "only the page itself: {:?}", page.requests());
}

#[test]
fn the_report_is_drawn_offline_without_complaint_and_nothing_is_cut_off() {
    let Some(mut page) = page() else { return };
    let (_dir, file) = report(250);
    for (window, scheme) in WINDOWS.into_iter().flat_map(|window| [(window, "light"), (window, "dark")]) {
        page.show(&file, window, scheme);
        let drawn = page
            .evaluate("[...document.querySelectorAll('.curve')].filter(c => c.getAttribute('d').length > 99).length");
        assert!(drawn.as_u64().unwrap() >= 12, "{drawn} curves have points");
        assert_eq!(page.evaluate(CUT_OFF), serde_json::json!([]), "{window:?}");
        page.screenshot(&screenshot(&format!("report-{}-{scheme}", window.0)));
        page.evaluate("document.querySelector('#viewer .tools button').click(); goTo(123, true)");
        page.settle();
        page.screenshot(&screenshot(&format!("report-{}-{scheme}-close-up", window.0)));
        page.evaluate("document.querySelector('.diagnostics').open = true; scrollTo(0, 1e6)");
        page.settle();
        let seen = page.evaluate(
            "document.querySelector('#plot-nis').scrollIntoView({ block: 'center' }),
             (box => (Math.min(box.bottom, innerHeight) - Math.max(box.top, 0)) / box.height)(document.querySelector('.picture').getBoundingClientRect())",
        );
        assert!(seen.as_f64().unwrap() > 0.9, "the picture stays in view: {seen} of it, {window:?}");
        page.screenshot(&screenshot(&format!("report-{}-{scheme}-middle", window.0)));
        page.evaluate("scrollTo(0, 1e6)");
        page.settle();
        assert_eq!(page.evaluate(CUT_OFF), serde_json::json!([]), "{window:?}, all of it");
        page.screenshot(&screenshot(&format!("report-{}-{scheme}-bottom", window.0)));
    }
    assert_quiet_and_offline(&page, &file);
}

#[test]
fn hovering_and_clicking_a_plot_shows_that_frame_and_dragging_zooms() {
    let Some(mut page) = page() else { return };
    let (_dir, file) = report(250);
    page.show(&file, WINDOWS[0], "light");

    let quarter = centre_of(&mut page, "#plot-path svg.chart:last-child", 0.25);
    page.mouse("mouseMoved", quarter);
    let hovered = shown_frame(&mut page);
    let picture = page.evaluate("document.querySelector('.picture').dataset.frame");
    assert_eq!(
        hovered,
        format!("Frame {}", picture.as_str().unwrap()),
        "every frame is stored, so it is the one shown"
    );
    page.evaluate("document.querySelector('.diagnostics').open = true; document.querySelector('#plot-psr').scrollIntoView({ block: 'center' })");
    page.settle();
    let half = centre_of(&mut page, "#plot-psr svg.chart:last-child", 0.5);
    page.mouse("mouseMoved", half);
    assert_ne!(shown_frame(&mut page), hovered, "hovering another plot shows another frame");

    page.mouse("mousePressed", half);
    page.mouse("mouseReleased", half);
    let held = shown_frame(&mut page);
    page.mouse("mouseMoved", (half.0 + 99.0, half.1));
    assert_eq!(shown_frame(&mut page), held, "a click holds the frame");

    page.evaluate("document.querySelector('#places button').click()");
    page.settle();
    assert_eq!(shown_frame(&mut page), "Frame 126", "the first entry of the list is the loss");

    let quarter = (half.0 - 99.0, half.1);
    for (kind, place) in [("mousePressed", quarter), ("mouseMoved", half), ("mouseReleased", half)] {
        page.mouse(kind, place);
    }
    let zoomed = page.evaluate("document.querySelector('#zoom-out').textContent");
    assert!(zoomed.as_str().unwrap().contains("show all"), "{zoomed}");
    assert_eq!(page.evaluate("document.querySelector('#zoom-out').hidden"), false);
    page.screenshot(&screenshot("report-zoomed"));
    page.evaluate("document.querySelector('#zoom-out').click()");
    page.settle();
    assert_eq!(page.evaluate("document.querySelector('#zoom-out').hidden"), true);

    let svg = page.evaluate("Chart.prototype.standalone.call(plots[1], view)");
    let svg = svg.as_str().unwrap();
    assert!(svg.starts_with("<svg") && !svg.contains("var(--"), "an exported plot stands alone");
    let png = page.evaluate(
        "new Promise(done => { save = (name, blob) => done([name, blob.type, blob.size]);
           savePng('p.png', Chart.prototype.standalone.call(plots[1], view)); })",
    );
    assert_eq!((png[0].as_str(), png[1].as_str()), (Some("p.png"), Some("image/png")));
    assert!(png[2].as_u64().unwrap() > 10_000, "a picture of {} bytes", png[2]);
    std::fs::write(screenshot("exported").with_extension("svg"), svg).unwrap();
    assert_quiet_and_offline(&page, &file);
}

#[test]
fn keys_hide_curves_the_axis_changes_its_unit_and_a_frame_has_an_address() {
    let Some(mut page) = page() else { return };
    let (_dir, file) = report(250);
    page.show(&file, WINDOWS[0], "light");

    let curves =
        "[document.querySelectorAll('.curve.smoothed').length, document.querySelectorAll('.picture .smoothed').length]";
    page.evaluate("goTo(50, true)");
    page.settle();
    let before = page.evaluate(curves);
    page.evaluate("document.querySelector('.key[data-look=smoothed]').click()");
    page.settle();
    let after = page.evaluate(curves);
    assert!(after[0].as_u64() < before[0].as_u64() && after[1] == 0 && before[1] == 1, "{before} {after}");
    assert_eq!(
        page.evaluate("document.querySelector('#plot-error .key[data-look=smoothed]').getAttribute('aria-pressed')"),
        "false"
    );

    let unit = "[...document.querySelectorAll('#plot-path text')].map(text => text.textContent).filter(text => ['frame', 's'].includes(text))";
    assert_eq!(page.evaluate(unit), serde_json::json!(["frame"]));
    page.evaluate("[...document.querySelectorAll('#axes button')].find(b => b.textContent === 'Seconds').click()");
    page.settle();
    assert_eq!(page.evaluate(unit), serde_json::json!(["s"]));
    let half = centre_of(&mut page, "#plot-path svg.chart:last-child", 0.5);
    page.evaluate("view.held = false");
    page.mouse("mouseMoved", half);
    let frame: usize = shown_frame(&mut page).trim_start_matches("Frame ").parse().unwrap();
    assert!((110..=140).contains(&frame), "the middle of the axis is the middle of the recording: {frame}");

    assert_eq!(
        page.evaluate("goTo(134, true), new Promise(done => setTimeout(() => done(location.hash), 200))"),
        "#frame=134"
    );
    page.evaluate("location.hash = '#frame=77', new Promise(done => setTimeout(done, 200))");
    assert_eq!(shown_frame(&mut page), "Frame 77");
    page.evaluate("document.querySelector('.player button').click(), new Promise(done => setTimeout(done, 1500))");
    page.evaluate("document.querySelector('.player button').click()");
    page.settle();
    let played: usize = shown_frame(&mut page).trim_start_matches("Frame ").parse().unwrap();
    assert!(played > 77, "{played}");
    page.evaluate("const slider = document.querySelector('.player input'); slider.value = 200; slider.oninput()");
    page.settle();
    assert_eq!(shown_frame(&mut page), "Frame 200");
    assert_quiet_and_offline(&page, &file);
}

#[test]
fn a_page_of_ten_thousand_frames_is_drawn_within_its_size() {
    let Some(mut page) = page() else { return };
    let (_dir, file) = report(10_000);
    let bytes = std::fs::metadata(&file).unwrap().len();
    assert!(bytes <= DEFAULT_MAX_BYTES as u64, "{bytes} bytes");
    page.show(&file, WINDOWS[1], "light");
    let opened_ms = page.evaluate("performance.timing.loadEventEnd - performance.timing.navigationStart");
    let redraw_ms = page.evaluate("(() => { const t = performance.now(); draw(); return performance.now() - t; })()");
    let hover_ms = page.evaluate("(() => { const t = performance.now(); for (let i = 0; i < 100; i++) { view.frame = i * 90; cursor(); } return (performance.now() - t) / 100; })()");
    eprintln!("10,000 frames: {bytes} bytes, opened in {opened_ms} ms, redraw {redraw_ms} ms, hover {hover_ms} ms");
    assert_eq!(page.evaluate(CUT_OFF), serde_json::json!([]));
    page.screenshot(&screenshot("report-10000"));
    assert_quiet_and_offline(&page, &file);
}

#[test]
fn a_comparison_is_drawn_with_a_ribbon_for_each_run() {
    let Some(mut page) = page() else { return };
    let dir = tempfile::tempdir().unwrap();
    let noisy = Noise { filtered_px: 0.8, smoothed_px: 0.4, ..GOOD };
    let names = [("paper", noisy), ("robust", GOOD)].map(|(name, quality)| {
        write_run(&dir.path().join(name), 250, quality, true);
        dir.path().join(name)
    });
    let runs: Vec<Run> = names.iter().map(|dir| Run::read(dir).unwrap()).collect();
    let file = dir.path().join("comparison.html");
    write_comparison(&file, &runs, &comparison_rows(&runs), DEFAULT_MAX_BYTES).unwrap();
    for (window, scheme) in [(WINDOWS[0], "dark"), (WINDOWS[1], "light"), (WINDOWS[2], "dark")] {
        page.show(&file, window, scheme);
        assert_eq!(page.evaluate("document.querySelectorAll('#plot-status').length"), 2);
        assert_eq!(page.evaluate(CUT_OFF), serde_json::json!([]));
        page.screenshot(&screenshot(&format!("comparison-{}-{scheme}", window.0)));
    }
    assert_quiet_and_offline(&page, &file);
}

/// `seamtrack` with arguments, in a folder; exit code 3 says BAD and is none of a page's business.
fn seamtrack(folder: &Path, arguments: &[&str]) {
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_seamtrack")).current_dir(folder).args(arguments).output();
    let run = run.unwrap();
    assert!(matches!(run.status.code(), Some(0 | 3)), "{arguments:?}: {}", String::from_utf8_lossy(&run.stderr));
}

fn fixture(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name).display().to_string()
}

#[test]
fn every_page_of_the_demonstration_and_of_a_batch_fits_every_window() {
    let Some(mut page) = page() else { return };
    let dir = tempfile::tempdir().unwrap();
    let (butt, hairline) = (fixture("demo-butt"), fixture("demo-hairline"));
    let (butt_truth, hairline_truth) = (format!("{butt}/truth.csv"), format!("{hairline}/truth.csv"));
    let list =
        format!("input,truth\n{butt},{butt_truth}\ncovers,covers/truth.csv\n{hairline},{hairline_truth}\nnowhere,\n");
    std::fs::write(dir.path().join("list.csv"), list).unwrap();
    let run = |arguments: &str| seamtrack(dir.path(), &arguments.split(' ').collect::<Vec<_>>());
    run("synth H-butt-covers --seed 61 --frames 120 -o covers");
    for more in ["robust --mm-per-px 0.073 --tolerance 0.1 --speed 5", "paper --preset paper", "pixels"] {
        let arguments = format!("track --manifest list.csv --quiet -o {more}");
        let one_is_missing = std::process::Command::new(env!("CARGO_BIN_EXE_seamtrack"))
            .current_dir(dir.path())
            .args(arguments.split(' '))
            .status();
        assert_eq!(one_is_missing.unwrap().code(), Some(1));
    }
    run("compare robust paper -o methods.html");
    run("compare robust/covers paper/covers -o comparison.html");
    let pages = [
        "robust/demo-butt/report.html",
        "robust/covers/report.html",
        "robust/demo-hairline/report.html",
        "pixels/demo-butt/report.html",
        "comparison.html",
        "robust/index.html",
        "methods.html",
    ];
    for name in pages {
        let file = dir.path().join(name);
        let is_static = name.ends_with("index.html") || name == "methods.html";
        for (window, scheme) in WINDOWS.into_iter().flat_map(|window| [(window, "light"), (window, "dark")]) {
            if is_static {
                page.show_static(&file, window, scheme);
            } else {
                page.show(&file, window, scheme);
            }
            assert_eq!(page.evaluate(CUT_OFF), serde_json::json!([]), "{name} {window:?}");
            let shot = name.replace(".html", "").replace('/', "-");
            page.screenshot(&screenshot(&format!("demo-{shot}-{}-{scheme}", window.0)));
        }
    }
    assert_eq!(page.complaints(), Vec::<String>::new());
}

/// Labels the parts of the page that the README explains, and takes its picture.
#[test]
#[ignore = "makes docs/pictures/report.png: make pictures"]
fn the_picture_of_the_readme() {
    let Some(mut page) = page() else { return };
    let dir = tempfile::tempdir().unwrap();
    let run = |arguments: &str| seamtrack(dir.path(), &arguments.split(' ').collect::<Vec<_>>());
    run("synth H-butt-covers --seed 61 --frames 120 -o covers");
    run("track covers --truth covers/truth.csv --mm-per-px 0.073 --speed 5 --quiet -o result");
    page.show(&dir.path().join("result/report.html"), (1366, 1290), "light");
    page.evaluate(
        "(() => {
           document.querySelector('.program').textContent = 'seamtrack · covers';
           const parts = ['.light', '#plot-status h2', '#plot-path h2', '#plot-gap h2', '#plot-error h2', '#viewer .now b', '#places h2', '.diagnostics summary'];
           parts.forEach((selector, k) => {
             const box = document.querySelector(selector).getBoundingClientRect();
             const label = document.createElement('div');
             label.textContent = k + 1;
             label.style = `position:absolute;left:${Math.max(box.left + scrollX - 25, 3)}px;top:${box.top + scrollY + box.height / 2 - 11}px;width:22px;height:22px;border-radius:11px;background:#b23a06;color:#fff;font:600 13px/22px system-ui;text-align:center;z-index:9`;
             document.body.append(label);
           });
           goTo(60, true);
         })()",
    );
    page.settle();
    let picture = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/pictures/report.png");
    page.screenshot(&picture);
}
