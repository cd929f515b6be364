//! What every face says of a result is in its document, for forty kinds of results.

use std::{collections::BTreeSet, sync::OnceLock, thread};

use serde_json::Value;
use vn100_analysis::{
    End, Shortfall, SourceResult,
    protocol::{Layout, MESSAGES, Quantity},
};

use super::fixture::measured;
use crate::remedies::page_words;
use crate::{
    ArchiveRow, ArchivedFile, Consumer, CsvTable, Document, Ended, FilterNoise,
    figure::ReportFigures,
    html::{PageOptions, Program, report_page, result_parts},
    metrics_text,
    summary::Summary,
    units::parameter_unit,
};
use vn100_analysis::{noise::Term, sensor_of};

/// What becomes of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fate {
    Empty,
    Few,
    Short,
    Calm,
    Moved,
    Vibrating,
    Drifting,
    Failed,
}

const FATES: [Fate; 8] = {
    use Fate::*;
    [Empty, Few, Short, Calm, Moved, Vibrating, Drifting, Failed]
};

/// Each message of the sensor with each fate.
fn kinds() -> &'static [(String, SourceResult)] {
    static MADE: OnceLock<Vec<(String, SourceResult)>> = OnceLock::new();
    MADE.get_or_init(|| {
        thread::scope(|scope| {
            let made = MESSAGES.map(|layout| scope.spawn(move || FATES.map(|fate| kind(layout, fate))));
            made.into_iter().flat_map(|made| made.join().unwrap()).collect()
        })
    })
}

fn kind(layout: &Layout, fate: Fate) -> (String, SourceResult) {
    let samples = match fate {
        Fate::Empty => 0,
        Fate::Few => 12,
        Fate::Short | Fate::Failed => 300,
        _ => 1500,
    };
    let channels: Vec<(f64, f64)> = (layout.channels.iter())
        .map(|channel| {
            let (mean, std) = match channel.quantity {
                Quantity::AngularRate => (0.0009, 0.0008),
                Quantity::Acceleration if channel.name == "accel_z" => (-9.8, 0.01),
                Quantity::MagneticField => (0.2, 0.002),
                Quantity::Temperature => (25.0, 0.1),
                Quantity::Pressure => (101.325, 0.01),
                _ => (0.3, 0.01),
            };
            let count = channel.scale / 10_f64.powi(channel.decimals.into());
            (mean / count, (std / count).max(1.0))
        })
        .collect();
    let stds: Vec<f64> = channels.iter().map(|(_, std)| *std).collect();
    let result = measured((layout, 40.0), samples, &channels, |place, sample, _| match fate {
        Fate::Moved => 500.0 * stds[place] * (sample / 11.0).sin(),
        Fate::Vibrating => 2.0 * stds[place] * (sample * 2.0).sin(),
        Fate::Drifting => 10.0 * stds[place] * sample / 1500.0,
        _ => 0.0,
    });
    let name = format!("{} {fate:?}", layout.message);
    if fate != Fate::Failed {
        return (name, result);
    }
    let shortfall =
        Shortfall { wanted: std::time::Duration::from_secs(60), measured: std::time::Duration::from_secs(7) };
    let end = End::SourceFailed("the port is gone".into());
    (
        name,
        Ended { end: &end, shortfall: Some(&shortfall), unmet: &[], is_live: true, words: page_words }.complete(result),
    )
}

fn document(result: &SourceResult) -> Value {
    serde_json::to_value(Document::new(result, page_words)).unwrap()
}

/// All numbers of a document, as they are printed.
fn numbers(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Number(number) => {
            found.insert(number.as_f64().unwrap().to_string());
        }
        Value::Array(all) => all.iter().for_each(|value| numbers(value, found)),
        Value::Object(all) => all.values().for_each(|value| numbers(value, found)),
        _ => {}
    }
}

fn numbers_of(document: &Value) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    numbers(document, &mut found);
    found
}

