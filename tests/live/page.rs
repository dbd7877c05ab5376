//! The page over HTTP, and in a browser: what it shows, whom it obeys, and that nobody who looks holds up the loop.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Child;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::browser::{Page, chromium};
use crate::program::{configured, done, end, free_tcp, numbers, seamtrack, text, wait_until};

const TOKEN: &str = "twelve letters";

/// A live run with a page, while it lasts.
pub struct Run {
    _folder: tempfile::TempDir,
    live: Option<Child>,
    address: SocketAddr,
}

impl Run {
    fn start(more: &str) -> Self {
        Self::at("scene:butt-clean", more)
    }

    /// At a camera, with more of a configuration.
    pub fn at(camera: &str, more: &str) -> Self {
        let (folder, address) = (tempfile::tempdir().unwrap(), free_tcp());
        let config = format!("camera = \"{camera}\"\npage = \"{address}\"\n{more}\n[track]\nmm_per_px = 0.073\n");
        let live = seamtrack().args(["live", "--quiet", "--config"]).arg(configured(folder.path(), &config)).spawn();
        let run = Self { _folder: folder, live: Some(live.unwrap()), address };
        wait_until("a page", || TcpStream::connect(address).is_ok());
        run
    }

    /// Sends a request as it stands and gives status line and body.
    fn ask(&self, request: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut bytes = vec![];
        stream.read_to_end(&mut bytes).unwrap();
        let head = bytes.windows(4).position(|window| window == b"\r\n\r\n").map_or(bytes.len(), |at| at + 4);
        let status = text(&bytes[..head]).split(' ').nth(1).and_then(|word| word.parse().ok()).unwrap_or(0);
        (status, bytes[head..].to_vec())
    }

    pub fn request(&self, method: &str, path: &str, more: &str) -> (u16, Vec<u8>) {
        let address = self.address;
        self.ask(&format!("{method} {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n{more}\r\n"))
    }

    /// The lines of a new listener to events.
    pub fn events(&self) -> impl Iterator<Item = Value> + use<> {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        write!(stream, "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let lines = BufReader::new(stream).lines().map(Result::unwrap);
        lines.filter_map(|line| serde_json::from_str(line.strip_prefix("data: ")?).ok())
    }

    #[cfg(feature = "camera")]
    pub fn pid(&self) -> u32 {
        self.live.as_ref().unwrap().id()
    }

    /// What the run says at its end.
    pub fn end(mut self) -> String {
        let live = self.live.take().unwrap();
        end(&live, "-TERM");
        done(&live.wait_with_output().unwrap())
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        if let Some(mut live) = self.live.take() {
            let _ = live.kill();
            let _ = live.wait();
        }
    }
}

#[test]
fn states_arrive_pictures_are_jpeg_and_what_is_not_there_is_refused() {
    let run = Run::start("");
    let (status, page) = run.request("GET", "/", "");
    let page = text(&page);
    assert!(status == 200 && page.contains("id=\"state\"") && !page.contains("id=\"reset\""), "{page}");
    // The name of SVG is no address.
    let page = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!page.contains("http://") && !page.contains("https://"), "nothing from outside");
    let events: Vec<Value> = run.events().take(15).collect();
    assert!(events[0].is_array(), "first the last minute: {}", events[0]);
    let cycles: Vec<u64> = events[1..].iter().map(|event| event["cycle"].as_u64().unwrap()).collect();
    assert!(cycles.windows(2).all(|pair| pair[0] <= pair[1]) && cycles[0] < cycles[13], "{cycles:?}");
    let last = &events[14];
    assert!(last["state"].is_string() && last["frames"].as_array().unwrap().len() == 4, "{last}");
    // A starved tracker has none for a while.
    wait_until("a picture", || run.request("GET", "/picture.jpg", "").0 == 200);
    let (status, jpeg) = run.request("GET", "/picture.jpg", "");
    assert!(status == 200 && jpeg.starts_with(&[0xff, 0xd8]) && jpeg.ends_with(&[0xff, 0xd9]));
    for (method, path, expected) in [
        ("GET", "/nope", 404),
        ("GET", "/../live.toml", 404),
        ("GET", "/picture.jpg/..%2f..%2fetc/passwd", 404),
        ("POST", "/", 405),
        ("DELETE", "/events", 405),
        ("GET", "/stop", 405),
        ("POST", "/stop", 403),
    ] {
        assert_eq!(run.request(method, path, "").0, expected, "{method} {path}");
    }
    assert_eq!(run.ask("GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n").0, 403, "DNS rebinding");
    assert_eq!(run.ask("\u{1}\u{2}nonsense\r\n\r\n").0, 400);
    assert_eq!(run.request("GET", "/", "").0, 200, "it goes on");
    run.end();
}

