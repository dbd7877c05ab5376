//! As much of YAML as OpenCV, ROS and Kalibr write: nested keys, numbers, words, lists in brackets over several lines.
//! OpenCV's header `%YAML:1.0` is no YAML, which other readers stumble over.

use std::collections::BTreeMap;

/// Deepest nesting, and most values a list has.
const DEEPEST: usize = 16;
const LONGEST_LIST: usize = 10_000;

/// The values of a file by their path, as in `camera_matrix.data`. A value is a list of words; one word where it is no list.
#[derive(Debug, Clone, PartialEq)]
pub struct Yaml(BTreeMap<String, Vec<String>>);

impl Yaml {
    /// Reads a text.
    ///
    /// # Errors
    /// With the line that is not understood.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut values = BTreeMap::new();
        let mut path: Vec<(usize, String)> = vec![];
        let mut lines = text.lines().enumerate();
        while let Some((number, line)) = lines.next() {
            let line = without_comment(line.trim_start_matches('\u{feff}'));
            let body = line.trim();
            let skipped = body.is_empty() || body.starts_with('%') || body.starts_with('-') || body == "...";
            if skipped {
                continue;
            }
            let indent = line.len() - line.trim_start().len();
            let wrong = |what: &str| format!("line {}, {what}: {body}", number + 1);
            let (key, value) = body.split_once(':').ok_or_else(|| wrong("expected `key: value`"))?;
            path.retain(|(outer, _)| *outer < indent);
            if path.len() >= DEEPEST {
                return Err(wrong("nested too deeply"));
            }
            path.push((indent, key.trim().trim_matches(['"', '\'']).to_owned()));
            let mut value = value.trim().to_owned();
            if value.starts_with("!!") {
                value = value.split_once(' ').map_or(String::new(), |(_, rest)| rest.trim().to_owned());
            }
            while value.starts_with('[') && !value.contains(']') {
                let (_, more) = lines.next().ok_or_else(|| wrong("a list without its end"))?;
                value = value + " " + without_comment(more).trim();
            }
            if value.is_empty() {
                continue;
            }
            let name = path.iter().map(|(_, key)| key.as_str()).collect::<Vec<_>>().join(".");
            let list = value.trim_start_matches('[').trim_end_matches(']');
            let words: Vec<String> = if value.starts_with('[') {
                list.split(',').map(str::trim).filter(|word| !word.is_empty()).map(ToOwned::to_owned).collect()
            } else {
                vec![value.trim_matches(['"', '\'']).to_owned()]
            };
            if words.len() > LONGEST_LIST {
                return Err(wrong("too long a list"));
            }
            values.insert(name, words);
        }
        Ok(Self(values))
    }

    /// The numbers at the first of `paths` that exists.
    ///
    /// # Errors
    /// When one is no finite number.
    pub fn numbers(&self, paths: &[&str]) -> Result<Option<Vec<f64>>, String> {
        let Some((path, words)) = paths.iter().find_map(|path| Some((path, self.0.get(*path)?))) else {
            return Ok(None);
        };
        let number = |word: &String| word.parse::<f64>().ok().filter(|x| x.is_finite());
        let numbers: Option<Vec<f64>> = words.iter().map(number).collect();
        numbers.map(Some).ok_or_else(|| format!("{path} holds something that is no finite number"))
    }

    /// The word at a path.
    #[must_use]
    pub fn word(&self, path: &str) -> Option<&str> {
        self.0.get(path).and_then(|words| words.first()).map(String::as_str)
    }
}

fn without_comment(line: &str) -> &str {
    if line.trim_start().starts_with('#') {
        ""
    } else {
        line.split_once(" #").map_or(line, |(before, _)| before).trim_end()
    }
}

#[cfg(test)]
mod tests {
    use super::Yaml;

    #[test]
    fn the_three_dialects_are_read() {
        let text = "%YAML:1.0\n---\nK: !!opencv-matrix\n   rows: 3\n   data: [ 1.5e+03, 0., 9.3,\n       0., 1., 2., 0., 0., 1. ]\nname: \"left cam\" # ours\n";
        let yaml = Yaml::parse(text).unwrap();
        assert_eq!(yaml.numbers(&["camera_matrix.data", "K.data"]).unwrap().unwrap().len(), 9);
        assert_eq!(yaml.word("name"), Some("left cam"));
        let kalibr = Yaml::parse("cam0:\n  T_cn:\n  - [1, 0]\n  resolution: [752, 480]\n").unwrap();
        assert_eq!(kalibr.numbers(&["cam0.resolution"]).unwrap(), Some(vec![752.0, 480.0]));
    }

    #[test]
    fn what_is_not_understood_is_named_by_its_line() {
        assert!(Yaml::parse("a: 1\nnonsense\n").unwrap_err().contains("line 2"));
        assert!(Yaml::parse("a: [1, 2").unwrap_err().contains("without its end"));
        assert!(Yaml::parse("a: [1, nan]\n").unwrap().numbers(&["a"]).is_err());
    }
}