#[track_caller]
fn check(name: &str, known: &BTreeSet<String>, text: &str, of: &str) {
    let Ok(number) = text.parse::<f64>() else { return };
    assert!(known.contains(&number.to_string()), "{name}: {text} of {of:?} is not in the document");
}

#[test]
fn numbers_of_tables_and_metrics_are_those_of_the_document() {
    let all = kinds();
    assert_eq!(all.len(), 40);
    let file = ArchivedFile { path: "a".into(), bytes: 1, modified_ns: 2, options: String::new() };
    for (name, result) in all {
        let document = document(result);
        let known = numbers_of(&document);
        let metrics = metrics_text(&[(result, None)]);
        let own =
            ["vn100_info", "vn100_link_up", "vn100_warning", "vn100_rate_offset", "vn100_link_load", "vn100_temp"];
        for line in
            metrics.lines().filter(|line| !line.starts_with('#') && !own.iter().any(|own| line.starts_with(own)))
        {
            check(name, &known, line.rsplit_once(' ').unwrap().1, line);
        }
        for row in ArchiveRow::of_file(&file, std::slice::from_ref(result)) {
            let row: serde_json::Map<String, Value> = serde_json::from_str(&row.json_line()).unwrap();
            for (column, cell) in
                row.iter().filter(|(column, _)| !["bytes", "modified_ns", "rows"].contains(&&***column))
            {
                check(name, &known, &cell.to_string(), column);
            }
            assert_eq!(row["completion"], document["completion"], "{name}");
            assert_eq!(row["error"], document["source"]["error"], "{name}");
        }
        let tables = [".metadata.csv", ".allan.csv", ".statistics.csv", ".parameters.csv"];
        for table in CsvTable::ALL.iter().filter(|table| tables.contains(&table.ending)) {
            for row in table.text(result, page_words).lines().skip(1) {
                // of the graphical readings the document has the SI units alone
                let is_derived = row.contains(",graphical_") && row.ends_with(",false");
                row.split(',').filter(|_| !is_derived).for_each(|cell| check(name, &known, cell, row));
            }
        }
    }
}

#[test]
fn what_is_withheld_stands_in_no_face() {
    let mut withheld = BTreeSet::new();
    for (name, result) in kinds() {
        let document = document(result);
        let metrics = metrics_text(&[(result, None)]);
        let summary = Summary::new(result, page_words);
        let tables: String = CsvTable::ALL.iter().map(|table| table.text(result, page_words)).collect();
        for channel in document["channels"].as_array().unwrap() {
            for (term, metric) in [
                ("white", "vn100_white_noise"),
                ("bias_instability", "vn100_bias_instability"),
                ("rate_random_walk", "vn100_rate_random_walk"),
            ] {
                let found = &channel["noise"][term];
                if ["value", "lower", "upper"].iter().any(|part| found[part].is_number()) {
                    continue;
                }
                let axis = channel["name"].as_str().unwrap();
                withheld.extend(found["status"].as_str().map(str::to_owned));
                assert!(!metrics.lines().any(|line| line.starts_with(metric) && line.contains(axis)), "{name} {axis}");
                let row = format!("{axis},{term},");
                let rows: Vec<&str> = tables.lines().filter(|line| line.starts_with(&row)).collect();
                assert!(rows.iter().all(|row| row.contains(",,,,")), "{name}: {rows:?}");
            }
        }
        if !document["motion"].is_null() {
            assert!(summary.sensors.is_empty() && !tables.contains("graphical,"), "{name}");
            assert!(Consumer::ALL.iter().all(|to| to.file(&FilterNoise::of(result, 60.0)).is_err()), "{name}");
        }
    }
    for status in ["moved", "not-observable", "not-measurable"] {
        assert!(withheld.contains(status), "{status} is not among {withheld:?}");
    }
}

