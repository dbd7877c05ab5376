//! When two paths are the same.

use rayon::prelude::*;

use crate::follow::{Path, Value};

/// Share of the frames with two values in which they lie within 2 of their combined σ, at least.
const LEAST_WITHIN_2_SIGMA: f64 = 0.95;
/// No two values lie further apart, in their combined σ.
const FARTHEST_SIGMA: f64 = 5.0;
/// The mean difference, in the mean of the combined σ, at most.
const LARGEST_BIAS_SIGMA: f64 = 0.5;
/// The two mean σ differ by this factor at most: a camera is not trusted much less for being turned.
const LARGEST_STD_RATIO: f64 = 2.0;
/// Share of the frames with a value in one path that have one in the other, at least.
const LEAST_COMMON: f64 = 0.95;
/// What is said of a frame is said in the other path within this many frames of it, but for this share of the frames.
const EDGE_FRAMES: usize = 3;
const MOST_SAID_OTHERWISE: f64 = 0.05;

/// Asserts that in each of `scenes` the two paths of `paths` say the same, the causal and the smoothed one.
pub fn assert_same_paths(scenes: &[&str], paths: impl Fn(&str) -> (Path, Path) + Sync) {
    let problems: Vec<String> = scenes
        .par_iter()
        .filter_map(|name| {
            let (one, other) = paths(name);
            let problems = problems(&one, &other);
            (!problems.is_empty()).then(|| format!("{name}: {}", problems.join("; ")))
        })
        .collect();
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
}

/// In what two paths of one recording differ.
fn problems(one: &Path, other: &Path) -> Vec<String> {
    let n = one.says.len();
    assert_eq!(n, other.says.len());
    let found = one.causal.iter().flatten().count() * 2 > n;
    [("causal", &one.causal, &other.causal), ("smoothed", &one.smoothed, &other.smoothed)]
        .into_iter()
        .filter_map(|(lane, a, b)| Some(format!("{lane}: {}", differences(a, b)?)))
        .chain(said_otherwise(one, other))
        .chain((!found).then(|| "the seam is not found in the first place".to_owned()))
        .collect()
}

/// In what two sequences of values differ, if they do.
fn differences(one: &[Option<Value>], other: &[Option<Value>]) -> Option<String> {
    let both: Vec<(Value, Value)> = one.iter().zip(other).filter_map(|(a, b)| Some(((*a)?, (*b)?))).collect();
    let n = both.len() as f64;
    let either = one.iter().zip(other).filter(|(a, b)| a.is_some() || b.is_some()).count() as f64;
    let combined_mm = |(a, b): &(Value, Value)| a.std_mm.hypot(b.std_mm);
    let away = |pair: &(Value, Value)| (pair.0.mm - pair.1.mm).abs() / combined_mm(pair);
    let mean = |figure: &dyn Fn(&(Value, Value)) -> f64| both.iter().map(figure).sum::<f64>() / n;
    let within = both.iter().filter(|pair| away(pair) <= 2.0).count() as f64 / n;
    let farthest = both.iter().map(away).fold(0.0, f64::max);
    let bias = mean(&|(a, b)| a.mm - b.mm) / mean(&combined_mm);
    let std_ratio = mean(&|(_, b)| b.std_mm) / mean(&|(a, _)| a.std_mm);
    let same = n / either >= LEAST_COMMON
        && within >= LEAST_WITHIN_2_SIGMA
        && farthest <= FARTHEST_SIGMA
        && bias.abs() <= LARGEST_BIAS_SIGMA
        && (1.0 / LARGEST_STD_RATIO..=LARGEST_STD_RATIO).contains(&std_ratio);
    (!same).then(|| {
        format!(
            "{n} of {either} frames with a value have two, {within:.2} of them within 2 combined σ, the farthest {farthest:.1} σ apart, mean difference {bias:+.2} σ, σ {std_ratio:.2} times as large"
        )
    })
}

/// How many frames are said otherwise, not only sooner or later, if too many are.
fn said_otherwise(one: &Path, other: &Path) -> Option<String> {
    let n = one.says.len();
    let unmatched = |a: &Path, b: &Path| {
        let near = |i: usize| i.saturating_sub(EDGE_FRAMES)..(i + EDGE_FRAMES + 1).min(n);
        (0..n).filter(|&i| !b.says[near(i)].contains(&a.says[i])).count()
    };
    let otherwise = unmatched(one, other).max(unmatched(other, one));
    (otherwise as f64 > MOST_SAID_OTHERWISE * n as f64).then(|| format!("{otherwise} of {n} frames are said otherwise"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::follow::Says;

    /// A path of 60 frames with σ = 0.1 mm, off by `off_mm(frame)`, seen from frame `from` on.
    fn path(from: usize, off_mm: impl Fn(usize) -> f64) -> Path {
        let value = |i: usize| (i >= from).then(|| Value { mm: 0.3 * i as f64 + off_mm(i), std_mm: 0.1 });
        let values: Vec<Option<Value>> = (0..60).map(value).collect();
        let says = values.iter().map(|value| if value.is_some() { Says::Seen } else { Says::Nothing }).collect();
        Path { says, causal: values.clone(), smoothed: values }
    }

    #[test]
    fn paths_within_their_sigma_are_the_same_and_others_are_not() {
        let plain = path(4, |_| 0.0);
        let same = |other: Path| problems(&plain, &other).is_empty();
        assert!(same(path(4, |i| if i % 2 == 0 { 0.2 } else { -0.2 })));
        assert!(same(path(5, |_| 0.05)), "a frame later and a little aside");
        assert!(!same(path(4, |_| 0.1)), "all aside");
        assert!(!same(path(4, |i| if i == 30 { 0.8 } else { 0.0 })), "one far aside");
        assert!(!same(path(14, |_| 0.0)), "found much later");
        let doubtful = |v: Option<Value>| v.map(|v| Value { std_mm: 0.3, ..v });
        assert!(!same(Path { causal: plain.causal.iter().copied().map(doubtful).collect(), ..plain.clone() }));
        let predicted = Path { says: vec![Says::Predicted; 60], ..plain.clone() };
        assert!(!same(predicted));
    }
}
