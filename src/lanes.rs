//! Sums and exponentials over whole images, written so that the compiler makes vector instructions of them. The order of the
//! operations is fixed: the same numbers on every machine.

/// How many sums go side by side.
const LANES: usize = 16;

/// Σ f(x), in lanes.
#[inline(always)]
fn sum_of(values: &[f32], f: impl Fn(f32) -> f32) -> f64 {
    // Blocks are short, so that single precision is enough within one.
    const BLOCK: usize = 32 * LANES;
    let mut total = 0.0;
    for block in values.chunks(BLOCK) {
        let mut sums = [0.0f32; LANES];
        let chunks = block.chunks_exact(LANES);
        for (sum, &value) in sums.iter_mut().zip(chunks.remainder()) {
            *sum += f(value);
        }
        for chunk in chunks {
            for (sum, &value) in sums.iter_mut().zip(chunk) {
                *sum += f(value);
            }
        }
        total += sums.iter().map(|&sum| f64::from(sum)).sum::<f64>();
    }
    total
}

/// Σ x.
pub fn sum(values: &[f32]) -> f64 {
    sum_of(values, |x| x)
}

/// Σ x².
pub fn sum_of_squares(values: &[f32]) -> f32 {
    sum_of(values, |x| x * x) as f32
}

/// Σ (x − about)².
pub fn sum_of_squares_about(values: &[f32], about: f32) -> f64 {
    sum_of(values, |x| (x - about) * (x - about))
}

/// The largest value; −∞ of none.
pub fn largest(values: &[f32]) -> f32 {
    let larger = |a: f32, b: f32| if b > a { b } else { a };
    let mut most = [f32::NEG_INFINITY; LANES];
    let chunks = values.chunks_exact(LANES);
    for (most, &value) in most.iter_mut().zip(chunks.remainder()) {
        *most = larger(*most, value);
    }
    for chunk in chunks {
        for (most, &value) in most.iter_mut().zip(chunk) {
            *most = larger(*most, value);
        }
    }
    most.into_iter().fold(f32::NEG_INFINITY, larger)
}

/// exp(x) for x ≤ 0, to 2·10⁻⁷ of it; 0 where it is below 10⁻³⁷. By 2ⁿ·exp(r), |r| ≤ ½ ln 2, and a Taylor polynomial.
#[inline(always)]
pub fn exp_of_negative(x: f32) -> f32 {
    /// Added to a small number and taken away again, it leaves the nearest whole one, which then stands in its lowest bits.
    const ROUND: f32 = 12_582_912.0;
    const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
    let inside = if x > -86.0 { x } else { -86.0 };
    let shifted = inside * std::f32::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = inside - n * LN_2[0] - n * LN_2[1];
    let series =
        1.0 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0)))) * r * r + r * (1.0 + 0.5 * r);
    let power = f32::from_bits((shifted.to_bits().wrapping_add(127)) << 23);
    if x > -86.0 { power * series } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_that_of_the_library_to_single_precision() {
        for i in 0..200_000 {
            let x = -86.0 * (i as f32 / 200_000.0).powi(3);
            let (ours, theirs) = (f64::from(exp_of_negative(x)), f64::from(x).exp());
            assert!((ours / theirs - 1.0).abs() < 3e-7, "{x}: {ours} against {theirs}");
        }
        assert_eq!(
            (exp_of_negative(-200.0), exp_of_negative(f32::NEG_INFINITY), exp_of_negative(0.0)),
            (0.0, 0.0, 1.0)
        );
    }

    #[test]
    fn sums_and_the_largest_are_those_of_all_values_whatever_their_number() {
        for n in [0, 1, 15, 16, 17, 511, 512, 513, 5000] {
            let values: Vec<f32> = (0..n).map(|i| ((i * 37) % 101) as f32 * 0.25 - 9.0).collect();
            let wide = || values.iter().map(|&x| f64::from(x));
            assert!((sum(&values) - wide().sum::<f64>()).abs() < 1e-3);
            let squares: f64 = wide().map(|x| x * x).sum();
            assert!((f64::from(sum_of_squares(&values)) - squares).abs() <= 1e-6 * squares);
            let about: f64 = wide().map(|x| (x - 2.0).powi(2)).sum();
            assert!((sum_of_squares_about(&values, 2.0) - about).abs() <= 1e-6 * about);
            assert_eq!(largest(&values), values.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        }
    }
}
