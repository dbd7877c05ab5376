//! The head that all pages share: one house style, and nothing from outside the file.

use maud::{Markup, PreEscaped, html};

const STYLE: &str = include_str!("page/page.css");

/// The content-security policy of a page that needs neither the network nor a script.
pub(super) const WITHOUT_SCRIPT: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

/// The head of a page called `title`, under the content-security policy `policy`; `own` is what the page adds to the style.
pub(crate) fn head(title: &str, policy: &str, own: &Markup) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta http-equiv="Content-Security-Policy" content=(policy);
            meta name="color-scheme" content="light dark";
            link rel="icon" href="data:,";
            title { (title) }
            style { (PreEscaped(STYLE)) }
            (own)
        }
    }
}
