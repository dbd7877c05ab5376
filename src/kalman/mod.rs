//! Kalman filters for a seam measured frame by frame: one engine ([`Gaussian`] over a [`StateSpace`]), the models of
//! four papers on top of it.
//!
//! The letters are the literature's: x state, P its covariance, F transition, Qd process noise over one step, H
//! measurement matrix, R measurement noise, S covariance of the innovation, K gain. Units are those of the model that
//! made the state space; times are seconds.
//!
//! | file | what it does |
//! |---|---|
//! | `state_space`, `gaussian` | the engine: a model over one step, predict and update of a Gaussian state |
//! | `constant_velocity` | white noise, Zhang 2009 |
//! | `coloured_measurement` | coloured measurement noise, Du 2022: the seam tracker's own |
//! | `coloured_process` | coloured process noise with the displacement measured, the infrared paper |
//! | `width`, `adaptive`, `literal` | the clad's width and learnt noise statistics, Jiang 2016 |
//! | `imm` | several models at once |
//! | `model` | what every model offers a series |
//! | `series`, `smoother`, `fit` | a whole recording: filtered, smoothed, its noise found by likelihood |
//! | `link` | a filter that runs, smoothed a few frames behind |
//! | `consistency` | whether a filter's own idea of its error is right |

pub mod adaptive;
mod bending;
mod coloured_measurement;
mod coloured_process;
pub mod consistency;
mod constant_velocity;
pub mod fit;
mod gaussian;
mod imm;
mod link;
pub mod literal;
mod model;
mod nelder_mead;
mod series;
pub mod smoother;
mod state_space;
mod width;

pub use bending::Bending;
pub use coloured_measurement::ColouredMeasurement;
pub use coloured_process::{ColouredProcess, with_displacement};
pub use constant_velocity::{Acceleration, ConstantVelocity, TwoPointCovariance, gain_table};
pub use fit::Filtered;
pub use gaussian::{ChiSquareGate, Gaussian, InnovationNotPositive, Update};
pub use imm::{Imm, ImmUpdate};
pub use link::{Link, first_of};
pub use model::{Model, NoiseParameter};
pub use series::{Frame, SeriesError, Step, Trajectory};
pub use state_space::{InvalidParameter, StateSpace};
pub use width::Width;
