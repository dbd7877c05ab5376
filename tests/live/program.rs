//! The program, its configuration, and free ports.

use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

pub fn seamtrack() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seamtrack"));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// An address that nobody listened at a moment ago.
pub fn free_tcp() -> SocketAddr {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap()
}

pub fn free_udp() -> SocketAddr {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap()
}

/// Writes a configuration.
pub fn configured(folder: &Path, text: &str) -> PathBuf {
    let file = folder.join("live.toml");
    std::fs::write(&file, text).unwrap();
    file
}

/// Asks a program to end, as a terminal or a service manager does.
pub fn end(child: &Child, signal: &str) {
    let pid = child.id().to_string();
    assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
}

pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < Duration::from_secs(60), "{what}: not within a minute");
        std::thread::sleep(Duration::from_millis(20));
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The standard output of a program that did what it was asked for.
pub fn done(output: &Output) -> String {
    assert!(output.status.success(), "{:?}: {}", output.status, text(&output.stderr));
    text(&output.stdout)
}

/// The numbers of a report's line that begins with `name`.
pub fn numbers(report: &str, name: &str) -> Vec<f64> {
    let line = report.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("no {name:?} in {report}"));
    let line = &line[name.len()..];
    line.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-')).filter_map(|word| word.parse().ok()).collect()
}
