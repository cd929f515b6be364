//! The needs of blind and visually impaired readers of the live page and of its report.

use std::collections::BTreeMap;

use tempfile::TempDir;

use crate::page::Served;
use crate::support::capture;

/// The elements of this name: attributes, and content up to the next end of such an element.
fn elements<'a>(html: &'a str, name: &str) -> Vec<(&'a str, &'a str)> {
    let (begin, end) = (format!("<{name}"), format!("</{name}>"));
    let rest = html.split(&begin).skip(1).filter(|rest| rest.starts_with([' ', '>']));
    let parts = rest.filter_map(|rest| rest.split_once('>'));
    parts.map(|(attributes, rest)| (attributes, rest.split(&end).next().unwrap_or_default())).collect()
}

fn attribute<'a>(attributes: &'a str, name: &str) -> Option<&'a str> {
    attributes.split(&format!(" {name}=\"")).nth(1)?.split('"').next()
}

/// Checks landmarks, headings, names of tables and pictures, and targets of references.
fn assert_structure(page: &str, html: &str) {
    assert!(html.contains("<html lang=\"en\""), "{page}");
    for landmark in ["main", "header", "h1"] {
        assert_eq!(elements(html, landmark).len(), 1, "{page}: {landmark}");
    }
    let mut before = 0;
    for heading in html.split("<h").skip(1) {
        let Some(level @ 1..=6) = heading.chars().next().and_then(|digit| digit.to_digit(10)) else { continue };
        assert!(level <= before + 1, "{page}: a heading {level} behind one of {before}: {}", &heading[..60]);
        before = level;
    }
    for (attributes, content) in elements(html, "table") {
        assert!(content.contains("<caption") || attributes.contains("aria-label"), "{page}: {}", &content[..200]);
    }
    for (attributes, content) in elements(html, "th") {
        // an empty corner is no heading
        assert!(attribute(attributes, "scope").is_some() || content.is_empty(), "{page}: {attributes} {content}");
    }
    for (attributes, content) in elements(html, "svg") {
        let is_named = attributes.contains("aria-label") || content.contains("<title");
        assert!(attributes.contains("role=\"img\"") && is_named, "{page}: {attributes}");
    }
    for (attributes, content) in elements(html, "details") {
        assert!(content.contains("<summary"), "{page}: {attributes}");
    }
    let mut ids = BTreeMap::new();
    for id in html.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        *ids.entry(id).or_insert(0) += 1;
    }
    let twice: Vec<_> = ids.iter().filter(|(_, count)| **count > 1).collect();
    assert!(twice.is_empty(), "{page}: {twice:?}");
    for place in html.split("href=\"#").skip(1).filter_map(|rest| rest.split('"').next()) {
        assert!(ids.contains_key(place), "{page}: nothing at #{place}");
    }
}

/// Relative luminance of `#rrggbb` or `#rgb` (WCAG 2).
fn luminance(colour: &str) -> f64 {
    let digits: String = match colour.len() {
        4 => colour[1..].chars().flat_map(|digit| [digit, digit]).collect(),
        _ => colour[1..].to_owned(),
    };
    let part = |at: usize| {
        let value = f64::from(u8::from_str_radix(&digits[at..at + 2], 16).unwrap()) / 255.0;
        if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * part(0) + 0.7152 * part(2) + 0.0722 * part(4)
}

fn contrast(a: &str, b: &str) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[test]
fn the_pages_are_complete_for_blind_readers() {
    let folder = TempDir::new().unwrap();
    let files = ["a.mcap", "b.mcap"].map(|name| {
        let file = capture(folder.path(), name, &["--message", "VNIMU", "-d", "1min"]);
        file.to_str().unwrap().to_owned()
    });
    for files in [&files[..1], &files[..]] {
        let arguments: Vec<&str> = ["replay"].into_iter().chain(files.iter().map(String::as_str)).collect();
        let mut served = Served::start(&[&arguments[..], &["--speed", "max"]].concat());
        served.wait_for_the_end();
        for page in ["/", "/1", "/report.html"].into_iter().filter(|page| *page != "/1" || files.len() > 1) {
            assert_structure(page, &served.get(page).1);
        }
    }
}

/// The texts of the cells of every table, without its caption, which has a number in the report.
fn tables(html: &str) -> Vec<Vec<String>> {
    let cells = |table: &str| {
        let table = table.split("</caption>").last().unwrap_or_default();
        let texts = table.split('<').filter_map(|piece| Some(piece.split_once('>')?.1.to_owned()));
        texts.filter(|text| !text.is_empty()).collect()
    };
    elements(html, "table").into_iter().map(|(_, table)| cells(table)).collect()
}

#[test]
fn the_tables_of_the_page_are_those_of_the_report() {
    let folder = TempDir::new().unwrap();
    let file = capture(folder.path(), "a.mcap", &["--message", "VNIMU", "-d", "5min"]);
    let mut served = Served::start(&["replay", file.to_str().unwrap(), "--speed", "max"]);
    served.wait_for_the_end();
    let (page, report) = (tables(&served.get("/").1), tables(&served.get("/report.html").1));
    assert!(page.len() > 8 && page.iter().all(|table| !table.is_empty()), "{page:?}");
    for table in page {
        assert!(report.contains(&table), "{table:?}");
    }
}

#[test]
fn letters_and_lines_have_contrast_in_light_and_dark() {
    let folder = TempDir::new().unwrap();
    let file = capture(folder.path(), "a.mcap", &["-d", "10s"]);
    let page = Served::start(&["replay", file.to_str().unwrap(), "--speed", "max"]).get("/").1;
    let css = page.split("<style>").nth(1).unwrap().split("</style>").next().unwrap();
    let themes = css.split(":root {").skip(1).filter_map(|rest| rest.split('}').next());
    let themes: Vec<BTreeMap<&str, &str>> = themes
        .map(|theme| theme.split(';').filter_map(|line| line.trim().strip_prefix("--")?.split_once(": ")).collect())
        .filter(|theme: &BTreeMap<&str, &str>| theme.contains_key("paper"))
        .collect();
    assert!(themes.len() >= 2, "{themes:?}");
    for theme in themes {
        let of = |name: &str| *theme.get(name).unwrap_or_else(|| panic!("no {name} in {theme:?}"));
        let letters = ["ink", "soft", "link", "axis", "quiet"].map(|name| (name, "paper"));
        let shaded = ["ink", "soft", "link"].map(|name| (name, "shade"));
        let marked = [
            ("problem", "problem-back"),
            ("caution", "caution-back"),
            ("note", "note-back"),
            ("fine-ink", "fine-back"),
            ("ink", "problem-back"),
            ("soft", "note-back"),
        ];
        for (name, behind) in letters.into_iter().chain(shaded).chain(marked) {
            let contrast = contrast(of(name), of(behind));
            assert!(contrast >= 4.5, "{name} on {behind}: {contrast:.2}");
        }
        for curve in ["c0", "c1", "c2", "c3", "c4", "c5"] {
            let contrast = contrast(of(curve), of("paper"));
            assert!(contrast >= 3.0, "{curve}: {contrast:.2}");
        }
    }
}
