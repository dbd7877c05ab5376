//! What a simulated cell tells of its weld.

use std::fmt;

use crate::live::spread::Spread;
use crate::live::{State, Why, state_names};

/// What the torch did.
#[derive(Debug, Clone, Default)]
pub struct CellReport {
    /// Cycles of the robot.
    pub cycles: u64,
    /// By the state that was answered; EGM tells none.
    pub by_state: [u64; State::ALL.len()],
    /// Answers with a correction.
    pub corrections: u64,
    /// Answers without one.
    pub holds: u64,
    /// Cycles without an answer in time, and most of them in a row; those of a cut network not counted.
    pub late: u64,
    /// Most late ones in a row.
    pub longest_late: u64,
    /// From asking to the answer \[ms\].
    pub answer_ms: Spread,
    /// Largest correction of one cycle \[mm\].
    pub largest_step_mm: f64,
    /// Torch beside the seam, from 10 mm behind the first correction on, also after a reset.
    pub torch: TorchError,
    /// The seam beside the taught line at the same places: what the error were without corrections.
    pub uncorrected: TorchError,
    /// Why corrections stopped, in their order.
    pub stops: Vec<String>,
    /// How far the torch came \[mm\].
    pub reached_mm: f64,
    /// Pictures sent, and lost on purpose.
    pub pictures: u64,
    /// Pictures lost on purpose.
    pub lost: u64,
    /// Pictures not made, since the one before was not ready.
    pub skipped: u64,
}

/// A distance's mean, root mean square and maximum, without keeping its values.
#[derive(Debug, Clone, Default)]
pub struct TorchError {
    count: u64,
    sum_mm: f64,
    squares_mm2: f64,
    max_mm: f64,
}

impl TorchError {
    /// Takes one.
    pub(super) fn push(&mut self, error_mm: f64) {
        self.count += 1;
        self.sum_mm += error_mm;
        self.squares_mm2 += error_mm * error_mm;
        self.max_mm = self.max_mm.max(error_mm.abs());
    }

    /// Number of values.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Root mean square \[mm\].
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        (self.squares_mm2 / (self.count.max(1)) as f64).sqrt()
    }

    /// Mean \[mm\].
    #[must_use]
    pub fn mean_mm(&self) -> f64 {
        self.sum_mm / (self.count.max(1)) as f64
    }

    /// Largest \[mm\].
    #[must_use]
    pub const fn max_mm(&self) -> f64 {
        self.max_mm
    }
}

impl fmt::Display for TorchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "mean {:+.3}, rms {:.3}, max {:.3}", self.mean_mm(), self.rms_mm(), self.max_mm)
    }
}

impl fmt::Display for CellReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "torch beside the seam [mm]: {} over {:.0} mm", self.torch, self.reached_mm)?;
        writeln!(f, "without corrections [mm]: {}", self.uncorrected)?;
        if self.by_state.iter().any(|count| *count > 0) {
            writeln!(f, "states: {}", state_names(&self.by_state))?;
        }
        writeln!(f, "answers: corrections {}, holds {}", self.corrections, self.holds)?;
        writeln!(f, "answer [ms]: {}", self.answer_ms)?;
        let late_pct = 100.0 * self.late as f64 / self.cycles.max(1) as f64;
        writeln!(
            f,
            "late: {} of {} cycles ({late_pct:.2} %), longest run {}",
            self.late, self.cycles, self.longest_late
        )?;
        writeln!(f, "largest step [mm]: {:.4}", self.largest_step_mm)?;
        writeln!(f, "pictures: {} sent, {} lost, {} skipped", self.pictures, self.lost, self.skipped)?;
        self.stops.iter().try_for_each(|stop| writeln!(f, "stopped: {stop}"))
    }
}

/// A stop in words.
pub fn stop_in_words(why: Option<Why>, at_mm: f64) -> String {
    format!("{} at {at_mm:.1} mm", why.map_or("unknown", Why::name))
}
