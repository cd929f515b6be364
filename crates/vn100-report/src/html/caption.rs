//! Numbered captions of figures and tables, in the order of the page.

use std::cell::Cell;

use maud::{Markup, html};

/// Counts the figures and tables of one page.
#[derive(Debug, Default)]
pub(crate) struct Captions {
    figures: Cell<u32>,
    tables: Cell<u32>,
    /// On a page whose parts come and go no number stays the same.
    without_numbers: bool,
}

impl Captions {
    pub(crate) fn without_numbers() -> Self {
        Self { without_numbers: true, ..Self::default() }
    }

    /// The caption of the next figure.
    pub(crate) fn figure(&self, text: &str) -> Markup {
        html! { figcaption { (self.number("Figure", &self.figures)) (text) } }
    }

    /// The caption of the next table.
    pub(crate) fn table(&self, text: &str) -> Markup {
        html! { caption { span { (self.number("Table", &self.tables)) (text) } } }
    }

    fn number(&self, kind: &str, counter: &Cell<u32>) -> Markup {
        html! { @if !self.without_numbers { b { (kind) " " (next(counter)) } ". " } }
    }
}

fn next(counter: &Cell<u32>) -> u32 {
    counter.set(counter.get() + 1);
    counter.get()
}
