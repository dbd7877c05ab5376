//! The campaign as tables of Markdown.

use seamtrack::eval::Errors;
use seamtrack::synth::scenario::{Joint, Scenario};

use crate::draw::{KINDS, LIGHTS, Recording, peak_speed_px};
use crate::score::Outcome;
use crate::visible::Unseen;

/// Classes of picture sizes: name, and the pixels up to which it goes \[million\].
const SIZES: [(&str, f64); 3] = [("to 0.5 MP", 0.5), ("to 1.5 MP", 1.5), ("larger", f64::INFINITY)];

const HEAD: &str = "| | recordings | pass | with wrong values: causal / smoothed | far values | right kind | unavailable %: median / worst | mean error px: median / worst | mean error mm: median | smoothed px: median | in 2σ | height px: median | height in 2σ |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";

/// Joint by size, then light, then all.
pub fn summary(outcomes: &[Outcome]) -> String {
    let mut text = HEAD.to_owned();
    for kind in KINDS {
        for (i, (size, most)) in SIZES.into_iter().enumerate() {
            let least = if i == 0 { 0.0 } else { SIZES[i - 1].1 };
            let here = |o: &&Outcome| {
                let image = &o.recording.scenario.image;
                let megapixels = (image.width_px * image.height_px) as f64 / 1e6;
                o.recording.kind == kind && megapixels > least && megapixels <= most
            };
            text += &line(&format!("{kind} {size}"), &outcomes.iter().filter(here).collect::<Vec<_>>());
        }
    }
    for (light, _) in LIGHTS {
        text += &line(light, &outcomes.iter().filter(|o| o.recording.light == light).collect::<Vec<_>>());
    }
    text + &line("all", &outcomes.iter().collect::<Vec<_>>())
}

/// The failed recordings, one line each.
pub fn failures(outcomes: &[Outcome]) -> String {
    let failed: Vec<&Outcome> = outcomes.iter().filter(|outcome| !outcome.passed()).collect();
    if failed.is_empty() {
        return String::new();
    }
    let mut text = String::from("\nFailed:\n");
    failed.into_iter().for_each(|outcome| text += &report(outcome));
    text
}

/// How many draws each rule gave up.
pub fn given_up(outcomes: &[Outcome]) -> String {
    let all: Vec<Unseen> = outcomes.iter().flat_map(|outcome| outcome.recording.unseen.iter().copied()).collect();
    let mut text = format!("\nDraws given up, of {}:\n", all.len() + outcomes.len());
    for (reason, words) in Unseen::ALL {
        text += &format!("{:5}  {words}\n", all.iter().filter(|&&given_up| given_up == reason).count());
    }
    text
}

/// A recording and what became of it, in one line.
pub fn report(o: &Outcome) -> String {
    let causal = o.causal.map_or("no value".to_owned(), |e| {
        format!("mean {:.2} px, max {:.1} px, in 2σ {:.2}", o.px(e.mae), o.px(e.max), e.coverage_2sigma.unwrap_or(0.0))
    });
    format!(
        "{} {}\n    found {}, {} wrong ({} smoothed), {} far, {:.0} % unavailable, {causal}\n",
        if o.passed() { "pass" } else { "FAIL" },
        parameters(&o.recording),
        o.found.unwrap_or("nothing"),
        o.wrong,
        o.smoothed_wrong,
        o.far,
        100.0 * o.unavailable
    )
}

/// A recording in one line.
fn parameters(recording: &Recording) -> String {
    let s = &recording.scenario;
    format!(
        "#{} {} {} {}x{} {} {:.4} mm/px σ {:.2} px, {:.0} grey × {:.2}, {:.1} ms, {:.1} px/frame {}, ragged {:.2} px, tilt {:+.2}: {}",
        recording.number,
        recording.light,
        recording.kind,
        s.image.width_px,
        s.image.height_px,
        s.image.stripe,
        s.mm_per_px.get(),
        s.stripe.sigma_px,
        s.stripe.amplitude_grey,
        s.sensor.gain,
        1e3 * s.period_s,
        peak_speed_px(s),
        path(s),
        s.edges.raggedness_px,
        s.stripe.tilt,
        joint(&s.joint),
    )
}