#[test]
fn orders_need_the_token_and_are_carried_out_once() {
    let run = Run::start(&format!("page_token = \"{TOKEN}\""));
    assert!(text(&run.request("GET", "/", "").1).contains("id=\"reset\""));
    for wrong in ["", "Authorization: Bearer wrong letters!\r\n", "Authorization: Basic dHdlbHZlIGxldHRlcnM=\r\n"] {
        assert_eq!(run.request("POST", "/stop", wrong).0, 403);
    }
    let right = format!("Authorization: Bearer {TOKEN}\r\n");
    let mut states = run.events().skip(1).map(|event| (event["state"].clone(), event["why"].clone()));
    assert_ne!(states.next().unwrap().1, "asked");
    assert_eq!(run.request("POST", "/stop", &right).0, 200);
    assert!(states.by_ref().take(20).any(|(state, why)| state == "STOP" && why == "asked"));
    assert_eq!(run.request("POST", "/reset", &right).0, 200);
    assert!(states.by_ref().take(20).any(|(state, _)| state != "STOP"));
    run.end();
}

#[test]
fn who_reads_slowly_or_not_at_all_holds_up_nobody() {
    let run = Run::start("");
    // Listeners that never read, half requests, and more connections than there are places.
    let mut idle = vec![];
    for i in 0..60 {
        let mut stream = TcpStream::connect(run.address).unwrap();
        let what = [
            "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n",
            "GET /picture.jpg HTTP/1.1\r\nHost: localhost\r\n\r\n",
            "GET /",
        ];
        // What is hung up on may be so before it is written to.
        let _ = stream.write_all(what[i % 3].as_bytes());
        idle.push(stream);
    }
    std::thread::sleep(Duration::from_secs(3));
    idle.truncate(12);
    std::thread::sleep(Duration::from_millis(300));
    let began = Instant::now();
    let cycles: Vec<u64> = run.events().skip(1).take(21).map(|event| event["cycle"].as_u64().unwrap()).collect();
    let took_s = began.elapsed().as_secs_f64();
    let per_s = (cycles[20] - cycles[0]) as f64 / took_s;
    println!("{per_s:.0} cycles a second beside 12 listeners that do not read, events took {took_s:.2} s for 2.1");
    // 100 on a quiet machine, where it was measured.
    assert!(per_s > 10.0, "the robot's thread goes on: {per_s}");
    drop(idle);
    println!("{}", run.end());
}

#[test]
fn a_page_that_cannot_be_had_is_one_clear_error() {
    let folder = tempfile::tempdir().unwrap();
    let told = |more: &str| {
        let text_of_config = format!("camera = \"scene:butt-clean\"\n{more}\n[track]\nmm_per_px = 0.073\n");
        let output = seamtrack().args(["live", "--config"]).arg(configured(folder.path(), &text_of_config)).output();
        text(&output.unwrap().stderr)
    };
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let said = told(&format!("page = \"{}\"", taken.local_addr().unwrap()));
    assert!(said.contains("is another program on it?") && said.lines().count() == 1, "{said}");
    assert!(told("page = \"127.0.0.1:0\"\npage_token = \"short\"").contains("12 characters or more"));
}

/// Where screenshots go, to be looked at.
fn screenshot(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("live-screenshots");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(format!("{name}.png"))
}

#[test]
fn the_page_lives_in_a_browser() {
    let Some(program) = chromium() else {
        eprintln!("SKIPPED: no chromium on PATH, so the page was not opened; on Debian: apt-get install chromium");
        return;
    };
    for (name, window, scheme) in [("wide", (1366, 768), "light"), ("phone", (390, 844), "dark")] {
        // One browser a run: when a run ends its page complains.
        let mut page = Page::open(&program);
        let run = Run::start(&format!("page_token = \"{TOKEN}\""));
        let is_there =
            "+document.documentElement?.dataset.shown > 25 && +document.documentElement.dataset.pictures > 3";
        page.show_url(&format!("http://{}/", run.address), window, scheme, is_there);
        page.screenshot(&screenshot(name));
        let state = page.evaluate("document.getElementById('state').textContent");
        assert!(["WAIT", "OK", "COAST", "LOST", "STOP"].iter().any(|known| state == *known), "{state}");
        assert_eq!(page.evaluate("document.documentElement.scrollWidth <= innerWidth"), true, "{name}");
        assert!(page.evaluate("+document.documentElement.dataset.width").as_f64().unwrap() > 100.0);
        let own = format!("http://{}/", run.address);
        let foreign: Vec<String> =
            page.requests().into_iter().filter(|url| !url.starts_with("http://127.0.0.1:")).collect();
        assert!(foreign.is_empty(), "only {own}: {foreign:?}");
        assert_eq!(page.complaints(), Vec::<String>::new());
        page.evaluate(
            "document.getElementById('token').value = 'twelve letters'; document.getElementById('stop').click()",
        );
        page.wait_for("document.getElementById('said').textContent === 'done'");
        page.wait_for("document.getElementById('state').textContent === 'STOP'");
        let report = run.end();
        println!("{report}");
        assert!(numbers(&report, "robot's cycles:").iter().sum::<f64>() > 100.0, "{report}");
    }
}
