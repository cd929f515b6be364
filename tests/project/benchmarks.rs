//! The tables of `BENCHMARKS.md` have the rows of `benches/figures.jsonl`. `VN100_WRITE=1 cargo
//! test -p vn100 --test project benchmarks` writes them.

use std::{env, fs, path::PathBuf};

use serde_json::Value;

/// A line before each table names the table of the data file that it shows.
const MARKER: &str = "<!-- figures: ";

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

fn figures() -> Vec<Value> {
    let text = fs::read_to_string(path("benches/figures.jsonl")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The rows of a table: the first column names the row, the others are values or the date.
fn rows<'a>(table: &'a str, head: &'a str, figures: &'a [Value]) -> impl Iterator<Item = String> {
    let columns: Vec<&str> = head.trim_matches('|').split('|').map(str::trim).skip(1).collect();
    figures.iter().filter(move |figure| figure["table"] == table).map(move |figure| {
        let cell = |column: &&str| match *column {
            "date" => figure["date"].as_str().unwrap(),
            name => figure["values"][name].as_str().unwrap_or_default(),
        };
        let cells: Vec<&str> = columns.iter().map(cell).collect();
        format!("| {} | {} |", figure["row"].as_str().unwrap(), cells.join(" | "))
    })
}

/// The page with the rows of the figures in its tables.
fn rendered(page: &str, figures: &[Value]) -> String {
    let mut lines = page.lines();
    let mut rendered = Vec::new();
    while let Some(line) = lines.next() {
        rendered.push(line.to_owned());
        let Some(table) = line.strip_prefix(MARKER).and_then(|rest| rest.strip_suffix(" -->")) else { continue };
        let head = lines.find(|line| line.starts_with('|')).unwrap();
        rendered.extend(["", head, lines.next().unwrap()].map(str::to_owned));
        let after = lines.by_ref().find(|line| !line.starts_with('|'));
        rendered.extend(rows(table, head, figures));
        rendered.extend(after.map(str::to_owned));
    }
    rendered.join("\n") + "\n"
}

#[test]
fn the_tables_of_the_page_are_those_of_the_data_file() {
    let (page_path, figures) = (path("BENCHMARKS.md"), figures());
    let page = fs::read_to_string(&page_path).unwrap();
    let rendered = rendered(&page, &figures);
    if env::var_os("VN100_WRITE").is_some() {
        return fs::write(page_path, rendered).unwrap();
    }
    assert!(page.matches(MARKER).count() >= 6, "{} tables", page.matches(MARKER).count());
    assert_eq!(page, rendered, "VN100_WRITE=1 writes the page");
}

#[test]
fn each_row_has_its_date_its_command_and_a_place_of_its_own() {
    let figures = figures();
    let mut places: Vec<(&str, &str)> = Vec::new();
    for figure in &figures {
        let text = |name: &str| figure[name].as_str().unwrap_or_else(|| panic!("no {name}: {figure}"));
        assert_eq!(text("date").len(), "2026-11-26".len(), "{figure}");
        assert!(!text("command").is_empty() && !figure["values"].as_object().unwrap().is_empty(), "{figure}");
        places.push((text("table"), text("row")));
    }
    let all = places.len();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), all, "a row is there twice");
}

#[test]
fn a_table_takes_its_rows_from_the_figures() {
    let figure = serde_json::json!({"table": "a", "row": "x", "date": "2026-11-26", "values": {"s": "1.0"}});
    let page = "text\n<!-- figures: a -->\n\n| of | s | m | date |\n|---|---|---|---|\n| old | 2 | 3 | 4 |\n\nmore\n";
    let expected = page.replace("| old | 2 | 3 | 4 |", "| x | 1.0 |  | 2026-11-26 |");
    assert_eq!(rendered(page, &[figure]), expected);
}
