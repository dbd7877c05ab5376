//! Student's t: how far a 95 % interval reaches when few values gave its σ.

/// The 97.5 % point of the normal distribution.
const NORMAL: f64 = 1.959_963_985;

/// The factor of a two-sided 95 % interval with `freedom` degrees of freedom, at least 1 (expansion of Cornish and
/// Fisher, Abramowitz & Stegun 26.7.5; within 1 % from 3 degrees on).
#[must_use]
pub fn student_95(freedom: f64) -> f64 {
    // The expansion is poor below three; 12.7 and 4.3 are exact.
    if freedom < 1.5 {
        return 12.706;
    }
    if freedom < 2.5 {
        return 4.303;
    }
    let z = NORMAL;
    let [z3, z5, z7, z9] = [3, 5, 7, 9].map(|power| z.powi(power));
    z + (z3 + z) / (4.0 * freedom)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * freedom.powi(2))
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * freedom.powi(3))
        + (79.0 * z9 + 776.0 * z7 + 1482.0 * z5 - 1920.0 * z3 - 945.0 * z) / (92_160.0 * freedom.powi(4))
}

#[cfg(test)]
mod tests {
    use super::student_95;

    #[test]
    fn the_factors_are_those_of_the_tables() {
        for (freedom, factor) in
            [(1.0, 12.706), (2.0, 4.303), (3.0, 3.182), (5.0, 2.571), (10.0, 2.228), (100.0, 1.984)]
        {
            assert!((student_95(freedom) / factor - 1.0).abs() < 0.01, "{freedom}");
        }
    }
}
