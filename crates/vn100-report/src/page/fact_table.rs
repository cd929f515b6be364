//! A table of facts: a name and a value in each row.

use maud::{Markup, html};

/// Stands where a thing is absent.
pub(super) const NOT_RECORDED: &str = "not recorded";

/// A name and its value.
pub(super) type Row = (String, String);

pub(super) fn table(rows: &[Row]) -> Markup {
    html! {
        div.scroll {
            table.facts {
                @for (name, value) in rows {
                    tr { th scope="row" { (name) } td.absent[value == NOT_RECORDED] { (value) } }
                }
            }
        }
    }
}

pub(super) fn row(name: &str, value: impl Into<String>) -> Row {
    (name.to_owned(), value.into())
}

pub(super) fn or_not_recorded(name: &str, value: Option<String>) -> Row {
    row(name, value.filter(|value| !value.trim().is_empty()).unwrap_or_else(|| NOT_RECORDED.into()))
}
