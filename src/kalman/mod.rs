//! the filters of the four papers, one engine.
