//! Kalman filters for a seam measured frame by frame: one engine ([`Gaussian`] over a [`StateSpace`]), the models of
//! four papers on top of it.
//!
//! The letters are the literature's: x state, P its covariance, F transition, Qd process noise over one step, H
//! measurement matrix, R measurement noise, S covariance of the innovation, K gain. Units are those of the model that
//! made the state space; times are seconds.

mod coloured_measurement;
mod gaussian;
mod imm;
mod state_space;

pub use coloured_measurement::ColouredMeasurement;
pub use gaussian::{ChiSquareGate, Gaussian, InnovationNotPositive, Update};
pub use imm::{Imm, ImmUpdate};
pub use state_space::{InvalidParameter, StateSpace};
