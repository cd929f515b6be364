//! A table of a page: names of the columns, and rows below.

use maud::{Markup, Render, html};

pub(super) fn table(class: Option<&str>, columns: &[&str], rows: &Markup) -> Markup {
    html! {
        div.scroll {
            table class=[class] {
                thead { tr { @for name in columns { th scope="col" { (name) } } } }
                tbody { (rows) }
            }
        }
    }
}

/// A row whose first cell names it.
pub(super) fn row(name: impl Render, cells: impl IntoIterator<Item = String>) -> Markup {
    html! { tr { th scope="row" { (name) } @for cell in cells { td { (cell) } } } }
}
