//! The width of documentation comments, which the formatter leaves alone.

use crate::source::source_files;

/// Of prose.
const WIDEST: usize = 100;

/// Of examples and drawings, as of code.
const WIDEST_CODE: usize = 120;

/// Sentences of the sensor and rows of tables have no blank to break at.
fn cannot_be_broken(text: &str) -> bool {
    text.trim_start().starts_with('|') || text.contains("$VN")
}

/// The documentation lines of a file that are too wide, by their numbers.
fn wide_lines(source: &str) -> Vec<usize> {
    let (mut wide, mut in_example) = (Vec::new(), false);
    for (number, line) in (1..).zip(source.lines()) {
        let trimmed = line.trim_start();
        let Some(text) = trimmed.strip_prefix("///").or_else(|| trimmed.strip_prefix("//!")) else {
            in_example = false;
            continue;
        };
        let is_fence = text.trim_start().starts_with("```");
        in_example ^= is_fence;
        let widest = if in_example || is_fence { WIDEST_CODE } else { WIDEST };
        if line.chars().count() > widest && !cannot_be_broken(text) {
            wide.push(number);
        }
    }
    wide
}

#[test]
fn documentation_fits_in_100_columns() {
    let of_file =
        |(name, text): (String, String)| wide_lines(&text).into_iter().map(move |line| format!("{name}:{line}"));
    let wide: Vec<String> = source_files().into_iter().flat_map(of_file).collect();
    assert!(wide.is_empty(), "wider than {WIDEST} columns: {}", wide.join(", "));
}

#[test]
fn wide_prose_is_found_and_examples_may_be_as_wide_as_code() {
    let (prose, code) = ("x".repeat(100), "x".repeat(110));
    let source =
        format!("//! {prose}\n/// ```\n/// {code}\n/// ```\n/// {code}\nlet {code};\n/// $VN{code}\n/// short");
    assert_eq!(wide_lines(&source), [1, 5]);
}