#[test]
fn the_summary_has_the_parameters_and_statements_of_the_document() {
    let terms = [
        ("N", Term::White, "white"),
        ("B", Term::BiasInstability, "bias_instability"),
        ("K", Term::RateRandomWalk, "rate_random_walk"),
        ("R", Term::RateRamp, "rate_ramp"),
    ];
    let mut compared = 0;
    for (name, result) in kinds() {
        let document = document(result);
        let summary = Summary::new(result, page_words);
        for status in &summary.statuses {
            let of_document = document["statuses"].as_array().unwrap().iter();
            let same = of_document.clone().find(|other| other["aspect"] == status.aspect).unwrap();
            let findings: Vec<&str> = status.findings.iter().map(|(text, _)| text.as_str()).collect();
            assert_eq!(same["findings"], serde_json::json!(findings), "{name}");
        }
        for table in &summary.sensors {
            let rows = table.rows.iter().filter(|row| !row.is_detail && row.cells.len() == table.axes.len());
            for row in rows {
                let (_, term, key) = terms.into_iter().find(|(symbol, ..)| row.label.ends_with(symbol)).unwrap();
                for (axis, cell) in table.axes.iter().zip(&row.cells) {
                    let (quantity, sensor) = match table.title {
                        "Gyroscope" => (Quantity::AngularRate, "gyro"),
                        "Accelerometer" => (Quantity::Acceleration, "accel"),
                        _ => (Quantity::MagneticField, "mag"),
                    };
                    let (_, factor) = parameter_unit(sensor_of(quantity).unwrap(), term);
                    let axis = format!("{sensor}_{axis}");
                    let mut channels = document["channels"].as_array().unwrap().iter();
                    let found = &channels.find(|channel| channel["name"] == axis).unwrap()["noise"][key];
                    let (shown, of) = match cell.strip_prefix("≤ ") {
                        Some(bound) => (bound, "upper"),
                        None => (cell.split(' ').next().unwrap(), "value"),
                    };
                    let Ok(shown) = shown.parse::<f64>() else { continue };
                    let expected = found[of].as_f64().unwrap_or_else(|| panic!("{name} {axis} {key} {found}")) * factor;
                    assert!((shown / expected - 1.0).abs() < 0.051, "{name} {axis} {key}: {shown}, not {expected}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 150, "{compared}");
}

#[test]
fn the_pages_have_the_warnings_and_statuses_of_the_document_and_tables_its_codes() {
    for (name, result) in kinds() {
        let document = document(result);
        let options = PageOptions {
            confidence: 0.95,
            asked: "as asked",
            words: page_words,
            program: Program { name: "vn100 test", commit: None },
            span_s: 60.0,
        };
        let records = std::slice::from_ref(result);
        let page = report_page(records, &ReportFigures::of(records), options);
        let live: String = result_parts(result, options).iter().map(|part| &*part.html).collect();
        let escaped =
            |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
        let statuses = document["statuses"].as_array().unwrap().iter().filter(|_| result.timing.samples > 0);
        for finding in statuses.flat_map(|status| status["findings"].as_array().unwrap()) {
            let finding = escaped(finding.as_str().unwrap());
            assert!(page.contains(&finding) && live.contains(&finding), "{name}: {finding}");
        }
        let warnings =
            CsvTable::ALL.iter().find(|table| table.ending == ".warnings.csv").unwrap().text(result, page_words);
        let metrics = metrics_text(&[(result, None)]);
        for warning in document["warnings"].as_array().unwrap() {
            let kind = warning["kind"].as_str().unwrap();
            assert!(page.contains(kind) && live.contains(kind), "{name} {kind}");
            assert!(warnings.contains(kind) && metrics.contains(kind), "{name} {kind}");
        }
        let is_error_shown = document["source"]["error"].as_str().is_none_or(|error| page.contains(error));
        assert!(is_error_shown, "{name}: {}", document["source"]["error"]);
    }
}
