//! Numbered captions of figures and tables, in the order of the page.

use std::cell::Cell;

use maud::{Markup, html};

/// Counts the figures and tables of one page.
#[derive(Debug, Default)]
pub(crate) struct Captions {
    figures: Cell<u32>,
    tables: Cell<u32>,
}

impl Captions {
    /// The caption of the next figure.
    pub(crate) fn figure(&self, text: &str) -> Markup {
        html! { figcaption { b { "Figure " (next(&self.figures)) } ". " (text) } }
    }

    /// The caption of the next table.
    pub(crate) fn table(&self, text: &str) -> Markup {
        html! { caption { span { b { "Table " (next(&self.tables)) } ". " (text) } } }
    }
}

fn next(counter: &Cell<u32>) -> u32 {
    counter.set(counter.get() + 1);
    counter.get()
}
