//! How text stands on a terminal: paragraphs, and rows of a table with an axis in each column.

use std::fmt::{self, Write};

/// Columns a line may take; what every terminal has.
pub(super) const WIDTH: usize = 80;

/// Of the column that names the rows of a table with an axis in each of the others.
pub(super) const LABEL: usize = 24;

/// Of the column of an axis.
pub(super) const COLUMN: usize = 17;

/// A paragraph.
pub(super) fn fill(text: &str, first_indent: &str, indent: &str) -> String {
    let options = textwrap::Options::new(WIDTH).initial_indent(first_indent).subsequent_indent(indent);
    // an exponent stays with its number
    textwrap::fill(text, options.word_splitter(textwrap::WordSplitter::NoHyphenation))
}

/// A row of such a table.
pub(super) fn row<T>(out: &mut String, label: &str, cells: &[T], cell: impl Fn(&T) -> String) -> fmt::Result {
    let mut line = format!("{label:<LABEL$}");
    for value in cells {
        write!(line, " {:>COLUMN$}", cell(value))?;
    }
    writeln!(out, "{}", line.trim_end())
}
