//! Which pictures belong together: the same view with the laser off and on.

use std::collections::BTreeMap;

/// A view: the picture with the laser on, and the one with the laser off if there is one; numbers of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// Laser on.
    pub lit: usize,
    /// Laser off.
    pub dark: Option<usize>,
}

/// Words in a name that say that the laser is on, or off. "off" is asked for first, since "laser_off" holds both.
const DARK_WORDS: [&str; 6] = ["off", "dark", "checker", "board", "without", "ambient"];
const LIT_WORDS: [&str; 6] = ["laser", "on", "stripe", "line", "lit", "light"];

/// Pairs pictures by the number in their names, as in `off_03.png` and `on_03.png`; a set in which every number appears
/// once is laser-on alone.
///
/// # Errors
/// When numbers appear once and twice, or a pair's names do not say which is which.
pub fn pair_by_name(names: &[String]) -> Result<Vec<Pair>, String> {
    let mut by_number: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (i, name) in names.iter().enumerate() {
        let number =
            last_number(name).ok_or_else(|| format!("{name} has no number to pair it by: give --pairs LIST.csv"))?;
        by_number.entry(number).or_default().push(i);
    }
    if by_number.values().all(|same| same.len() == 1) {
        return Ok(by_number.into_values().map(|same| Pair { lit: same[0], dark: None }).collect());
    }
    let mut pairs = vec![];
    for (number, same) in by_number {
        let [a, b] = same[..] else {
            let listed: Vec<&str> = same.iter().map(|&i| names[i].as_str()).collect();
            return Err(format!(
                "number {number} has {} picture(s), {}, where others have two: add the missing one, or give --pairs LIST.csv",
                listed.len(),
                listed.join(", ")
            ));
        };
        let pair = match (is_lit(&names[a]), is_lit(&names[b])) {
            (Some(true), Some(false)) => Pair { lit: a, dark: Some(b) },
            (Some(false), Some(true)) => Pair { lit: b, dark: Some(a) },
            _ => {
                return Err(format!(
                    "{} and {} do not say which has the laser on: name them on_{number} and off_{number}, or give --pairs LIST.csv",
                    names[a], names[b]
                ));
            }
        };
        pairs.push(pair);
    }
    Ok(pairs)
}

/// Pairs as a list gives them: lines `dark,lit`, or `lit` alone, names of pictures; a header is skipped.
///
/// # Errors
/// When a line names a picture that is not there.
pub fn pair_by_list(list: &str, names: &[String]) -> Result<Vec<Pair>, String> {
    let number = |name: &str| names.iter().position(|known| known == name);
    let mut pairs = vec![];
    for (i, line) in list.lines().map(|line| line.trim().trim_start_matches('\u{feff}')).enumerate() {
        let cells: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).filter(|cell| !cell.is_empty()).collect();
        let found: Option<Vec<usize>> = cells.iter().map(|name| number(name)).collect();
        match (found.as_deref(), cells.len()) {
            (_, 0) => {}
            (Some(&[lit]), _) => pairs.push(Pair { lit, dark: None }),
            (Some(&[dark, lit]), _) => pairs.push(Pair { lit, dark: Some(dark) }),
            (None, 1 | 2) if i == 0 && cells.iter().all(|cell| number(cell).is_none() && !cell.contains('.')) => {}
            _ => {
                return Err(format!(
                    "line {} of the list, {line}: expected dark,lit with names of pictures in the folder",
                    i + 1
                ));
            }
        }
    }
    if pairs.is_empty() { Err("the list names no pictures".into()) } else { Ok(pairs) }
}

fn last_number(name: &str) -> Option<u64> {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let digits = stem.split(|c: char| !c.is_ascii_digit()).rfind(|part| !part.is_empty())?;
    digits.parse().ok()
}

/// Whether a name says that the laser is on.
fn is_lit(name: &str) -> Option<bool> {
    let lower = name.to_lowercase();
    let stem = lower.rsplit_once('.').map_or(lower.as_str(), |(stem, _)| stem);
    // "on", "off" and "no" that stand by themselves say more than what else is in a name, as in board_on and no_laser.
    let is_word = |word: &str| stem.split(|c: char| !c.is_alphabetic()).any(|part| part == word);
    if is_word("on") && !is_word("off") {
        return Some(true);
    }
    if is_word("no") {
        return Some(false);
    }
    if DARK_WORDS.iter().any(|word| stem.contains(word)) {
        return Some(false);
    }
    LIT_WORDS.iter().any(|word| stem.contains(word)).then_some(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &[&str]) -> Vec<String> {
        list.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn pictures_are_paired_by_number_and_word() {
        let pairs =
            pair_by_name(&names(&["checker_01.jpg", "checker_02.jpg", "laser_01.jpg", "laser_02.jpg"])).unwrap();
        assert_eq!(pairs, [Pair { lit: 2, dark: Some(0) }, Pair { lit: 3, dark: Some(1) }]);
        let pairs = pair_by_name(&names(&["03_laser_off.png", "03_laser_on.png"])).unwrap();
        assert_eq!(pairs, [Pair { lit: 1, dark: Some(0) }]);
        for (dark, lit) in
            [("board_off_3.bmp", "board_on_3.bmp"), ("no_laser3.tif", "laser3.tif"), ("cam-3-OFF.png", "cam-3-ON.png")]
        {
            let pairs = pair_by_name(&names(&[dark, lit])).unwrap();
            assert_eq!(pairs, [Pair { lit: 1, dark: Some(0) }], "{dark}");
        }
    }

    #[test]
    fn every_number_once_is_laser_on_alone() {
        let pairs = pair_by_name(&names(&["a_1.png", "a_2.png"])).unwrap();
        assert_eq!(pairs, [Pair { lit: 0, dark: None }, Pair { lit: 1, dark: None }]);
    }

    #[test]
    fn a_missing_partner_and_names_that_say_nothing_are_named() {
        let problem = pair_by_name(&names(&["off_1.png", "on_1.png", "on_2.png"])).unwrap_err();
        assert!(problem.contains("number 2") && problem.contains("on_2.png"), "{problem}");
        assert!(pair_by_name(&names(&["a_1.png", "b_1.png"])).unwrap_err().contains("--pairs"));
        assert!(pair_by_name(&names(&["a.png"])).unwrap_err().contains("--pairs"));
    }

    #[test]
    fn a_list_pairs_whatever_the_names() {
        let known = names(&["x.png", "y.png", "z.png"]);
        let pairs = pair_by_list("dark,lit\ny.png,x.png\nz.png\n", &known).unwrap();
        assert_eq!(pairs, [Pair { lit: 0, dark: Some(1) }, Pair { lit: 2, dark: None }]);
        assert!(pair_by_list("y.png,w.png\n", &known).unwrap_err().contains("line 1"));
    }
}
