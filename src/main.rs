//! `seamtrack`: the weld seam in laser-stripe frames, in millimetres.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let command = cli::Cli::parse();
    if !command.ends_itself() {
        cli::signals::end_without_leftovers();
    }
    let done = command.run();
    cli::signals::wait_if_ending();
    match done {
        Ok(code) => code,
        Err(error) => {
            // One line: every cause adds to the one before it.
            cli::say::tell(&cli::say::one_line(error.as_ref()));
            ExitCode::from(1)
        }
    }
}
