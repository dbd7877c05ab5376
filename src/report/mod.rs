//! What a run leaves behind and how a person looks at it: `path.csv`, `summary.json`, `report.html`, the overlay
//! and the terminal summary. This folder reads results only; it never tracks.

pub mod atomic;
pub mod results;
pub mod summary;
