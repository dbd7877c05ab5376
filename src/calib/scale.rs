//! One scale: pixels against known displacements.

use super::student::student_95;

/// Fewest positions: with four a line has two degrees of freedom and any interval is a guess.
pub const LEAST_POSITIONS: usize = 5;
/// The positions must span at least this \[px\].
pub const LEAST_SPAN_PX: f64 = 20.0;
/// No position may hold more than this share of the line: with two clusters of positions one place decides the slope.
const MOST_LEVERAGE: f64 = 0.8;

/// One position: where it was seen, and where it truly is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// Coordinate in the picture \[px\].
    pub px: f64,
    /// Displacement by the gauge or the robot \[mm\].
    pub mm: f64,
}

/// A scale that positions do not determine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScaleError {
    /// Too few.
    #[error("{0} positions are too few: {LEAST_POSITIONS} or more, spread evenly over the picture")]
    TooFew(usize),
    /// Too near to one another.
    #[error(
        "the positions span {0:.1} px, {LEAST_SPAN_PX} is the least: spread them over the part of the picture that you use"
    )]
    TooNear(f64),
    /// Nearly all at one place.
    #[error("one position, {:.2} mm, decides the scale by itself ({:.0} % of the line): spread the positions evenly", .0, 100.0 * .1)]
    BadlySpread(f64, f64),
    /// Numbers that are not finite, or a scale without one.
    #[error("the positions give no scale: {0}")]
    NoScale(&'static str),
}

/// A scale with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ScaleFit {
    /// The scale \[mm/px\], above 0.
    pub mm_per_px: f64,
    /// Its σ \[mm/px\].
    pub std_mm_per_px: f64,
    /// Half its 95 % interval \[mm/px\].
    pub half_95_mm_per_px: f64,
    /// Whether the displacement grows against the coordinate.
    pub reversed: bool,
    /// Root mean square distance from the line \[mm\].
    pub rms_mm: f64,
    /// Largest distance of a position from the line \[mm\]: noise and nonlinearity.
    pub worst_mm: f64,
    /// The displacement where that is \[mm\].
    pub worst_at_mm: f64,
    /// Largest error of a position that took no part in the fit \[mm\].
    pub held_out_mm: f64,
    /// Number of positions, and how many count as independent.
    pub positions: usize,
    /// See above.
    pub independent: f64,
}

