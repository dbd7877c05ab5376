//! Steps of a filter as links of a chain, for a smoother that looks a few frames ahead while the filter runs.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::SMatrix;

use super::gaussian::{Gaussian, symmetric};

/// One step of a filter: what it predicted, what it then knew, and how a correction of the prediction corrects the step
/// before (the gain of Rauch, Tung and Striebel 1965).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link<const N: usize> {
    /// The state predicted from the step before.
    pub prior: Gaussian<N>,
    /// The state after the step's measurement.
    pub posterior: Gaussian<N>,
    /// C of the step before; none where the filter started, or started anew.
    pub gain: Option<SMatrix<f64, N, N>>,
}

impl<const N: usize> Link<N> {
    /// The first link of a chain.
    #[must_use]
    pub const fn first(state: Gaussian<N>) -> Self {
        Self { prior: state, posterior: state, gain: None }
    }

    /// The link to a prediction `prior` made from `before` by the transition `F`, before its measurement.
    #[must_use]
    pub fn predicted(before: &Gaussian<N>, F: &SMatrix<f64, N, N>, prior: Gaussian<N>) -> Self {
        let gain = prior.P.cholesky().map(|inverse| inverse.solve(&(F * before.P)).transpose());
        Self { prior, posterior: prior, gain }
    }

    /// The same moment once more.
    #[must_use]
    pub fn repeated(&self) -> Self {
        Self { prior: self.posterior, posterior: self.posterior, gain: Some(SMatrix::identity()) }
    }
}

/// The state of the first of `links` given all of them, as far as they hang together.
#[must_use]
pub fn first_of<const N: usize>(links: &[Link<N>]) -> Option<Gaussian<N>> {
    let whole = links.iter().skip(1).take_while(|link| link.gain.is_some()).count();
    let mut smoothed = links.get(whole)?.posterior;
    for pair in links[..=whole].windows(2).rev() {
        let [before, after] = pair else { continue };
        let Some(C) = after.gain else { break };
        let filtered = before.posterior;
        smoothed = Gaussian {
            x: filtered.x + C * (smoothed.x - after.prior.x),
            P: symmetric(filtered.P + C * (smoothed.P - after.prior.P) * C.transpose()),
        };
    }
    Some(smoothed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kalman::{ColouredMeasurement, Frame, Trajectory, smoother};

    /// A wandering series through a filter, as links and as a trajectory.
    fn series() -> (Vec<Link<3>>, Trajectory<3, 1>) {
        let model = ColouredMeasurement::new(1e-2, 0.1, 0.5, 0.2, 1.0).unwrap();
        let start = model.start_from_clean(0.0, 1.0).unwrap();
        let frames: Vec<Frame<1>> = (1..40)
            .map(|t| {
                let t = f64::from(t);
                Frame {
                    dt_s: 1.0,
                    z: [(t % 7.0 != 0.0).then(|| 3.0 * (0.2 * t).sin() + 0.3 * (5.1 * t).cos())],
                    R: None,
                }
            })
            .collect();
        let run = Trajectory::filter(start, &frames, |seconds| model.state_space(seconds), None).unwrap();
        let mut links = vec![Link::first(start)];
        for step in &run.steps {
            let before = links[links.len() - 1].posterior;
            let link = Link::predicted(&before, &step.space.F, step.prior);
            links.push(Link { posterior: step.update.posterior, ..link });
        }
        (links, run)
    }

    #[test]
    fn links_of_one_model_give_what_its_fixed_lag_smoother_gives() {
        let (links, run) = series();
        for (lag, expected) in [(0, smoother::fixed_lag(&run, 0)), (6, smoother::fixed_lag(&run, 6))] {
            for (i, expected) in expected.iter().enumerate() {
                let end = (i + lag + 1).min(links.len());
                let smoothed = first_of(&links[i..end]).unwrap();
                assert!((smoothed.x - expected.x).amax() < 1e-9 && (smoothed.P - expected.P).amax() < 1e-9);
            }
        }
    }

    #[test]
    fn a_filter_that_starts_anew_says_nothing_of_what_was_before() {
        let (mut links, _) = series();
        links[5].gain = None;
        assert_eq!(first_of(&links[3..9]), first_of(&links[3..5]));
        assert_eq!(first_of::<3>(&[]), None);
    }

    #[test]
    fn a_repeated_moment_has_the_same_state() {
        let (mut links, _) = series();
        let twice = links[8].repeated();
        links.insert(9, twice);
        let (once, again) = (first_of(&links[8..14]).unwrap(), first_of(&links[9..14]).unwrap());
        assert!((once.x - again.x).amax() < 1e-12);
    }
}
