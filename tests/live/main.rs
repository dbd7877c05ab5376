//! `seamtrack live` and `seamtrack cell`, as programs.

mod cell;
mod peers;
mod program;
mod record;
