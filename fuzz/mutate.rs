//! Inputs out of a corpus, changed at random: the same for the same seed.

use std::path::{Path, PathBuf};

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What numbers and words are replaced by.
const HOSTILE: [&str; 24] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "18446744073709551616",
    "0x7f",
    "\"\"",
    "[]",
    "[[[[[[[[",
    "{}",
    "true",
    "\n",
    "\r\n",
    ",",
    ";",
    "\u{feff}",
    "\0",
    "=",
    "99999999999999999999999999999999",
];
/// Longest input \[bytes\].
const LONGEST: usize = 1 << 16;

/// The inputs that others are made from.
pub struct Corpus {
    inputs: Vec<Vec<u8>>,
    words: Vec<Vec<u8>>,
}

impl Corpus {
    /// The files of a target's folder below `fuzz/corpus`, in the order of their names.
    pub fn read(target: &str) -> std::io::Result<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
        let mut files: Vec<PathBuf> =
            std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
        files.sort();
        let inputs: Vec<Vec<u8>> = files.iter().map(std::fs::read).collect::<std::io::Result<_>>()?;
        let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"_.-".contains(byte);
        let mut words: Vec<Vec<u8>> = inputs
            .iter()
            .flat_map(|input| input.split(|byte| !is_word(byte)))
            .filter(|word| (1..40).contains(&word.len()))
            .map(<[u8]>::to_vec)
            .collect();
        words.sort();
        words.dedup();
        words.extend(HOSTILE.iter().map(|word| word.as_bytes().to_vec()));
        Ok(Self { inputs, words })
    }

    /// Its inputs as they are.
    pub fn inputs(&self) -> &[Vec<u8>] {
        &self.inputs
    }

    /// Input `number` of the campaign `seed`.
    pub fn changed(&self, seed: u64, number: u64) -> Vec<u8> {
        let mut random = Pcg64Mcg::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number);
        let mut input = self.inputs.choose(&mut random).cloned().unwrap_or_default();
        for _ in 0..random.random_range(1..=8) {
            self.change(&mut input, &mut random);
        }
        input.truncate(LONGEST);
        input
    }

    fn change(&self, input: &mut Vec<u8>, random: &mut Pcg64Mcg) {
        let place = random.random_range(0..=input.len());
        let end = (place + random.random_range(0..=32)).min(input.len());
        match random.random_range(0..10) {
            0 if place < input.len() => input[place] ^= 1 << random.random_range(0..8),
            1 if place < input.len() => input[place] = random.random(),
            2 => input.insert(place, random.random()),
            3 => drop(input.drain(place..end)),
            4 => {
                let part = input[place..end].to_vec();
                let to = random.random_range(0..=input.len());
                input.splice(to..to, part);
            }
            5 => input.truncate(place),
            6 => {
                let other = self.inputs.choose(random).map_or(&[][..], |other| other);
                let from = random.random_range(0..=other.len());
                input.truncate(place);
                input.extend_from_slice(&other[from..]);
            }
            // A number or a word becomes another.
            _ => {
                let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"_.-".contains(byte);
                let from = input[..place].iter().rposition(|byte| !is_word(byte)).map_or(0, |before| before + 1);
                let to = input[place..].iter().position(|byte| !is_word(byte)).map_or(input.len(), |n| place + n);
                let word = self.words.choose(random).map_or(&[][..], |word| word);
                input.splice(from..to, word.iter().copied());
            }
        }
    }
}
