//! The melt-pool sensors: measures against made-up pools whose truth is known, and the program as a user meets it.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bad_input;
mod command;
mod measure;
mod npy;
mod real;