/// Fits pixels as a line over millimetres, since the gauge is what is exact, and turns it round. Residuals that follow one
/// another, as those of a recording do, count for fewer positions: n (1 − ρ)/(1 + ρ). Where the slope changes along the way more than
/// that lets expect, the slopes without one stretch of the way after another give the interval (delete-a-group jackknife: Kott 2001).
///
/// # Errors
/// When positions are too few, badly spread, or do not follow a line at all.
pub fn fit_scale(positions: &[Position]) -> Result<ScaleFit, ScaleError> {
    let n = positions.len() as f64;
    if positions.len() < LEAST_POSITIONS {
        return Err(ScaleError::TooFew(positions.len()));
    }
    if positions.iter().any(|p| !(p.px.is_finite() && p.mm.is_finite())) {
        return Err(ScaleError::NoScale("a number is not finite"));
    }
    let extent = |of: fn(&Position) -> f64| {
        let values = || positions.iter().map(of);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let span_px = extent(|p| p.px);
    if span_px < LEAST_SPAN_PX {
        return Err(ScaleError::TooNear(span_px));
    }
    let mean_px = positions.iter().map(|p| p.px).sum::<f64>() / n;
    let mean_mm = positions.iter().map(|p| p.mm).sum::<f64>() / n;
    let spread: f64 = positions.iter().map(|p| (p.mm - mean_mm).powi(2)).sum();
    let slope = positions.iter().map(|p| (p.mm - mean_mm) * (p.px - mean_px)).sum::<f64>() / spread;
    if !slope.is_finite() || slope == 0.0 {
        return Err(ScaleError::NoScale("all displacements are equal"));
    }
    let leverage = |p: &Position| 1.0 / n + (p.mm - mean_mm).powi(2) / spread;
    if let Some(p) = positions.iter().find(|p| leverage(p) > MOST_LEVERAGE) {
        return Err(ScaleError::BadlySpread(p.mm, leverage(p)));
    }
    let residual_px = |p: &Position| p.px - mean_px - slope * (p.mm - mean_mm);
    let squares: f64 = positions.iter().map(|p| residual_px(p).powi(2)).sum();
    let mut in_order: Vec<&Position> = positions.iter().collect();
    in_order.sort_by(|a, b| a.mm.total_cmp(&b.mm));
    let neighbours: f64 = in_order.windows(2).map(|pair| residual_px(pair[0]) * residual_px(pair[1])).sum();
    let correlation = if squares > 0.0 { (neighbours / squares).clamp(0.0, 0.98) } else { 0.0 };
    let independent = (n * (1.0 - correlation) / (1.0 + correlation)).max(3.0);
    let variance_px2 = squares / (n - 2.0) * n / independent;
    let mm_per_px = 1.0 / slope.abs();
    let scatter = ((variance_px2 / spread).sqrt(), independent - 2.0);
    let (slope_std, freedom) = by_stretches(&in_order).filter(|stretches| stretches.0 > scatter.0).unwrap_or(scatter);
    let std_mm_per_px = slope_std * mm_per_px * mm_per_px;
    // The slope of what was seen must be more than what the scatter makes.
    if slope.abs() < 3.0 * scatter.0 {
        return Err(ScaleError::NoScale(
            "the coordinate does not follow the displacement; is it the right column, and the right recording?",
        ));
    }
    let worst = positions.iter().max_by(|a, b| residual_px(a).abs().total_cmp(&residual_px(b).abs()));
    let held_out_mm =
        positions.iter().map(|p| (residual_px(p) / (1.0 - leverage(p))).abs() * mm_per_px).fold(0.0, f64::max);
    Ok(ScaleFit {
        mm_per_px,
        std_mm_per_px,
        half_95_mm_per_px: student_95(freedom) * std_mm_per_px,
        reversed: slope < 0.0,
        rms_mm: (squares / n).sqrt() * mm_per_px,
        worst_mm: worst.map_or(0.0, |p| residual_px(p).abs() * mm_per_px),
        worst_at_mm: worst.map_or(0.0, |p| p.mm),
        held_out_mm,
        positions: positions.len(),
        independent,
    })
}

/// Stretches of the way for [`by_stretches`], and the fewest positions in one. Chosen.
const STRETCHES: usize = 8;
const LEAST_IN_STRETCH: usize = 5;

/// σ of the slope \[px/mm\] by leaving out one stretch of the way after another, and its degrees of freedom; none for few positions,
/// of which one stretch would be too much.
fn by_stretches(in_order: &[&Position]) -> Option<(f64, f64)> {
    let n = in_order.len();
    if n < STRETCHES * LEAST_IN_STRETCH {
        return None;
    }
    let slopes: Vec<f64> = (0..STRETCHES)
        .map(|k| {
            let left_out = k * n / STRETCHES..(k + 1) * n / STRETCHES;
            let kept = || in_order.iter().enumerate().filter(|(i, _)| !left_out.contains(i)).map(|(_, p)| p);
            let count = kept().count() as f64;
            let (mm, px) = (kept().map(|p| p.mm).sum::<f64>() / count, kept().map(|p| p.px).sum::<f64>() / count);
            kept().map(|p| (p.mm - mm) * (p.px - px)).sum::<f64>() / kept().map(|p| (p.mm - mm).powi(2)).sum::<f64>()
        })
        .collect();
    let stretches = STRETCHES as f64;
    let mean = slopes.iter().sum::<f64>() / stretches;
    let squares: f64 = slopes.iter().map(|slope| (slope - mean).powi(2)).sum();
    Some((((stretches - 1.0) / stretches * squares).sqrt(), stretches - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg32;

    fn positions(count: usize, noise_px: f64, seed: u64) -> Vec<Position> {
        let mut random = Pcg32::new(seed, 1);
        let noise = |random: &mut Pcg32| -> f64 { StandardNormal.sample(random) };
        (0..count)
            .map(|i| Position {
                px: 100.0 + 40.0 * i as f64 + noise_px * noise(&mut random),
                mm: 0.08 * 40.0 * i as f64,
            })
            .collect()
    }

    #[test]
    fn the_interval_covers_the_scale_as_often_as_it_says() {
        let covers = |seed| {
            let fit = fit_scale(&positions(8, 0.5, seed)).unwrap();
            (fit.mm_per_px - 0.08).abs() < fit.half_95_mm_per_px
        };
        let covered = (0..400).filter(|&seed| covers(seed)).count();
        assert!((368..=396).contains(&covered), "{covered} of 400");
    }

    #[test]
    fn a_scale_that_changes_along_the_way_is_less_sure_than_its_scatter_says() {
        let straight = positions(100, 2.0, 1);
        let bent: Vec<Position> =
            straight.iter().map(|p| Position { px: p.px + 3e-6 * (p.px - 100.0).powi(2), ..*p }).collect();
        let (sure, unsure) = (fit_scale(&straight).unwrap(), fit_scale(&bent).unwrap());
        assert!(unsure.half_95_mm_per_px > 2.0 * sure.half_95_mm_per_px, "{unsure:?} {sure:?}");
        let half = |from: usize| fit_scale(&bent[from..from + 50]).unwrap().mm_per_px;
        assert!((half(0) - half(50)).abs() < 4.0 * unsure.half_95_mm_per_px);
    }

    #[test]
    fn positions_that_determine_no_scale_are_refused() {
        assert_eq!(fit_scale(&positions(4, 0.1, 1)), Err(ScaleError::TooFew(4)));
        let near: Vec<Position> = positions(8, 0.0, 1).iter().map(|p| Position { px: p.px / 40.0, mm: p.mm }).collect();
        assert!(matches!(fit_scale(&near), Err(ScaleError::TooNear(_))));
        let mut bunched = vec![Position { px: 100.0, mm: 0.0 }; 7];
        bunched.push(Position { px: 400.0, mm: 24.0 });
        assert!(matches!(fit_scale(&bunched), Err(ScaleError::BadlySpread(..))));
    }

    #[test]
    fn a_position_off_the_line_is_named_with_its_place() {
        let mut all = positions(9, 0.0, 1);
        all[4].px += 5.0;
        let fit = fit_scale(&all).unwrap();
        approx::assert_relative_eq!(fit.worst_at_mm, all[4].mm);
        assert!(fit.worst_mm > 0.3 && fit.held_out_mm > fit.worst_mm);
        assert!(!fit.reversed);
    }
}
