//! The width of documentation comments, which the formatter leaves alone.

use crate::source::source_files;

const WIDEST: usize = 100;

/// What has no blank to break at: rows of tables and sentences of the sensor.
fn cannot_be_broken(line: &str) -> bool {
    let text = line.trim_start_matches(['/', '!', ' ']);
    text.starts_with('|') || text.contains("$VN")
}

#[test]
fn documentation_fits_in_100_columns() {
    let wide: Vec<String> = source_files()
        .iter()
        .flat_map(|(name, text)| {
            (1..).zip(text.lines()).filter_map(move |(number, line)| {
                let is_doc = line.trim_start().starts_with("///") || line.trim_start().starts_with("//!");
                let is_wide = line.chars().count() > WIDEST && !cannot_be_broken(line);
                (is_doc && is_wide).then(|| format!("{name}:{number}: {line}"))
            })
        })
        .collect();
    assert!(wide.is_empty(), "wider than {WIDEST} columns:\n{}", wide.join("\n"));
}
