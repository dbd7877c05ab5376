//! What a run leaves behind and how a person looks at it: `path.csv`, `summary.json`, `report.html`, the overlay
//! and the terminal summary. This folder reads results only; it never tracks.
//!
//! A results directory holds
//! * `path.csv` and `summary.json`: the contract ([`results`], [`summary`]);
//! * `truth.csv`: a copy of the truth, if one was given ([`truth`]);
//! * `thumbnails/`: JPEGs of a bounded number of frames, and `index.json` with their marks ([`thumbnails`]);
//! * of the melt pool: the files of [`pool`] instead;
//! * `report.html` ([`page`]) and `*.tum` ([`tum`]), which [`export`] makes from the former.

pub mod atomic;
#[cfg(feature = "cli")]
pub mod batch;
#[cfg(feature = "cli")]
pub mod calibration;
#[cfg(feature = "cli")]
mod canvas;
#[cfg(feature = "cli")]
mod charts;
#[cfg(feature = "cli")]
pub mod compare;
pub mod errors;
#[cfg(feature = "cli")]
pub mod export;
pub mod facts;
#[cfg(feature = "cli")]
pub mod foxglove;
#[cfg(feature = "cli")]
mod head;
pub mod marks;
#[cfg(feature = "cli")]
pub mod matrix;
#[cfg(feature = "cli")]
pub mod measures;
#[cfg(feature = "cli")]
mod model;
#[cfg(feature = "cli")]
pub mod overlay;
#[cfg(feature = "cli")]
pub mod page;
mod path_row;
#[cfg(feature = "cli")]
pub mod places;
#[cfg(feature = "cli")]
pub mod pool;
pub mod results;
pub mod run;
pub mod summary;
#[cfg(feature = "cli")]
pub mod table;
#[cfg(feature = "cli")]
pub mod terminal;
#[cfg(feature = "cli")]
pub mod textplot;
pub mod thumbnails;
pub mod tolerance;
pub mod trace;
pub mod truth;
pub mod tum;
pub mod verdict;

#[cfg(feature = "page")]
pub(crate) use head::head;
