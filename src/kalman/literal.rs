//! Jiang 2016, equations (15)–(19), as printed: for study only, since they lose positive definiteness at once.
//!
//! Read are (19) as Φ X̂ + ŵ, for η does not have the state's size, and η̂ into the innovation; Q̂ enters (12) as the
//! 3×3 matrix that (16) gives. The recursions count from k₀ so that the start's numbers weigh for k₀ frames.
#![expect(non_snake_case, reason = "matrices carry the literature's letters")]

use nalgebra::{SMatrix, SVector};

use super::gaussian::{Gaussian, symmetric};
use super::state_space::{StateSpace, is_semidefinite};

/// The printed adaptive filter: state, and the four statistics it learns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiteralAdaptation<const N: usize, const M: usize> {
    /// The state.
    pub state: Gaussian<N>,
    /// ŵ, mean of the process noise (15).
    pub w: SVector<f64, N>,
    /// Q̂, covariance of the process noise (16).
    pub Q: SMatrix<f64, N, N>,
    /// η̂, mean of the measurement noise (17).
    pub eta: SVector<f64, M>,
    /// R̂, covariance of the measurement noise (18).
    pub R: SMatrix<f64, M, M>,
    k: u32,
}

/// The outcome of one step of the printed equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiteralStep<const N: usize, const M: usize> {
    /// The state before the measurement.
    pub prior: Gaussian<N>,
    /// Y − H X̂⁻ − η̂; none without a complete measurement.
    pub innovation: Option<SVector<f64, M>>,
    /// Covariance of the innovation.
    pub S: SMatrix<f64, M, M>,
    /// eᵀ S⁻¹ e, which is negative where S is indefinite.
    pub nis: Option<f64>,
    /// The first matrix that is no covariance any more.
    pub lost: Option<Lost>,
}

/// A matrix that is no longer a covariance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lost {
    /// P before the measurement.
    PredictedP,
    /// The innovation's S.
    S,
    /// P after the measurement.
    P,
    /// The learnt Q̂.
    Q,
    /// The learnt R̂.
    R,
}

impl std::fmt::Display for Lost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::PredictedP => "the predicted P",
            Self::S => "the innovation's S",
            Self::P => "the updated P",
            Self::Q => "the learnt Q",
            Self::R => "the learnt R",
        })
    }
}

impl<const N: usize, const M: usize> LiteralAdaptation<N, M> {
    /// Starts with the noises of `space` and zero means, counting from `k0`.
    #[must_use]
    pub fn new(start: Gaussian<N>, space: &StateSpace<N, M>, k0: u32) -> Self {
        Self { state: start, w: SVector::zeros(), Q: space.Qd, eta: SVector::zeros(), R: space.R, k: k0 }
    }

    /// One step with the F and H of `space`. An incomplete measurement only predicts: the paper has none.
    pub fn step(&mut self, space: &StateSpace<N, M>, z: &[Option<f64>; M]) -> LiteralStep<N, M> {
        let (F, H) = (&space.F, &space.H);
        let before = self.state;
        let carried = F * before.P * F.transpose();
        let prior = Gaussian { x: F * before.x + self.w, P: symmetric(carried + self.Q) };
        let HPHt = H * prior.P * H.transpose();
        let S = symmetric(HPHt + self.R);
        self.state = prior;
        let complete = z.iter().all(|row| row.is_some_and(f64::is_finite));
        let lost = (!is_semidefinite(&prior.P)).then_some(Lost::PredictedP);
        if !complete {
            return LiteralStep { prior, innovation: None, S, nis: None, lost };
        }
        let Some(S_inverse) = S.try_inverse() else {
            return LiteralStep { prior, innovation: None, S, nis: None, lost: lost.or(Some(Lost::S)) };
        };
        let deviation = SVector::from(z.map(|row| row.unwrap_or_default())) - H * prior.x;
        let e = deviation - self.eta;
        let K = prior.P * H.transpose() * S_inverse;
        let I_KH = SMatrix::<f64, N, N>::identity() - K * H;
        let P = symmetric(I_KH * prior.P * I_KH.transpose() + K * self.R * K.transpose());
        self.state = Gaussian { x: prior.x + K * e, P };

        self.k = self.k.saturating_add(1);
        let (old, new) = (f64::from(self.k - 1) / f64::from(self.k), 1.0 / f64::from(self.k));
        self.w = self.w * old + (self.state.x - F * before.x) * new;
        self.Q = self.Q * old + (K * e * e.transpose() * K.transpose() + P - carried) * new;
        self.eta = self.eta * old + deviation * new;
        self.R = self.R * old + (e * e.transpose() - HPHt) * new;

        let after = [
            (Lost::S, is_semidefinite(&S)),
            (Lost::P, is_semidefinite(&P)),
            (Lost::Q, is_semidefinite(&self.Q)),
            (Lost::R, is_semidefinite(&self.R)),
        ];
        let lost = lost.or(after.into_iter().find_map(|(matrix, definite)| (!definite).then_some(matrix)));
        LiteralStep { prior, innovation: Some(e), S, nis: Some(e.dot(&(S_inverse * e))), lost }
    }
}
