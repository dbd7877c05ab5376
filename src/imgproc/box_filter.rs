//! Running means along a row, the one smoothing the notch evidence needs: constant time a sample.

/// Prefix sums of a row, reusable from row to row.
#[derive(Debug, Clone, Default)]
pub(crate) struct RunningSums {
    prefix: Vec<f64>,
}

impl RunningSums {
    /// Takes the sums of `row`.
    pub(crate) fn load(&mut self, row: impl Iterator<Item = f32>) {
        self.prefix.clear();
        self.prefix.push(0.0);
        let mut sum = 0.0;
        self.prefix.extend(row.map(|value| {
            sum += f64::from(value);
            sum
        }));
    }

    /// Number of samples of the row.
    pub(crate) fn len(&self) -> usize {
        self.prefix.len().saturating_sub(1)
    }

    /// Sum and number of the samples within `half` of `centre`; the window ends at the row's ends.
    fn window(&self, centre: usize, half: usize) -> (f64, f64) {
        let (first, end) = (centre.saturating_sub(half), (centre + half + 1).min(self.len()));
        (self.prefix[end] - self.prefix[first], (end - first) as f64)
    }

    /// Mean of the samples within `half` of `centre`.
    pub(crate) fn mean(&self, centre: usize, half: usize) -> f32 {
        let (sum, count) = self.window(centre, half);
        (sum / count) as f32
    }

    /// Mean within `contrast.centre` minus the mean of the flanks between `contrast.guard` and `contrast.outer`.
    /// Both flanks weigh the same, so that a slope gives nothing; zero where one of them leaves the row.
    pub(crate) fn contrast(&self, at: usize, contrast: Contrast) -> f32 {
        let Contrast { centre, guard, outer } = contrast;
        if at < outer || at + outer >= self.len() {
            return 0.0;
        }
        let flank = |first: usize, end: usize| (self.prefix[end] - self.prefix[first]) / (end - first) as f64;
        let flanks = 0.5 * (flank(at - outer, at - guard) + flank(at + guard + 1, at + outer + 1));
        self.mean(at, centre) - flanks as f32
    }

    /// Mean of the `reach` samples to the right minus that to the left; zero where one of them leaves the row.
    pub(crate) fn step(&self, at: usize, reach: usize) -> f32 {
        if at < reach || at + reach >= self.len() {
            return 0.0;
        }
        let left = self.prefix[at] - self.prefix[at - reach];
        let right = self.prefix[at + reach + 1] - self.prefix[at + 1];
        ((right - left) / reach as f64) as f32
    }
}

/// Half widths of a centre-minus-flanks filter \[px\], `centre <= guard < outer`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Contrast {
    /// The centre is `|d| <= centre`.
    pub(crate) centre: usize,
    /// The flanks begin beyond `guard` …
    pub(crate) guard: usize,
    /// … and end at `outer`.
    pub(crate) outer: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_has_no_contrast_and_a_dip_has_its_depth() {
        let contrast = Contrast { centre: 1, guard: 3, outer: 9 };
        let mut sums = RunningSums::default();
        sums.load((0..60).map(|u| 0.5 * u as f32));
        assert!((9..51).all(|u| sums.contrast(u, contrast).abs() < 1e-4));
        sums.load((0..60).map(|u| if (29..=31).contains(&u) { 3.0 } else { 10.0 }));
        assert!((sums.contrast(30, contrast) + 7.0).abs() < 1e-5);
        assert_eq!(sums.contrast(2, contrast), 0.0);
    }

    #[test]
    fn a_step_has_its_height_and_a_dip_none() {
        let mut sums = RunningSums::default();
        sums.load((0..60).map(|u| if u < 30 { 1.0 } else { 4.0 }));
        assert!((sums.step(30, 8) - 3.0).abs() < 1e-6 && sums.step(45, 8) == 0.0);
        sums.load((0..60).map(|u| if u == 30 { 1.0 } else { 4.0 }));
        assert_eq!(sums.step(30, 8), 0.0);
    }

    #[test]
    fn a_window_at_the_border_averages_what_there_is() {
        let mut sums = RunningSums::default();
        sums.load([1.0, 2.0, 3.0, 4.0].into_iter());
        assert_eq!(sums.mean(0, 1), 1.5);
        assert_eq!(sums.mean(2, 9), 2.5);
    }
}
