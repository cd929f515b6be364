//! Numbered captions of figures and tables, in the order of the page.

use std::cell::Cell;

use maud::{Markup, html};

/// Counts the figures and tables of one page.
#[derive(Debug, Default)]
pub(super) struct Captions {
    figures: Cell<u32>,
    tables: Cell<u32>,
}

impl Captions {
    /// The caption of the next figure.
    pub(super) fn figure(&self, text: &str) -> Markup {
        let number = next(&self.figures);
        html! { figcaption { b { "Figure " (number) } ". " (text) } }
    }

    /// The caption of the next table.
    pub(super) fn table(&self, text: &str) -> Markup {
        let number = next(&self.tables);
        html! { caption { b { "Table " (number) } ". " (text) } }
    }
}

fn next(counter: &Cell<u32>) -> u32 {
    counter.set(counter.get() + 1);
    counter.get()
}
