//! `seamtrack live` and `seamtrack cell`, as programs.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

#[cfg(feature = "page")]
#[path = "../browser/mod.rs"]
#[expect(dead_code, reason = "other tests move the mouse and open files")]
mod browser;
#[cfg(all(feature = "camera", feature = "page"))]
mod camera;
mod cell;
#[cfg(feature = "page")]
mod page;
mod peers;
mod program;
mod record;
