//! What all pages are made of: tables, and text that is safe to show.

use crate::steers_terminal;
use maud::{Markup, Render, html};

/// The text of a page, with a replacement mark for each character of a name or note that steers a
/// terminal, is an error in HTML, or makes one name look like another.
pub(crate) fn text_of(markup: Markup) -> String {
    let text = markup.into_string();
    let steers = |c: char| steers_terminal(c) && !matches!(c, '\n' | '\t');
    // pages are large: most are not copied
    if text.contains(steers) { text.replace(steers, "\u{fffd}") } else { text }
}

pub(crate) fn table(caption: &Markup, class: Option<&str>, columns: &[&str], rows: &Markup) -> Markup {
    html! {
        div.scroll {
            table class=[class] {
                (caption)
                thead { tr { @for name in columns { th scope="col" { (name) } } } }
                tbody { (rows) }
            }
        }
    }
}

/// A row whose first cell names it.
pub(crate) fn row(name: impl Render, cells: impl IntoIterator<Item = String>) -> Markup {
    html! { tr { th scope="row" { (name) } @for cell in cells { td { (cell) } } } }
}
