//! px to mm.
