//! The melt-pool measures against made-up pools whose truth is known.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod measure;
