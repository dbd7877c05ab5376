//! `seamtrack`: the weld seam in laser-stripe frames, in millimetres.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    // A reader that has seen enough (`seamtrack … | head`) ends the program quietly, as it does other tools.
    sigpipe::reset();
    let command = cli::Cli::parse();
    match command.run() {
        Ok(code) => code,
        Err(error) => {
            // One line: every cause adds to the one before it.
            eprintln!("seamtrack: {}", cli::one_line(&error));
            ExitCode::from(1)
        }
    }
}
