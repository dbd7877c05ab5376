//! What a run over a melt pool leaves: its own `path.csv` and `summary.json`, the page, the overlay.

mod overlay;
mod page;
mod results;
mod summary;
mod truth;
mod verdict;

pub use overlay::{PoolMarks, draw};
pub use page::write_pool_report;
pub use results::{PoolRow, read_pool_csv, write_pool_csv};
pub use summary::{
    PoolCalibration, PoolErrors, PoolInput, PoolSummary, SENSOR, is_pool_summary, read_pool_summary, write_pool_summary,
};
pub use truth::parse_true_values;
pub use verdict::{PoolVerdict, pool_verdict};
