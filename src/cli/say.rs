//! Standard output and standard error. Either may be closed or full: that ends no run and loses no result.

use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::Context;

/// Longest message on one line \[characters\]; the middle of a longer one is left out. Chosen: a path and a reason fit.
const LONGEST_MESSAGE: usize = 1000;
/// What stays of a longer one at its end, where the reason and the remedy stand.
const END_OF_MESSAGE: usize = 300;

/// Writes text to standard output. A reader that has left (`seamtrack … | head`) is no error: it has seen enough.
///
/// # Errors
/// When standard output cannot be written, such as on a full disk.
pub fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("cannot write to standard output"),
        _ => Ok(()),
    }
}

/// Writes a line to standard error, if that can be written. Control characters are shown, not sent.
pub fn tell(message: &str) {
    let line = format!("seamtrack: {}\n", plain(&bounded(message)));
    let _ = std::io::stderr().lock().write_all(line.as_bytes());
}

/// A path for the terminal: control characters, which a file's name may hold, are shown, not sent.
pub fn shown(path: &Path) -> String {
    plain(&path.to_string_lossy())
}

/// The text without characters that steer a terminal: control characters and those that turn the writing round.
pub fn plain(text: &str) -> String {
    let steers = |c: char| {
        c.is_control() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    text.chars().fold(String::with_capacity(text.len()), |mut plain, c| {
        if steers(c) {
            plain.extend(c.escape_default());
        } else {
            plain.push(c);
        }
        plain
    })
}

/// An error and its causes in one line, no cause twice.
pub fn one_line(error: &(dyn std::error::Error + 'static)) -> String {
    let mut line = String::new();
    let causes = std::iter::successors(Some(error), |cause| cause.source());
    for cause in causes.map(|cause| cause.to_string().trim().replace('\n', " ")) {
        if !line.contains(&cause) {
            line += if line.is_empty() { "" } else { ": " };
            line += &cause;
        }
    }
    line
}

fn bounded(message: &str) -> String {
    let length = message.chars().count();
    if length <= LONGEST_MESSAGE {
        return message.to_owned();
    }
    let start: String = message.chars().take(LONGEST_MESSAGE - END_OF_MESSAGE).collect();
    let end: String = message.chars().skip(length - END_OF_MESSAGE).collect();
    format!("{start} … {end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_and_letters_of_any_language_kept() {
        assert_eq!(plain("Näht\u{1b}[2J\u{7}\r\u{202e}"), "Näht\\u{1b}[2J\\u{7}\\r\\u{202e}");
    }

    #[test]
    fn a_long_message_keeps_its_beginning_and_its_end() {
        let long = format!("rec: {}: copy it again", "x".repeat(200_000));
        let told = bounded(&long);
        assert!(
            told.chars().count() < LONGEST_MESSAGE + 5
                && told.starts_with("rec: x")
                && told.ends_with("x: copy it again")
        );
    }
}
