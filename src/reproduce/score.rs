//! The papers' error figures.

/// Errors of one run, estimate − truth, in one unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Mean absolute error.
    pub mean_absolute: f64,
    /// Largest absolute error.
    pub largest: f64,
    /// Standard deviation of the absolute error, as in Du 2022.
    pub deviation_of_absolute: f64,
    /// Root mean square error.
    pub rms: f64,
    /// Mean signed error.
    pub mean: f64,
}

impl Score {
    /// The figures of `errors`; all zero for none.
    #[must_use]
    pub fn of(errors: &[f64]) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "counts far below 2⁵²")]
        let count = errors.len().max(1) as f64;
        let mean_of = |value: &dyn Fn(f64) -> f64| errors.iter().map(|error| value(*error)).sum::<f64>() / count;
        let mean_absolute = mean_of(&f64::abs);
        let square = mean_of(&|error| error * error);
        Self {
            mean_absolute,
            largest: errors.iter().copied().map(f64::abs).fold(0.0, f64::max),
            deviation_of_absolute: (square - mean_absolute * mean_absolute).max(0.0).sqrt(),
            rms: square.sqrt(),
            mean: mean_of(&|error| error),
        }
    }

    /// Mean square error: the "covariance" of the infrared paper and Jiang 2016, where a run's own mean error counts
    /// as error.
    #[must_use]
    pub fn mean_square(&self) -> f64 {
        self.rms * self.rms
    }

    /// The median of each figure over several runs.
    #[must_use]
    pub fn median(runs: &[Self]) -> Self {
        Self::each(runs, median)
    }

    /// The worst of each figure over several runs: the one farthest from 0.
    #[must_use]
    pub fn worst(runs: &[Self]) -> Self {
        Self::each(runs, |values| {
            values.into_iter().fold(0.0, |worst: f64, value| if value.abs() > worst.abs() { value } else { worst })
        })
    }

    fn each(runs: &[Self], choose: impl Fn(Vec<f64>) -> f64) -> Self {
        let of = |value: fn(&Self) -> f64| choose(runs.iter().map(value).collect());
        Self {
            mean_absolute: of(|run| run.mean_absolute),
            largest: of(|run| run.largest),
            deviation_of_absolute: of(|run| run.deviation_of_absolute),
            rms: of(|run| run.rms),
            mean: of(|run| run.mean),
        }
    }
}

/// The middle value, or the mean of the two in the middle; 0 for none.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    match values.len() {
        0 => 0.0,
        count if count % 2 == 1 => values[half],
        _ => 0.5 * (values[half - 1] + values[half]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figures_are_those_of_the_papers() {
        let score = Score::of(&[1.0, -7.0]);
        assert_eq!((score.mean_absolute, score.largest, score.mean, score.mean_square()), (4.0, 7.0, -3.0, 25.0));
        assert_eq!(score.deviation_of_absolute, 3.0);
    }

    #[test]
    fn the_worst_is_taken_figure_by_figure() {
        let worst = Score::worst(&[Score::of(&[1.0, -7.0]), Score::of(&[4.5, 4.5]), Score::of(&[-5.0, -5.0])]);
        assert_eq!((worst.mean_absolute, worst.largest, worst.mean), (5.0, 7.0, -5.0));
    }

    #[test]
    fn the_median_of_an_even_number_lies_between_the_two_in_the_middle() {
        assert_eq!(median(vec![4.0, 1.0, 3.0, 100.0]), 3.5);
    }
}
