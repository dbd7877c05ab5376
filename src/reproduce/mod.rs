//! The four papers' experiments, run as printed, with the paper's figures beside ours.
//!
//! Where a paper's data are not published its series are simulated, and each table says with which noise. Seeds are
//! 1, 2, … and every figure is the median over them.

pub mod du;
pub mod infrared;
pub mod jiang;
mod score;
mod series;
mod table;
pub mod zhang;

pub use score::Score;
pub use table::{Row, Table};