fn path(scenario: &Scenario) -> &'static str {
    use seamtrack::synth::scenario::PathTerm;
    match scenario.path.first() {
        Some(PathTerm::Straight { .. }) => "straight",
        Some(PathTerm::Sine { .. }) => "sine",
        Some(PathTerm::SCurve { .. }) => "s-curve",
        Some(PathTerm::Polyline { .. }) => "polyline",
        None => "still",
    }
}

fn joint(joint: &Joint) -> String {
    match joint {
        Joint::Butt(j) => format!(
            "gap {:.1} px, depth {:.0}, bent {:.1} over {:.0}, floor {:.2}",
            j.gap_px.at(0.0),
            j.depth_px,
            j.bent_edge_px,
            j.bent_length_px,
            j.floor_reflectance
        ),
        Joint::Lap(j) => format!("step {:.1} px, shadow {:.1}", j.step_px.at(0.0), j.shadow_px),
        Joint::Vgroove(j) => format!(
            "half width {:.0} px, depth {:.0}, root {:.1}, flanks {:.2}",
            j.half_width_px,
            j.depth_px,
            j.root_gap_px.at(0.0),
            j.flank_reflectance
        ),
        Joint::Fillet(j) => format!("slopes {:+.2} {:+.2}, toe {:.0} px", j.left_slope, j.right_slope, j.toe_px),
        Joint::Hairline(_) | Joint::Flat => String::new(),
    }
}

fn line(name: &str, outcomes: &[&Outcome]) -> String {
    let count = |is: fn(&Outcome) -> bool| outcomes.iter().filter(|outcome| is(outcome)).count();
    let of = |figure: fn(&Outcome) -> Option<f64>| outcomes.iter().filter_map(|outcome| figure(outcome)).collect();
    let errors = |of: fn(&Outcome) -> Option<Errors>| outcomes.iter().filter_map(|o| of(o)).collect::<Vec<Errors>>();
    let (unavailable, mean_px): (Vec<f64>, Vec<f64>) =
        (of(|o| Some(100.0 * o.unavailable)), of(|o| Some(o.px(o.causal?.mae))));
    format!(
        "| {name} | {} | {} | {} / {} | {} | {} | {} / {} | {} / {} | {} | {} | {} | {} | {} |\n",
        outcomes.len(),
        count(Outcome::passed),
        count(|o| o.wrong > 0),
        count(|o| o.smoothed_wrong > 0),
        outcomes.iter().map(|o| o.far).sum::<usize>(),
        count(Outcome::is_right_kind),
        cell(median(&unavailable), 0),
        cell(worst(&unavailable), 0),
        cell(median(&mean_px), 2),
        cell(worst(&mean_px), 2),
        cell(median(&of(|o| Some(o.causal?.mae))), 3),
        cell(median(&of(|o| Some(o.px(o.smoothed?.mae)))), 2),
        cell(coverage(&errors(|o| o.causal)), 2),
        cell(median(&of(|o| Some(o.px(o.height?.mae)))), 2),
        cell(coverage(&errors(|o| o.height)), 2),
    )
}

/// Share of all the frames that lie within 2σ, where a σ is stated.
fn coverage(errors: &[Errors]) -> Option<f64> {
    let claims = || errors.iter().filter_map(|e| Some((e.coverage_2sigma?, e.frames as f64)));
    let frames: f64 = claims().map(|(_, frames)| frames).sum();
    (frames > 0.0).then(|| claims().map(|(share, frames)| share * frames).sum::<f64>() / frames)
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

fn worst(values: &[f64]) -> Option<f64> {
    values.iter().copied().max_by(f64::total_cmp)
}

fn cell(value: Option<f64>, decimals: usize) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.decimals$}"))
}
