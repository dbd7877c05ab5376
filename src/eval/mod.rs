//! a path against a truth.
