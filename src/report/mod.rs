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
pub mod batch;
pub mod calibration;
mod canvas;
mod charts;
pub mod compare;
pub mod errors;
pub mod export;
pub mod facts;
pub mod foxglove;
mod head;
pub mod marks;
pub mod matrix;
pub mod measures;
mod model;
pub mod overlay;
pub mod page;
mod path_row;
pub mod places;
pub mod pool;
pub mod results;
pub mod run;
pub mod summary;
pub mod table;
pub mod terminal;
pub mod textplot;
pub mod thumbnails;
pub mod tolerance;
pub mod trace;
pub mod truth;
pub mod tum;
pub mod verdict;
