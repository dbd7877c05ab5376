//! The page itself, in the house style of the report and without anything from outside.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::report::head;

const STYLE: &str = include_str!("live.css");
const SCRIPT: &str = include_str!("live.js");
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; connect-src 'self'; img-src 'self' data:";

/// The page; `has_orders` when there is a token, by which it can reset and stop.
pub fn page(has_orders: bool) -> String {
    let own = html! { style { (PreEscaped(STYLE)) } };
    let number = |id: &str, name: &str, unit: &str| -> Markup {
        html! { div { span { (name) } b id=(id) { "–" } i { (unit) } } }
    };
    html! {
        (DOCTYPE)
        html lang="en" {
            (head("seamtrack live", POLICY, &own))
            body.silent {
                p.program { "seamtrack " (env!("CARGO_PKG_VERSION")) " · live" }
                div.live {
                    div { img #picture alt="what the camera sees, with the tracker's marks"; }
                    div {
                        div #state role="status" { "…" }
                        div #why {}
                        div.numbers {
                            (number("path_mm", "path", "mm"))
                            (number("remaining_mm", "still to go", "mm"))
                            (number("total_mm", "corrected", "mm"))
                            (number("gap_mm", "gap at the stripe", "mm"))
                            (number("age_ms", "newest picture", "ms old"))
                            (number("latency_ms", "exposure to estimate", "ms"))
                            (number("step_ms", "tracker's step", "ms"))
                        }
                        svg #minute viewBox="0 0 1000 200" preserveAspectRatio="none" role="img" aria-label="the last minute" {
                            line x1="0" x2="1000" y1="100" y2="100" {}
                            g #total {} g #remaining {}
                        }
                        p.legend {
                            span { "the last minute, " span #scale {} } b.total { "corrected" } b.remaining { "still to go" }
                        }
                        p #counters {}
                        @if has_orders {
                            form #orders {
                                input #token type="password" placeholder="token" aria-label="token" autocomplete="off";
                                button #reset type="button" { "reset" } button #stop type="button" { "stop" }
                                span #said role="status" {}
                            }
                        }
                    }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}
