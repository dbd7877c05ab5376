//! Camera and laser plane: against a rendered sensor whose truth is known, against real boards, and against misuse.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod chain;
mod command;
mod misuse;
mod real;
mod sensor;
mod track;
