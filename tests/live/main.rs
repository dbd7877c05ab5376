//! `seamtrack live` and `seamtrack cell`, as programs.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod cell;
mod peers;
mod program;
mod record;
