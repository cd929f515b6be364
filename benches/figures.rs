//! Keeps measured figures in `figures.jsonl`, from which the tables of `BENCHMARKS.md` are rendered.
//! Every benchmark includes this file.
#![allow(clippy::unwrap_used, reason = "a benchmark stops at the first surprise")]

use std::{env, fs, process::Command};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../benches/figures.jsonl");

/// Replaces a row of a table with these values, or appends it, with the date of today and the
/// command line of this benchmark. Only if `VN100_RECORD` is set: a figure counts if its machine was
/// idle.
pub(crate) fn record(table: &str, row: &str, values: &[(&str, String)]) {
    if env::var_os("VN100_RECORD").is_none() {
        return;
    }
    let date = Command::new("date").arg("+%F").output().unwrap().stdout;
    let (date, command) = (String::from_utf8(date).unwrap(), command());
    let values: Vec<String> = values.iter().map(|(name, value)| format!("{name:?}:{value:?}")).collect();
    let (of_table, values) = (format!("{{\"table\":{table:?},"), values.join(","));
    let of_row = format!("{of_table}\"row\":{row:?},");
    let line = format!("{of_row}\"date\":{:?},\"command\":{command:?},\"values\":{{{values}}}}}", date.trim());
    let text = fs::read_to_string(FILE).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    match lines.iter().position(|line| line.starts_with(&of_row)) {
        Some(place) => lines[place] = &line,
        None => {
            let last = lines.iter().rposition(|line| line.starts_with(&of_table));
            lines.insert(last.map_or(lines.len(), |last| last + 1), &line);
        }
    }
    fs::write(FILE, lines.join("\n") + "\n").unwrap();
}

fn command() -> String {
    let arguments: Vec<String> = env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let command = concat!("cargo bench -p ", env!("CARGO_PKG_NAME"), " --bench ", env!("CARGO_CRATE_NAME"));
    if arguments.is_empty() { command.into() } else { format!("{command} -- {}", arguments.join(" ")) }
}
