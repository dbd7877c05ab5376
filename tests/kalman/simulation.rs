//! Series drawn from a model, with the truth kept.

use nalgebra::{DMatrix, SMatrix, SVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use seamtrack::kalman::{Frame, Gaussian, StateSpace};

pub struct Series<const N: usize, const M: usize> {
    pub truth: Vec<SVector<f64, N>>,
    pub frames: Vec<Frame<M>>,
}

/// A draw from N(0, covariance), which may be singular.
fn draw<const N: usize>(covariance: &SMatrix<f64, N, N>, rng: &mut Pcg64) -> SVector<f64, N> {
    let eigen = DMatrix::from_fn(N, N, |i, j| covariance[(i, j)]).symmetric_eigen();
    let mut sum = SVector::<f64, N>::zeros();
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        let normal: f64 = StandardNormal.sample(rng);
        sum += SVector::<f64, N>::from_iterator(vector.iter().copied()) * (value.max(0.0).sqrt() * normal);
    }
    sum
}

/// `steps` frames from a state drawn from `start`.
pub fn simulate<const N: usize, const M: usize>(
    space: &StateSpace<N, M>,
    start: &Gaussian<N>,
    dt_s: f64,
    steps: usize,
    seed: u64,
) -> Series<N, M> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut x = start.x + draw(&start.P, &mut rng);
    let (mut truth, mut frames) = (Vec::new(), Vec::new());
    for _ in 0..steps {
        x = space.F * x + draw(&space.Qd, &mut rng);
        let z = space.H * x + draw(&space.R, &mut rng);
        truth.push(x);
        frames.push(Frame::new(dt_s, std::array::from_fn(|row| Some(z[row]))));
    }
    Series { truth, frames }
}
