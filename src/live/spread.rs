//! How numbers are spread, in memory that does not grow.

use std::fmt;

/// Bins a decade, and the least and largest number that has a bin of its own.
const BINS_A_DECADE: f64 = 50.0;
const LEAST: f64 = 1e-4;
const BINS: usize = 450;

/// Numbers above zero by size, each known to 5 %; the largest exactly.
#[derive(Debug, Clone)]
pub struct Spread {
    bins: Vec<u64>,
    count: u64,
    largest: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self { bins: vec![0; BINS], count: 0, largest: 0.0 }
    }
}

impl Spread {
    /// Takes a number; of one that is none nothing is kept.
    pub fn push(&mut self, number: f64) {
        if number.is_nan() {
            return;
        }
        let bin = ((number / LEAST).log10() * BINS_A_DECADE).clamp(0.0, (BINS - 1) as f64);
        self.bins[bin as usize] += 1;
        self.count += 1;
        self.largest = self.largest.max(number);
    }

    /// How many numbers were taken.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The largest.
    #[must_use]
    pub const fn largest(&self) -> f64 {
        self.largest
    }

    /// The number that the share `share` of all does not exceed, to 5 %.
    #[must_use]
    pub fn quantile(&self, share: f64) -> f64 {
        let wanted = (share * self.count as f64).ceil() as u64;
        let mut below = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            below += count;
            if below >= wanted && below > 0 {
                return (LEAST * 10f64.powf((bin + 1) as f64 / BINS_A_DECADE)).min(self.largest);
            }
        }
        self.largest
    }
}

impl fmt::Display for Spread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.count == 0 {
            return f.write_str("none");
        }
        let (p50, p99) = (self.quantile(0.5), self.quantile(0.99));
        write!(f, "p50 {p50:.3}, p99 {p99:.3}, max {:.3} ({} values)", self.largest, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_to_five_percent_and_the_largest_is_exact() {
        let mut spread = Spread::default();
        (1..=10_000).for_each(|i| spread.push(f64::from(i) * 1e-3));
        for (share, expected) in [(0.5, 5.0), (0.99, 9.9)] {
            assert!((spread.quantile(share) / expected - 1.0).abs() < 0.05, "{}", spread.quantile(share));
        }
        assert_eq!((spread.largest(), spread.count(), Spread::default().quantile(0.5)), (10.0, 10_000, 0.0));
    }
}
