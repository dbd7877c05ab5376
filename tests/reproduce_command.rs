//! `seamtrack reproduce` as a user meets it.

use assert_cmd::Command;
use predicates::str::contains;

#[test]
fn the_worked_step_stands_beside_the_papers_digits() {
    let mut command = Command::cargo_bin("seamtrack").unwrap();
    let output = command.args(["reproduce", "infrared"]).assert().success().get_output().stdout.clone();
    let text = String::from_utf8(output).unwrap();
    let line = |label: &str| -> Vec<String> {
        let line = text.lines().find(|line| line.trim_start().starts_with(label)).unwrap();
        line.split_whitespace().rev().take(4).map(str::to_owned).collect()
    };
    assert_eq!(line("ours: filtered"), ["2.3636", "237.18", "4.6364", "239.45"]);
    assert_eq!(line("paper: filtered"), line("ours: filtered"));
}

#[test]
fn a_paper_nobody_knows_is_a_usage_error() {
    let mut command = Command::cargo_bin("seamtrack").unwrap();
    command.args(["reproduce", "newton"]).assert().code(2).stderr(contains("zhang"));
}
