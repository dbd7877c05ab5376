//! Interacting multiple models: a straight seam, a bending one and a corner at once (Blom and Bar-Shalom 1988).

use nalgebra::{SMatrix, SVector};

use super::gaussian::{ChiSquareGate, Gaussian, InnovationNotPositive, symmetric};
use super::state_space::{InvalidParameter, StateSpace, finite};

/// Largest difference of NIS that still separates two models' likelihoods: beyond it one odd measurement would
/// switch the mixture for good. 60, that is e⁻³⁰, chosen.
const MAX_NIS_DIFFERENCE: f64 = 60.0;

/// K filters over one state, each with its probability. A step is a value: nothing is allocated, nothing mutated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Imm<const N: usize, const K: usize> {
    /// The state under each model.
    pub states: [Gaussian<N>; K],
    /// The probability of each model; they add up to one.
    pub probabilities: [f64; K],
    stay: f64,
}

/// The outcome of one update of the mixture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImmUpdate<const N: usize, const M: usize, const K: usize> {
    /// The mixture after the measurement.
    pub posterior: Imm<N, K>,
    /// Log-likelihood of the measurement under the mixture; 0 when nothing was measured.
    pub log_likelihood: f64,
    /// f of each model: 1 unless the gate reduced it.
    pub weights: [f64; K],
}

impl<const N: usize, const K: usize> Imm<N, K> {
    /// K equally probable models that share the state `start`; each keeps its role in the next step with probability
    /// `stay` and gives the rest to the others in equal parts.
    ///
    /// # Errors
    /// When `stay` is not within 0 … 1.
    pub fn new(start: Gaussian<N>, stay: f64) -> Result<Self, InvalidParameter> {
        if !(0.0..=1.0).contains(&finite("the probability to stay", stay)?) {
            return Err(InvalidParameter::NotAProbability { name: "the probability to stay", value: stay });
        }
        #[expect(clippy::cast_precision_loss, reason = "a handful of models")]
        let equal = 1.0 / K as f64;
        Ok(Self { states: [start; K], probabilities: [equal; K], stay: if K == 1 { 1.0 } else { stay } })
    }

    /// Probability that model `from` gives way to model `to` when each stays with probability `stay`.
    fn transition(stay: f64, from: usize, to: usize) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a handful of models")]
        let others = (K.max(2) - 1) as f64;
        if from == to { stay } else { (1.0 - stay) / others }
    }

    /// The mixture one step later: the states mixed by the transition probabilities, each predicted by its model.
    #[must_use]
    pub fn predict<const M: usize>(&self, spaces: &[StateSpace<N, M>; K]) -> Self {
        self.predict_over(spaces, 1.0)
    }

    /// The same where the models of `spaces` lie `steps` steps apart, whole or not: the more, the likelier a change.
    #[must_use]
    pub fn predict_over<const M: usize>(&self, spaces: &[StateSpace<N, M>; K], steps: f64) -> Self {
        let stay = self.stay.powf(steps);
        let probabilities: [f64; K] = std::array::from_fn(|to| {
            (0..K).map(|from| Self::transition(stay, from, to) * self.probabilities[from]).sum()
        });
        let states = std::array::from_fn(|to| {
            let share: [f64; K] = std::array::from_fn(|from| {
                Self::transition(stay, from, to) * self.probabilities[from] / probabilities[to].max(f64::MIN_POSITIVE)
            });
            moment_match(&self.states, &share).predict(&spaces[to])
        });
        Self { states, probabilities, stay: self.stay }
    }

    /// The mixture after a measurement with the R of `spaces` (override it there by [`StateSpace::with_R`]); every
    /// model is gated by its own innovation. Rows that are none count as not measured.
    ///
    /// # Errors
    /// When a model's S is not positive definite.
    pub fn update<const M: usize>(
        &self,
        spaces: &[StateSpace<N, M>; K],
        z: &[Option<f64>; M],
        gate: Option<ChiSquareGate<M>>,
    ) -> Result<ImmUpdate<N, M, K>, InnovationNotPositive> {
        let mut posterior = *self;
        let mut log_likelihoods = [0.0; K];
        let mut weights = [1.0; K];
        for (model, space) in spaces.iter().enumerate() {
            let update = self.states[model].update(space, z, gate)?;
            posterior.states[model] = update.posterior;
            log_likelihoods[model] = update.log_likelihood;
            weights[model] = update.weight;
        }
        let best = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut total = 0.0;
        for (probability, log_likelihood) in posterior.probabilities.iter_mut().zip(log_likelihoods) {
            *probability *= (log_likelihood - best).max(-0.5 * MAX_NIS_DIFFERENCE).exp();
            total += *probability;
        }
        for probability in &mut posterior.probabilities {
            *probability /= total;
        }
        Ok(ImmUpdate { posterior, log_likelihood: best + total.ln(), weights })
    }

    /// The mixture's mean and covariance, the spread between the models included.
    #[must_use]
    pub fn output(&self) -> Gaussian<N> {
        moment_match(&self.states, &self.probabilities)
    }

    /// Normalised innovation squared of a measurement against the whole mixture, eᵀ (H P Hᵀ + R)⁻¹ e with P from
    /// [`Imm::output`]; none when nothing was measured.
    ///
    /// # Errors
    /// When the innovation's covariance is not positive definite.
    pub fn nis<const M: usize>(
        &self,
        space: &StateSpace<N, M>,
        z: &[Option<f64>; M],
    ) -> Result<Option<f64>, InnovationNotPositive> {
        Ok(self.output().update(space, z, None)?.nis)
    }

    /// The transition the mixture stands for, Σ μᵢ Fᵢ.
    #[must_use]
    pub fn transition_matrix<const M: usize>(&self, spaces: &[StateSpace<N, M>; K]) -> SMatrix<f64, N, N> {
        spaces.iter().zip(self.probabilities).map(|(space, probability)| space.F * probability).sum()
    }

    /// The process noise the mixture stands for, Σ μᵢ Qdᵢ.
    #[must_use]
    pub fn process_noise<const M: usize>(&self, spaces: &[StateSpace<N, M>; K]) -> SMatrix<f64, N, N> {
        spaces.iter().zip(self.probabilities).map(|(space, probability)| space.Qd * probability).sum()
    }
}

/// The Gaussian with the mean and covariance of the mixture Σ wᵢ N(xᵢ, Pᵢ).
fn moment_match<const N: usize, const K: usize>(states: &[Gaussian<N>; K], weights: &[f64; K]) -> Gaussian<N> {
    let x: SVector<f64, N> = states.iter().zip(weights).map(|(state, weight)| state.x * *weight).sum();
    let spread = |(state, weight): (&Gaussian<N>, &f64)| {
        let d = state.x - x;
        (state.P + d * d.transpose()) * *weight
    };
    Gaussian { x, P: symmetric(states.iter().zip(weights).map(spread).sum()) }
}
