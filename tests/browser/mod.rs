//! Headless Chromium, driven by its DevTools protocol over a pipe: no driver program, no port, no network.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a browser that does not answer fails the test")]

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use base64::Engine;
use serde_json::{Value, json};

/// Longest wait for an answer of the browser.
const PATIENCE: Duration = Duration::from_secs(60);

/// The browser's program, if it is installed.
pub fn chromium() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    let candidates = std::env::split_paths(&folders)
        .flat_map(|folder| ["chromium", "chromium-browser", "google-chrome"].map(|name| folder.join(name)));
    candidates.into_iter().find(|path| path.is_file())
}

/// One page in a browser of its own.
pub struct Page {
    browser: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    session: String,
    last_id: u64,
    /// Everything the page reported since it was opened, as protocol messages.
    pub events: Vec<Value>,
    _profile: tempfile::TempDir,
}

impl Page {
    /// Start the browser with an empty page.
    pub fn open(chromium: &Path) -> Self {
        let profile = tempfile::tempdir().unwrap();
        // The protocol's pipe is file descriptors 3 (in) and 4 (out).
        let mut browser = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1"])
            .arg(chromium)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
            .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
            .args(["--remote-debugging-pipe", "--hide-scrollbars"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let to = browser.stdin.take().unwrap();
        let answers = browser.stdout.take().unwrap();
        let (sender, from) = channel();
        std::thread::spawn(move || read_messages(answers, |message| sender.send(message).is_ok()));
        let (session, events) = (String::new(), Vec::new());
        let mut page = Self { browser, to, from, session, last_id: 0, events, _profile: profile };
        let target = page.call("Target.createTarget", json!({"url": "about:blank"}));
        let attached = page.call("Target.attachToTarget", json!({"targetId": target["targetId"], "flatten": true}));
        page.session = attached["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Page", "Runtime", "Network", "Log"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        page
    }

    /// Call a method of the protocol and wait for its result.
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        self.last_id += 1;
        let mut message = json!({"id": self.last_id, "method": method, "params": params});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        write!(self.to, "{message}\0").unwrap();
        loop {
            let answer = self.from.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("no answer to {method}"));
            if answer["id"] == self.last_id {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    /// The value of a JavaScript expression.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let result = self
            .call("Runtime.evaluate", json!({"expression": expression, "returnByValue": true, "awaitPromise": true}));
        assert!(result["exceptionDetails"].is_null(), "{expression}: {}", result["exceptionDetails"]);
        result["result"]["value"].clone()
    }

    /// Show `file`, which draws itself by a script, in a window of a size and colour scheme, and wait until it is drawn.
    pub fn show(&mut self, file: &Path, window: (u32, u32), scheme: &str) {
        self.show_until(file, window, scheme, "document.documentElement?.dataset.ready === 'true'");
    }

    /// Show `file`, which has no script.
    pub fn show_static(&mut self, file: &Path, window: (u32, u32), scheme: &str) {
        let place = json!(file.to_string_lossy());
        let loaded = format!("document.readyState === 'complete' && decodeURIComponent(location.pathname) === {place}");
        self.show_until(file, window, scheme, &loaded);
    }

    fn show_until(&mut self, file: &Path, window: (u32, u32), scheme: &str, is_there: &str) {
        self.show_url(&format!("file://{}", file.display()), window, scheme, is_there);
    }

    /// Show what is at an address, and wait until an expression is true.
    pub fn show_url(&mut self, url: &str, (width, height): (u32, u32), scheme: &str, is_there: &str) {
        self.call(
            "Emulation.setDeviceMetricsOverride",
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false}),
        );
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
        self.call("Page.navigate", json!({ "url": url }));
        self.wait_for(is_there);
        self.settle();
    }

    /// Wait until an expression is true.
    pub fn wait_for(&mut self, is_there: &str) {
        for _ in 0..600 {
            if self.evaluate(is_there) == true {
                return;
            }
            assert_eq!(self.complaints(), Vec::<String>::new());
            std::thread::sleep(Duration::from_millis(50));
        }
        panic!("{is_there} did not come true; events: {:?}", self.complaints());
    }

    /// Wait until what was asked for is painted.
    pub fn settle(&mut self) {
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))");
    }

    /// Send a mouse event at a place in the window.
    pub fn mouse(&mut self, kind: &str, (x, y): (f64, f64)) {
        let button = if kind == "mouseMoved" { "none" } else { "left" };
        self.call("Input.dispatchMouseEvent", json!({"type": kind, "x": x, "y": y, "button": button, "clickCount": 1}));
        self.settle();
    }

    /// Save what the window shows as PNG.
    pub fn screenshot(&mut self, path: &Path) {
        let shot = self.call("Page.captureScreenshot", json!({"format": "png"}));
        let png = base64::prelude::BASE64_STANDARD.decode(shot["data"].as_str().unwrap()).unwrap();
        std::fs::write(path, png).unwrap();
    }

    /// Console messages, exceptions and log entries since the start.
    pub fn complaints(&self) -> Vec<String> {
        let loud = ["Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"];
        let is_loud = |event: &&Value| loud.iter().any(|method| event["method"] == *method);
        self.events.iter().filter(is_loud).map(Value::to_string).collect()
    }

    /// Addresses requested since the start, but for what the page carries within itself.
    pub fn requests(&self) -> Vec<String> {
        let sent = self.events.iter().filter(|event| event["method"] == "Network.requestWillBeSent");
        let urls = sent.filter_map(|event| event["params"]["request"]["url"].as_str());
        urls.filter(|url| !url.starts_with("data:") && !url.starts_with("blob:")).map(str::to_owned).collect()
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // Closing the pipe ends the browser; wait, so that its profile can be removed.
        let _ = write!(self.to, "{}\0", json!({"id": 0, "method": "Browser.close"}));
        for _ in 0..100 {
            if matches!(self.browser.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}

fn read_messages(answers: impl Read, mut deliver: impl FnMut(Value) -> bool) {
    let mut answers = BufReader::with_capacity(1 << 20, answers);
    let mut message = Vec::new();
    while answers.read_until(0, &mut message).is_ok_and(|count| count > 0) {
        message.pop();
        if !serde_json::from_slice(&message).is_ok_and(&mut deliver) {
            return;
        }
        message.clear();
    }
}
