//! The measured series: a CSV with the columns `time_s,z1` and, for some models, `z2`.

use std::path::Path;

use anyhow::{Context, bail};

/// A measured series in the order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurements {
    /// When \[s\], each later than the one before.
    pub time_s: Vec<f64>,
    /// The first column; none where the cell is empty.
    pub z1: Vec<Option<f64>>,
    /// The second column, if there is one.
    pub z2: Option<Vec<Option<f64>>>,
}

impl Measurements {
    /// Reads the file.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let context = || format!("cannot read {}", path.display());
        let file = std::fs::File::open(path).with_context(context)?;
        Self::parse(file).with_context(|| path.display().to_string())
    }

    fn parse(input: impl std::io::Read) -> anyhow::Result<Self> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(input);
        let headers = reader.headers()?.clone();
        let column = |name: &str| headers.iter().position(|header| header == name);
        let (Some(time), Some(first)) = (column("time_s"), column("z1")) else {
            bail!("the first line must name the columns time_s,z1 (and may name z2)");
        };
        let second = column("z2");
        let mut series = Self { time_s: vec![], z1: vec![], z2: second.map(|_| vec![]) };
        for record in reader.records() {
            let record = record?;
            let line = record.position().map_or(0, csv::Position::line);
            let cell = |column: usize| number(record.get(column).unwrap_or_default(), line);
            let Some(time_s) = cell(time)? else { bail!("line {line} has no time_s") };
            if let Some(before) = series.time_s.last()
                && *before >= time_s
            {
                bail!("line {line}: time_s {time_s} is not after {before}: sort the lines by time, each time once");
            }
            series.time_s.push(time_s);
            series.z1.push(cell(first)?);
            if let (Some(column), Some(z2)) = (second, &mut series.z2) {
                z2.push(cell(column)?);
            }
        }
        if series.time_s.len() < 2 {
            bail!("there are {} measurements: at least 2 are needed", series.time_s.len());
        }
        Ok(series)
    }

    /// Time since the line before \[s\]; the first line takes the median.
    pub fn steps_s(&self) -> Vec<f64> {
        let between = self.time_s.windows(2).map(|pair| pair[1] - pair[0]);
        std::iter::once(self.median_step_s()).chain(between).collect()
    }

    /// The median time from line to line \[s\].
    pub fn median_step_s(&self) -> f64 {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps[steps.len() / 2]
    }
}

/// A finite number, or none for an empty cell.
fn number(cell: &str, line: u64) -> anyhow::Result<Option<f64>> {
    if cell.is_empty() {
        return Ok(None);
    }
    match cell.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Some(value)),
        _ => bail!("line {line}: `{cell}` is not a number: leave the cell empty where nothing was measured"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> String {
        Measurements::parse(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn an_empty_cell_is_a_missing_measurement_and_columns_go_by_name() {
        let series = Measurements::parse("z1,note,time_s\n5,a,0\n,b,0.5\n6,c,0.7\n".as_bytes()).unwrap();
        assert_eq!(series.z1, [Some(5.0), None, Some(6.0)]);
        assert_eq!(series.z2, None);
        assert_eq!(series.steps_s()[1..], [0.5, 0.7 - 0.5]);
    }

    #[test]
    fn bad_lines_are_named_with_the_remedy() {
        assert_eq!(said("a,b\n1,2\n"), "the first line must name the columns time_s,z1 (and may name z2)");
        let nan = "line 3: `nan` is not a number: leave the cell empty where nothing was measured";
        assert_eq!(said("time_s,z1\n0,1\n1,nan\n"), nan);
        let order = "line 3: time_s 0 is not after 0: sort the lines by time, each time once";
        assert_eq!(said("time_s,z1\n0,1\n0,2\n"), order);
        assert_eq!(said("time_s,z1\n0,1\n"), "there are 1 measurements: at least 2 are needed");
    }
}
