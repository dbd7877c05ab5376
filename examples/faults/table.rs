//! The tables.

use std::fmt::Write as _;

use crate::kinds::Kind;
use crate::not_a_seam::Shown;
use crate::score::{Claims, Run};

/// One row a fault.
pub fn faults(runs: &[Run]) -> String {
    let mut text = String::from(
        "| fault | runs | wrong: tracked; coasting; smoothed | without a seam: tracked; coasting; smoothed | largest error mm: causal; smoothed | noticed after: median / worst | tracked again after: median / worst | never again |\n|---|---|---|---|---|---|---|---|\n",
    );
    for kind in Kind::ALL {
        let of_kind: Vec<&Run> = runs.iter().filter(|run| run.kind == kind).collect();
        if !of_kind.is_empty() {
            text += &row(kind.name(), &of_kind);
        }
    }
    text + &row("**all**", &runs.iter().collect::<Vec<_>>())
}

fn row(name: &str, runs: &[&Run]) -> String {
    let sum = |of: &dyn Fn(&Run) -> usize| runs.iter().map(|run| of(run)).sum::<usize>();
    let largest = |of: &dyn Fn(&Run) -> f64| runs.iter().map(|run| of(run)).fold(0.0, f64::max);
    let three = |of: &dyn Fn(&Claims) -> usize| {
        format!(
            "{}; {}; {}",
            sum(&|run| of(&run.tracked)),
            sum(&|run| of(&run.coasting)),
            sum(&|run| of(&run.smoothed))
        )
    };
    let lasting = |is: &dyn Fn(&Run) -> bool, frames: &dyn Fn(&Run) -> Option<usize>| {
        let mut counts: Vec<usize> =
            runs.iter().filter(|run| is(run)).map(|run| frames(run).unwrap_or(usize::MAX)).collect();
        counts.sort_unstable();
        let shown = |count: usize| if count == usize::MAX { "never".to_owned() } else { count.to_string() };
        match counts.last() {
            None => "–".to_owned(),
            Some(&worst) => format!("{} / {}", shown(counts[counts.len() / 2]), shown(worst)),
        }
    };
    format!(
        "| {name} | {} | {} | {} | {:.2}; {:.2} | {} | {} | {} |\n",
        runs.len(),
        three(&|claims| claims.wrong),
        three(&|claims| claims.invented),
        largest(&|run| run.tracked.largest_mm.max(run.coasting.largest_mm)),
        largest(&|run| run.smoothed.largest_mm),
        lasting(&|run| run.is_hidden, &|run| run.noticed),
        lasting(&|run| run.comes_back, &|run| run.again),
        sum(&|run| usize::from(run.comes_back && run.again.is_none())),
    )
}

/// The runs in which something wrong was said, or the seam was not followed before.
pub fn failures(runs: &[Run]) -> String {
    let mut text = String::new();
    for run in runs.iter().filter(|run| !run.is_right() || !run.was_tracked || (run.comes_back && run.again.is_none()))
    {
        let (t, c, s) = (run.tracked, run.coasting, run.smoothed);
        let _ = writeln!(
            text,
            "--rows {} {} {} {}: from frame {}; wrong {}; {}; {}, without a seam {}; {}; {}, off by {:.2}; {:.2}; {:.2} mm{}",
            run.kind.name(),
            run.joint,
            run.number,
            run.repeat,
            run.first,
            t.wrong,
            c.wrong,
            s.wrong,
            t.invented,
            c.invented,
            s.invented,
            t.largest_mm,
            c.largest_mm,
            s.largest_mm,
            if run.was_tracked { "" } else { ", not tracked before" },
        );
    }
    text
}

/// A run frame by frame.
pub fn rows(run: &Run) -> String {
    let mut text = String::from("frame,status,true_px,u_px,v_px,std_mm,smooth_u_px,smooth_v_px\n");
    let cell = |px: Option<f64>| px.map_or_else(String::new, |px| format!("{px:.2}"));
    for (row, seam) in run.rows.iter().zip(&run.seams_px) {
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{}",
            row.frame,
            row.status,
            cell(*seam),
            cell(row.u_px),
            cell(row.v_px),
            cell(row.x_std_mm),
            cell(row.smooth_u_px),
            cell(row.smooth_v_px)
        );
    }
    let _ = writeln!(text, "fault from frame {}; {} mm/px", run.first, run.mm_per_px);
    text
}

/// One row for each kind of picture without a seam.
pub fn not_a_seam(shown: &[Shown]) -> String {
    let mut text = String::from(
        "| picture | recordings | frames | values: tracked; coasting | with σ under 1 mm | smoothed with σ under 1 mm | recordings taken for |\n|---|---|---|---|---|---|---|\n",
    );
    let all = shown.iter().fold(Shown::called("**all**"), |sum, one| sum.with(one));
    for one in shown.iter().chain([&all]) {
        let taken_for: Vec<String> = one.taken_for.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {}; {} | {} | {} | {} |",
            one.name,
            one.recordings,
            one.frames,
            one.tracked,
            one.coasting,
            one.sure,
            one.smoothed_sure,
            if taken_for.is_empty() { "–".to_owned() } else { taken_for.join(", ") }
        );
    }
    text
}
